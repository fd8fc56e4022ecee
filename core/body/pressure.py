"""The pressure of the fill.

    f = p dV/dx,   V = sum over faces of x_0 . (x_1 x x_2) / 6

dV/dx_i is a sixth of the sum of x_j x x_k over the faces of vertex i; on a closed surface it gives no net force and no
net torque. For a gas p = (p_a + p_0) (V_0/V)^gamma - p_a, for a liquid or a solid p = p_0 + kappa (V_0 - V) / V_0.
The gauge pressure p_0 belongs to the modelled shape: under it the body swells until its skin holds it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Floats, Ints, sums_at
from ..constants import AIR_EXPONENT, AIR_PRESSURE, LIQUID_BULK_MODULUS
from ..fills import FILLS, PressureLaw
from ..mesh.surface import Mesh, cap_centres


@dataclass(frozen=True, slots=True, kw_only=True)
class Pressure:
    """The fill of a body.

    fill: a key of `fills.FILLS`.
    rest_volume: [m3].
    rest_pressure: gauge pressure at that volume [Pa].
    triangles: (t, 3) of the mesh.
    cap_edges: (c, 2) border edges; cap_loop: (c,) the hole that each belongs to.
    """

    fill: str
    rest_volume: float
    rest_pressure: float
    triangles: Ints
    cap_edges: Ints
    cap_loop: Ints

    @property
    def kind(self) -> PressureLaw:
        """Return the law of its pressure."""
        return FILLS[self.fill].law


def build_pressure(mesh: Mesh, fill: str, rest_pressure: float = 0.0) -> Pressure:
    """Build the fill of a mesh; an open sheet has none."""
    return Pressure(
        fill=fill if mesh.pressurable else "none", rest_volume=mesh.volume, rest_pressure=rest_pressure,
        triangles=mesh.triangles, cap_edges=mesh.cap_edges, cap_loop=mesh.cap_loop,
    )  # fmt: skip


def volume_and_gradient(law: Pressure, x: Floats) -> tuple[float, Floats]:
    """Return the volume [m3] and its gradient (3, n) [m2] at positions (3, n) [m]."""
    n, x = x.shape[1], x - x.mean(axis=1)[:, None]
    at, crosses = [law.triangles.ravel("F")], list[Floats]()
    i, j, k = (x[:, corner] for corner in law.triangles.T)
    crosses += [_cross(j, k), _cross(k, i), _cross(i, j)]
    if len(law.cap_edges):
        centres, count = cap_centres(x.T, law.cap_edges, law.cap_loop)
        start, end = (x[:, each] for each in law.cap_edges.T)
        centre, base = centres[law.cap_loop].T, _cross(start, end)
        # the centre of a cap moves with the mean of its border: each vertex there has its share of that gradient
        share = np.stack([sums_at(law.cap_loop, each, len(count)) / count for each in base])
        at += [law.cap_edges.ravel("F"), law.cap_edges[:, 0]]
        crosses += [_cross(end, centre), _cross(centre, start), share[:, law.cap_loop]]
    vertices, cross = np.concatenate(at), np.concatenate(crosses, axis=1)
    gradient = np.stack([sums_at(vertices, each, n) for each in cross]) / 6
    return float((x * gradient).sum()) / 3, gradient


def _cross(a: Floats, b: Floats) -> Floats:
    product: Floats = np.cross(a, b, axis=0).astype(np.float64, copy=False)
    return product


def pressure_at(law: Pressure, volume: float) -> float:
    """Return the gauge pressure [Pa] at a volume [m3]."""
    if law.kind is PressureLaw.GAS:
        # a body that is turned inside out has a negative volume; a hundredth keeps the power finite
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


def force(law: Pressure, x: Floats) -> Floats:
    """Return the forces (3, n) [N] at positions (3, n) [m]."""
    volume, gradient = volume_and_gradient(law, x)
    return pressure_at(law, volume) * gradient
