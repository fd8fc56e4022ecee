"""Which methods are worth offering, and where they diverge: what the kept charts say."""

from __future__ import annotations

import math

import pytest

from studies.charts import KEPT
from studies.charts.stability import bound, linearised, small_body
from studies.charts.work_precision import DECADES, NATIVE, Point, cases, exact, front, kept, run
from studies.files import read_csv
from studies.methods.registry import METHODS

FRONTS = KEPT / "fronts.csv"


def point(method: str, error: float, cost: float, unsolved: int = 0) -> Point:
    return Point(case="x", method=method, steps=1, error=error, cost=cost, unsolved=unsolved)


def test_the_front_is_the_cheapest_solved_run_in_numpy_and_of_equals_the_most_accurate() -> None:
    runs = [
        point("rk4", 1e-5, 9.0), point("semi_implicit", 5e-2, 1.05), point("velocity_verlet", 2e-2, 1.1),
        point("explicit_euler", math.inf, 0.1), point("backward_euler", 1e-6, 0.1, unsolved=1),
        point(NATIVE, 1e-6, 0.01),
    ]  # fmt: skip
    found = front(runs)
    assert {bound: p.method for bound, p in found.items() if p} == {
        1e-1: "velocity_verlet", 1e-2: "rk4", 1e-3: "rk4", 1e-4: "rk4", 1e-5: "rk4",
    }  # fmt: skip
    assert found[1e-6] is None


def test_the_kept_fronts_name_every_scene_and_runs_that_meet_their_bound() -> None:
    rows = read_csv(FRONTS)
    assert {row["scene"] for row in rows} == {case.name for case in cases(quick=False)}
    for row in rows:
        assert row["method"] in METHODS
        assert float(row["error_at_most"]) in DECADES
        assert float(row["relative_error"]) <= float(row["error_at_most"])


def test_the_products_method_is_on_a_front_and_the_one_that_only_shows_a_failure_is_on_none() -> None:
    best = {row["method"] for row in read_csv(FRONTS)}
    assert "semi_implicit" in best
    assert "explicit_euler" not in best


def test_the_kept_fronts_are_those_of_the_kept_points() -> None:
    """A front depends on costs, so it is not measured again here."""
    points = kept(KEPT / "work_precision.csv")
    wanted = {(s, b): p.method for s, some in points.items() for b, p in front(some).items() if p}
    assert {(row["scene"], float(row["error_at_most"])): row["method"] for row in read_csv(FRONTS)} == wanted


def test_what_is_on_the_front_of_the_oscillator_comes_as_near_when_it_is_run_again() -> None:
    case = next(case for case in cases(quick=True) if case.name == "oscillator")
    wanted = exact(case)
    for row in read_csv(FRONTS):
        if row["scene"] == case.name:
            error = run(case, row["method"], int(row["steps"]), wanted).error
            assert error == pytest.approx(float(row["relative_error"]), rel=0.02, abs=1e-9)


def test_the_kept_map_has_limits_within_a_tenth_of_theory_over_four_decades_and_none_for_the_rest() -> None:
    found = [row for row in read_csv(KEPT / "stability_bounds.csv") if row["measured_dt_s"] != "nan"]
    for method in {row["method"] for row in found}:
        mine = [row for row in found if row["method"] == method]
        k = [float(row["k_n_per_m"]) for row in mine]
        assert max(k) / min(k) > 0.99e4
        limit = bound(method, linearised(small_body(k[0])))  # by theory as it is now, not as it was kept
        assert limit == pytest.approx(float(mine[0]["bound_dt_s"]), rel=1e-6)
        assert all(float(r["measured_dt_s"]) == pytest.approx(float(r["bound_dt_s"]), rel=0.1) for r in mine)
    diverged = {row["method"] for row in read_csv(KEPT / "stability.csv") if row["label"] == "diverged"}
    assert diverged == {row["method"] for row in found} == {n for n, m in METHODS.items() if m.kind == "explicit"}
