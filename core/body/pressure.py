"""The pressure of what fills the body.

    f = p dV/dx,   V = sum over faces of x_0 . (x_1 x x_2) / 6

dV/dx_i is a sixth of the sum of x_j x x_k round vertex i, so it sums to no net force and no net torque on any
closed surface. Of a gas p = (p_a + p_0) (V_0/V)^gamma - p_a, of a liquid or a solid p = p_0 + kappa (V_0 - V) / V_0.
p_0, the pressure at rest, is that of the shape at rest: with it the body swells until its skin holds it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Floats, Ints, row_parts, sums_at
from ..constants import AIR_EXPONENT, AIR_PRESSURE, LIQUID_BULK_MODULUS
from ..fills import FILLS, PressureLaw
from ..mesh.rings import Rings
from ..mesh.surface import Mesh, cap_centres
from .springs import around


@dataclass(frozen=True, slots=True, kw_only=True)
class Pressure:
    """The fill of a body.

    fill: a key of `fills.FILLS`.
    rest_volume: [m3].
    rest_pressure: above that outside, at that volume [Pa].
    rings: of the mesh.
    cap_edges: (c, 2) border edges, and cap_loop: (c,) the hole each closes.
    """

    fill: str
    rest_volume: float
    rest_pressure: float
    rings: Rings
    cap_edges: Ints
    cap_loop: Ints

    @property
    def kind(self) -> PressureLaw:
        """Return the law of its pressure."""
        return FILLS[self.fill].law


def build_pressure(mesh: Mesh, fill: str, rest_pressure: float = 0.0) -> Pressure:
    """Prepare the fill of a mesh; a sheet without an inside has none."""
    return Pressure(
        fill=fill if mesh.pressurable else "none", rest_volume=mesh.volume, rest_pressure=rest_pressure,
        rings=mesh.rings, cap_edges=mesh.cap_edges, cap_loop=mesh.cap_loop,
    )  # fmt: skip


def volume_and_gradient(law: Pressure, x: Floats, arms: Floats | None = None) -> tuple[float, Floats]:
    """Return the volume [m3] and its gradient (3, n) [m2] at positions (3, n)."""
    n = np.zeros_like(x)
    for part in row_parts(x.shape[1]) if len(law.rings.neighbours) else ():
        d = around(law.rings, x, part) if arms is None else arms[:, :, part]
        for c in range(3):
            a, b = d[(c + 1) % 3], d[(c + 2) % 3]
            n[c, part] = np.einsum("sn,sn->n", a[:-1], b[1:]) - np.einsum("sn,sn->n", b[:-1], a[1:])
            n[c, part] += a[-1] * b[0] - b[-1] * a[0]
    centre = x.mean(axis=1)
    _add_corners(law, n, x - centre[:, None])
    volume = float(np.einsum("cn,cn->", x - centre[:, None], n)) / 18
    return volume, n / 6


def volume(law: Pressure, x: Floats) -> float:
    """Return the volume [m3] at positions (3, n)."""
    return volume_and_gradient(law, x)[0]


def pressure_at(law: Pressure, volume: float) -> float:
    """Return the pressure [Pa] above that outside, at a volume [m3]."""
    if law.kind is PressureLaw.GAS:
        # a body turned inside out has no volume left: hold it at a hundredth
        squeeze = (law.rest_volume / max(volume, 0.01 * law.rest_volume)) ** AIR_EXPONENT
        return float(AIR_PRESSURE * (squeeze - 1) + law.rest_pressure * squeeze)
    if law.kind is PressureLaw.BULK:
        return LIQUID_BULK_MODULUS * (law.rest_volume - volume) / law.rest_volume + law.rest_pressure
    return 0.0


def pressure_slope(law: Pressure, volume: float) -> float:
    """Return -dp/dV [Pa/m3] at a volume."""
    if law.kind is PressureLaw.GAS:
        squeeze = law.rest_volume / max(volume, 0.01 * law.rest_volume)
        whole = AIR_PRESSURE + law.rest_pressure
        return float(AIR_EXPONENT * whole * squeeze ** (AIR_EXPONENT + 1) / law.rest_volume)
    return LIQUID_BULK_MODULUS / law.rest_volume if law.kind is PressureLaw.BULK else 0.0


def energy(law: Pressure, x: Floats) -> float:
    """Return the work [J] stored in the fill, counted from the volume at rest."""
    volume, _ = volume_and_gradient(law, x)
    if law.kind is PressureLaw.GAS:
        g, v0 = AIR_EXPONENT, law.rest_volume
        squeezed = v0 * ((v0 / volume) ** (g - 1) - 1) / (g - 1)
        return AIR_PRESSURE * (squeezed - (v0 - volume)) + law.rest_pressure * squeezed
    if law.kind is PressureLaw.BULK:
        less = law.rest_volume - volume
        return (LIQUID_BULK_MODULUS * less / (2 * law.rest_volume) + law.rest_pressure) * less
    return 0.0


def force(law: Pressure, x: Floats, arms: Floats | None = None) -> Floats:
    """Return the forces (3, n) [N]."""
    volume, gradient = volume_and_gradient(law, x, arms)
    return pressure_at(law, volume) * gradient


def _add_corners(law: Pressure, n: Floats, x: Floats) -> None:
    """Add what the rings leave out: faces at vertices without a ring, and the cones that close the holes."""
    size = x.shape[1]
    first, second, third = law.rings.corners.T
    at, to = [first], [np.cross(x[:, second], x[:, third], axis=0)]
    if len(law.cap_edges):
        a, b = law.cap_edges.T
        centre, count = cap_centres(x.T, law.cap_edges, law.cap_loop)
        c = centre[law.cap_loop].T
        at += [a, b]
        to += [np.cross(x[:, b], c, axis=0), np.cross(c, x[:, a], axis=0)]
        # the centre moves with the mean of its border
        tip = np.cross(x[:, a], x[:, b], axis=0)
        share = np.stack([sums_at(law.cap_loop, tip[k], len(count)) / count for k in range(3)])
        at.append(a)
        to.append(share[:, law.cap_loop])
    where, what = np.concatenate(at), np.concatenate(to, axis=1)
    if len(where):
        for k in range(3):
            n[k] += sums_at(where, what[k], size)
