"""Who is near whom: a vertex and a face, or two edges, with a plane between them that neither passes.

A query finds every pair nearer than a reach. Until the next one each of a pair stays on its side of the plane between
their nearest points, and no vertex goes farther than half the reach: so nothing passes through anything, whatever the
forces. The plane beside a collider or a prop moves with it. Source: the displacement bounds of offset geometric contact
(Chen et al. 2025), with planes in place of spheres, so that what slides along or goes away is not stopped.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from core.base import Bools, Floats, Ints

from .constants import BOUND, FLAT, ROUNDING, SHARP


@dataclass(frozen=True, slots=True, kw_only=True)
class Surfaces:
    """Surfaces one after the other, first the bodies, then the colliders.

    of_vertex: (n,) the surface of each vertex.
    corners: (t, 3) vertices of the triangles.
    edges: (e, 2) their edges, lower vertex first.
    edges_of: (t, 3) edges of each triangle; k goes from corner k to the next.
    across: (e, 2) the third corner of the faces beside each edge, -1 on a border.
    ring_start, ring: neighbours of each vertex.
    rest: (n, 3) positions at rest [m].
    edge: (k,) mean length of the edges of each surface [m].
    """

    of_vertex: Ints
    corners: Ints
    edges: Ints
    edges_of: Ints
    across: Ints
    ring_start: Ints
    ring: Ints
    rest: Floats
    edge: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Pairs:
    """What is near each other.

    at: (m, 4) a vertex and the corners of a face, or the ends of two edges.
    ones: (m,) how many of them lie on the side of the normal: 1 or 2.
    part: (m, 2) the triangle of the face, or both edges.
    rigid: (m, 2) which of the two is of a collider or a prop.
    normal: (m, 3) unit, towards the first.
    level: (m,) they keep apart by normal . x = level,
    keep: (m,) each soft one by at least this [m].
    gap: (m,) their distance [m].
    weight: (m,) of what they do: fades where edges are flat.
    """

    at: Ints
    ones: Ints
    part: Ints
    rigid: Bools
    normal: Floats
    level: Floats
    keep: Floats
    gap: Floats
    weight: Floats


def join_surfaces(positions: list[Floats], triangles: list[Ints]) -> Surfaces:
    """Join surfaces with rest positions (n, 3) [m] and triangles (t, 3) of each."""
    starts = np.cumsum([0, *map(len, positions)])
    of_vertex = np.repeat(np.arange(len(positions)), [len(x) for x in positions])
    corners = np.concatenate([t + start for t, start in zip(triangles, starts, strict=False)]).astype(np.int64)
    rest = np.concatenate(positions)
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, inverse = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    inverse = inverse.ravel()
    across = np.full((len(edges), 2), -1)
    opposite = np.roll(corners, -2, axis=1).ravel()
    across[inverse[::-1], 0] = opposite[::-1]  # the first of them
    second = opposite != across[inverse, 0]
    across[inverse[second], 1] = opposite[second]
    both = np.concatenate([edges, edges[:, ::-1]])
    order = np.argsort(both[:, 0], kind="stable")
    lengths = np.linalg.norm(rest[edges[:, 0]] - rest[edges[:, 1]], axis=1)
    owner = of_vertex[edges[:, 0]]
    count = np.bincount(owner, minlength=len(positions))
    return Surfaces(
        of_vertex=of_vertex, corners=corners, edges=edges, edges_of=inverse.reshape(-1, 3), across=across,
        ring_start=np.searchsorted(both[order, 0], np.arange(len(rest) + 1)), ring=both[order, 1], rest=rest,
        edge=np.bincount(owner, weights=lengths, minlength=len(positions)) / np.maximum(count, 1),
    )  # fmt: skip


def shares_on_edges(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Return how far along segments ab and cd, all (m, 3), their nearest points lie, (m, 2). Source: Ericson, 5.1.9."""
    u, v, r = b - a, d - c, a - c
    uu, vv, uv, ur, vr = _dot(u, u), _dot(v, v), _dot(u, v), _dot(u, r), _dot(v, r)
    spread = uu * vv - uv * uv
    with np.errstate(all="ignore"):
        s = np.where(spread > 1e-12 * uu * vv, np.clip((uv * vr - ur * vv) / spread, 0, 1), 0.0)
        t = np.where(vv > 0, (uv * s + vr) / vv, 0.0)
        outside = (t < 0) | (t > 1)
        t = np.clip(t, 0, 1)
        s = np.where(outside, np.where(uu > 0, np.clip((uv * t - ur) / uu, 0, 1), 0.0), s)
    return np.stack([s, t], axis=1)


