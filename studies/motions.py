"""Motions of a fingertip for studies and tests."""

from __future__ import annotations

from core.native.motion import FingertipMotion
from core.vectors import Vector


def straight(start: Vector, end: Vector, *, ticks: int, radius: float, fresh: bool = False) -> FingertipMotion:
    """Return an even motion from start to end (3,) [m]."""
    x, y, z = ((a + (b - a) / ticks) if ticks else b for a, b in zip(start, end, strict=True))
    return FingertipMotion(start, (x, y, z), end, radius, fresh)
