"""How far what meets may go before the next query: planes between pairs, which move with what is rigid."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from core.base import Floats, Ints

from .constants import ROUNDING, TRIES
from .proximity import Pairs, measure, planes_between


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """What holds vertices back until the next query.

    before: (n, 3) where they were at the query [m].
    slack: (n,) how far each may go [m].
    pairs: what is near each other.
    start, rows: the planes of each vertex, as rows of pairs.
    corners: at which of their four it is.
    """

    before: Floats
    slack: Floats
    pairs: Pairs
    start: Ints
    rows: Ints
    corners: Ints


def bounds_of(before: Floats, slack: Floats, pairs: Pairs) -> Bounds:
    """Return the bounds that follow from a query."""
    flat = pairs.at.ravel()
    order = np.argsort(flat, kind="stable")
    return Bounds(
        before=before, slack=slack, pairs=pairs, rows=order // 4, corners=order % 4,
        start=np.searchsorted(flat[order], np.arange(len(slack) + 1)),
    )  # fmt: skip


def moved(b: Bounds, x: Floats, last: Floats) -> Bounds:
    """Return the bounds where all are at x and were at `last` before this substep, both (n, 3) [m].

    Each plane beside what is rigid goes to the side of it that the other one sees, and that between two that are soft
    to the middle between them, where both were on their sides of it before.
    """
    p = b.pairs
    (low, high), (lower, higher) = _sides(b, x), _sides(b, last)
    least, most = higher + p.keep, lower - p.keep
    middle = np.where(least <= most, np.minimum(np.maximum((low + high) / 2, least), most), p.level)
    level = np.where(p.rigid[:, 0], low, np.where(p.rigid[:, 1], high, middle))
    return replace(b, pairs=replace(p, level=level))


def _sides(b: Bounds, x: Floats) -> tuple[Floats, Floats]:
    """Return how far along its normal the first of each pair is at least, and the second at most, (m,) [m]."""
    p, first = b.pairs, np.arange(4) < b.pairs.ones[:, None]
    along = np.einsum("mkc,mc->mk", x[p.at], p.normal)
    return np.where(first, along, np.inf).min(axis=1), np.where(first, -np.inf, along).max(axis=1)


def left_of(b: Bounds, x: Floats) -> Floats:
    """Return how far the four (m, 4) of each pair are from what it lets them reach [m].

    It is inf for what is rigid; where both are, for the first alone.
    """
    p, first = b.pairs, np.arange(4) < b.pairs.ones[:, None]
    along = np.einsum("mkc,mc->mk", x[p.at], p.normal) - p.level[:, None]
    rigid = np.where(first, p.rigid[:, :1], p.rigid[:, 1:] & ~p.rigid[:, :1])
    return np.where(rigid, np.inf, np.where(first, along, -along) - p.keep[:, None])


def settle(
    b: Bounds, vertex: int, x: Floats, last: Floats, way: Floats | None, margin: float
) -> tuple[Floats, bool]:
    """Return where a vertex at x (3,) may be, and whether it may be there.

    Args:
        last: (3,) where it was before this substep.
        way: (3,) that what pushes it went in the substep, None where nothing does.
        margin: beyond its planes [m].
    """
    for start in [x] if way is None else [x, last + way]:
        at = _brought_back(b, vertex, start, margin)
        if is_allowed(b, vertex, at):
            return at, True
    return last, is_allowed(b, vertex, last)


def is_allowed(b: Bounds, vertex: int, x: Floats) -> bool:
    """Tell whether a vertex may be at x (3,)."""
    if not float(np.linalg.norm(x - b.before[vertex])) <= b.slack[vertex]:
        return False
    return bool((_left(b, vertex, x) >= 0).all())


def beyond(b: Bounds, vertex: int, x: Floats) -> Ints:
    """Return the planes that a vertex at x (3,) is beyond, the farthest first."""
    left = _left(b, vertex, x)
    order = np.argsort(left, kind="stable")
    found: Ints = _planes(b, vertex)[order[left[order] < 0]]
    return found


def way_of(b: Bounds, row: int, x: Floats, was: Floats) -> Floats:
    """Return by what way (3,) the nearest point of the rigid one of a pair went from `was` to x, both (n, 3) [m]."""
    p, at = b.pairs, b.pairs.at[row]
    w = np.abs(measure(x[at][None], p.ones[row : row + 1])[0][0])
    first = np.arange(4) < p.ones[row]
    way: Floats = (w * (first if p.rigid[row, 0] else ~first)) @ (x[at] - was[at])
    return way


def renewed(b: Bounds, rows: Ints, x: Floats, closest: Floats) -> Bounds:
    """Return the bounds with new planes for some pairs, where all (n, 3) are now.

    They stand between the nearest points of two that are apart, so that each is on its side.

    Args:
        closest: (n,) nearer than this [m], nothing goes nearer still.
    """
    p = b.pairs
    some = planes_between(x, p.at[rows], p.ones[rows], closest[p.at[rows]].max(axis=1), p.rigid[rows])
    changed = {}
    for name in ("normal", "level", "keep"):
        changed[name] = getattr(p, name).copy()
        changed[name][rows] = getattr(some, name)
    return replace(b, pairs=replace(p, **changed))


def _brought_back(b: Bounds, vertex: int, x: Floats, margin: float) -> Floats:
    """Return x (3,) after some sweeps that put it onto the planes of a vertex, so that it still slides along them."""
    most, before = b.slack[vertex] * (1 - ROUNDING), b.before[vertex]
    planes, sign = _planes(b, vertex), _signs(b, vertex)
    for sweep in range(TRIES + 1):
        moving = False
        x = _shortened(before, x, most) if sweep else x
        for plane, way in zip(planes, sign, strict=True) if sweep < TRIES else ():
            left = way * (b.pairs.normal[plane] @ x - b.pairs.level[plane]) - b.pairs.keep[plane]
            if left < 0:
                x, moving = x + way * (margin - left) * b.pairs.normal[plane], True
        if not moving:
            break
    return x


def _planes(b: Bounds, vertex: int) -> Ints:
    return b.rows[b.start[vertex] : b.start[vertex + 1]]


def _signs(b: Bounds, vertex: int) -> Floats:
    corners = b.corners[b.start[vertex] : b.start[vertex + 1]]
    return np.where(corners < b.pairs.ones[_planes(b, vertex)], 1.0, -1.0)


def _left(b: Bounds, vertex: int, x: Floats) -> Floats:
    """Return how far x (3,) is from what each of the vertex's planes lets it reach [m], below 0 beyond that."""
    planes = _planes(b, vertex)
    left: Floats = _signs(b, vertex) * (b.pairs.normal[planes] @ x - b.pairs.level[planes]) - b.pairs.keep[planes]
    return left


def _shortened(before: Floats, x: Floats, most: float) -> Floats:
    way = x - before
    length = float(np.linalg.norm(way))
    return before + way * (most / length) if length > most else x