def measure(x: Floats, ones: Ints) -> tuple[Floats, Floats, Floats]:
    """Measure pairs at positions x (m, 4, 3) [m].

    Returns:
        the signed weights (m, 4) of the vertices at their nearest points, the vector between these (m, 3) towards the
        first, and its length (m,) [m].
    """
    face, edge = ones == 1, ones == 2
    w = np.empty((len(x), 4))
    w[face, 0] = 1
    w[face, 1:] = -weights_on_face(*(x[face, k] for k in range(4)))
    along = shares_on_edges(*(x[edge, k] for k in range(4)))
    w[edge, 0], w[edge, 1], w[edge, 2], w[edge, 3] = 1 - along[:, 0], along[:, 0], along[:, 1] - 1, -along[:, 1]
    between = np.einsum("mk,mkc->mc", w, x)
    return w, between, np.sqrt(_dot(between, between))


def find_pairs(
    s: Surfaces, x: Floats, first: int, second: int, *, reach: float, closest: float, bodies: int | None = None
) -> Pairs:
    """Find what of two surfaces, or of one, is nearer than a reach [m] at positions x (n, 3) [m].

    Args:
        closest: nearer than this [m], nothing goes nearer still.
        bodies: how many of the surfaces are soft, None where all are.
    """
    low = np.maximum(_box(x, s, first)[0], _box(x, s, second)[0]) - reach
    high = np.minimum(_box(x, s, first)[1], _box(x, s, second)[1]) + reach
    at, part = [np.zeros((0, 4), np.int64)], [np.zeros((0, 2), np.int64)]
    ones = [np.zeros(0, np.int64)]
    for one, other in [(first, second), (second, first)][: 1 if first == second else 2]:
        vertices = np.flatnonzero((s.of_vertex == one) & _within(x[:, None], low, high))
        vertices = vertices[np.isin(vertices, s.corners)]
        faces = np.flatnonzero((s.of_vertex[s.corners[:, 0]] == other) & _within(x[s.corners], low, high))
        i, j = near_boxes(x[vertices][:, None], x[s.corners[faces]], reach)
        i, j = vertices[i], faces[j]
        apart = (s.corners[j] != i[:, None]).all(axis=1)
        i, j = i[apart], j[apart]
        at.append(np.column_stack([i, s.corners[j]]))
        part.append(np.column_stack([j, j]))
        ones.append(np.ones(len(i), np.int64))
    inside = _within(x[s.edges], low, high)
    owner = s.of_vertex[s.edges[:, 0]]
    e, f = (np.flatnonzero(inside & (owner == which)) for which in (first, second))
    i, j = near_boxes(x[s.edges[e]], x[s.edges[f]], reach)
    i, j = e[i], f[j]
    apart = (s.edges[i][:, :, None] != s.edges[j][:, None]).all(axis=(1, 2)) & ((first != second) | (i < j))
    i, j = i[apart], j[apart]
    at.append(np.column_stack([s.edges[i], s.edges[j]]))
    part.append(np.column_stack([i, j]))
    ones.append(np.full(len(i), 2))
    return _with_planes(s, x, np.concatenate(at), np.concatenate(ones), np.concatenate(part), reach, closest, bodies)


def touching_distance(s: Surfaces, pairs: Pairs, offsets: Floats, skins: Floats, bodies: int) -> Floats:
    """Return the distance (m,) [m] at which pairs touch; a body touches itself only where it was apart at rest.

    Args:
        offsets, skins: (k,) that surfaces keep from soft bodies, and from what does not give [m].
        bodies: how many of the surfaces are soft.
    """
    a, b = s.of_vertex[pairs.at[:, 0]], s.of_vertex[pairs.at[:, 3]]
    touch = np.where((a < bodies) | (b < bodies), offsets[a] + offsets[b], skins[a] + skins[b])
    same = a == b
    touch[same] = np.minimum(touch[same], measure(s.rest[pairs.at[same]], pairs.ones[same])[2] / 2)
    return touch


class Planes(NamedTuple):
    """Planes between the nearest points of pairs: what `Pairs` says of them; and those points, (m, 3) [m]."""

    normal: Floats
    level: Floats
    keep: Floats
    gap: Floats
    weights: Floats
    first: Floats
    second: Floats


def planes_between(x: Floats, at: Ints, ones: Ints, closest: Floats, rigid: Bools) -> Planes:
    """Return the planes between pairs at (m, 4).

    Two that are soft have half of their distance each; beside what is rigid, one has all of it.

    Args:
        x: (n, 3) positions [m].
        ones: (m,) how many of the vertices lie on the side of the normal.
        closest: (m,) nearer than this [m], nothing goes nearer still.
        rigid: (m, 2) which of the two is rigid.
    """
    w, between, gap = measure(x[at], ones)
    normal = between / np.maximum(gap, 1e-300)[:, None]
    side = np.arange(4) < ones[:, None]
    point = np.einsum("mk,mkc->mc", np.where(side, w, 0), x[at])
    other = point - between
    whole = np.where(rigid.any(axis=1), gap, gap / 2)
    least = np.minimum(whole, closest) / 2
    keep = np.where(gap > closest, least + (1 - BOUND) * (whole - least), whole * (1 - ROUNDING))
    return Planes(normal, _dot(normal, other + between / 2), keep, gap, w, point, other)


