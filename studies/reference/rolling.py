"""Rolling resistance: what lies on something turns against it only by a moment above a small arm times its load.

Without it a ball rocks for a minute on its facets, as no foam or rubber does: the damping of a soft body resists its
deformation, which is slow while it rolls. A moment M acts on the body, and back on the bodies that press it,

    M = stop(kept + part L / h),   kept = stop(kept + share L / h),   |stop| <= arm x load

with L its angular momentum as it turns against them and h the substep: critically damped, so it stands still, and what
is kept then holds it there. Source: the coefficient of rolling resistance, Johnson, Contact Mechanics, 8.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from core.base import Bools, Floats, Ints

from .constants import BACK, ROLL_ARM


@dataclass(slots=True)
class Turning:
    """How a free body turns: its inertia (3, 3) [kg m2] about its centre (3,) [m], and its spin (3,) [1/s].

    inverse: (3, 3) of the inertia of its skin.
    fill: (3,) angular momentum of its fill [kg m2/s], None where it was changed.
    given: (3,) moment by which the skin turns the fill [N m].
    kept, moment: (3,) that resist it [N m]: kept from substep to substep, and in the next one, reactions included.
    """

    size: float
    inverse: Floats = field(default_factory=lambda: np.eye(3))
    fill: Floats | None = None
    given: Floats = field(default_factory=lambda: np.zeros(3))
    centre: Floats = field(default_factory=lambda: np.zeros(3))
    inertia: Floats = field(default_factory=lambda: np.eye(3))
    spin: Floats = field(default_factory=lambda: np.zeros(3))
    kept: Floats = field(default_factory=lambda: np.zeros(3))
    moment: Floats = field(default_factory=lambda: np.zeros(3))

    def measure(self, mass: Floats, x: Floats, v: Floats) -> None:
        """Note how a body (3, n) [m], [m/s] turns."""
        self.centre = x @ mass / mass.sum()
        r = x - self.centre[:, None]
        self.inertia = np.eye(3) * (mass * r * r).sum() - (mass * r) @ r.T
        self.inverse = np.linalg.pinv(self.inertia, hermitian=True)
        self.spin = self.inverse @ (np.cross(r, v, axis=0) @ mass)

    def turn_fill(self, share: Floats, dt: float) -> None:
        """Let the fill, whose momentum is such a share (3, 3) of the skin's, turn with it in a substep [s]."""
        more = share @ self.inertia
        before, self.fill, self.inertia = self.fill, more @ self.spin, self.inertia + more
        self.given = np.zeros(3) if before is None else (self.fill - before) / dt

    def acceleration(self, x: Floats) -> Floats:
        """Return what the moments take out of vertices (3, n) [m/s2]."""
        turn = self.inverse @ (self.moment + self.given)
        return np.asarray(np.cross(turn[:, None], x - self.centre[:, None], axis=0), np.float64)


def resist(bodies: Sequence[Turning | None], surfaces: Ints, pushes: Floats, dt: float, sleeps: Bools) -> None:
    """Set the moments that act in the next substep.

    Args:
        bodies: free ones; None where a surface does not turn by itself.
        surfaces: (m, 2) of what touches.
        pushes: (m,) normal impulses [N s].
        dt: the substep [s].
        sleeps: (k,) which sleep, and keep what they had.
    """
    load, beside, resisting = np.zeros(len(bodies)), np.zeros((len(bodies), 3)), {}
    for (i, j), push in zip(surfaces.tolist(), pushes.tolist(), strict=True):
        for one, other in ((i, j), (j, i)) if i != j else ():
            partner = bodies[other]
            load[one] += push
            beside[one] += 0.0 if partner is None else push * partner.spin
    for i, body in enumerate(bodies):
        if body is None or sleeps[i]:
            continue
        body.moment = np.zeros(3)
        if load[i] == 0:
            body.kept = np.zeros(3)
            continue
        stop = body.inertia @ (body.spin - beside[i] / load[i]) / dt
        most = ROLL_ARM * body.size * load[i] / dt
        resisting[i] = _limited(body.kept + BACK * stop, most)
        body.kept = _limited(body.kept + BACK**2 / 4 * stop, most)
    for i, moment in resisting.items():
        bodies[i].moment += moment  # type: ignore[union-attr]
    for (i, j), push in zip(surfaces.tolist(), pushes.tolist(), strict=True):
        for one, other in ((i, j), (j, i)) if i != j else ():
            partner = bodies[other]
            if one in resisting and partner is not None:
                partner.moment -= push / load[one] * resisting[one]


def _limited(moment: Floats, most: float) -> Floats:
    size = float(np.linalg.norm(moment))
    return moment * (most / size) if size > most else moment
