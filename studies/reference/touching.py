"""What touches: in each substep, impulses that let nothing go nearer than the distance at which it touches, with
Coulomb friction; and what is nearer all the same is brought apart, without a speed.

For a pair at distance d (r: where it touches), with relative speed u along its normal, and g = 1 / mass of the two:

    j = max(0, (w - u) / g)   with   w = -(d - r) / h where d > r, and 0 where it is nearer

so that after the substep h it is not nearer than r, or no nearer than before. Each substep measures its nearest points
again. The pairs are resolved one after the other, ordered by their vertices, until they agree; then those still too
near are separated. What sticks goes back to where it stuck first, so that it does not creep: an anchor, which follows
where it slides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core.base import Bools, Floats, Ints

from .constants import BACK, EXACT, FLAT, PINNED_GIVE, ROUNDING, SWEEPS, TINY
from .proximity import Pairs, Surfaces, measure


@dataclass(frozen=True, slots=True, kw_only=True)
class Meetings:
    """Pairs that may touch, listed at the last look and measured as the substep began.

    at: (m, 4) their vertices.
    ones: (m,) how many of them lie on the side of the normal: 1 or 2.
    weights: (m, 4) signed, of their nearest points.
    normal: (m, 3) unit, towards the first.
    point: (m, 3) where they meet [m].
    gap: (m,) their distance [m].
    touch: (m,) at which they touch [m].
    friction: (m,) coefficient.
    give: (m,) 1 / mass [1/kg].
    most: (m,) of its lightest vertex.
    share: (m,) of what they do: fades where edges are flat.
    anchor: (m, 3) where on its way since the look it stuck last [m]; `resolve` moves it.
    """

    at: Ints
    ones: Ints
    weights: Floats
    normal: Floats
    point: Floats
    gap: Floats
    touch: Floats
    friction: Floats
    give: Floats
    most: Floats
    share: Floats
    anchor: Floats


def order_of(pairs: Pairs, s: Surfaces) -> Ints:
    """Return the order (m,) in which pairs are taken: faces first, by their vertices, each side from the lowest."""
    face = pairs.ones == 1
    keys = np.where(
        face[:, None], np.column_stack([pairs.at[:, 0], np.sort(pairs.at[:, 1:], axis=1)]),
        np.column_stack([np.sort(pairs.at[:, :2], axis=1), np.sort(pairs.at[:, 2:], axis=1)]),
    )  # fmt: skip
    swap = ~face & (s.of_vertex[pairs.at[:, 0]] == s.of_vertex[pairs.at[:, 3]]) & (keys[:, 2] < keys[:, 0])
    keys[swap] = keys[swap][:, [2, 3, 0, 1]]
    order: Ints = np.lexsort((keys[:, 3], keys[:, 2], keys[:, 1], keys[:, 0], pairs.ones))
    return order


def look(
    s: Surfaces, pairs: Pairs, touch: Floats, friction: Floats, x: Floats, inverse_mass: Floats, approach: float
) -> Meetings:
    """Return what may touch before the next look.

    Args:
        pairs: that may, in their order.
        touch: (m,) the distance at which they do [m].
        friction: (n,) coefficient of each vertex.
        x: (n, 3) positions [m].
        inverse_mass: (n,) [1/kg], 0 where something is led.
        approach: how much farther than they touch they are looked at [m].
    """
    w, between, gap = measure(x[pairs.at], pairs.ones)
    may = (gap < touch + approach) & (gap > 0) & inverse_mass[pairs.at].any(axis=1)
    may &= np.where(pairs.ones == 1, True, (np.abs(w) > 0).all(axis=1))
    share = pairs.weight.copy()
    for row in np.flatnonzero(may & (pairs.ones == 1) & (w[:, 1:] > -EXACT).any(axis=1)):
        vertex = int(pairs.at[row, 0])
        if _is_nearest(s, x, int(pairs.part[row, 0]), w[row], x[vertex], between[row]):
            share[row] = _share_of_border(s, x, vertex, between[row] / gap[row])
        else:
            share[row] = 0.0
    may &= share > 0
    at, ones, anchor = pairs.at[may], pairs.ones[may], np.zeros((int(may.sum()), 3))
    side = np.arange(4) < ones[:, None]
    mu = np.abs(w[may]) * friction[at]
    return _measured(
        at, ones, x, inverse_mass, touch=touch[may], share=share[may], anchor=anchor,
        friction=np.sqrt((mu * side).sum(axis=1) * (mu * ~side).sum(axis=1)),
    )  # fmt: skip


def measured(m: Meetings, x: Floats, inverse_mass: Floats) -> Meetings:
    """Return meetings with the nearest points, the normals and the distances that they have at x (n, 3) [m]."""
    return _measured(
        m.at, m.ones, x, inverse_mass, touch=m.touch, share=m.share, anchor=m.anchor, friction=m.friction
    )


def _measured(at: Ints, ones: Ints, x: Floats, inverse_mass: Floats, **others: Floats) -> Meetings:
    w, between, gap = measure(x[at], ones)
    return Meetings(
        at=at, ones=ones, weights=w, normal=between / (gap[:, None] + TINY), gap=gap,
        point=np.einsum("mk,mkc->mc", w * (np.arange(4) < ones[:, None]), x[at]),
        give=(w * w * inverse_mass[at]).sum(axis=1), most=inverse_mass[at].max(axis=1, initial=0.0), **others,
    )  # fmt: skip


def resolve(
    m: Meetings, way: Floats, v: Floats, inverse_mass: Floats, dt: float, sleeps: Bools, touch: float
) -> tuple[Floats, Floats, Floats, Ints]:
    """Return what comes of a substep in which pairs touch.

    Args:
        way: (n, 3) of the vertices since the look, as the substep began [m].
        v: (n, 3) velocities [m/s] of the substep.
        inverse_mass: (n,) [1/kg].
        dt: the substep [s].
        sleeps: (m,) whether a side of a meeting does: then both are at rest.
        touch: greatest distance at which anything touches [m].

    Returns:
        velocities (n, 3) [m/s], by how much vertices are brought apart (n, 3) [m], the impulse that each meeting gave
        its first side (m, 3) [N s], and which of them touched.
    """
    v, out, passed = v.copy(), np.zeros_like(v), np.zeros((len(m.gap), 3))
    # the distance as the substep began, the least speed apart, and how fast it is to go back to where it stuck
    active: dict[int, tuple[float, float, Floats]] = {}
    for k in np.flatnonzero(~sleeps).tolist():
        along = m.weights[k] @ way[m.at[k]]
        begin, slid = float(m.gap[k]), along - m.anchor[k]
        if begin + dt * float(m.normal[k] @ (m.weights[k] @ v[m.at[k]])) < m.touch[k]:
            back = BACK / dt * (slid - (m.normal[k] @ slid) * m.normal[k])
            active[k] = begin, min(0.0, (float(m.touch[k]) - begin) / dt), back
            _push(m, k, *active[k][1:], passed, v, inverse_mass)
        else:
            m.anchor[k] = along
    for _ in range(SWEEPS):
        most = max((_push(m, k, *of[1:], passed, v, inverse_mass) for k, of in active.items()), default=0.0)
        if not most > BACK * touch / dt:
            break
    for k, (begin, _, back) in active.items():
        gap = begin + float(m.normal[k] @ (m.weights[k] @ (dt * v[m.at[k]] + out[m.at[k]])))
        by = BACK * max(float(m.touch[k]) - gap, 0.0) * _share_over_give(m, k)
        out[m.at[k]] += (by * m.weights[k] * inverse_mass[m.at[k]])[:, None] * m.normal[k]
        push = float(passed[k] @ m.normal[k])
        if np.linalg.norm(passed[k] - push * m.normal[k]) >= float(m.friction[k]) * push * (1 - ROUNDING):
            m.anchor[k] += dt / BACK * back
    return v, out, passed, np.array(list(active), np.int64)


def _share_over_give(m: Meetings, k: int) -> float:
    return float(m.share[k] / max(m.give[k], PINNED_GIVE * m.most[k])) if m.give[k] > 0 else 0.0


def _push(m: Meetings, k: int, least: float, back: Floats, passed: Floats, v: Floats, inverse_mass: Floats) -> float:
    """Add to the impulse of a meeting so much that it goes no nearer than it may, and slides as friction lets it.

    Return by how much that changes its relative velocity [m/s].
    """
    at, w, normal = m.at[k], m.weights[k], m.normal[k]
    u, by = w @ v[at], _share_over_give(m, k)
    along, before = float(u @ normal), float(passed[k] @ normal)
    push = max(before + by * (least - along), 0.0)
    drag = passed[k] - before * normal - by * (u - along * normal + back)
    size, most = float(np.linalg.norm(drag)), float(m.friction[k]) * push
    impulse = push * normal + (drag * (most / size) if size > most else drag)
    v[at] += (w * inverse_mass[at])[:, None] * (impulse - passed[k])
    changed, passed[k] = float(m.give[k] * np.linalg.norm(impulse - passed[k])), impulse
    return changed


def _is_nearest(s: Surfaces, x: Floats, triangle: int, w: Floats, vertex: Floats, between: Floats) -> bool:
    """Tell whether the nearest point of a face is that of the surface round it: else a face beside it has a pair."""
    point, on = vertex - between, np.flatnonzero(w[1:] < -EXACT)
    corners = s.corners[triangle]
    if len(on) == 2:
        off = 3 - int(on.sum())
        both = s.across[s.edges_of[triangle, (off + 1) % 3]]
        others = both[(both != corners[off]) & (both >= 0)]
    else:
        corner = int(corners[on[0]])
        others = s.ring[s.ring_start[corner] : s.ring_start[corner + 1]]
    return not bool(((x[others] - point) @ between > 0).any())


def _share_of_border(s: Surfaces, x: Floats, vertex: int, normal: Floats) -> float:
    """Return how much the border of a face acts on a vertex, in the direction of a normal.

    0 where the surface of the vertex runs through, from a neighbour that is nearer to one that is farther: then some
    other pair is nearer, and this one would only stop what slides. 1 where it falls away, or rises, on both sides.
    """
    arms = x[s.ring[s.ring_start[vertex] : s.ring_start[vertex + 1]]] - x[vertex]
    arms /= np.maximum(np.linalg.norm(arms, axis=1), 1e-300)[:, None]
    slopes = arms @ normal
    nearer = int(slopes.argmin())
    through = min(float(slopes[(arms @ arms[nearer]).argmin()]), -float(slopes[nearer]))
    return 1 - float(np.clip(through / FLAT, 0, 1))
