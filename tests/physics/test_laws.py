"""The contract every law keeps: force is minus the gradient of energy, stiffness minus that of force, and so on.

Each law is given as (energy, force, stiffness_product) of positions (3, n), on shapes disturbed at random.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from core.base import Floats
from core.body import paper, pressure, shape_matching, springs
from core.body.shape_matching import fit_pose
from core.mesh.surface import Mesh, mesh_from_triangles
from studies.specimen import cube_triangles
from tests.bodies import ball, hemisphere, joined, sheet, walled_box

SHAPES = {
    "ball": ball(1), "cube": cube_triangles(2, 1.0), "capped": hemisphere(8, 4), "wall inside": walled_box(),
    "two balls": joined(ball(0), (0.5 * ball(0)[0] + [2, 0, 0], ball(0)[1])),
    "tube": (lambda p, f: (p, f[np.abs(p[f][:, :, 2]).min(axis=1) < 0.49]))(*cube_triangles(3, 1.0)),
    "half open": (lambda p, f: (p, f[3:]))(*ball(1)),
}  # fmt: skip


@dataclass(frozen=True)
class Law:
    """Hold what a law promises; the stiffness of Eq. (4) and of a pose that follows the body is not offered."""

    energy: Callable[[Floats], float]
    force: Callable[[Floats], Floats]
    stiffness_product: Callable[[Floats, Floats], Floats] | None


def springs_of(mesh: Mesh, rng: np.random.Generator) -> springs.Springs:
    count = len(mesh.springs)
    return springs.build_springs(mesh, rng.uniform(1, 50, count), rng.uniform(0, 1, count))


def membrane(mesh: Mesh, rng: np.random.Generator) -> Law:
    law = springs_of(mesh, rng)
    return Law(
        lambda x: springs.energy(law, x), lambda x: springs.force(law, x),
        lambda x, u: springs.stiffness_product(law, x, u),
    )  # fmt: skip


def equation_4(mesh: Mesh, rng: np.random.Generator) -> Law:
    law = springs_of(mesh, rng)
    return Law(lambda x: paper.spring_energy(law, x), lambda x: paper.spring_force(law, x), None)


def fill(kind: str) -> Callable[[Mesh, np.random.Generator], Law]:
    def law_of(mesh: Mesh, rng: np.random.Generator) -> Law:
        law = pressure.build_pressure(mesh, kind)
        assert law.fill == kind
        return Law(
            lambda x: pressure.energy(law, x), lambda x: pressure.force(law, x),
            lambda x, u: pressure.stiffness_product(law, x, u),
        )  # fmt: skip

    return law_of


def shape_matching_law(mesh: Mesh, rng: np.random.Generator, knee: float) -> shape_matching.ShapeMatching:
    n = len(mesh.rest_positions)
    k1 = rng.uniform(1, 5, n)
    return shape_matching.ShapeMatching(
        rest=mesh.rest_positions.T, k1=k1, k2=k1 * rng.uniform(0.5, 8, n), d0=np.full(n, knee),
        damping=rng.uniform(0, 1, n), mass=rng.uniform(0.1, 1, n),
    )  # fmt: skip


def pinned_matching(mesh: Mesh, rng: np.random.Generator) -> Law:
    law = shape_matching_law(mesh, rng, 0.1)
    pose = fit_pose(law.rest, law.rest + rng.normal(0, 0.3, law.rest.shape), law.k1)
    return Law(
        lambda x: shape_matching.energy(law, x, pose), lambda x: shape_matching.force(law, x, None, pose),
        lambda x, u: shape_matching.stiffness_product(law, x, u, pose),
    )  # fmt: skip


def free_matching(mesh: Mesh, rng: np.random.Generator) -> Law:
    law = shape_matching_law(mesh, rng, 1e9)
    return Law(lambda x: shape_matching.energy(law, x), lambda x: shape_matching.force(law, x), None)


LAWS = {
    "springs": membrane, "Eq. (4)": equation_4, "air": fill("air"), "liquid": fill("liquid"),
    "pinned matching": pinned_matching, "free matching": free_matching,
}  # fmt: skip


def disturbed(mesh: Mesh, rng: np.random.Generator, amount: float = 0.05) -> Floats:
    """Return positions (3, n) turned, moved and disturbed at random."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    x = turn @ mesh.rest_positions.T + rng.normal(0, 3, (3, 1))
    return x + rng.normal(0, amount, x.shape)


