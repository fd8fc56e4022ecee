"""The linear system A = M + h C + h^2 K that every implicit step and equilibrium solves, as the solver calls it.

Where a law is linear enough A is the derivative of what the step solves for, x and v moving as x + h s, v + s; it
leaves out how springs under compression push sideways and how a fingertip's normals turn.
"""

from dataclasses import replace

import numpy as np
import pytest

from core.base import Floats
from core.body.model import Model, build_model
from core.body.shape_matching import fit_pose
from core.material import Material
from core.mesh.surface import base_vertices, mesh_from_triangles
from studies.methods.newton import meet_faces, pressed
from studies.methods.tangent import Tangent, tangent
from studies.reference import contact
from studies.reference.laws import State
from tests.physics.disturbed import SHAPES, difference, disturbed

STEP = 1e-3  # [s]
SOFT = Material(K1=610, K2=7230, x0=0.0163, k=600, mass=0.2, fill="liquid")
LAWS = ("springs", "air", "liquid", "matching", "all")


def body(shape: str, law: str = "all", *, pinned: bool = False, uneven: bool = False) -> Model:
    """Return a body a tenth as large as its shape, of all its laws, of one, or of all but a fill."""
    points, faces = SHAPES[shape]
    mesh = mesh_from_triangles(0.1 * points, faces)
    softness = np.random.default_rng(2).uniform(0, 1, len(points)) if uneven else None
    fill = law if law in ("air", "liquid") else "liquid" if law == "all" else "none"
    pins = base_vertices(mesh) if pinned else None
    model = build_model(mesh, [replace(SOFT, fill=fill)], pinned=pins, softness=softness)
    if law not in ("springs", "no fill", "all"):
        springs = model.springs
        none = replace(springs, stiffness=0 * springs.stiffness, damping=0 * springs.damping)
        model = replace(model, springs=none)
    if law not in ("matching", "no fill", "all"):
        shape_law, trace = model.matching, 1e-15 * model.matching.k1  # a pose is fitted with k1 as the weight
        model = replace(model, matching=replace(
            shape_law, k1=trace, k2=trace, damping=0 * trace, tension=0 * shape_law.tension, pull=0 * shape_law.pull,
        ))  # fmt: skip
    return model


def state_at(model: Model, x: Floats, *, pinned: bool = False) -> State:
    """Return a still state at positions (3, n); pinned: the shape at rest stays where it fits them best."""
    pose = fit_pose(model.matching.rest, x, model.mass) if pinned else None
    return State(positions=x, velocities=np.zeros_like(x), pose=pose)


def state_at_rest(model: Model, state: State) -> Floats:
    """Return where the shape at rest is pinned, (3, n)."""
    assert state.pose is not None
    return state.pose[0] @ model.matching.rest + state.pose[1][:, None]


def derivative(model: Model, state: State, s: Floats, touches: list[contact.Touch] | None = None) -> Floats:
    """Return what `Tangent.product` stands for, from the accelerations that Newton's method brings to balance."""

    def unbalanced(u: Floats) -> Floats:
        moved = replace(state, positions=state.positions + STEP * u, velocities=state.velocities + u)
        return model.mass * (u - STEP * pressed(model, moved, touches or [])[0]) * (model.inverse_mass > 0)

    size = float(np.abs(s).max())
    return size * difference(unbalanced, np.zeros_like(s), s / size, step=1e-6 * model.mesh.size / STEP)


def dense(system: Tangent, n: int) -> Floats:
    """Return A (3 n, 3 n)."""
    return np.stack([system.product(unit.reshape(3, n)).ravel() for unit in np.eye(3 * n)], axis=1)


def assert_same(found: Floats, wanted: Floats, mass_alone: Floats, tolerance: float = 1e-6) -> None:
    """Compare products; what the laws add to the mass sets the scale."""
    laws = np.abs(wanted - mass_alone).max()
    assert laws > 0
    np.testing.assert_allclose(found, wanted, rtol=0, atol=tolerance * laws)


def lengths(model: Model, x: Floats) -> Floats:
    first, second = model.springs.pairs.T
    return np.asarray(np.linalg.norm(x[:, second] - x[:, first], axis=0), np.float64)


def fingertip(model: Model, x: Floats, depth: float) -> contact.Touch:
    """Return a still fingertip that presses the top of a body at positions (3, n) to a depth [m]."""
    tip, radius = x[:, x[2].argmax()], 0.02
    centre, nobody = tip + [0.0, 0.0, radius - depth], np.zeros(0, np.int64)
    return contact.Touch(
        centre=centre, velocity=np.zeros(3), radius=radius, vertices=nobody, triangles=model.mesh.triangles,
        radii=np.full(len(model.mesh.triangles), radius),
    )  # fmt: skip


