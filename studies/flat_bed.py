"""A round tip on a flat membrane on a bed, in one dimension: how near any law of the bed comes to a measured curve.

Around the axis of the press w(r) obeys T (r w')' / r = g(w) outside the contact and lies on the sphere inside it; all
depths are solved at once by an active set. No mesh, no friction, no sideways motion: what is missed here is missed for
want of freedom in the law, and what a body on a mesh misses beyond it is the mesh's.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from core.base import Bools, Floats
from core.body.estimate import estimate
from core.calibration.inversion import DEPTHS, LEAST, LIGHT, TINY, piece_ends
from core.calibration.least_squares import bounded
from core.material import Indenter, Material

NODES, SWEEPS, ROUNDS = 100, 16, 60
DAMPED, MORE, LESS = 0.01, 4.0, 0.5  # as in `inversion`; nothing scatters here
FAR = 8.0  # spreads beyond the contact: the dent has ended


def least_missed(material: Material, indenter: Indenter, size: float, deepest: float, steepest: float) -> float:
    """Return the RMS error over full scale of the best law of a bed.

    Args:
        material: as measured with the indenter.
        size: of the body [m].
        deepest: depth [m] down to which the law holds.
        steepest: slope that it may have, times that of the closed form.
    """
    first = estimate(replace(material, indenter=indenter, constants=None), size)
    tension, ends = first.kappa1 * material.spread**2, piece_ends(material.x0, deepest)
    depths = deepest * np.arange(1, DEPTHS + 1) / DEPTHS
    wanted = np.array([material.law(depth) for depth in depths.tolist()])
    weighs = np.sqrt(wanted.max() * (LIGHT * wanted.max() + wanted))
    slopes = np.minimum(np.where(ends <= material.x0, first.kappa1, first.kappa2), max(steepest, 1.0) * first.kappa1)
    best, damped = None, DAMPED
    least = np.where(ends == ends[0], LEAST, TINY) * first.kappa1
    for _ in range(SWEEPS):
        force, gains = pressed(indenter.radius, material.spread, depths, tension, ends, slopes)
        off = (force - wanted) / weighs
        if best is None or off @ off < best[0] @ best[0]:
            best, damped = (off, slopes, gains, force), damped * LESS
        else:
            damped *= MORE
        off, at, gains, _ = best
        scale = first.kappa1 + at
        low, high = (least - at) / scale, (max(steepest, 1.0) * first.kappa1 - at) / scale
        slopes = at + scale * bounded(gains / weighs[:, None] * scale, -off, low, np.maximum(low, high), damped)
    assert best
    return float(np.sqrt((((best[3] - wanted) / wanted.max()) ** 2).mean()))


def pressed(
    radius: float, spread: float, depths: Floats, tension: float, ends: Floats, slopes: Floats
) -> tuple[Floats, Floats]:
    """Return the force (k,) [N] at each depth, and its derivative by each slope (k, m) [m3]."""
    r = _nodes(radius, spread, float(depths.max()))
    middle = (r[1:] + r[:-1]) / 2
    pull = 2 * np.pi * tension * middle / np.diff(r)
    area = np.pi * np.diff(np.concatenate([[0], middle, r[-1:]]) ** 2)
    within = np.minimum(r, radius)
    tip = np.where(r < radius, depths[:, None] - radius + np.sqrt(radius**2 - within**2), -1.0)
    met = np.append(pull, 0) + np.append(0, pull)
    starts, width = np.append(0, ends[:-1]), np.append(np.diff(ends, prepend=0)[:-1], 1e9)
    w, touching = np.maximum(tip, 0), tip > 0.3 * depths[:, None]
    for _ in range(ROUNDS):
        reached = np.clip(w[..., None] - starts, 0, width)
        slope = slopes[np.minimum(np.searchsorted(ends, w), len(slopes) - 1)]
        right = np.where(touching, tip, area * (slope * w - reached @ slopes))
        now = _tridiagonal(np.where(touching, 1.0, met + area * slope), pull, touching, right)
        now = np.maximum(now, 0)
        force = met * now + area * (np.clip(now[..., None] - starts, 0, width) @ slopes)
        force[:, :-1] -= pull * now[:, 1:]
        force[:, 1:] -= pull * now[:, :-1]
        then, before = np.where(touching, force > 0, now < tip), w
        same, w, touching = np.array_equal(then, touching), now, then
        if same and np.abs(now - before).max() < 1e-7:
            break
    # a unit more of depth moves the membrane by p; dF/ds is what the bed gains in it
    p = _tridiagonal(np.where(touching, 1.0, met + area * slope), pull, touching, touching.astype(float))
    gains = np.einsum("kn,knm->km", p * area, np.clip(w[..., None] - starts, 0, width))
    return (force * touching).sum(axis=1), gains


def _nodes(radius: float, spread: float, deepest: float) -> Floats:
    inner = 1.3 * min(radius, np.sqrt(2 * radius * deepest))
    half = NODES // 2
    beyond = inner + FAR * spread * np.linspace(0, 1, NODES - half + 1)[1:] ** 1.6
    return np.concatenate([np.linspace(0, inner, half), beyond])


def _tridiagonal(diagonal: Floats, pull: Floats, fixed: Bools, right: Floats) -> Floats:
    """Solve the rows (k, n) whose neighbours pull (n - 1,), where they are not fixed. Source: Thomas."""
    lower, upper = np.where(fixed[:, 1:], 0, -pull), np.where(fixed[:, :-1], 0, -pull)
    d, q = diagonal.copy(), right.copy()
    for i in range(1, d.shape[1]):
        share = lower[:, i - 1] / d[:, i - 1]
        d[:, i] -= share * upper[:, i - 1]
        q[:, i] -= share * q[:, i - 1]
    x = q / d
    for i in range(d.shape[1] - 2, -1, -1):
        x[:, i] = (q[:, i] - upper[:, i] * x[:, i + 1]) / d[:, i]
    return x