Case = tuple[Law, Floats, np.random.Generator]
EVERY = [(law, shape) for law in LAWS for shape in SHAPES]
IMPLICIT = [(law, shape) for law, shape in EVERY if law not in ("Eq. (4)", "free matching")]
FREE = [(law, shape) for law, shape in EVERY if law != "pinned matching"]


@pytest.fixture
def case(request: pytest.FixtureRequest) -> Case:
    rng = np.random.default_rng(7)
    law, shape = request.param
    mesh = mesh_from_triangles(*SHAPES[shape])
    return LAWS[law](mesh, rng), disturbed(mesh, rng), rng


def of_cases(cases: list[tuple[str, str]]) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("case", cases, indirect=True, ids=" of ".join)


def difference(f: Callable[[Floats], Floats | float], x: Floats, u: Floats, step: float = 1e-5) -> Floats | float:
    """Return the derivative of f along u by central differences of fourth order."""
    h = step * u
    return (8 * (f(x + h) - f(x - h)) - (f(x + 2 * h) - f(x - 2 * h))) / (12 * step)


@of_cases(EVERY)
def test_force_is_minus_the_gradient_of_energy(case: Case) -> None:
    law, x, rng = case
    force = law.force(x)
    scale = np.linalg.norm(force)
    assert scale > 0
    for u in (rng.normal(size=x.shape), np.eye(x.size)[rng.integers(x.size)].reshape(x.shape)):
        assert float((force * u).sum()) == pytest.approx(-difference(law.energy, x, u), rel=1e-6, abs=1e-6 * scale)


@of_cases(IMPLICIT)
def test_stiffness_is_minus_the_derivative_of_force(case: Case) -> None:
    law, x, rng = case
    assert law.stiffness_product is not None
    for _ in range(2):
        u = rng.normal(size=x.shape)
        wanted = -difference(law.force, x, u)
        np.testing.assert_allclose(law.stiffness_product(x, u), wanted, atol=1e-6 * np.abs(wanted).max())


@of_cases(IMPLICIT)
def test_stiffness_is_symmetric(case: Case) -> None:
    law, x, rng = case
    assert law.stiffness_product is not None
    u, w = rng.normal(size=(2, *x.shape))
    one, other = law.stiffness_product(x, u), law.stiffness_product(x, w)
    assert float((one * w).sum()) == pytest.approx(float((other * u).sum()), rel=1e-9, abs=1e-9 * np.linalg.norm(one))


def assert_no_net(force: Floats, x: Floats) -> None:
    size = np.abs(force).sum()
    arm = x - x.mean(axis=1, keepdims=True)
    np.testing.assert_allclose(force.sum(axis=1), 0, atol=1e-13 * size)
    np.testing.assert_allclose(np.cross(arm.T, force.T).sum(axis=0), 0, atol=1e-12 * size * np.abs(arm).max())


@of_cases(FREE)
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
        (springs.force(membrane_law, x, v), springs.force(membrane_law, x)),
        (shape_matching.force(shape_law, x, v), shape_matching.force(shape_law, x)),
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
    np.testing.assert_allclose(springs.force(law, x, v) - springs.force(law, x), 0, atol=10 * scale)
    damped = shape_matching.force(shape_law, x, v) - shape_matching.force(shape_law, x)
    np.testing.assert_allclose(damped, 0, atol=10 * scale)


@pytest.mark.parametrize("shape", SHAPES)
def test_forces_turn_with_the_body(shape: str) -> None:
    rng = np.random.default_rng(5)
    mesh = mesh_from_triangles(*SHAPES[shape])
    x = disturbed(mesh, rng, 0.1)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    for make in (membrane, equation_4, fill("air"), fill("liquid"), free_matching):
        law = make(mesh, np.random.default_rng(6))
        force = law.force(x)
        np.testing.assert_allclose(law.force(turn @ x + 1.0), turn @ force, atol=1e-9 * np.abs(force).max())


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


def test_a_sheet_has_no_fill() -> None:
    mesh = mesh_from_triangles(*sheet())
    law = pressure.build_pressure(mesh, "air")
    assert law.fill == "none" and not pressure.force(law, 1.1 * mesh.rest_positions.T).any()
