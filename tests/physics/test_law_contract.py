"""The contract every law keeps: force is minus the gradient of energy, inner forces have no sum, and so on.

Each law is given as (energy, force) of positions (3, n), on shapes disturbed at random. The derivatives of the forces
are those of test_tangent.py.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from core.base import Floats
from core.body import pressure, shape_matching, springs
from core.body.shape_matching import fit_pose
from core.mesh.surface import Mesh, mesh_from_triangles
from studies.methods import penalty
from studies.reference import energy, paper
from studies.reference.contact import Touch
from studies.reference.laws import matching_force, spring_force
from studies.reference.paper import spring_energy
from tests.bodies import ball
from tests.physics.disturbed import SHAPES, difference, disturbed, turn


@dataclass(frozen=True)
class Law:
    energy: Callable[[Floats], float]
    force: Callable[[Floats], Floats]


def springs_of(mesh: Mesh, rng: np.random.Generator) -> springs.Springs:
    count = len(mesh.springs)
    return springs.build_springs(mesh, rng.uniform(1, 50, count), rng.uniform(0, 1, count))


def membrane(mesh: Mesh, rng: np.random.Generator) -> Law:
    law = springs_of(mesh, rng)
    return Law(lambda x: energy.of_springs(law, x), lambda x: springs.force(law, x))


def membrane_of_the_reference(mesh: Mesh, rng: np.random.Generator) -> Law:
    law = springs_of(mesh, rng)
    return Law(lambda x: energy.of_springs(law, x), lambda x: spring_force(law, x))


def equation_4(mesh: Mesh, rng: np.random.Generator) -> Law:
    law = springs_of(mesh, rng)
    return Law(lambda x: spring_energy(law, x), lambda x: paper.spring_force(law, x))


def fill(kind: str, rest_pressure: float = 0.0) -> Callable[[Mesh, np.random.Generator], Law]:
    def law_of(mesh: Mesh, rng: np.random.Generator) -> Law:
        law = pressure.build_pressure(mesh, kind, rest_pressure)
        assert law.fill == kind
        return Law(lambda x: energy.of_fill(law, x), lambda x: pressure.force(law, x))

    return law_of


def shape_matching_law(mesh: Mesh, rng: np.random.Generator, knee: float) -> shape_matching.ShapeMatching:
    n = len(mesh.rest_positions)
    k1 = rng.uniform(1, 5, n)
    rest, tension = np.array(mesh.rest_positions.T, order="C"), rng.uniform(0, 5, len(mesh.springs))
    return shape_matching.ShapeMatching(
        rest=rest, k1=k1, k2=k1 * rng.uniform(0.5, 8, n), d0=np.full(n, knee), damping=rng.uniform(0, 1, n),
        mass=rng.uniform(0.1, 1, n), pairs=mesh.springs, tension=tension,
        pull=shape_matching.tension_force(mesh.springs, tension, rest),
    )  # fmt: skip


def pinned_matching(mesh: Mesh, rng: np.random.Generator) -> Law:
    law = shape_matching_law(mesh, rng, 0.1)
    pose = fit_pose(law.rest, law.rest + rng.normal(0, 0.3, law.rest.shape), law.k1)
    return Law(lambda x: energy.of_matching(law, x, pose), lambda x: shape_matching.force(law, x, pose))


def free_matching(mesh: Mesh, rng: np.random.Generator) -> Law:
    law = shape_matching_law(mesh, rng, 1e9)
    return Law(lambda x: energy.of_matching(law, x), lambda x: matching_force(law, x))


def fingertip(mesh: Mesh, rng: np.random.Generator) -> Law:
    """Press a fifth of the radius deep, wherever the body is."""
    stiffness, n, radius = rng.uniform(1, 50, len(mesh.rest_positions)), len(mesh.rest_positions), 0.5
    nobody, still = np.zeros(0, np.int64), np.zeros(3)
    centre: list[Floats] = []

    def met(x: Floats) -> penalty.Meeting:
        if not centre:  # at the first look, then it stays there
            far = x[:, np.linalg.norm(x - x.mean(axis=1, keepdims=True), axis=0).argmax()]
            outward = (far - x.mean(axis=1)) / np.linalg.norm(far - x.mean(axis=1))
            centre.append(far + 0.8 * radius * outward)
        touch = Touch(
            centre=centre[0], velocity=still, radius=radius, vertices=nobody, triangles=mesh.triangles,
            radii=np.full(len(mesh.triangles), radius),
        )  # fmt: skip
        return penalty.meeting(x, touch, stiffness, mesh.rest_positions.T)

    return Law(lambda x: penalty.energy(met(x)), lambda x: penalty.force(met(x), n))


LAWS = {
    "springs": membrane, "springs, ring by ring": membrane_of_the_reference, "Eq. (4)": equation_4,
    "air": fill("air"), "liquid": fill("liquid"),
    "pumped air": fill("air", 3e5), "drawn air": fill("air", -8e4), "pumped liquid": fill("liquid", 3e5),
    "pinned matching": pinned_matching, "free matching": free_matching, "fingertip": fingertip,
}  # fmt: skip


Case = tuple[Law, Floats, np.random.Generator]
EVERY = [(law, shape) for law in LAWS for shape in SHAPES]
INNER = [(law, shape) for law, shape in EVERY if law not in ("pinned matching", "fingertip")]


@pytest.fixture
def case(request: pytest.FixtureRequest) -> Case:
    rng = np.random.default_rng(7)
    law, shape = request.param
    mesh = mesh_from_triangles(*SHAPES[shape])
    return LAWS[law](mesh, rng), disturbed(mesh, rng), rng


def of_cases(cases: list[tuple[str, str]]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("case", cases, indirect=True, ids=" of ".join)


@of_cases(EVERY)
def test_force_is_minus_the_gradient_of_energy(case: Case) -> None:
    law, x, rng = case
    force = law.force(x)
    scale = np.linalg.norm(force)
    assert scale > 0
    for u in (rng.normal(size=x.shape), np.eye(x.size)[rng.integers(x.size)].reshape(x.shape)):
        assert float((force * u).sum()) == pytest.approx(-difference(law.energy, x, u), rel=1e-6, abs=1e-6 * scale)


def assert_no_net(force: Floats, x: Floats) -> None:
    size = np.abs(force).sum()
    arm = x - x.mean(axis=1, keepdims=True)
    np.testing.assert_allclose(force.sum(axis=1), 0, atol=1e-13 * size)
    np.testing.assert_allclose(np.cross(arm.T, force.T).sum(axis=0), 0, atol=1e-12 * size * np.abs(arm).max())


@of_cases(INNER)
def test_a_law_inside_the_body_exerts_no_net_force_and_torque(case: Case) -> None:
    law, x, _ = case
    assert_no_net(law.force(x), x)


@pytest.mark.parametrize("shape", SHAPES)
def test_dashpots_and_drag_exert_no_net_force_and_torque_and_take_energy(shape: str) -> None:
    rng = np.random.default_rng(3)
    mesh = mesh_from_triangles(*SHAPES[shape])
    x = disturbed(mesh, rng)
    v = rng.normal(size=x.shape)
    membrane_law, shape_law = springs_of(mesh, rng), shape_matching_law(mesh, rng, 0.02)  # beyond the knee
    for force, still in (
        (spring_force(membrane_law, x, v), spring_force(membrane_law, x)),
        (matching_force(shape_law, x, v), matching_force(shape_law, x)),
    ):
        assert_no_net(force, x)
        assert_no_net(still, x)
        assert float(((force - still) * v).sum()) < 0


@pytest.mark.parametrize("shape", SHAPES)
def test_nothing_damps_a_rigid_motion(shape: str) -> None:
    rng = np.random.default_rng(4)
    mesh = mesh_from_triangles(*SHAPES[shape])
    x = disturbed(mesh, rng)
    v = np.cross(rng.normal(size=3), x.T).T + rng.normal(size=(3, 1))
    law, shape_law = springs_of(mesh, rng), shape_matching_law(mesh, rng, 0.02)
    scale = 1e-12 * np.abs(v).max()
    np.testing.assert_allclose(spring_force(law, x, v) - spring_force(law, x), 0, atol=10 * scale)
    damped = matching_force(shape_law, x, v) - matching_force(shape_law, x)
    np.testing.assert_allclose(damped, 0, atol=10 * scale)


@pytest.mark.parametrize("shape", SHAPES)
def test_forces_turn_with_the_body(shape: str) -> None:
    rng = np.random.default_rng(5)
    mesh = mesh_from_triangles(*SHAPES[shape])
    x = disturbed(mesh, rng, 0.1)
    turned = turn(rng)
    for make in (membrane, equation_4, fill("air"), fill("liquid"), free_matching):
        law = make(mesh, np.random.default_rng(6))
        force = law.force(x)
        np.testing.assert_allclose(law.force(turned @ x + 1.0), turned @ force, atol=1e-9 * np.abs(force).max())


@pytest.mark.parametrize("shape", SHAPES)
def test_a_body_at_rest_feels_no_force(shape: str) -> None:
    mesh = mesh_from_triangles(*SHAPES[shape])
    x = mesh.rest_positions.T
    laws = (membrane, 50), (equation_4, 50), (fill("air"), 1e5), (fill("liquid"), 2e6), (free_matching, 5)
    for make, scale in laws:
        np.testing.assert_allclose(make(mesh, np.random.default_rng(8)).force(x), 0, atol=1e-13 * scale)


def test_a_squeezed_body_presses_outward_and_a_swollen_one_inward() -> None:
    mesh = mesh_from_triangles(*ball(1))
    for kind in ("air", "liquid"):
        law = pressure.build_pressure(mesh, kind)
        for scale, sign in ((0.99, 1), (1.01, -1)):
            x = scale * mesh.rest_positions.T
            assert (sign * (pressure.force(law, x) * x).sum(axis=0) > 0).all()


def test_air_follows_the_adiabatic_law_and_liquid_its_bulk_modulus() -> None:
    mesh = mesh_from_triangles(*ball(0))
    air, liquid = (pressure.build_pressure(mesh, kind) for kind in ("air", "liquid"))
    v0 = mesh.volume
    assert (101_325 + pressure.pressure_at(air, 0.5 * v0)) == pytest.approx(101_325 * 2**1.4)
    assert pressure.pressure_at(liquid, 0.999 * v0) == pytest.approx(2e6 * 0.001)
    assert pressure.pressure_at(air, -v0) == pressure.pressure_at(air, 0.0) < np.inf
