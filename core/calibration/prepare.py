"""From a recording to one loading curve: sign, cycles, dwell, first touch, tare, and the work lost in unloading."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base import DimpleError, Floats
from .contact import find_touch
from .fit import Free
from .question import Answers, Candidate, Question, Undecided, WrongColumns
from .reader import Measurement
from .strokes import FULL, Cycle, find_cycles, moving, roughness, spikes
from .table import MIN_ROWS

_AGREE = 0.10  # of full scale, RMS: cycles that differ more are different presses
_SNAP = 0.10  # of full scale: a fall of the force while the depth grows
_MANY = 60  # reversals: rows are not in the order they were measured
_EVEN, _UNEVEN = 0.05, 0.35  # scatter of the steps of a driven axis, and of what cannot be one


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadingCurve:
    """One press of a recording, its rows in the order they were measured.

    depth: (n,) from the first touch, negative before it [m].
    force: (n,) tared [N].
    unloading_depth: (m,) from the first touch [m], empty where there is no unloading.
    unloading_force: (m,) tared [N].
    free: which of the touch and the tare are estimates; see fit.fit_law.
    cycle: which press it is, counted from 1.
    cycles: how many there are.
    touch: of the first touch, in the file's own depth [m].
    tare: force at the first touch [N].
    loss: share of the work that unloading does not return, None where it is not known.
    notes: messages about how the press was prepared.
    warnings: messages about what may be wrong.
    """

    depth: Floats
    force: Floats
    unloading_depth: Floats
    unloading_force: Floats
    free: Free
    cycle: int
    cycles: int
    touch: float
    tare: float
    loss: float | None
    notes: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def damping_ratio(self) -> float | None:
        """Return the damping ratio of a linear body with this loss, a hint only.

        One loop from 0 to a depth X loses pi c w (X/2)^2 of the k X^2 / 2 put in; with c w = 2 z k that is pi z.
        """
        return None if self.loss is None else self.loss / math.pi


def prepare(measurement: Measurement, answers: Answers | None = None) -> LoadingCurve:
    """Prepare a recording.

    Raises:
        Undecided: which way presses, or which of several cycles, is open.
        DimpleError: there is no press in it.
    """
    answers = answers or Answers()
    notes: list[str] = []
    warnings: list[str] = []
    depth, force = _without_spikes(measurement, warnings)
    if np.ptp(depth) == 0 or np.ptp(force) == 0:
        raise DimpleError("The depth or the force is the same in every row, so there is no press to fit.")
    force = _pressing_sign(force, answers, notes)
    depth = _inward_sign(depth, force, notes)
    _check_columns(measurement, depth, force, answers)
    cycles = find_cycles(depth)
    if not cycles:
        raise DimpleError("The depth never grows: the file holds unloading only, no press.")
    cycles = _long_enough(cycles, depth, notes)
    if len(cycles) > max(_MANY, 1) or (len(cycles) > 8 and len(depth) / len(cycles) < 16):
        raise DimpleError(
            f"The depth turns back {len(cycles)} times in {len(depth)} rows: they are not in the order measured, "
            "or the depth is not the column taken."
        )
    strokes = [_stroke(depth, force, cycle, answers) for cycle in cycles]
    chosen = _choose(strokes, answers, notes)
    stroke = strokes[chosen]
    notes.append(stroke.note)
    if stroke.dwelt:
        notes.append(f"{stroke.dwelt} rows in which the depth stood still were left out.")
    _look_for_snap(stroke, warnings)
    unloading = slice(cycles[chosen].peak, cycles[chosen].end + 1)
    unloading_depth, unloading_force = depth[unloading] - stroke.touch, force[unloading] - stroke.tare
    return LoadingCurve(
        depth=stroke.depth, force=stroke.force, unloading_depth=unloading_depth, unloading_force=unloading_force,
        free=stroke.free, cycle=chosen + 1, cycles=len(cycles), touch=stroke.touch, tare=stroke.tare,
        loss=_loss(stroke, unloading_depth, unloading_force), notes=tuple(notes), warnings=tuple(warnings),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class _Stroke:
    """One loading stroke from the first touch.

    depth: (n,) [m].
    force: (n,) tared [N].
    touch: in the file's own depth [m].
    tare: force at the touch [N].
    free: which of both are estimates.
    dwelt: number of rows that were left out because the depth stood still.
    note: a message about how the touch was found.
    """

    depth: Floats
    force: Floats
    touch: float
    tare: float
    free: Free
    dwelt: int
    note: str


def _without_spikes(measurement: Measurement, warnings: list[str]) -> tuple[Floats, Floats]:
    depth, force = measurement.depth, measurement.force
    wrong = spikes(depth) | spikes(force)
    if wrong.any():
        rows = ", ".join(str(row + 1) for row in np.flatnonzero(wrong)[:5])
        more = " ..." if wrong.sum() > 5 else ""
        warnings.append(f"{int(wrong.sum())} rows stand apart from their neighbours and were left out ({rows}{more}).")
    return depth[~wrong], force[~wrong]


def _pressing_sign(force: Floats, answers: Answers, notes: list[str]) -> Floats:
    """Return the force with pressing positive."""
    if answers.press not in (None, "positive", "negative"):
        raise DimpleError(f"The sign of a press is positive or negative (it is {answers.press}).")
    start = float(np.median(force[: max(3, min(20, len(force) // 50))]))
    up, down = float(force.max()) - start, start - float(force.min())
    largest = force[np.abs(force).argmax()]
    negative = down > up
    unsure = min(up, down) > 0.5 * max(up, down) or negative != (largest < 0)
    if answers.press is None and unsure:
        raise Undecided(
            Question(
                name="press",
                text="The force goes both ways from where it begins. Which sign is a press?",
                candidates=(
                    Candidate(value="positive", label=f"from {start:.4g} N up to {force.max():.4g} N"),
                    Candidate(value="negative", label=f"from {start:.4g} N down to {force.min():.4g} N"),
                ),
            )
        )
    if answers.press == "negative" or (answers.press is None and negative):
        notes.append("The force is negative where it presses and was turned round.")
        return -force
    return force


def _inward_sign(depth: Floats, force: Floats, notes: list[str]) -> Floats:
    """Return the depth growing inward: with the force."""
    low, high = np.quantile(depth, [0.05, 0.95])
    agreement = float((force[depth >= high].mean() - force[depth <= low].mean()) / np.ptp(force))
    if abs(agreement) < 0.1:
        raise WrongColumns(
            "The force is no greater at the deepest rows than at the shallowest: these are not a press, or not the "
            "right columns."
        )
    if agreement < 0:
        notes.append("The depth falls as the force grows and was turned round.")
        return -depth
    return depth


def _check_columns(measurement: Measurement, depth: Floats, force: Floats, answers: Answers) -> None:
    """Ask where the force advances like a driven axis and the depth does not: the headers may be exchanged."""
    if answers.depth_column or answers.force_column:
        return
    if _scatter(force) < _EVEN and _scatter(depth) > _UNEVEN:
        (depth_at, force_at), d, f = measurement.columns, measurement.depth_header, measurement.force_header
        raise Undecided(
            Question(
                name="depth_column",
                text=f"“{f}” advances evenly like a driven depth and “{d}” does not: are they exchanged? "
                "Which is the depth?",
                candidates=(
                    Candidate(value=str(depth_at), label=f"{d}, as the header says (a press driven by its force)"),
                    Candidate(value=str(force_at), label=f"{f}, for they are exchanged"),
                ),
            )
        )


def _scatter(values: Floats) -> float:
    """Return the scatter of the steps of a column against their mean."""
    steps = np.abs(np.diff(values))
    steps = steps[steps > 0]
    return float(steps.std() / steps.mean()) if len(steps) > 3 else 0.0


def _long_enough(cycles: list[Cycle], depth: Floats, notes: list[str]) -> list[Cycle]:
    """Leave out presses that are no more than a few stray rows, and those that are much less deep than the rest."""
    deepest = max(float(depth[cycle.peak]) for cycle in cycles)
    deep = [cycle for cycle in cycles if depth[cycle.peak] - depth.min() >= FULL * (deepest - depth.min())]
    whole = [cycle for cycle in deep if cycle.peak - cycle.start + 1 >= MIN_ROWS] or deep
    if len(whole) < len(cycles):
        peaks = ", ".join(f"{1e3 * depth[cycle.peak]:.4g}" for cycle in cycles if cycle not in whole)
        notes.append(f"Touches to {peaks} mm, less deep or of a few rows only, were left out.")
    return whole


def _stroke(depth: Floats, force: Floats, cycle: Cycle, answers: Answers) -> _Stroke:
    rows = slice(cycle.start, cycle.peak + 1)
    keep = moving(depth[rows])
    x, f = depth[rows][keep], force[rows][keep]
    if len(x) < MIN_ROWS:
        raise DimpleError(f"A press has {len(x)} rows; a fit needs at least {MIN_ROWS}.")
    if answers.contact_mm is not None:
        touch, before = answers.contact_mm / 1e3, x < answers.contact_mm / 1e3
        tare = float(np.median(f[before])) if before.sum() > 2 else 0.0
        free: Free = () if before.sum() > 2 else ("tare",)
        note = "The touch is as given."
        if not x.min() - np.ptp(x) <= touch < x.max():
            raise DimpleError(f"The touch at {answers.contact_mm} mm lies outside the depths of the file.")
    else:
        found = find_touch(x, f)
        touch, tare, free, note = found.depth, found.tare, found.free, found.note
    return _Stroke(
        depth=x - touch, force=f - tare, touch=touch, tare=tare, free=free, dwelt=int((~keep).sum()), note=note
    )  # fmt: skip


def _choose(strokes: list[_Stroke], answers: Answers, notes: list[str]) -> int:
    """Return which cycle to fit: the one that was given, else the first where the others agree with it."""
    if answers.cycle is not None:
        if not 1 <= answers.cycle <= len(strokes):
            raise DimpleError(f"There is no cycle {answers.cycle}: the file holds {len(strokes)}.")
        return answers.cycle - 1
    if len(strokes) == 1:
        return 0
    apart = [_difference(strokes[0], other) for other in strokes[1:]]
    if max(apart) <= _AGREE:
        notes.append(
            f"{len(strokes)} presses agree within {100 * max(apart):.1f} % of full scale; the first is fitted."
        )
        return 0
    raise Undecided(
        Question(
            name="cycle",
            text=f"The file holds {len(strokes)} presses that differ by up to {100 * max(apart):.0f} % of full scale. "
            "Which one is fitted?",
            candidates=tuple(
                Candidate(value=str(i + 1), label=f"{1e3 * s.depth.max():.4g} mm deep, up to {s.force.max():.4g} N")
                for i, s in enumerate(strokes)
            ),
        )
    )


def _difference(first: _Stroke, other: _Stroke) -> float:
    """Return how far two strokes are apart where both were: RMS as a share of full scale."""
    grid = np.linspace(0, min(first.depth.max(), other.depth.max()), 100)
    a, b = (np.interp(grid, np.maximum.accumulate(s.depth), s.force) for s in (first, other))
    return float(np.sqrt(((a - b) ** 2).mean()) / max(np.abs(a).max(), 1e-300))


def _look_for_snap(stroke: _Stroke, warnings: list[str]) -> None:
    fall = np.maximum.accumulate(stroke.force) - stroke.force
    deepest, span = float(fall.max()), float(np.ptp(stroke.force))
    if deepest > _SNAP * span + 8 * roughness(stroke.force):
        where = 1e3 * float(stroke.depth[fall.argmax()])
        warnings.append(
            f"The force falls by {deepest:.3g} N ({100 * deepest / span:.0f} % of full scale) before {where:.3g} mm "
            "while the depth grows: the object snaps, and two slopes cannot show that."
        )


def _loss(stroke: _Stroke, depth: Floats, force: Floats) -> float | None:
    """Return the share of the work that unloading (m,) [m], [N] does not return, None where it is not complete."""
    inside = stroke.depth > 0
    if len(depth) < 8 or depth.min() > 0.2 * stroke.depth.max():
        return None
    spent, returned = _work(stroke.depth[inside], stroke.force[inside]), -_work(depth, np.maximum(force, 0))
    return min(max(1 - returned / spent, 0.0), 1.0) if spent > 0 else None


def _work(depth: Floats, force: Floats) -> float:
    return float(((force[1:] + force[:-1]) / 2 * np.diff(depth)).sum())
