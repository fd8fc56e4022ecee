"""Real files that an earlier reader got wrong: each is right with the likeliest answers."""

from pathlib import Path

import pytest

from tests.calibration.test_specimens import by_default

HARD = Path(__file__).parents[3] / "shared" / "data" / "calibration" / "hard"
# K1 [N/m], touch [mm of the file], tare [N], and what is asked; by least squares over a grid of touch and knee
RIGHT = {
    "two_equal_answers": (170, 0.0, 0.0, []), "preload_dome": (100, None, 0.0, ["contact_mm"]),
    "air_poke_1": (463, -3.81, -0.036, []), "air_poke_2": (230, -3.65, -0.037, []),
    "gel": (1751, 0.0, 0.0, []), "gel_load_cell_below": (1751, 0.0, -7.95, []),
    "untared_approach": (398, -6.94, -0.42, []), "air_skin": (None, 2.665, 0.34, []),
}  # fmt: skip


@pytest.mark.skipif(not HARD.is_dir(), reason="the shared data is not here")
@pytest.mark.parametrize("name", RIGHT)
def test_a_hard_file_is_right_with_the_likeliest_answers(name: str) -> None:
    K1, touch, tare, questions = RIGHT[name]
    asked, done = by_default(HARD / f"{name}.csv")
    assert asked == questions
    if K1 is None:  # one slope by eye; by its rows two, one below and one above it
        assert done.fit.K1.value < 8.2e4 < done.fit.K2.value
    else:
        assert abs(done.fit.K1.value - K1) < done.fit.K1.half_width
    span = 1e3 * float(done.measurement.depth.max() - done.measurement.depth.min())
    assert touch is None or done.loading.reading(0) == pytest.approx(touch, abs=0.02 * span)
    assert done.loading.tare == pytest.approx(tare, abs=max(0.03 * abs(tare), 0.01))