@pytest.mark.parametrize("pinned", [False, True], ids=["loose", "pinned"])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("shape", SHAPES)
def test_the_system_is_the_derivative_of_the_step_where_the_shape_at_rest_is_pinned(
    shape: str, law: str, pinned: bool
) -> None:
    """Stretched, so that nothing is left out of the springs, and in places beyond the knee of shape matching."""
    model, rng = body(shape, law, pinned=pinned, uneven=True), np.random.default_rng(3)
    state = state_at(model, 1.6 * disturbed(model.mesh, rng, 0.003), pinned=True)
    assert (lengths(model, state.positions) > model.springs.rest_lengths).all()
    assert (np.linalg.norm(state.positions - state_at_rest(model, state), axis=0) > model.matching.d0).any()
    free = model.inverse_mass > 0
    s = rng.normal(size=state.positions.shape) * free
    assert_same(tangent(model, state, STEP).product(s), derivative(model, state, s), model.mass * s)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("shape", SHAPES)
def test_the_system_is_the_derivative_of_the_step_of_a_free_body_in_its_shape_at_rest(shape: str, law: str) -> None:
    """Wherever it is and however it is turned; the shape at rest follows it."""
    model, rng = body(shape, law, uneven=True), np.random.default_rng(4)
    state = state_at(model, disturbed(model.mesh, rng, 0.0))
    s = rng.normal(size=state.positions.shape) * (model.inverse_mass > 0)
    assert_same(tangent(model, state, STEP).product(s), derivative(model, state, s), model.mass * s, 1e-5)


@pytest.mark.parametrize("pinned", [False, True], ids=["free", "pinned"])
@pytest.mark.parametrize("law", ["no fill", "all"])
@pytest.mark.parametrize("shape", SHAPES)
def test_the_system_is_symmetric_and_without_a_fill_never_below_the_mass(shape: str, law: str, pinned: bool) -> None:
    """Crumpled and pressed, its skin under compression. The pressure of a fill may well buckle it."""
    model, rng = body(shape, law, uneven=True), np.random.default_rng(5)
    state = state_at(model, 0.9 * disturbed(model.mesh, rng, 0.005), pinned=pinned)
    met = meet_faces(model, state, [fingertip(model, state.positions, 0.005)])
    assert len(met[0].depths)
    free = np.tile(model.inverse_mass > 0, 3)
    system = dense(tangent(model, state, STEP, met), len(model.mass))[np.ix_(free, free)]
    np.testing.assert_allclose(system, system.T, rtol=0, atol=1e-9 * np.abs(system).max())
    root = np.sqrt(np.tile(model.mass, 3))[free]
    least = np.linalg.eigvalsh(system / np.outer(root, root)).min()
    assert least > 1 - 1e-9 or law == "all"


def test_a_fingertip_adds_the_derivative_of_its_push_but_for_the_turn_of_its_normals() -> None:
    """They turn by s / R a displacement s: beside c s the push then changes by c depth s / R."""
    model = body("ball")
    state = state_at(model, model.mesh.rest_positions.T.copy(), pinned=True)
    s = np.random.default_rng(9).normal(size=state.positions.shape)
    off = {}
    for depth in (2e-5, 2e-4):
        touch = fingertip(model, state.positions, depth)
        met = meet_faces(model, state, [touch])
        wanted = derivative(model, state, s, [touch]) - derivative(model, state, s)
        found = tangent(model, state, STEP, met).product(s) - tangent(model, state, STEP).product(s)
        off[depth] = np.abs(found - wanted).max() / np.abs(wanted).max()
    assert off[2e-5] < 0.005 and off[2e-4] / off[2e-5] == pytest.approx(10, rel=0.1)


@pytest.mark.parametrize("pinned", [False, True], ids=["free", "pinned"])
@pytest.mark.parametrize("shape", ["ball", "tube"])
def test_the_preconditioner_is_symmetric_positive_and_brings_the_modes_together(shape: str, pinned: bool) -> None:
    model, rng = body(shape, uneven=True), np.random.default_rng(10)
    state = state_at(model, disturbed(model.mesh, rng, 0.0), pinned=pinned)
    system, n, free = tangent(model, state, STEP), len(model.mass), np.tile(model.inverse_mass > 0, 3)
    matrix = dense(system, n)[np.ix_(free, free)]
    inverse = dense(replace(system, product=system.precondition), n)[np.ix_(free, free)]
    np.testing.assert_allclose(inverse, inverse.T, rtol=0, atol=1e-9 * np.abs(inverse).max())
    half = np.linalg.cholesky((inverse + inverse.T) / 2)
    assert np.linalg.cond(half.T @ matrix @ half) < np.linalg.cond(matrix) / 5
