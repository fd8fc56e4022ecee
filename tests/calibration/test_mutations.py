"""Damaged files give a clear error, a question or a right answer; never a wrong one in silence, never a hang."""

import random
import signal
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from core.base import DimpleError
from core.calibration.calibrate import calibrate
from core.calibration.question import Undecided
from core.calibration.reader import MAX_BYTES
from tests.calibration.damage import DAMAGE, TRUTH, WRITERS, damaged, press

HANG_S = 20  # of processor time, which no other load shortens


@contextmanager
def no_hang() -> Iterator[None]:
    if not hasattr(signal, "setitimer"):
        yield
        return

    def stop(*_: object) -> None:
        raise TimeoutError(f"still reading after {HANG_S} s")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, HANG_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def outcome(path) -> str:
    """Return what became of a file: "error", "question", "right", "warned" or "wrong in silence"."""
    try:
        with no_hang():
            done = calibrate(path)
    except Undecided as undecided:
        assert undecided.questions and all(question.candidates for question in undecided.questions)
        return "question"
    except DimpleError as error:
        assert len(str(error)) > 20
        return "error"
    fit = done.fit
    assert all(np.isfinite([fit.K1.value, fit.K2.value, fit.x0.value]))
    names = ("K1", "K2", "x0") if fit.model == "two" else ("K1",)
    right = True
    for name in names:
        constant = getattr(fit, name)
        right &= abs(constant.value - TRUTH[name]) < max(0.1 * TRUTH[name], 2 * constant.half_width)
    if right:
        return "right"
    return "warned" if done.warnings else "wrong in silence"


@pytest.mark.parametrize("files", [6, pytest.param(30, marks=pytest.mark.slow)])
def test_undamaged_files_are_right(files, write):
    for seed in range(files):
        rng = random.Random(seed)
        text, encoding = WRITERS[seed % len(WRITERS)](*press(rng))
        assert outcome(write(text, encoding)) == "right", (seed, WRITERS[seed % len(WRITERS)].__name__)


@pytest.mark.parametrize("seed", [1204, 1708])
def test_a_press_that_breaks_off_soon_after_the_touch_has_one_slope_or_is_asked_about(seed, write):
    """Two pieces through its noise would have their knee before the touch."""
    content, _ = damaged(seed)
    assert outcome(write(content)) in ("right", "question")


@pytest.mark.parametrize("step", [9, pytest.param(1, marks=pytest.mark.slow)])
def test_of_500_damaged_files_none_is_wrong_in_silence(step, write):
    """Every ninth of them still has every kind of damage and every instrument."""
    count: Counter[str] = Counter()
    wrong, seeds = [], range(0, 500, step)
    assert {seed % len(DAMAGE) for seed in seeds} == set(range(len(DAMAGE)))
    assert {seed // len(DAMAGE) % len(WRITERS) for seed in seeds} == set(range(len(WRITERS)))
    for seed in seeds:
        content, what = damaged(seed)
        result = outcome(write(content))
        count[result] += 1
        if result == "wrong in silence":
            wrong.append(what)
    assert wrong == []
    assert count["right"] > len(seeds) / 4, count  # not by refusing everything
    assert count["warned"] < len(seeds) / 20, count
    assert count["question"] and count["error"], count


@pytest.mark.parametrize("size", [MAX_BYTES + 1, 200 * 2**20])
def test_sizes_beyond_the_limit_are_refused_at_once(size, tmp_path):
    path = tmp_path / "huge.csv"
    with path.open("wb") as file:
        file.write(b"Depth (mm),Force (N)\n" + b"1.0,2.0\n" * 1000)
        file.truncate(size)
    with pytest.raises(DimpleError, match="larger than 64 MB"):
        calibrate(path)
