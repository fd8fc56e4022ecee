"""Where the way of a fingertip is known, a proxy is fine there and coarse elsewhere, if no even one would do."""


import numpy as np
import pytest

from core.base import DimpleError
from core.body.model import Model, build_model
from core.mesh.surface import base_vertices
from core.reduction import decision, planner, processor_time
from core.reduction.benchmark import BenchmarkPress, PressResult, choose_presses, outcome_of, press_body
from core.reduction.grading import FAR, FINE, MOST, Led, Pressed, coarser, pressed_by
from core.reduction.planner import plan
from core.reduction.proxy import Proxy, build_proxy
from core.solver.backend import create
from studies import bodies

RADIUS = 0.004


@pytest.fixture(scope="module")
def fine() -> Model:
    """A head of 60,000 vertices: under a fingertip of 4 mm it would take a proxy of 25,000 to keep the tolerances."""
    mesh = bodies.head(100, 0.2)
    return build_model(mesh, [bodies.GEL], pinned=base_vertices(mesh))


@pytest.fixture(scope="module")
def press(fine: Model) -> BenchmarkPress:
    return choose_presses(fine, RADIUS, 4, seed=3)[3]


def way_of(press: BenchmarkPress) -> list[np.ndarray]:
    """Return the path of a fingertip that comes from afar and goes in."""
    return [np.array([press.at + press.outward * away for away in (10 * press.radius, press.radius - press.depth)])]


def near(model: Model, press: BenchmarkPress) -> Pressed:
    found = pressed_by(model.mesh, way_of(press), press.radius)
    assert found
    return found


def pressed(model: Model, press: BenchmarkPress) -> PressResult:
    *_, (_, end) = press_body(create(model), press, substeps=model.substeps(1e-3))
    return end


def test_a_path_is_near_the_surface_where_a_fingertip_can_press_it(fine: Model, press: BenchmarkPress) -> None:
    places = np.array(near(fine, press).places)
    assert len(places) < 10 and np.linalg.norm(places - press.at, axis=1).max() < RADIUS
    assert pressed_by(fine.mesh, [np.array([[1.0, 0, 0], [2.0, 0, 0]])], RADIUS) is None
    along = pressed_by(fine.mesh, [np.array([press.at, -press.at])], RADIUS)
    assert along and len(along.places) > len(places), "what goes through presses where it comes out, too"
    often = pressed_by(fine.mesh, [np.concatenate(20 * way_of(press))], RADIUS)
    assert often and set(near(fine, press).places) <= set(often.places) and len(often.places) < 2 * len(places) + 3
    way = np.linspace(0, 1, 2000)[:, None]
    scribbled = np.hstack([0.1 * np.sin(300 * way), 0.1 * np.cos(311 * way), 0.1 * np.sin(way)])
    assert pressed_by(fine.mesh, [scribbled], RADIUS) is None, "it goes all over the head"


@pytest.mark.parametrize("size", [0.3, 100.0], ids=["a plate", "an endless one"])
def test_a_plate_is_near_a_surface_where_its_way_leads_it_and_nowhere_else(fine: Model, size: float) -> None:
    points, top = fine.mesh.rest_positions, fine.mesh.rest_positions[:, 2].max()
    plate = size * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) + (0, 0, top + 0.1)
    faces = np.array([(0, 1, 2), (0, 2, 3)])

    def places(depth: float) -> np.ndarray | None:
        found = pressed_by(
            fine.mesh, [], RADIUS, colliders=[Led(plate, faces, np.array([(0, 0, 0), (0, 0, -0.1 - depth)]))]
        )
        return None if found is None else np.array(found.places)

    assert places(-0.05) is None, "it stays above"
    found = places(0.004)
    assert found is not None and len(found) < MOST and found[:, 2].min() > top - 0.004 - 4.5 * RADIUS
    cap = points[points[:, 2] > top - 0.004]
    assert np.linalg.norm(cap[:, None] - found, axis=2).min(axis=1).max() < FINE * RADIUS
    assert places(0.15) is None, "it goes all over the head"


def test_seeds_lie_closer_where_the_fingertip_goes_and_farther_elsewhere(fine: Model, press: BenchmarkPress) -> None:
    there = Pressed((tuple(press.at.tolist()),), RADIUS)
    proxy = build_proxy(fine, 600, there)
    assert len(proxy.seeds) == 600 and proxy.pressed == there
    seeds = fine.mesh.rest_positions[proxy.seeds]
    nearest = np.sort(np.linalg.norm(seeds[:, None] - seeds, axis=2), axis=1)[:, 1]
    away = np.linalg.norm(seeds - press.at, axis=1) / RADIUS
    close, far = nearest[away < FINE], nearest[away > 15]
    assert np.median(close) == pytest.approx(proxy.spacing, rel=0.2)
    assert np.median(far) == pytest.approx(FAR * proxy.spacing, rel=0.3)
    assert (coarser(seeds, there)[away < FINE] == 1).all() and (coarser(seeds, there)[away > 15] == FAR).all()


