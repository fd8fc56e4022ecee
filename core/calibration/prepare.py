"""From a recording to one loading curve: sign, cycles, dwell, first touch, tare, and the work lost in unloading."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message
from .blocks import MIN_ROWS
from .contact import find_touch
from .direction import oriented, which_order
from .parameters import Free
from .question import Answers, Candidate, Question, Undecided
from .reader import Measurement
from .strokes import FULL, Cycle, dip, find_cycles, moving, rises, roughness, spikes, standing, tear

_AGREE = 0.10  # of full scale, RMS: cycles that differ more are different presses
_SNAP = 0.10  # of full scale: a fall of the force while the depth grows
_BEFORE = 20.0  # of the range of depth: a touch given farther before the first row is a slip of the pen
_GAINED = 0.03  # of the work: what a way back returns beyond it is no error of measurement
_MANY = 60  # reversals: rows are not in the order they were measured
_QUICK = 0.1  # of the rows of the longest press: a press of fewer is a touch in passing


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
    touch: of the first touch, in the file's own depth but growing inward [m].
    tare: force at the first touch [N].
    inward: sign of the file's own depth where it grows inward.
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
    inward: int
    loss: float | None
    notes: tuple[str, ...]
    warnings: tuple[str, ...]

    def reading(self, depth: float) -> float:
        """Return what the file calls a depth [m] from the first touch [mm]."""
        return 1e3 * self.inward * (self.touch + depth)

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
    depth, force, inward = oriented(measurement, depth, force, answers, notes)
    cycles = find_cycles(depth)
    unordered = answers.order is None and not measurement.timed
    if not cycles and unordered:
        raise Undecided(which_order(Message("The depth only falls, which would be a way back and no press")))
    if not cycles:
        raise DimpleError("The depth never grows: the file holds unloading only, no press.")
    cycles = _long_enough(cycles, depth, notes)
    if len(cycles) > max(_MANY, 1) or (len(cycles) > 8 and len(depth) / len(cycles) < 16):
        raise DimpleError(
            "The depth turns back {cycles} times in {rows} rows: they are not in the order measured, or the depth is "
            "not the column taken.",
            cycles=len(cycles), rows=len(depth)
        )  # fmt: skip
    strokes = [_stroke(depth, force, cycle, answers, inward) for cycle in cycles]
    chosen = _choose(strokes, answers, notes)
    stroke = strokes[chosen]
    notes += stroke.notes
    if stroke.torn and answers.until_mm is None:
        raise Undecided(_torn(stroke, inward))
    if stroke.dwelt:
        notes.append(Message("{dwelt} rows in which the depth stood still were left out.", dwelt=stroke.dwelt))
    _look_for_snap(stroke, warnings)
    unloading = slice(cycles[chosen].peak, cycles[chosen].end + 1)
    unloading_depth, unloading_force = depth[unloading] - stroke.touch, force[unloading] - stroke.tare
    loss = _loss(stroke, unloading_depth, unloading_force)
    _check_loss(loss, unordered, warnings)
    return LoadingCurve(
        depth=stroke.depth, force=stroke.force, unloading_depth=unloading_depth, unloading_force=unloading_force,
        free=stroke.free, cycle=chosen + 1, cycles=len(cycles), touch=stroke.touch, tare=stroke.tare,
        inward=inward, loss=None if loss is None else max(loss, 0.0),
        notes=tuple(notes), warnings=tuple(warnings),
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
    torn: depths [m] and force [N]: where the force falls for good, how deep it goes on, and from what force.
    notes: messages about how it was read.
    """

    depth: Floats
    force: Floats
    touch: float
    tare: float
    free: Free
    dwelt: int
    torn: tuple[float, float, float] | None
    notes: tuple[str, ...]


def _without_spikes(measurement: Measurement, warnings: list[str]) -> tuple[Floats, Floats]:
    depth, force = measurement.depth, measurement.force
    wrong = spikes(depth) | spikes(force)
    if wrong.any():
        rows = ", ".join(str(row + 1) for row in np.flatnonzero(wrong)[:5])
        more = " ..." if wrong.sum() > 5 else ""
        warnings.append(Message(
            "{count} rows stand apart from their neighbours and were left out ({rows}{more}).",
            count=int(wrong.sum()), rows=rows, more=more
        ))  # fmt: skip
    return depth[~wrong], force[~wrong]


def _long_enough(cycles: list[Cycle], depth: Floats, notes: list[str]) -> list[Cycle]:
    """Leave out presses that are no more than a few stray rows, and those that are much less deep than the rest."""
    deepest = max(float(depth[cycle.peak]) for cycle in cycles)
    deep = [cycle for cycle in cycles if depth[cycle.peak] - depth.min() >= FULL * (deepest - depth.min())]
    rows = [cycle.peak - cycle.start + 1 for cycle in deep]
    least = max(MIN_ROWS, _QUICK * max(rows))
    whole = [cycle for cycle, count in zip(deep, rows, strict=True) if count >= least] or deep
    if len(whole) < len(cycles):
        peaks = ", ".join(f"{1e3 * depth[cycle.peak]:.4g}" for cycle in cycles if cycle not in whole)
        notes.append(Message("Touches to {peaks} mm, less deep or of a few rows only, were left out.", peaks=peaks))
    return whole


