"""Beside a fit by brute force: the intervals hold the truth as often as they say, and nothing is silently wrong."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from core.base import Floats
from core.calibration.calibrate import Calibration, calibrate
from core.calibration.question import Answers, Undecided
from core.calibration.virtual_press import write_press

KINDS = ("touch", "air", "air and tare", "pressed already", "untared", "adhesion", "drift")


@dataclass
class Press:
    """A press that was made up: depth [m] from the file's own zero, force [N], and what made it."""

    kind: str
    depth: Floats
    force: Floats
    K1: float
    K2: float
    x0: float
    touch: float
    tare: float


def made(seed: int) -> Press:
    """Make up a press with 1 to 3 % of noise, of each kind in turn."""
    random, kind = np.random.default_rng(seed), KINDS[seed % len(KINDS)]
    K1, rows = 10 ** random.uniform(1.5, 4.5), int(random.choice([120, 300, 900]))
    K2, deepest = K1 * 10 ** random.uniform(np.log10(2), 1), 10 ** random.uniform(-3, -1.5)
    x0 = deepest * random.uniform(0.35, 0.7)
    starts = {"touch": 0.0, "untared": 0.0, "pressed already": x0 * random.uniform(0.2, 0.5)}
    start = starts.get(kind, -deepest * random.uniform(0.2, 1.0))
    depth = np.linspace(start, deepest, rows)
    inside = np.maximum(depth, 0)
    force = K1 * np.minimum(inside, x0) + K2 * np.maximum(inside - x0, 0)
    full, tare = float(force.max()), 0.0
    if kind in ("air and tare", "untared"):
        tare = float(random.choice([-1, 1]) * random.uniform(0.1, 0.3) * full)
    if kind == "adhesion":
        force = force - 0.15 * full * np.exp(-(((depth - 0.2 * start) / (0.06 * start)) ** 2))
    if kind == "drift":
        force = force + random.uniform(-0.03, 0.03) * full * np.linspace(0, 1, rows)
    force = force + tare + random.uniform(0.01, 0.03) * full * random.normal(size=rows)
    zero = 0.0 if kind in ("touch", "untared") else start if kind == "pressed already" else random.choice([0.0, start])
    return Press(kind, depth - zero, force, K1, K2, x0, -zero, tare)


def by_brute_force(press: Press) -> tuple[Floats, Floats]:
    """Return K1, K2, x0 of the least squares over a grid of touch and knee, refined, and their standard errors."""
    x, f = press.depth, press.force
    fixed_touch, no_tare = press.kind in ("touch", "untared"), press.kind in ("touch", "pressed already")
    if press.kind == "adhesion":  # the way down to the dip and up again is no part of the law
        away = np.abs((x - press.touch - 0.2 * (x[0] - press.touch)) / (0.06 * (x[0] - press.touch))) > 3
        x, f = x[away], f[away]
    span, first = float(np.ptp(x)), float(x[0])
    touches = [first] if fixed_touch else np.linspace(first - span * (press.kind == "pressed already"), x[-1], 40)

    def columns(touch: float, knee: float) -> Floats:
        u = np.maximum(x - touch, 0)
        tare = np.zeros_like(x) if no_tare else np.ones_like(x)
        return np.stack([np.minimum(u, knee), np.maximum(u - knee, 0), tare], axis=1)

    best = (np.inf, np.zeros(5))
    for touch in touches:
        for knee in np.linspace(0, x[-1] - touch, 40)[2:-2]:
            found, *_ = np.linalg.lstsq(columns(touch, knee), f, rcond=None)
            loss = float(((f - columns(touch, knee) @ found) ** 2).sum())
            if loss < best[0] and found[:2].min() > 0:
                best = (loss, np.array([*found, knee, touch]))
    free = [0, 1, 3, *([] if no_tare else [2]), *([] if fixed_touch else [4])]
    scale = np.array([best[1][0], best[1][1], press.force.max(), span, span])

    def residual(step: Floats) -> Floats:
        values = best[1].copy()
        values[free] += step * scale[free]
        return (f - columns(values[4], values[3]) @ values[:3]) / press.force.max()

    done = least_squares(residual, np.zeros(len(free)), x_scale=0.01, diff_step=1e-6)
    values = best[1].copy()
    values[free] += done.x * scale[free]
    variance = 2 * done.cost / (len(x) - len(free))
    errors = np.sqrt(variance * np.diag(np.linalg.pinv(done.jac.T @ done.jac))) * scale[free]
    return values[[0, 1, 3]], errors[:3]


def by_one_who_saw_it(path: Path, press: Press) -> tuple[list[str], Calibration]:
    """Calibrate; answer every question with the touch nearest to that of the press."""
    answers, asked = Answers(), []
    while True:
        try:
            return asked, calibrate(path, answers)
        except Undecided as undecided:
            (question,) = undecided.questions
            asked.append(question.name)
            touches = [float(candidate.value) for candidate in question.candidates]
            nearest = min(touches, key=lambda each: abs(each - 1e3 * press.touch))
            answers = replace(answers, **{question.name: nearest})


@pytest.mark.parametrize("files", [42, pytest.param(300, marks=pytest.mark.slow)])
def test_a_touch_or_a_tare_that_is_typed_is_taken_and_not_asked_about(files: int, tmp_path: Path) -> None:
    """And the interval of a touch that was found with a typed tare is in those of the constants."""
    inside: dict[str, list[bool]] = {name: [] for name in ("K1", "K2", "x0")}
    for press in map(made, range(files)):
        write_press(tmp_path / "x.csv", press.depth, press.force)
        touched = calibrate(tmp_path / "x.csv", Answers(contact_mm=1e3 * press.touch))
        assert touched.loading.reading(0) == pytest.approx(1e3 * press.touch)
        tared = calibrate(tmp_path / "x.csv", Answers(tare_n=press.tare))
        assert tared.loading.tare == pytest.approx(press.tare)
        for name in inside if press.kind not in ("adhesion", "drift") else ():
            constant = getattr(tared.fit, name)
            inside[name].append(abs(constant.value - getattr(press, name)) <= constant.half_width)
    for name, held in inside.items():
        assert np.mean(held) >= (0.90 if files == 300 else 0.85), (name, np.mean(held))


@pytest.mark.parametrize("files", [42, pytest.param(300, marks=pytest.mark.slow)])
def test_the_intervals_hold_the_truth_and_nothing_is_wrong_in_silence(files: int, tmp_path: Path) -> None:
    names, silent = ("K1", "K2", "x0"), []
    inside: dict[str, list[bool]] = {name: [] for name in names}
    for seed in range(files):
        press = made(seed)
        write_press(tmp_path / "x.csv", press.depth, press.force)
        asked, done = by_one_who_saw_it(tmp_path / "x.csv", press)
        brute, errors = by_brute_force(press)
        off = []
        for i, name in enumerate(names):
            constant, truth = getattr(done.fit, name), getattr(press, name)
            off.append(abs(constant.value - truth) / max(constant.half_width, 1e-300))
            if press.kind != "drift":  # that of the force changes both slopes, as is said where it shows
                inside[name].append(off[-1] <= 1)
                inside.setdefault(f"brute {name}", []).append(abs(brute[i] - truth) <= 1.97 * errors[i])
        if max(off) > 3 and not asked and not done.warnings:
            silent.append((seed, press.kind, off))
    assert silent == []
    for name, held in inside.items():
        least = 0.90 if files == 300 else 0.85  # of 36 that are no drift, 95 % less two standard errors is 0.88
        assert least <= np.mean(held) <= 0.98, (name, np.mean(held))
