"""The lines of the overlay as plain numbers, without gpu: circles, arrows and charts."""

import math
from collections.abc import Sequence

from ..core.material import law_force

Point = tuple[float, ...]
Segment = tuple[Point, Point]
Law = tuple[float, float, float, float]  # K1, K2 [N/m], x0 [m], and the exponent of the depth in its first part

CIRCLE_SIDES = 32
BENT_LINES = 32  # segments of a curve that is not piecewise linear
ARROW_PER_NEWTON = 0.2  # [fingertip radii/N] long enough to compare two fingers by eye
ARROW_HEAD, ARROW_LONGEST = 0.4, 5.0  # [fingertip radii] its barbs; the limit: larger forces are read as numbers


def circle(centre: Point, across: Point, up: Point) -> list[Segment]:
    """Return the sides of a circle spanned by two half axes."""
    angles = [2 * math.pi * i / CIRCLE_SIDES for i in range(CIRCLE_SIDES + 1)]
    points = [_add(centre, _scaled(across, math.cos(a)), _scaled(up, math.sin(a))) for a in angles]
    return list(zip(points, points[1:], strict=False))


def outline(centre: Point, radius: float, view: Sequence[Sequence[float]]) -> list[Segment]:
    """Return the outline of a sphere in a view, given by its matrix; great circles would cover the dent."""
    across, up = (_scaled(tuple(row[:3]), radius) for row in view[:2])
    return circle(centre, across, up)


def arrow(centre: Point, force: Point, radius: float) -> list[Segment]:
    """Return an arrow along a force [N] from the surface of a fingertip [scene units]; nothing below 1 mN."""
    newtons = math.hypot(*force)
    if newtons < 1e-3:
        return []
    along = _scaled(force, 1 / newtons)
    start = _add(centre, _scaled(along, radius))
    tip = _add(start, _scaled(along, radius * min(ARROW_HEAD + ARROW_PER_NEWTON * newtons, ARROW_LONGEST)))
    # the two barbs may lie in any plane through the arrow
    least = min(range(3), key=lambda axis: abs(along[axis]))
    across = _cross(along, tuple(float(axis == least) for axis in range(3)))
    across = _scaled(across, 1 / math.hypot(*across))
    barbs = [_add(tip, _scaled(along, -ARROW_HEAD * radius), _scaled(across, side * 0.2 * radius)) for side in (-1, 1)]
    return [(start, tip), *((tip, barb) for barb in barbs)]


def law_curve(law: Law, deepest: float) -> list[Point]:
    """Return points (depth [m], force [N]) of a law up to a depth [m]: its corners, or many if it is curved."""
    depths = [0.0, min(law[2], deepest), deepest]
    if law[3] > 1:
        depths = evenly(deepest)
    return [(depth, law_force(depth, *law)) for depth in depths]


def evenly(deepest: float) -> list[float]:
    """Return the depths of the points of a curve that is not piecewise linear, up to a depth [m]."""
    return [deepest * i / BENT_LINES for i in range(BENT_LINES + 1)]


def round_up(value: float) -> float:
    """Return the end of an axis for a positive value: the first of 1, 2, 3, 4, 5, 6, 8, 10, 20... not below it."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in (1, 2, 3, 4, 5, 6, 8, 10) if step * decade >= value * (1 - 1e-9))


def into_box(points: Sequence[Point], ends: tuple[float, float], corner: Point, size: Point) -> list[Point]:
    """Map (depth, force) from 0..ends into a box on the screen; points outside are clamped to its edge."""
    return [
        tuple(c + s * min(max(value / end, 0.0), 1.0) for value, end, c, s in zip(p, ends, corner, size, strict=True))
        for p in points
    ]


def chained(points: Sequence[Point]) -> list[Segment]:
    """Return the lines between neighbouring points."""
    return list(zip(points, points[1:], strict=False))


def crosses(points: Sequence[Point], half: float) -> list[Segment]:
    """Return an upright cross at every point."""
    level = [((x - half, y), (x + half, y)) for x, y in points]
    return level + [((x, y - half), (x, y + half)) for x, y in points]


def _add(*points: Point) -> Point:
    return tuple(map(sum, zip(*points, strict=True)))


def _scaled(point: Point, factor: float) -> Point:
    return tuple(factor * value for value in point)


def _cross(a: Point, b: Point) -> Point:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
