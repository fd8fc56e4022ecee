"""Files that an earlier reader got wrong, and five more of each kind: right with the likeliest answers, and unasked."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from core.calibration.fit import Constant
from core.calibration.virtual_press import write_press
from tests.calibration.test_specimens import by_default

HARD = Path(__file__).parents[3] / "shared" / "data" / "calibration" / "hard"
# K1, K2 [N/m], x0 [mm], touch [mm of the file], tare [N]; by least squares over a grid of touch and knee
RIGHT = {
    "two_equal_answers": (170, 8700, 4.0, 0.0, 0.0), "preload_dome": (100, 4667, 4.32, None, 0.0),
    "air_poke_1": (463, 621, 2.07, -3.81, -0.036), "air_poke_2": (230, 428, 1.54, -3.65, -0.037),
    "gel": (1751, None, None, 0.0, 0.0), "gel_load_cell_below": (1751, None, None, 0.0, -7.95),
    "untared_approach": (398, 892, None, -6.94, -0.42), "air_skin": (None, None, None, 2.665, 0.34),
}  # fmt: skip
ASKED = {"preload_dome": ["contact_mm"]}


@pytest.mark.skipif(not HARD.is_dir(), reason="the shared data is not here")
@pytest.mark.parametrize("name", RIGHT)
def test_a_hard_file_is_right_with_the_likeliest_answers(name: str) -> None:
    *constants, touch, tare = RIGHT[name]
    asked, done = by_default(HARD / f"{name}.csv")
    assert asked == ASKED.get(name, [])
    for constant, right, unit in zip((done.fit.K1, done.fit.K2, done.fit.x0), constants, (1, 1, 1e3), strict=True):
        assert right is None or holds(constant, right / unit)
    if name == "air_skin":  # one slope by eye; by its rows two, one below and one above it
        assert done.fit.K1.value < 8.2e4 < done.fit.K2.value
    span = 1e3 * float(done.measurement.depth.max() - done.measurement.depth.min())
    assert touch is None or done.loading.reading(0) == pytest.approx(touch, abs=0.02 * span)
    assert done.loading.tare == pytest.approx(tare, abs=max(0.03 * abs(tare), 0.01))


def holds(constant: Constant, truth: float) -> bool:
    return abs(constant.value - truth) <= constant.half_width


def dome(x: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return the force of a rubber dome [N] at depths of 0 to 1 (n,): it rises, snaps, and meets the base."""
    snap, base = random.uniform(0.3, 0.5), random.uniform(0.8, 0.9)
    rise = np.sin(np.pi * np.minimum(x, base) / (2 * snap)) * np.exp(-2 * np.maximum(x - snap, 0))
    return np.maximum(rise, 0.3 * (x > snap)) + 40 * np.maximum(x - base, 0)


def gel(x: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return the force of a gel [N] at depths of 0 to 1 (n,), which stiffens smoothly."""
    return 160 * (0.1 * x + 0.9 * x ** random.uniform(3, 6))


def bent(x: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return the force of a foam [N] at depths of 0 to 1 (n,): two slopes."""
    return np.minimum(x, 0.5) + random.uniform(1.8, 4) * np.maximum(x - 0.5, 0)


# force, where the file begins [share of the depth], tare and noise [share of full scale], what is asked
MADE: dict[str, tuple[Callable, float, float, float, list[str]]] = {
    "key switch": (dome, 0.0, 0.0, 1e-4, []), "preloaded dome": (dome, 0.1, 0.0, 1e-4, ["contact_mm"]),
    "poke with air": (bent, -0.9, -0.02, 0.04, []), "skin with air": (gel, -0.7, 0.02, 1e-3, []),
    "gel": (gel, 0.0, 0.0, 1e-3, []), "gel on a cell below 0": (gel, 0.0, -0.05, 1e-3, []),
    "foam on an untared cell": (bent, -0.5, -0.3, 0.02, []),
}  # fmt: skip


@pytest.mark.parametrize("kind", MADE)
@pytest.mark.parametrize("seed", range(5))
def test_five_more_of_each_kind_have_the_touch_and_the_tare_that_made_them(kind: str, seed: int, tmp_path) -> None:
    law, start, tare, noise, questions = MADE[kind]
    random = np.random.default_rng(seed)
    x = np.linspace(start, 1, 400)
    exact = law(np.maximum(x, 0), random)
    full = float(exact.max())
    write_press(tmp_path / "x.csv", 0.01 * (x - start), exact + full * (tare + noise * random.normal(size=400)))
    asked, done = by_default(tmp_path / "x.csv")
    # a dome that snaps before a tenth of the full force is no press of two slopes: then that is said instead
    assert asked == questions or (law is dome and any("misses the measured points" in each for each in done.warnings))
    assert done.loading.tare == pytest.approx(tare * full, abs=0.03 * full)
    if law is bent:
        assert done.fit.K1.value == pytest.approx(100, abs=1.5 * done.fit.K1.half_width)
    if not questions:
        assert done.loading.reading(0) == pytest.approx(-10 * start, abs=1.5 if law is gel else 0.3)
    elif asked:
        assert done.loading.reading(0) < 0, "pressed already"
