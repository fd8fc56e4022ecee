"""Work in steps: a generator yields the share that is done and returns its result."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any, TypeVar

_Result = TypeVar("_Result")


def result_of(steps: Generator[Any, None, _Result]) -> _Result:
    """Run steps to their end and return their result."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            found: _Result = end.value
            return found


def as_share(
    steps: Generator[float, None, _Result], done: float, share: float
) -> Generator[float, None, _Result]:
    """Run a part of the work: yield how far the whole is, of which so much was done before and this is such a share."""
    while True:
        try:
            part = next(steps)
        except StopIteration as end:
            found: _Result = end.value
            return found
        yield done + share * part