def _with_planes(
    s: Surfaces, x: Floats, at: Ints, ones: Ints, part: Ints, reach: float, closest: float, bodies: int | None
) -> Pairs:
    near = measure(x[at], ones)[2] < reach
    at, ones, part = at[near], ones[near], part[near]
    rigid = np.asarray(s.of_vertex[at[:, [0, 3]]] >= (len(s.edge) if bodies is None else bodies))
    planes = planes_between(x, at, ones, np.full(len(at), closest), rigid)
    weight = np.ones(len(at))
    edge = np.flatnonzero(ones == 2)
    weight[edge] = (np.abs(planes.weights[edge]) > 0).all(axis=1)
    stiff = np.asarray(rigid[edge].any(axis=1))
    for k, points, sign in ((0, planes.first, -1), (1, planes.second, 1)):
        sharp = _sharpness(s, x, part[edge, k], points[edge], sign * planes.normal[edge], stiff)
        # what is rigid and sharp presses skin that is flat, or folded round it
        weight[edge] *= np.where(stiff & ~rigid[edge, k], 1.0, sharp)
    return Pairs(
        at=at, ones=ones, part=part, rigid=rigid, normal=planes.normal, level=planes.level, keep=planes.keep,
        gap=planes.gap, weight=weight,
    )  # fmt: skip


def _sharpness(s: Surfaces, x: Floats, edges: Ints, points: Floats, normals: Floats, rigid: Bools) -> Floats:
    """Return how much edges stick out in a direction: 1 where the faces beside fall away, 0 where they are flat.

    Of what is rigid and coarse, one of them may be flat: two bars that lie crosswise touch nowhere else.
    """
    least, most, flat = np.ones(len(edges)), np.zeros(len(edges)), np.ones(len(edges))
    for side in range(2):
        across = s.across[edges, side]
        arm = x[across] - points
        slope = -_dot(arm, normals) / np.maximum(np.sqrt(_dot(arm, arm)), 1e-300)
        sharp = np.clip((slope - FLAT) / (SHARP - FLAT), 0, 1)
        rises = np.clip((slope + SHARP) / (SHARP - FLAT), 0, 1)
        least = np.where(across < 0, least, np.minimum(least, sharp))
        flat = np.where(across < 0, flat, np.minimum(flat, rises))
        most = np.where(across < 0, 1.0, np.maximum(most, sharp))
    return np.where(rigid, most * flat, least)


def near_boxes(a: Floats, b: Floats, reach: float) -> tuple[Ints, Ints]:
    """Return which boxes round point sets a (m, i, 3) and b (n, j, 3) are nearer than a reach."""
    found: list[Ints] = []
    low, high = b.min(axis=1, initial=np.inf), b.max(axis=1, initial=-np.inf)
    for start in range(0, len(a), 256):
        some = a[start : start + 256]
        lower, higher = some.min(axis=1)[:, None], some.max(axis=1)[:, None]
        near = ((low - higher < reach) & (lower - high < reach)).all(axis=2)
        i, j = np.nonzero(near)
        found.append(np.stack([i + start, j]))
    if not found:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    i, j = np.concatenate(found, axis=1)
    return i, j


def _box(x: Floats, s: Surfaces, which: int) -> tuple[Floats, Floats]:
    mine = x[s.of_vertex == which]
    return mine.min(axis=0), mine.max(axis=0)


def _within(x: Floats, low: Floats, high: Floats) -> Bools:
    """Return whether the boxes round point sets x (m, k, 3) meet a box."""
    inside: npt.NDArray[np.bool_] = ((x.min(axis=1) <= high) & (x.max(axis=1) >= low)).all(axis=1)
    return inside


def _dot(a: Floats, b: Floats) -> Floats:
    return np.einsum("mc,mc->m", a, b)


def weights_on_face(p: Floats, a: Floats, b: Floats, c: Floats) -> Floats:
    """Return the weights (m, 3) of the points of triangles nearest to p, all (m, 3).

    Source: Ericson, Real-Time Collision Detection, 5.1.5.
    """
    d1, d2 = _dot(b - a, p - a), _dot(c - a, p - a)
    d3, d4 = _dot(b - a, p - b), _dot(c - a, p - b)
    d5, d6 = _dot(b - a, p - c), _dot(c - a, p - c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    zero, one = np.zeros_like(va), np.ones_like(va)
    cases = [
        (d1 <= 0) & (d2 <= 0), (d3 >= 0) & (d4 <= d3), (d6 >= 0) & (d5 <= d6), (vc <= 0) & (d1 >= 0) & (d3 <= 0),
        (vb <= 0) & (d2 >= 0) & (d6 <= 0), (va <= 0) & (d4 >= d3) & (d5 >= d6),
    ]  # fmt: skip
    with np.errstate(all="ignore"):
        on_bc = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = np.select(cases, [zero, one, zero, d1 / (d1 - d3), zero, 1 - on_bc], vb / (va + vb + vc))
        u = np.select(cases, [zero, zero, one, zero, d2 / (d2 - d6), on_bc], vc / (va + vb + vc))
    return np.stack([1 - v - u, v, u], axis=1)