def _stroke(depth: Floats, force: Floats, cycle: Cycle, answers: Answers, inward: int) -> _Stroke:
    rows = slice(cycle.start, cycle.peak + 1)
    x, f, notes = depth[rows], force[rows], []
    if (still := standing(x)) > 1:  # rows of one depth say one thing: what the force has come to
        rising = rises(f, f[:still])
        force_there = float(f[still - 1] if rising else np.median(f[:still]))
        how = "the force rises to {force:.4g} N" if rising else "the force is {force:.4g} N"
        notes.append(Message(
            "In the first {still} rows, before the depth moves, {how}; they count as one.",
            still=still, how=Message(how, force=force_there)
        ))  # fmt: skip
        x, f = x[still - 1 :].copy(), f[still - 1 :].copy()
        f[0] = force_there
    keep = moving(x)
    dwelt, x, f = int((~keep).sum()), x[keep], f[keep]
    if len(x) < MIN_ROWS:
        raise DimpleError("A press has {rows} rows; a fit needs at least {least}.", rows=len(x), least=MIN_ROWS)
    at = tear(f)
    torn = None if at is None else (float(x[at] + x[at + 1]) / 2, float(x[-1]), float(f[at]))
    pulled = dip(x, f)
    if pulled.any():
        notes.append(Message(
            "The force dips by {dip:.3g} N before the press, as where a tip sticks; {rows} rows of it were left out.",
            dip=f[~pulled][0] - f.min(), rows=int(pulled.sum())
        ))  # fmt: skip
        x, f = x[~pulled], f[~pulled]
    if answers.contact_mm is not None:
        touch = inward * answers.contact_mm / 1e3
        before = x < touch
        tare = float(np.median(f[before])) if before.sum() > 2 else 0.0
        free: Free = () if before.sum() > 2 else ("tare",)
        if not x.min() - _BEFORE * np.ptp(x) <= touch < x.max():
            raise DimpleError(
                "The touch at {contact_mm} mm lies outside the depths of the file.", contact_mm=answers.contact_mm
            )
    else:
        found = find_touch(x, f)
        touch, tare, free = found.depth, found.tare, found.free
    return _Stroke(
        depth=x - touch, force=f - tare, touch=touch, tare=tare, free=free, dwelt=dwelt, torn=torn, notes=tuple(notes)
    )


def _torn(stroke: _Stroke, inward: int) -> Question:
    at, deepest, force = stroke.torn or (0.0, 0.0, 0.0)
    return Question(
        name="until_mm",
        text=Message(
            "The force falls for good from {force:.4g} N at {at:.4g} mm: was the specimen torn? Down to which "
            "depth should it be fitted?",
            force=force,
            at=1e3 * inward * at,
        ),
        candidates=(
            Candidate(value=f"{1e3 * inward * at:.7g}", label="where the force begins to fall"),
            Candidate(value=f"{1e3 * inward * deepest:.7g}", label="the deepest row: no tear, it answers like this"),
        ),
        default=f"{1e3 * inward * at:.7g}",
    )


def _choose(strokes: list[_Stroke], answers: Answers, notes: list[str]) -> int:
    """Return which cycle to fit: the one that was given, else the first where the others agree with it."""
    if answers.cycle is not None:
        if not 1 <= answers.cycle <= len(strokes):
            raise DimpleError(
                "There is no cycle {cycle}: the file holds {presses}.", cycle=answers.cycle, presses=len(strokes)
            )
        return answers.cycle - 1
    if len(strokes) == 1:
        return 0
    apart = [_difference(strokes[0], other) for other in strokes[1:]]
    if max(apart) <= _AGREE:
        notes.append(Message(
            "{presses} presses agree within {apart:.1f} % of full scale; the first is fitted.",
            presses=len(strokes), apart=100 * max(apart)
        ))  # fmt: skip
        return 0
    raise Undecided(
        Question(
            name="cycle",
            text=Message(
                "The file holds {presses} presses that differ by up to {apart:.0f} % of full scale. Which one is "
                "fitted?",
                presses=len(strokes),
                apart=100 * max(apart),
            ),
            candidates=tuple(
                Candidate(
                    value=str(i + 1),
                    label=Message(
                        "{depth:.4g} mm deep, up to {force:.4g} N", depth=1e3 * s.depth.max(), force=s.force.max()
                    ),
                )
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
        warnings.append(Message(
            "The force falls by {deepest:.3g} N ({span:.0f} % of full scale) before {where:.3g} mm while the depth "
            "grows: the object snaps, and two slopes cannot show that.",
            deepest=deepest, span=100 * deepest / span, where=where
        ))  # fmt: skip


def _check_loss(loss: float | None, unordered: bool, warnings: list[str]) -> None:
    """Ask for the order of the rows, or warn where it is known, if more work comes back than was put in."""
    if loss is None or loss >= -_GAINED:
        return
    why = Message("The way back returns {loss:.0f} % more work than the press takes", loss=-100 * loss)
    if unordered:
        raise Undecided(which_order(Message("{why}, which no object does", why=why)))
    warnings.append(Message("{why}.\nNo object does that: force and depth may not be of one press.", why=why))


def _loss(stroke: _Stroke, depth: Floats, force: Floats) -> float | None:
    """Return the share of the work that unloading (m,) [m], [N] does not return, None where it is not complete.

    It is negative where more is returned.
    """
    inside = stroke.depth > 0
    if len(depth) < 8 or depth.min() > 0.2 * stroke.depth.max():
        return None
    spent, returned = _work(stroke.depth[inside], stroke.force[inside]), -_work(depth, np.maximum(force, 0))
    return min(1 - returned / spent, 1.0) if spent > 0 else None


def _work(depth: Floats, force: Floats) -> float:
    return float(((force[1:] + force[:-1]) / 2 * np.diff(depth)).sum())
