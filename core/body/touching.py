"""What touches pushes back: a stiff penalty with Coulomb friction in each substep.

For a pair at distance d < r, with relative speed u along its normal, and an impulse j whose effect is within the
substep h already: d' = d + h j g, u' = u + j g, where g is what the pair gives, 1/mass. From

    j = h (k (r - d') - c u'),   k = K / (h^2 g) r / d,   c = C / (h g)

follows j = (K r/d (r - d) / h - C u) / ((1 + K r/d + C) g): stable for any K, and the harder the nearer. It leaves the
pair no faster apart than r/d (r - d) in 5 ms: so what starts too near is not flung off. A vertex in
several pairs is shared between them, each taking an equal part of its mass, so pairs are independent.
"""

from __future__ import annotations

import numpy as np

from ..base import Bools, Floats, Ints, sums_at
from .contact import WEIGHT_FLOOR
from .proximity import Pairs, Surfaces, measure

STIFFNESS = 1.0  # of the mass over the substep squared, at the surface; grows as 1 / distance
DAMPING = 0.5  # of the mass over the substep
PART_TIME = 5e-3  # [s] in which what is too near parts at the soonest
LEAST_GAP = 0.02  # of the touching distance: the stiffness grows no further


def resolve(
    s: Surfaces, pairs: Pairs, touch: Floats, friction: Floats, x: Floats, v: Floats, inverse_mass: Floats, dt: float
) -> tuple[Floats, Floats, int]:
    """Return by how much what touches changes velocities, (n, 3) [m/s].

    Args:
        pairs: that may touch.
        touch: (m,) the distance at which they do [m].
        friction: (n,) coefficient of each vertex.
        x, v: (n, 3) positions [m] and velocities [m/s].
        inverse_mass: (n,) [1/kg], 0 where something is led.
        dt: the substep [s].

    Returns:
        them, the impulses (k, 3) [N s] that each surface got and (k, 3) [N m s] their moments about the origin, side by
        side, and how many pairs touch.
    """
    w, between, gap = measure(x[pairs.at], pairs.ones)
    meets = (gap < touch) & (gap > 0)
    meets &= np.where(pairs.ones == 1, True, (np.abs(w) > 0).all(axis=1))
    for row in np.flatnonzero(meets & (pairs.ones == 1) & (w == 0).any(axis=1)):
        meets[row] = _is_nearest(s, x, int(pairs.part[row, 0]), w[row], x[pairs.at[row, 0]], between[row])
    at, w, gap, touch = pairs.at[meets], w[meets], gap[meets], touch[meets]
    normal, weight = between[meets] / gap[:, None], pairs.weight[meets]
    used = (np.abs(w) > WEIGHT_FLOOR).astype(np.float64)
    shares = sums_at(at.ravel(), used.ravel(), len(x))
    give = (w * w * inverse_mass[at] * shares[at]).sum(axis=1)
    moves = give > 0
    give = np.where(moves, give, 1.0)
    u = np.einsum("mk,mkc->mc", w, v[at])
    along = np.einsum("mc,mc->m", u, normal)
    hard = STIFFNESS * touch / np.maximum(gap, LEAST_GAP * touch)
    apart = hard / STIFFNESS * (touch - gap) / PART_TIME
    push = (hard * (touch - gap) / dt - DAMPING * along) / ((1 + hard + DAMPING) * give)
    push = np.clip(push, 0, np.maximum((apart - along) / give, 0)) * weight * moves
    u = u - along[:, None] * normal
    slide = np.sqrt(np.einsum("mc,mc->m", u, u))
    drag = np.minimum(_friction(pairs, at, w, friction, meets) * push, weight * moves * slide / give)
    impulse = push[:, None] * normal - (drag / np.maximum(slide, 1e-300))[:, None] * u
    parts = w[:, :, None] * impulse[:, None]
    change = np.stack([sums_at(at.ravel(), parts[..., c].ravel(), len(x)) for c in range(3)], axis=1)
    change *= inverse_mass[:, None]
    count = int(s.of_vertex[-1]) + 1
    side = np.arange(4) < pairs.ones[meets][:, None]
    point = np.einsum("mk,mkc->mc", w * side, x[at])
    given = np.concatenate([impulse, np.cross(point, impulse)], axis=1)
    got = np.zeros((count, 6))
    np.add.at(got, s.of_vertex[at[:, 0]], given)
    np.subtract.at(got, s.of_vertex[at[:, 3]], given)
    return change, got, int(meets.sum())


def _friction(pairs: Pairs, at: Ints, w: Floats, friction: Floats, meets: Bools) -> Floats:
    """Return the geometric mean of the coefficients of both sides, (m,)."""
    side = np.arange(4) < pairs.ones[meets][:, None]
    mu = np.abs(w) * friction[at]
    mean: Floats = np.sqrt((mu * side).sum(axis=1) * (mu * ~side).sum(axis=1))
    return mean


def _is_nearest(s: Surfaces, x: Floats, triangle: int, w: Floats, vertex: Floats, between: Floats) -> bool:
    """Tell whether the nearest point of a face is that of the surface round it: else a face beside it has a pair."""
    point, on = vertex - between, np.flatnonzero(w[1:] < 0)
    corners = s.corners[triangle]
    if len(on) == 2:
        off = 3 - int(on.sum())
        both = s.across[s.edges_of[triangle, (off + 1) % 3]]
        others = both[(both != corners[off]) & (both >= 0)]
    else:
        corner = int(corners[on[0]])
        others = s.ring[s.ring_start[corner] : s.ring_start[corner + 1]]
    return not bool(((x[others] - point) @ between > 0).any())
