"""What the planner says of the shape of a dent holds for the proxies of thirty bodies."""

import numpy as np
import pytest

from core.reduction.proxy_rule import surface_error
from studies.charts import KEPT, proxies
from studies.charts.proxies import Row
from studies.files import read_csv
from studies.meshes import bodies


@pytest.fixture(scope="module")
def rows() -> list[Row]:
    """What `python3 dev.py charts --out tests/studies/charts` measured."""
    return [
        Row(
            body=row["body"], vertices=int(row["vertices"]), share=float(row["spacing_over_radius"]),
            spread=float(row["spread_over_radius"]), error=float(row["error_over_radius"]),
        )
        for row in read_csv(KEPT / "proxies.csv")
    ]  # fmt: skip


def test_nineteen_of_twenty_proxies_keep_in_49_of_50_presses_what_is_said_and_it_is_not_twice_what_is_so(
    rows: list[Row],
) -> None:
    assert {row.body for row in rows} == {body.name for body in bodies.BODIES}
    kept = np.array([row.error / surface_error(row.share, 1.0) for row in rows])
    assert np.mean(kept <= 1) > 0.95
    assert 0.5 < np.median(kept) < 0.7


def test_a_body_measured_again_gives_what_was_kept(rows: list[Row]) -> None:
    """In the mean to 15 percent: rounding chooses between seeds equally far, so another numpy makes other proxies."""
    body = bodies.BODIES[3]
    mine, again = [row for row in rows if row.body == body.name], list(proxies.rows(body))
    assert [row.vertices for row in again] == [row.vertices for row in mine]
    off = [np.log(one.error / row.error) for one, row in zip(again, mine, strict=True)]
    assert np.exp(np.mean(off)) == pytest.approx(1, abs=0.15)
