"""The paper's model, literally: Eqs. (1) to (10), with nothing repaired.

Its limits are stated by tests/physics/test_paper_limits.py.
Source: Sakama, Tanaka and Araki, Haptic Rendering for Virtual Object in Cyber Space.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from core.base import Bools, Floats, Ints, mean_of_pairs, sums_at
from core.body import frequency_bounds
from core.body.model import Model, build_model
from core.body.springs import Springs, build_springs
from core.material import Material, law_force
from core.mesh.surface import Mesh

from .constants import ROUNDING, TRAVEL
from .contact import Step, Touch
from .laws import State
from .path import FingerPath
from .ticks import each_tick, meet, moved_back, slow_down

_TINY = 1e-30


@dataclass(slots=True, kw_only=True)
class Literal(State):
    """What moves of a body by the paper's equations.

    inner_force: sum of K(x_i) over the fingertips [N], Eq. (1), for Eq. (2).
    contact: vertices touched in the step before, for Eq. (2).
    """

    inner_force: float = 0.0
    contact: Ints = field(default_factory=lambda: np.zeros(0, np.int64))


def literal_model(mesh: Mesh, materials: Sequence[Material], pinned: Bools | None = None) -> Model:
    """Return a body whose springs have k as it is in the table: of the rest, `run` takes mass and friction alone."""
    model = build_model(mesh, [replace(each, fill="none") for each in materials], pinned=pinned)
    k = np.array([each.k for each in materials])[mesh.triangle_material]
    stiffness, none = mean_of_pairs(k, mesh.spring_triangles), np.zeros(len(model.mass))
    return replace(
        model, springs=build_springs(mesh, stiffness, 0 * stiffness), compliance=none, decay=0.0,
        # Eq. (4) stiffens with stretch: k (2 |l| / |l0| - 1); allow for twice the rest length
        omega_squared=frequency_bounds.of_body(mesh, 3 * stiffness, none, model.inverse_mass, model.pressure),
    )  # fmt: skip


def at_rest(model: Model) -> Literal:
    """Return the state at rest."""
    x = np.array(model.mesh.rest_positions.T, order="C")
    return Literal(positions=x, velocities=np.zeros_like(x), pose=None)


def run(model: Model, state: Literal, path: FingerPath, *, tick: float, substeps: int) -> Floats:
    """Advance a state in place by the ticks [s] of a path; return the impulses (k, 3) [N s] on the fingertips.

    In each substep Eqs. (6) to (8) move it, and vertices are kept out of fingertips; faces are not.
    """
    total, dt = np.zeros((len(path.radii), 3)), tick / substeps
    limit = min(path.radii, default=np.inf) * 2 * TRAVEL
    for touches in each_tick(model, state, path, tick):
        met = [_of_vertices(touch) for touch in touches]
        for i in range(substeps):
            before = state.positions.copy()
            state.velocities += dt * forces(model, state) * model.inverse_mass
            state.positions += dt * state.velocities
            slow_down(before, state.positions, limit)
            now = moved_back(met, (substeps - 1 - i) * dt)
            state.contact = touched(state.positions, now)
            total += meet(model, state, now, Step(dt, limit))[:, 0]
    return total


def inner_force(material: Material, depths: Sequence[float]) -> float:
    """Return the sum of K(x) [N] over fingertips at depths [m], Eq. (1)."""
    return sum(law_force(depth, material.K1, material.K2, material.x0, 1.0) for depth in depths)


def touched(x: Floats, touches: Sequence[Touch]) -> Ints:
    """Return the vertices inside any fingertip or on its surface: the contact of Eq. (2)."""
    hits = [
        touch.vertices[
            ((x[:, touch.vertices] - touch.centre[:, None]) ** 2).sum(axis=0) < ((1 + ROUNDING) * touch.radius) ** 2
        ]
        for touch in touches
    ]
    return np.unique(np.concatenate(hits)) if hits else np.zeros(0, np.int64)


def contact_area(contact: Ints, triangles: Ints, x: Floats) -> float:
    """Return A_c [m2]: a third of each triangle's area for each of its corners in contact."""
    touching = np.zeros(x.shape[1])
    touching[contact] = 1
    areas = np.linalg.norm(_face_normals(triangles, x), axis=0) / 2
    return float((areas * touching[triangles].sum(axis=1)).sum()) / 3


def inner_pressure(force: float, area: float) -> float:
    """Return p = f / A_c [Pa], Eq. (2); no contact, no pressure."""
    return force / area if area > 0 else 0.0


def pressure_force(pressure: float, triangles: Ints, x: Floats, rest_area: float) -> Floats:
    """Return f_p = p (A_0 / n_0) v_n (3, n) [N], Eq. (3); v_n is the unit sum of the unit normals round a vertex."""
    normals = _face_normals(triangles, x)
    normals /= np.maximum(np.linalg.norm(normals, axis=0), _TINY)
    total = np.stack([sums_at(triangles.ravel(), np.repeat(normals[c], 3), x.shape[1]) for c in range(3)])
    return pressure * rest_area / x.shape[1] * total / np.maximum(np.linalg.norm(total, axis=0), _TINY)


def spring_force(law: Springs, x: Floats) -> Floats:
    """Return f_k = k (|l| - |l0|) l / |l0| (3, n) [N], Eq. (4), signed so that it restores."""
    i, j = law.pairs.T
    d = x[:, j] - x[:, i]
    pull = law.stiffness * (np.linalg.norm(d, axis=0) - law.rest_lengths) / np.maximum(law.rest_lengths, _TINY) * d
    n = x.shape[1]
    return np.stack([sums_at(i, pull[c], n) - sums_at(j, pull[c], n) for c in range(3)])


def spring_energy(law: Springs, x: Floats) -> float:
    """Return the energy [J] whose gradient Eq. (4) is: k (|l|^3 / (3 |l0|) - |l|^2 / 2 + |l0|^2 / 6)."""
    length, rest = np.linalg.norm(x[:, law.pairs[:, 1]] - x[:, law.pairs[:, 0]], axis=0), law.rest_lengths
    return float(law.stiffness @ (length**3 / (3 * rest) - length**2 / 2 + rest**2 / 6))


def forces(model: Model, state: Literal) -> Floats:
    """Return the force (3, n) [N] on every vertex, Eq. (5): pressure and springs, and nothing else."""
    x, triangles = state.positions, model.mesh.triangles
    state.pressure = inner_pressure(state.inner_force, contact_area(state.contact, triangles, x))
    return spring_force(model.springs, x) + pressure_force(
        state.pressure, triangles, x, float(model.mesh.triangle_areas.sum())
    )


def surface_tension(force: float, depth: float, length: float) -> float:
    """Return S [N] of a surface of length l [m] pressed in its middle by a force [N] to a depth [m], Eq. (9)."""
    return float(force * depth / (2 * np.hypot(length / 2, depth)))


def surface_stretch(tension: float, length: float, section: float, youngs_modulus: float) -> float:
    """Return lambda [m] of a surface of length [m], section A [m2] and Young's modulus E [Pa], Eq. (10)."""
    return tension * length / (2 * section * youngs_modulus)


def _of_vertices(touch: Touch) -> Touch:
    return replace(touch, triangles=touch.triangles[:0], radii=touch.radii[:0], faces=None)


def _face_normals(triangles: Ints, x: Floats) -> Floats:
    a, b, c = x[:, triangles[:, 0]], x[:, triangles[:, 1]], x[:, triangles[:, 2]]
    return np.asarray(np.cross(b - a, c - a, axis=0), np.float64)
