"""The planner simulates the full mesh where that runs live, else the smallest proxy within the tolerances."""

import time
from dataclasses import replace

import numpy as np
import pytest

from core import native
from core.base import TICK, DimpleError
from core.body.model import Model, build_model
from core.material import PRESETS
from core.mesh.surface import base_vertices
from core.reduction import decision, error_model, planner, processor_time
from core.reduction.active_regions import share_awake
from core.reduction.benchmark import choose_presses, compare_proxies
from core.reduction.grading import Pressed
from core.reduction.planner import Plan, plan
from core.reduction.proxy import Proxy, build_proxy
from core.session import Finger, Session
from studies import bodies
from studies.scenes import BALL, ball, cube, whole_skin

NYLON = PRESETS[0]
EVER_LIVE, NEVER_LIVE = 1e9, 0.0  # [s] per second


@pytest.fixture(scope="module")
def round_model() -> Model:
    mesh = ball(4)
    return build_model(mesh, [BALL], pinned=base_vertices(mesh))


@pytest.fixture(scope="module")
def nylon() -> Model:
    """Object 1 with 10,088 vertices."""
    mesh = cube(41, NYLON.size)
    return build_model(mesh, [NYLON.material], pinned=base_vertices(mesh))


def work(chosen: Plan) -> int:
    """Return vertices x steps per tick: the cost of a choice, the same on any machine."""
    return chosen.vertices * chosen.steps


def test_a_mesh_that_runs_live_is_simulated_in_full(round_model: Model) -> None:
    chosen = plan(round_model, budget=EVER_LIVE)
    assert chosen.proxy is None and chosen.asked == 0 and chosen.vertices == 2562
    assert (chosen.error, chosen.force_error) == (0.0, 0.0)
    assert chosen.steps == round_model.substeps(1e-3) > 1
    assert chosen.reason == f"The full mesh runs live: 2,562 vertices at {chosen.steps} steps per millisecond."


def test_a_mesh_too_slow_to_run_live_gets_a_proxy_with_a_reason(round_model: Model) -> None:
    chosen = plan(round_model, budget=NEVER_LIVE, tolerance=1e-3, force_tolerance=0.15, radius=0.02)
    assert chosen.proxy is not None and chosen.vertices < 1281
    for words in ("2,562 vertices", f"proxy of {chosen.vertices:,} vertices", ", within ", "% of the force"):
        assert words in chosen.reason


def test_tighter_tolerances_take_more_vertices(round_model: Model) -> None:
    needs = [error_model.vertices_for(round_model, t, f, 0.02) for t, f in ((2e-3, 0.9), (1e-3, 0.9), (1e-3, 0.05))]
    assert needs[0] < needs[1] < needs[2]
    # and a smaller fingertip makes a smaller dent
    small, large = (error_model.vertices_for(round_model, 1e-3, 0.1, radius) for radius in (0.005, 0.02))
    assert small > large


def test_the_largest_proxy_that_keeps_the_tolerances_without_a_margin_beats_a_full_mesh_that_is_not_live(
    round_model: Model,
) -> None:
    """It missed them by a hair on a cube of 40,000 vertices, which then ran at a thirteenth of real time."""
    shares = np.arange(0.5, 0.0, -0.002)
    share = next(f for f in shares if error_model.vertices_for(round_model, 1.0, f / decision.MARGIN, 0.02) > 1281)
    chosen = plan(round_model, budget=NEVER_LIVE, tolerance=1.0, force_tolerance=float(share), radius=0.02)
    assert chosen.proxy is not None and 1000 < chosen.vertices <= 1281
    assert chosen.force_error == pytest.approx(share, rel=0.2)


def test_where_no_proxy_is_accurate_enough_the_full_mesh_runs_slowly(round_model: Model) -> None:
    chosen = plan(round_model, budget=NEVER_LIVE, tolerance=1e-6)
    assert chosen.proxy is None and "no proxy of up to 1,281 vertices is within" in chosen.reason
    paper = build_model(round_model.mesh, [BALL], law_set="paper")
    assert "the paper's equations" in plan(paper, budget=NEVER_LIVE).reason


def test_a_full_mesh_far_from_live_gives_way_to_the_finest_live_proxy_which_says_what_it_misses() -> None:
    """A fingertip of 4 mm on a head of 60,000 vertices: in full it would run at a seventh of real time."""
    mesh = bodies.head(100, 0.2)
    model = build_model(mesh, [bodies.GEL], pinned=base_vertices(mesh))
    chosen = plan(model, radius=0.004)
    assert processor_time.cost_of(model) > decision.TOO_SLOW * processor_time.BUDGET
    assert chosen.proxy is not None and chosen.cost <= processor_time.BUDGET
    assert 2 * decision.FORCE_TOLERANCE < chosen.force_error < decision.COARSEST
    assert chosen.reason.endswith("A proxy cannot have the vertices to keep the tolerances.")
    # a fingertip that no proxy of this mesh can tell from a point is pressed in full
    assert plan(model, radius=0.001).proxy is None


