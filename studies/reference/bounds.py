"""How far vertices may go before the next query: planes between pairs, and a distance for what is near nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from core.base import Bools, Floats, Ints

from .constants import BOUND, QUICK, ROUNDING, TRIES
from .proximity import Pairs, Surfaces, planes_between


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """What holds vertices back until the next query.

    before: (n, 3) where they were at the query [m], and
    since: (n, 3) when their planes were looked at last [m].
    slack: (n,) how far each may go [m], and
    roam: (n,) how far before its planes are looked at [m].
    pairs: what is near each other, and
    anew: (m,) whether their planes were set anew since the query.
    start, rows: the planes of each vertex, as rows of pairs.
    corners: at which of their four it is.
    """

    before: Floats
    since: Floats
    slack: Floats
    roam: Floats
    pairs: Pairs
    anew: Bools
    start: Ints
    rows: Ints
    corners: Ints


def bounds_of(before: Floats, slack: Floats, pairs: Pairs) -> Bounds:
    """Return the bounds that follow from a query."""
    flat = pairs.at.ravel()
    order = np.argsort(flat, kind="stable")
    roam = slack.copy()
    side = (np.arange(4) >= pairs.ones[:, None]).astype(np.int64)
    np.minimum.at(roam, flat, np.take_along_axis(pairs.way, side, axis=1).ravel())
    return Bounds(
        before=before, since=before.copy(), slack=slack, roam=roam, pairs=pairs, rows=order // 4, corners=order % 4,
        anew=np.zeros(len(pairs.ones), bool), start=np.searchsorted(flat[order], np.arange(len(slack) + 1)),
    )  # fmt: skip


def free_behind(s: Surfaces, x: Floats, i: int, j: int, pairs: Pairs, reach: float) -> Floats:
    """Return how far the vertices (n,) of two surfaces i and j are from the other one at least [m], inf elsewhere.

    Between the two stands a slab, square to the mean normal of their pairs: what is farther than the reach from the
    other's side of it, and its neighbours with it, may go farther. Where one is all round the other there is none.

    Args:
        x: (n, 3) all vertices [m].
        pairs: of the two.
        reach: [m] that all are apart at least, but for the pairs.
    """
    one, other = s.of_vertex == i, s.of_vertex == j
    away = np.where(one | other, reach, np.inf)
    if i == j or not len(pairs.gap):
        return away
    ours = s.of_vertex[pairs.at[:, 0]] == i
    normal = np.where(ours[:, None], pairs.normal, -pairs.normal).sum(axis=0)
    along = x @ (normal / max(float(np.linalg.norm(normal)), 1e-300))
    away[one], away[other] = along[one] - along[other].max(), along[one].min() - along[other]
    least = away.copy()
    np.minimum.at(least, s.edges[:, 0], away[s.edges[:, 1]])
    np.minimum.at(least, s.edges[:, 1], away[s.edges[:, 0]])
    return np.maximum(least, reach)


def is_near(b: Bounds, vertex: int) -> bool:
    """Tell whether a vertex is near something."""
    return bool(b.start[vertex] < b.start[vertex + 1])


def renewed(
    b: Bounds, vertices: list[int], x: Floats, v: Floats, closest: Floats, soft: Bools, dt: float
) -> Bounds:
    """Return the bounds of some vertices where things are now, with new planes for those they have come near to.

    A plane holds until it is replaced, wherever the two have gone meanwhile on their sides of it: so what has moved
    along its planes, or together with what is beyond them, keeps them. The new one stands between the nearest points of
    two that are apart, so each is on its side of that too.

    Args:
        vertices: that have used their way.
        x, v: (n, 3) positions [m] and velocities [m/s].
        closest: (n,) nearer than this [m], nothing goes nearer still.
        soft: (n,) whether each vertex is of a body. What is stiff goes far in a substep: its planes are all set anew.
        dt: the substep [s].
    """
    rows = np.unique(np.concatenate([_spent(b, i, x[i], soft, dt * float(np.linalg.norm(v[i]))) for i in vertices]))
    at, ones = b.pairs.at[rows], b.pairs.ones[rows]
    some = planes_between(x, v, at, ones, closest[at].max(axis=1), soft[at])
    changed = {}
    for name in ("normal", "level", "keep"):
        changed[name] = getattr(b.pairs, name).copy()
        changed[name][rows] = getattr(some, name)
    b = replace(b, pairs=replace(b.pairs, **changed), since=b.since.copy(), roam=b.roam.copy(), anew=b.anew.copy())
    b.anew[rows] = True
    for vertex in np.union1d(at, vertices).tolist():
        gone, left = float(np.linalg.norm(x[vertex] - b.before[vertex])), _left(b, vertex, x[vertex])
        b.since[vertex], b.roam[vertex] = x[vertex], min(b.slack[vertex] - gone, left.min())
    return b


def beyond(b: Bounds, x: Floats) -> Bools:
    """Return which vertices at x (n, 3) have gone so far that their planes must be looked at, (n,)."""
    way = x - b.since
    far: Bools = np.einsum("nc,nc->n", way, way) > np.where(b.roam > 0, (b.roam / 2) ** 2, -1.0)
    return far


def is_allowed(b: Bounds, vertex: int, x: Floats) -> bool:
    """Tell whether a vertex may be at x (3,)."""
    if not float(np.linalg.norm(x - b.before[vertex])) <= b.slack[vertex]:
        return False
    return bool((_left(b, vertex, x) >= 0).all())


def hold_back(b: Bounds, vertex: int, x: Floats, last: Floats) -> Floats:
    """Return where a vertex that goes from last to x, both (3,), may be: on its planes, else so far back on its way."""
    most, before = b.slack[vertex] * (1 - ROUNDING), b.before[vertex]
    x = _shortened(before, x, most)
    planes, pairs = _planes(b, vertex), b.pairs
    sign = np.where(b.corners[b.start[vertex] : b.start[vertex + 1]] < pairs.ones[planes], 1.0, -1.0)
    for _ in range(TRIES):
        moved = False
        for plane, way, keep in zip(planes, sign, _kept(b, vertex), strict=True):
            short = keep * (1 + ROUNDING) - way * (pairs.normal[plane] @ x - pairs.level[plane])
            if short > 0:
                x, moved = x + way * short * pairs.normal[plane], True
        if not moved:
            return x
        x = _shortened(before, x, most)
    there, here, keep = _sides(b, vertex, x), _sides(b, vertex, last), _kept(b, vertex)
    late = (there < keep) & (here > there)
    part = (here[late] - keep[late]) / (here[late] - there[late]) * (1 - ROUNDING)
    share = min(1.0, max(float(part.min(initial=1.0)), 0.0))
    x = last + share * (x - last)
    return x if is_allowed(b, vertex, x) else last.copy()


def _planes(b: Bounds, vertex: int) -> Ints:
    return b.rows[b.start[vertex] : b.start[vertex + 1]]


def _spent(b: Bounds, vertex: int, x: Floats, soft: Bools, stride: float) -> Ints:
    """Return the planes that are due to be set anew for a vertex at x (3,) that goes a stride [m] in a substep."""
    planes, ways, gone = _planes(b, vertex), _ways(b, vertex), float(np.linalg.norm(x - b.before[vertex]))
    near = _sides(b, vertex, x) * (1 - BOUND) < b.pairs.keep[planes].mean(axis=1) / 2
    used = np.where(stride > QUICK * ways, gone, ways - _left(b, vertex, x))
    near = np.where(b.anew[planes], near, used > ways / 4)
    spent: Ints = planes[near | ~soft[b.pairs.at[planes]].all(axis=1)]
    return spent


def _ways(b: Bounds, vertex: int) -> Floats:
    """Return how far the vertex could go towards each of its planes at the query [m]."""
    planes, corners = _planes(b, vertex), b.corners[b.start[vertex] : b.start[vertex + 1]]
    ways: Floats = b.pairs.way[planes, (corners >= b.pairs.ones[planes]).astype(np.int64)]
    return ways


def _kept(b: Bounds, vertex: int) -> Floats:
    """Return how far the vertex must stay on its own side of each of its planes [m]."""
    planes, corners = _planes(b, vertex), b.corners[b.start[vertex] : b.start[vertex + 1]]
    kept: Floats = b.pairs.keep[planes, (corners >= b.pairs.ones[planes]).astype(np.int64)]
    return kept


def _sides(b: Bounds, vertex: int, x: Floats) -> Floats:
    """Return how far x (3,) is on the vertex's own side of each of its planes [m]."""
    planes = _planes(b, vertex)
    along = b.pairs.normal[planes] @ x - b.pairs.level[planes]
    return np.where(b.corners[b.start[vertex] : b.start[vertex + 1]] < b.pairs.ones[planes], along, -along)


def _left(b: Bounds, vertex: int, x: Floats) -> Floats:
    """Return how far x (3,) is from what each of the vertex's planes lets it reach [m], below 0 beyond that."""
    left: Floats = _sides(b, vertex, x) - _kept(b, vertex)
    return left


def _shortened(before: Floats, x: Floats, most: float) -> Floats:
    way = x - before
    length = float(np.linalg.norm(way))
    return before + way * (most / length) if length > most else x
