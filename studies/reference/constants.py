"""The numbers of the core, read from its page in C: the twin goes by the same ones."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

_PAGE = Path(__file__).parents[2] / "core" / "native" / "constants.h"
_FOUND = dict(re.findall(r"^#define DM_(\w+) +([-\d.e]+)\s", _PAGE.read_text(), re.MULTILINE))


def __getattr__(name: str) -> Any:
    """Return a number of the page by its name without DM_."""
    if name not in _FOUND:
        raise AttributeError(name)
    text = _FOUND[name]
    return int(text) if text.isdigit() else float(text)
