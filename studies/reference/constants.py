"""The numbers of the core, read from its page in C: the twin goes by the same ones."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

_PAGE = Path(__file__).parents[2] / "core" / "native" / "constants.h"
_FOUND = dict(re.findall(r"^#define DM_(\w+) +(.+?)\s*(?:/\*|$)", _PAGE.read_text(), re.MULTILINE))


def __getattr__(name: str) -> Any:
    """Return a number of the page, or what follows from others, by its name without DM_."""
    if name not in _FOUND:
        raise AttributeError(name)
    terms = re.findall(r"DM_(\w+)", _FOUND[name])
    return eval(_FOUND[name].replace("DM_", ""), {"__builtins__": {}}, {term: __getattr__(term) for term in terms})
