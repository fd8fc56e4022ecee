"""The planner's choices against the best ones, and the fit that its constants come from."""

import csv
import math
from pathlib import Path

import pytest

from core.reduction import planner
from studies import bodies, proxies
from studies.bodies import BodyCase
from studies.proxies import LINE, NEVER, SLACK, ProxyBenchmark, Row

CHARTS = Path(__file__).parent / "charts"


def kept(name: str) -> list[dict[str, str]]:
    with (CHARTS / name).open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    """The rows that `python3 dev.py charts --keep` measured for the fit."""
    return [
        Row(
            body=row["body"], vertices=int(row["vertices"]), share=float(row["spacing_over_radius"]),
            error=float(row["error_over_radius"]), force_error=float(row["force_error"]),
        )
        for row in kept("proxies_fit.csv")
        if row["fitted"] == "1"
    ]  # fmt: skip


def test_the_planners_constants_are_those_of_the_fit(rows: list[Row]) -> None:
    assert {row.body for row in rows} == {body.name for body in bodies.FITTED}
    given = (planner.ERROR, planner.ERROR_POWER, planner.FORCE_ERROR, planner.FORCE_POWER)
    assert proxies.fit(rows) == pytest.approx(given, rel=0.05)  # the proxies of another numpy version move them by 4 %


def test_a_fitted_body_measured_again_gives_what_was_kept(rows: list[Row]) -> None:
    """In the mean to 15 percent: rounding chooses between seeds equally far, so another numpy makes other proxies."""
    body = bodies.FITTED[3]
    again = proxies.rows(ProxyBenchmark(body, bodies.build(body)))
    mine = [row for row in rows if row.body == body.name]
    assert [row.vertices for row in again] == pytest.approx([row.vertices for row in mine], rel=0.01)
    for name in ("error", "force_error"):
        ratios = [getattr(one, name) / getattr(other, name) for one, other in zip(again, mine, strict=True)]
        assert math.prod(ratios) ** (1 / len(ratios)) == pytest.approx(1, abs=0.15), name


def test_no_shape_is_fitted_and_unseen() -> None:
    fitted, unseen, fresh = ({b.shape for b in group} for group in (bodies.FITTED, bodies.UNSEEN, bodies.FRESH))
    assert not fitted & (unseen | fresh) and not unseen & fresh


@pytest.mark.parametrize("body", [
    bodies.FRESH[4], *(pytest.param(bodies.UNSEEN[k], marks=pytest.mark.slow) for k in (3, 9, 11))
], ids=lambda body: body.name)  # fmt: skip
def test_choices_for_an_unseen_body_keep_their_tolerances_for_half_more_than_the_best_costs(body: BodyCase) -> None:
    """Measured by presses the planner did not see, so up to a third over; costs are counted: vertices x steps."""
    benchmark = ProxyBenchmark(body, bodies.build(body, 20))
    near = proxies.tolerances(body)[-1]
    for chosen in proxies.choices(benchmark, budget=NEVER, near=[near]):
        assert chosen.plan.proxy is not None
        assert chosen.excess <= SLACK
        assert chosen.ratio <= LINE


def test_the_best_is_the_cheapest_that_meets_the_tolerances_on_both_halves() -> None:
    body = bodies.UNSEEN[9]
    benchmark = ProxyBenchmark(body, bodies.build(body, 12), half=2)
    rungs = benchmark.ladder()
    assert [rung.vertices for rung in rungs] == sorted(rung.vertices for rung in rungs)
    assert rungs[-1].error == 0.0 and rungs[-1].meets(0.0, 0.0)
    near = (1.01 * max(h.error for h in rungs[-2].halves), 1.01 * max(h.force_error for h in rungs[-2].halves))
    assert rungs[-2].meets(*near) and not rungs[-2].meets(0.5 * near[0], near[1])
