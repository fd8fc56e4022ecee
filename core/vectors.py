"""Vectors as tuples of three numbers: for single points, and for the servo process, which has no numpy."""

from __future__ import annotations

import math

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)


def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def along(a: Vector, b: Vector, share: float) -> Vector:
    """Return a + share b."""
    return a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]


def scaled(a: Vector, factor: float) -> Vector:
    """Return factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


def length(a: Vector) -> float:
    """Return |a|."""
    return math.sqrt(dot(a, a))


def capped(a: Vector, most: float) -> Vector:
    """Return a, shortened if it is longer than `most`."""
    long = length(a)
    return scaled(a, most / long) if long > most else a


def is_finite(a: Vector) -> bool:
    """Tell whether all three are finite numbers."""
    return math.isfinite(a[0]) and math.isfinite(a[1]) and math.isfinite(a[2])