def test_a_proxy_that_is_graded_has_the_mass_the_stiffness_and_the_volume_of_its_mesh(
    fine: Model, press: BenchmarkPress
) -> None:
    proxy = build_proxy(fine, 600, near(fine, press))
    for coarse, whole in ((proxy.model.mass, fine.mass), (proxy.model.matching.k1, fine.matching.k1)):
        assert coarse.sum() == pytest.approx(whole.sum())
    assert proxy.model.mesh.closed and proxy.model.mesh.volume == pytest.approx(fine.mesh.volume, rel=0.03)


def test_a_proxy_fine_on_the_way_of_a_fingertip_has_the_force_that_an_even_one_misses(
    fine: Model, press: BenchmarkPress
) -> None:
    """The even one, of 8,000 vertices, is off by a fifth of the force, and says that it may be off by 29 %."""
    even, graded = plan(fine, radius=RADIUS), plan(fine, radius=RADIUS, pressed=near(fine, press))
    assert even.proxy and graded.proxy and even.force_error > 2 * decision.FORCE_TOLERANCE
    assert graded.force_error <= decision.FORCE_TOLERANCE and graded.error <= decision.TOLERANCE
    assert graded.vertices * graded.steps < even.vertices * even.steps / 10
    assert graded.reason.endswith("It is fine where it will be pressed.") and graded.cost < processor_time.BUDGET
    goal, found = pressed(fine, press), []
    for chosen in (even, graded):
        assert chosen.proxy
        end = pressed(chosen.proxy.model, press)
        found.append(outcome_of(fine, chosen.asked, chosen.proxy, chosen.steps, [end], [goal]))
    assert found[0].force_error > 1.5 * decision.FORCE_TOLERANCE
    assert found[1].force_error < decision.FORCE_TOLERANCE and found[1].error < decision.TOLERANCE
    assert found[1].error < 0.02 * RADIUS


def test_where_an_even_proxy_keeps_the_tolerances_live_nothing_depends_on_paths(
    fine: Model, press: BenchmarkPress
) -> None:
    there = near(fine, press)._replace(radius=0.01)
    even, known = plan(fine, radius=0.01), plan(fine, radius=0.01, pressed=there)
    assert even.proxy and known.proxy and known.proxy.pressed is None
    assert np.array_equal(even.proxy.seeds, known.proxy.seeds) and even.reason == known.reason
    assert plan(fine, radius=RADIUS, pressed=near(fine, press), budget=1e9).proxy is None


def test_the_steps_of_a_stiff_body_leave_an_even_proxy_too_slow_and_a_graded_one_live(
    fine: Model, press: BenchmarkPress
) -> None:
    """How many steps a proxy takes is known when it is made: then the graded one is, too."""
    there = near(fine, press)._replace(radius=0.008)
    even = plan(fine, radius=0.008)
    assert even.force_error <= decision.FORCE_TOLERANCE
    slow, live = (plan(fine, radius=0.008, budget=0.3 * even.cost, pressed=known) for known in (None, there))
    assert slow.cost > 0.3 * even.cost and live.cost <= 0.3 * even.cost
    assert live.proxy and live.proxy.pressed == there.where and live.force_error <= decision.FORCE_TOLERANCE


def test_where_no_graded_proxy_can_be_made_the_plan_is_as_without_paths(fine: Model, press: BenchmarkPress) -> None:
    made: list[Pressed | None] = []

    def build(model: Model, vertices: int, pressed: Pressed | None = None) -> Proxy:
        made.append(pressed)
        if pressed:
            raise DimpleError("its surface is too crumpled")
        return build_proxy(model, vertices)

    there = near(fine, press)
    chosen = planner.carry_out(decision.decide(fine, radius=RADIUS, pressed=there), build)
    assert chosen.proxy and chosen.proxy.pressed is None and made[0] == there.where
    assert chosen.reason == plan(fine, radius=RADIUS).reason


@pytest.mark.parametrize("far", [np.nan, np.inf, 1e30, 1e9])
def test_a_path_that_goes_farther_than_can_be_looked_at_is_none(far: float) -> None:
    mesh = bodies.head(20, 0.2)
    path = np.array([[0.0, 0.0, 0.1], [far, 0.0, 0.1]])
    assert pressed_by(mesh, [path], 0.004) is None


def test_a_mesh_that_is_hardly_finer_than_a_proxy_is_simulated_itself(press: BenchmarkPress) -> None:
    """A cube of 7,000 vertices on a proxy of 142 that was fine where it was pressed answered twice the law."""
    mesh = bodies.head(30, 0.2)
    model = build_model(mesh, [bodies.GEL], pinned=base_vertices(mesh))
    there = Pressed((tuple(press.at.tolist()),), RADIUS)
    chosen = plan(model, radius=RADIUS, pressed=there, budget=0.1 * processor_time.cost_of(model))
    assert chosen.reason == plan(model, radius=RADIUS, budget=0.1 * processor_time.cost_of(model)).reason
    assert chosen.proxy is None or chosen.proxy.pressed is None
