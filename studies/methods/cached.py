"""What a method prepares for a model, once."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any, TypeVar

from core.body.model import Model

Made = TypeVar("Made")
_made: dict[tuple[int, str], Any] = {}


def kept(model: Model, make: Callable[[Model], Made]) -> Made:
    """Return make(model), made at its first use and freed with the model."""
    key = id(model), f"{make.__module__}.{make.__qualname__}"
    if key not in _made:
        _made[key] = make(model)
        weakref.finalize(model, _made.pop, key, None)
    made: Made = _made[key]
    return made