@pytest.fixture(scope="module")
def large() -> Model:
    """A head of 0.6 m with edges of 5 mm: in full it would run at a fifteenth of real time."""
    mesh = bodies.head(80, 0.6)
    return build_model(mesh, [PRESETS[1].material], pinned=base_vertices(mesh))


def test_of_a_large_body_that_no_proxy_stands_for_only_what_moves_is_stepped(large: Model) -> None:
    chosen = plan(large, radius=0.01)
    assert chosen.proxy is None and chosen.vertices == len(large.mass)
    assert chosen.slack == chosen.error == pytest.approx(1e-4)
    assert 0.02 * processor_time.cost_of(large) < chosen.cost < 0.2 * processor_time.cost_of(large)
    assert "What moves by less than 0.1 mm rests; a fingertip moves about" in chosen.reason
    finer = plan(large, radius=0.01, tolerance=1e-4)
    assert finer.slack == pytest.approx(2e-5) and finer.cost > chosen.cost


def test_what_meets_others_or_is_liquid_or_runs_live_or_is_chosen_in_full_is_stepped_whole(large: Model) -> None:
    assert plan(large, radius=0.01, alone=False).slack == 0
    assert plan(large, radius=0.01, budget=EVER_LIVE).slack == 0
    assert planner.plan_full_mesh(large).slack == 0
    liquid = build_model(large.mesh, [PRESETS[2].material], pinned=large.pinned[large.mesh.source])
    assert plan(liquid, radius=0.01).slack == 0


def test_a_wide_fingertip_has_a_proxy_and_nothing_rests(large: Model) -> None:
    chosen = plan(large, radius=0.05, tolerance=5e-3)
    assert chosen.proxy is not None and chosen.slack == 0 and chosen.cost <= processor_time.BUDGET


def test_the_share_that_moves_is_near_what_is_stepped(large: Model) -> None:
    session, press = Session(large, slack=1e-4), choose_presses(large, 0.01, 3, seed=1)[1]
    stepped = []
    for k in range(15):
        at = press.at + press.outward * (0.01 - 0.005 * (k + 1) / 15)
        session.set_fingers([Finger(tuple(at), 0.01)])
        session.step(1 / 100)
        stepped.append(session._last.stepped / len(large.mass))
    assert 0.3 < np.mean(stepped) / share_awake(large, 0.01, 1e-4) < 1.2


def test_a_choice_by_hand_is_taken(round_model: Model) -> None:
    assert planner.plan_full_mesh(round_model).proxy is None
    chosen = planner.plan_proxy(round_model, 500, radius=0.02)
    assert chosen.asked == 500 and chosen.vertices == 500 and "As chosen" in chosen.reason
    with pytest.raises(DimpleError, match="from 60"):
        planner.plan_proxy(round_model, 2000, radius=0.02)


def test_where_no_proxy_can_be_made_the_next_larger_one_is_taken() -> None:
    """A belt of pins is narrower than the cells of 100 vertices, so a proxy with at most twice the work is taken."""
    belted = bodies.build(bodies.FITTED[28])
    with pytest.raises(DimpleError, match="pins are too few"):
        build_proxy(belted, 100)
    chosen = planner.plan_proxy(belted, 100, radius=0.02)
    assert 100 < chosen.asked < 2 ** (2 / 3) * 100
    with pytest.raises(DimpleError, match="not 20"):  # the number that was asked for, not the last one tried
        planner.plan_proxy(belted, 20, radius=0.02)


