"""The planner simulates the full mesh where that runs live, else the even proxy that the budget pays for."""

import time
from dataclasses import replace

import numpy as np
import pytest

from core.base import DimpleError
from core.body.model import Model, build_model
from core.mesh.surface import base_vertices
from core.reduction import proxy_rule
from core.reduction.proxy import SMALLEST, Proxy, build_proxy
from core.reduction.proxy_rule import plan, runs_live
from studies.meshes import bodies
from studies.scenes import BALL, BUDGET, ball, cube

EVER_LIVE = 1e9  # [s] per second
RADIUS = 0.01  # [m]


@pytest.fixture(scope="module")
def round_model() -> Model:
    mesh = ball(4)
    return build_model(mesh, [BALL], pinned=base_vertices(mesh))


def test_a_mesh_that_runs_live_is_simulated_in_full(round_model: Model) -> None:
    chosen = plan(round_model, radius=RADIUS, budget=EVER_LIVE)
    assert chosen.proxy is None and chosen.asked == 0 and chosen.error == 0.0
    steps = round_model.substeps(1e-3)
    assert chosen.reason == f"The full mesh runs live: 2,562 vertices at {steps} steps per millisecond."


def test_a_mesh_too_slow_to_run_live_gets_a_proxy_that_does_with_a_reason(round_model: Model) -> None:
    cost = proxy_rule.cost_of(round_model)
    chosen = plan(round_model, radius=0.02, budget=0.2 * cost)
    assert chosen.proxy is not None and runs_live(chosen.cost, 0.2 * cost)
    vertices, off = len(chosen.proxy.seeds), f"{1e3 * chosen.error:.2g}"
    for words in (
        "would run at 0.2x real time (2,562 vertices", f"A proxy of {vertices:,} vertices runs live; ",
        f"its dents are within {off} mm of the mesh's.",
    ):  # fmt: skip
        assert words in chosen.reason


@pytest.mark.parametrize("share", [0.8, 0.5, 0.2, 0.05])
def test_what_is_simulated_runs_live_and_uses_up_most_of_the_budget(round_model: Model, share: float) -> None:
    budget = share * proxy_rule.cost_of(round_model)
    chosen = plan(round_model, radius=RADIUS, budget=budget)
    assert chosen.proxy is not None and runs_live(chosen.cost, budget)
    assert chosen.cost > 0.5 * budget or len(chosen.proxy.seeds) == 1281, "a proxy has at most half of the vertices"


def test_a_head_too_fine_to_run_live_gets_a_proxy_that_the_budget_pays_for_whatever_the_fingertip() -> None:
    mesh = bodies.head(100, 0.2)
    model = build_model(mesh, [bodies.GEL], pinned=base_vertices(mesh))
    wide, small = (plan(model, radius=radius, budget=BUDGET) for radius in (0.016, 0.004))
    assert wide.proxy and small.proxy and wide.asked == small.asked
    assert 0.5 * BUDGET < wide.cost and runs_live(wide.cost, BUDGET)
    assert small.error == pytest.approx(4 * wide.error), "a small fingertip's dent is curved more"


def test_where_no_proxy_can_be_made_the_full_mesh_runs_slowly() -> None:
    few = build_model(cube(4, 0.05), [BALL], pinned=base_vertices(cube(4, 0.05)))
    assert plan(few, radius=RADIUS, budget=1e-9).proxy is None, "98 vertices have no proxy"


def test_a_choice_by_hand_is_taken(round_model: Model) -> None:
    assert proxy_rule.plan_full_mesh(round_model, budget=BUDGET).proxy is None
    chosen = proxy_rule.plan_proxy(round_model, 500, radius=0.02, budget=BUDGET)
    assert chosen.proxy and chosen.asked == len(chosen.proxy.seeds) == 500 and "As chosen" in chosen.reason
    with pytest.raises(DimpleError, match="from 60"):
        proxy_rule.plan_proxy(round_model, 2000, radius=0.02, budget=BUDGET)


def test_where_no_proxy_can_be_made_the_next_larger_one_is_taken() -> None:
    """A belt of pins is narrower than the cells of 100 vertices, so a proxy with at most twice the work is taken."""
    belted = bodies.build(bodies.BODIES[28])
    with pytest.raises(DimpleError, match="pins are too few"):
        build_proxy(belted, 100)
    chosen = proxy_rule.plan_proxy(belted, 100, radius=0.02, budget=BUDGET)
    assert 100 < chosen.asked < 2 ** (2 / 3) * 100
    with pytest.raises(DimpleError, match="not 20"):  # the number that was asked for, not the last one tried
        proxy_rule.plan_proxy(belted, 20, radius=0.02, budget=BUDGET)


def test_a_plan_is_the_same_however_busy_the_computer_is(round_model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    budget = 0.2 * proxy_rule.cost_of(round_model)
    first = plan(round_model, radius=RADIUS, budget=budget)
    for clock in ("perf_counter", "process_time", "time", "monotonic"):
        monkeypatch.setattr(time, clock, lambda: 1 / 0)
    again = plan(round_model, radius=RADIUS, budget=budget)
    assert first.proxy is not None and again.proxy is not None
    np.testing.assert_array_equal(first.proxy.seeds, again.proxy.seeds)
    assert (first.reason, first.cost) == (again.reason, again.cost)


def test_a_mesh_is_live_where_its_cost_is_as_near_to_the_budget_as_costs_are_known(round_model: Model) -> None:
    """The default cube, cut finer, took 1.004 of it, and was said to run at 1x real time anyway."""
    cost = proxy_rule.cost_of(round_model)
    for share, live in ((0.99, True), (0.93, False)):
        assert (plan(round_model, radius=RADIUS, budget=share * cost).proxy is None) == live


def test_where_none_of_any_size_can_be_made_the_full_mesh_is_simulated_or_its_stiffness_is_said(
    round_model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    def build(model: Model, vertices: int) -> Proxy:
        raise DimpleError("its surface is too crumpled.")

    monkeypatch.setattr(proxy_rule, "proxy_of", build)
    chosen = plan(round_model, radius=RADIUS, budget=1e-9)
    assert chosen.proxy is None and chosen.reason.endswith("simulated anyway: its surface is too crumpled.")
    with pytest.raises(DimpleError, match="so stiff or light on this mesh"):
        plan(replace(round_model, omega_squared=1e20), radius=RADIUS, budget=BUDGET)


def test_a_budget_that_pays_for_nothing_gets_the_smallest_proxy(round_model: Model) -> None:
    chosen = plan(round_model, radius=RADIUS, budget=1e-9)
    assert chosen.proxy is not None and chosen.asked < 2 * SMALLEST and "real time; its dents" in chosen.reason