def test_a_plan_is_the_same_however_busy_the_computer_is(
    round_model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = plan(round_model, budget=NEVER_LIVE, tolerance=1e-3, force_tolerance=0.15, radius=0.02)
    for clock in ("perf_counter", "process_time", "time", "monotonic"):
        monkeypatch.setattr(time, clock, lambda: 1 / 0)
    again = plan(round_model, budget=NEVER_LIVE, tolerance=1e-3, force_tolerance=0.15, radius=0.02)
    assert first.proxy is not None and again.proxy is not None
    np.testing.assert_array_equal(first.proxy.seeds, again.proxy.seeds)
    assert (first.reason, first.cost) == (again.reason, again.cost)


def test_a_proxy_that_runs_live_and_nearly_keeps_the_tolerances_beats_a_slow_one(round_model: Model) -> None:
    accurate = plan(round_model, budget=NEVER_LIVE, tolerance=1e-3, radius=0.02)
    close = plan(round_model, budget=0.9 * accurate.cost, tolerance=1e-3, radius=0.02)
    assert close.vertices < accurate.vertices and close.cost <= 0.9 * accurate.cost and "runs live" in close.reason
    assert close.error < 2e-3 and close.force_error < 2 * decision.FORCE_TOLERANCE
    far = plan(round_model, budget=0.2 * accurate.cost, tolerance=1e-3, radius=0.02)
    assert far.vertices == accurate.vertices and "real time" in far.reason, "none that runs live is near"


def test_a_mesh_is_live_where_its_cost_is_as_near_to_the_budget_as_costs_are_known(round_model: Model) -> None:
    """The default cube, cut finer, took 1.004 of it, and was said to run at 1x real time anyway."""
    cost = processor_time.cost_of(round_model)
    for share, live in ((0.99, True), (0.93, False)):
        assert ("runs live" in plan(round_model, budget=share * cost).reason) == live


def test_a_full_mesh_that_nearly_runs_live_beats_a_proxy_that_misses_a_tolerance(round_model: Model) -> None:
    """A bare cone at 0.6 of real time was given a proxy that was expected to be off by a fifth of the force."""
    cost, nearly = processor_time.cost_of(round_model), 0.7 * error_model.expected(round_model, 1281, 0.02)[1]
    for share, full in ((0.6, True), (0.52, False)):
        chosen = plan(round_model, budget=share * cost, tolerance=1.0, force_tolerance=nearly, radius=0.02)
        assert (chosen.proxy is None) == full, chosen.reason


def test_a_proxy_is_not_denied_vertices_for_the_many_steps_of_a_fine_mesh() -> None:
    """Seven a tick, where the proxy takes two: counted by those, one within the tolerances would not run live."""
    mesh = bodies.head(160, 0.2)
    model = build_model(mesh, [bodies.GEL], pinned=base_vertices(mesh))
    chosen = plan(model, radius=0.008)
    assert model.substeps(TICK) > 2 * chosen.steps
    assert chosen.error <= decision.TOLERANCE and chosen.force_error <= decision.FORCE_TOLERANCE
    assert chosen.cost < processor_time.BUDGET and chosen.reason.endswith("% of the force.")


def test_the_largest_proxy_that_runs_live_and_nearly_keeps_the_tolerances_beats_a_full_mesh_that_does_not(
    round_model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(planner, "NEARLY_LIVE", 1.0)  # this mesh takes 1.7 times what its largest proxy does
    most = 1281
    tolerance = next(t for t in np.geomspace(1e-3, 1e-5) if error_model.vertices_for(round_model, t, 9.0, 0.02) > most)
    cost = planner.plan_proxy(round_model, most, radius=0.02).cost
    live = plan(round_model, budget=1.01 * cost, tolerance=tolerance, force_tolerance=9.0, radius=0.02)
    assert 0.95 * most < live.vertices <= most and tolerance < live.error < 2 * tolerance
    slow = plan(round_model, budget=NEVER_LIVE, tolerance=tolerance, force_tolerance=9.0, radius=0.02)
    assert slow.proxy is None and "no proxy of up to" in slow.reason


def test_a_proxy_that_misses_the_tolerances_says_so(round_model: Model) -> None:
    accurate = plan(round_model, budget=NEVER_LIVE, tolerance=1e-3, radius=0.02)
    missed = []
    for share in (1.1, 0.8, 0.6, 0.4):
        chosen = plan(round_model, budget=share * accurate.cost, tolerance=1e-3, radius=0.02)
        missed.append(chosen.error > 1e-3 or chosen.force_error > decision.FORCE_TOLERANCE)
        assert missed[-1] == ("A proxy within the tolerances would not run live." in chosen.reason)
    assert any(missed) and not all(missed)


def test_the_cost_counts_vertices_and_steps(round_model: Model) -> None:
    cost = processor_time.NUMPY_COST if native.why_not() else processor_time.NATIVE_COST
    assert processor_time.cost_of(round_model) == pytest.approx(2562 * round_model.substeps(1e-3) * cost / 1e-3)


def test_a_plan_is_explained_before_a_proxy_is_made(round_model: Model) -> None:
    """On a million vertices to make one takes seconds, where a plan is to be there at once."""
    decided = decision.decide(round_model, budget=NEVER_LIVE, tolerance=1e-3, force_tolerance=0.15, radius=0.02)
    made: list[int] = []

    def build(model: Model, vertices: int, _pressed: Pressed | None = None) -> Proxy:
        made.append(vertices)
        return build_proxy(model, vertices)

    chosen = planner.carry_out(decided, build)
    assert made == [decided.vertices] == [chosen.asked] and chosen.proxy is not None
    assert f"{decided.vertices:,} vertices is to be made, within " in decided.reason
    said = decided.reason.replace("is to be made", "runs at 0x real time")
    assert said.replace(f"{decided.vertices:,} vertices runs", f"{chosen.vertices:,} vertices runs") == chosen.reason


def test_where_no_proxy_can_be_made_the_full_mesh_is_simulated_or_its_stiffness_is_said(round_model: Model) -> None:
    def build(model: Model, vertices: int, _pressed: Pressed | None = None) -> Proxy:
        raise DimpleError("its surface is too crumpled")

    decided = decision.decide(round_model, budget=NEVER_LIVE, tolerance=1e-3, force_tolerance=0.15, radius=0.02)
    chosen = planner.carry_out(decided, build)
    assert chosen.proxy is None and chosen.reason.endswith("simulated anyway: its surface is too crumpled.")
    stiff = decision.decide(replace(round_model, omega_squared=1e20), tolerance=1e-3, force_tolerance=0.15, radius=0.02)
    assert "too stiff" in stiff.reason
    with pytest.raises(DimpleError, match="so stiff or light on this mesh"):
        planner.carry_out(stiff, build)


def test_stiff_nylon_runs_for_a_fraction_of_its_work(nylon: Model) -> None:
    """Object 1, 10,088 vertices: within half a millimetre and a tenth of the force, it takes under half the work."""
    chosen = plan(nylon, budget=NEVER_LIVE)
    assert chosen.proxy is not None
    assert chosen.error <= 0.5e-3 and chosen.force_error <= 0.1
    used = max(chosen.error / decision.TOLERANCE, chosen.force_error / decision.FORCE_TOLERANCE)
    assert used > 0.6, "the smallest proxy uses up the tolerances"
    assert work(chosen) < 0.5 * len(nylon.mass) * nylon.substeps(TICK)


def test_a_membrane_as_stiff_as_the_papers_runs_on_a_proxy() -> None:
    """The literal k = 54.8 N/mm needs 196 steps per tick of 10,088 vertices: 25 times what runs live."""
    model = whole_skin(cube(41, NYLON.size), NYLON.material)
    assert model.substeps(TICK) > 190
    chosen = plan(model)
    assert chosen.proxy is not None
    assert work(chosen) < 0.03 * len(model.mass) * model.substeps(TICK)
    session = Session(model, proxy=chosen.proxy)
    for down in (0.0, 0.005, 0.01, 0.01):
        session.set_fingers([Finger((0.004, 0.003, 0.035 - down), 0.01)])
        frame = session.step(0.05)
        assert frame.finite and np.ptp(session.positions(), axis=0).max() < 0.06
    assert frame.depths[0] > 5e-3 and frame.finger_forces[0, 2] > 1.0, "it is pressed and presses back"


def test_presses_are_where_the_body_is_free(round_model: Model) -> None:
    presses = choose_presses(round_model, 0.02, 20, seed=3)
    pinned = round_model.mesh.rest_positions[round_model.pinned]
    assert min(p.at[2] for p in presses) > pinned[:, 2].max()
    np.testing.assert_allclose([np.linalg.norm(p.outward) for p in presses], 1.0)
    with pytest.raises(DimpleError, match="free"):
        choose_presses(build_model(round_model.mesh, [BALL], pinned=np.ones(2562)), 0.02, 1)


def test_a_comparison_gives_errors_against_the_mesh_and_why_a_proxy_is_missing(round_model: Model) -> None:
    progress = list(compare_proxies(round_model, choose_presses(round_model, 0.02, 1), [300, 1000, 5000]))
    shares, found = [share for share, _ in progress], [o for _, o in progress if o]
    assert np.diff(shares).min() > -1e-12 and shares[-1] == pytest.approx(1.0)
    mesh, coarse, fine, too_many = found
    assert (mesh.error, mesh.vertices) == (0.0, 2562)
    assert 0 < fine.error < coarse.error < 4e-3 and fine.cost > coarse.cost > 0
    assert "from 60" in too_many.note


@pytest.mark.parametrize("seed", range(5))
def test_presses_are_spread_evenly(round_model: Model, seed: int) -> None:
    """Of 24 on a ball three fall in each octant, give or take one; drawn one by one, some would get six or none."""
    free = build_model(round_model.mesh, [BALL])
    at = np.stack([press.at for press in choose_presses(free, 0.02, 24, seed=seed)])
    middle = round_model.mesh.rest_positions.mean(axis=0)
    count = np.bincount(((at > middle) * [1, 2, 4]).sum(axis=1), minlength=8)
    assert count.sum() == 24 and (np.abs(count - 3) <= 1).all()
