"""From a recording to one press: its range, its cycle, its rows, and the work lost in unloading."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ..base import DimpleError, Floats
from ..message import Message
from .measurement import Measurement
from .question import Answers, Question, Remarks, Undecided
from .strokes import CLEAR, Cycle, dip, find_cycles, oriented, roughness, spikes, still, tear
from .table import MIN_ROWS, SLIGHT

_AGREE = 10.0  # [% of full scale] RMS difference of two presses above which the object has changed in between


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadingCurve:
    """One press of a recording, its rows in the order of measurement.

    depth: (n,) from the first touch, negative before it [m].
    force: (n,) without the tare [N].
    unloading_depth: (m,) from the first touch [m], empty without unloading.
    unloading_force: (m,) without the tare [N].
    inward: 1 if the file's own depth grows inward, -1 if it falls.
    touch: the file's own depth at the first touch, with the sign changed if needed to grow inward [m].
    tare: force at the first touch [N].
    remarks: notes and warnings from preparing the press.
    """

    depth: Floats
    force: Floats
    unloading_depth: Floats
    unloading_force: Floats
    inward: int
    touch: float = 0.0
    tare: float = 0.0
    remarks: Remarks = field(default_factory=Remarks)

    def begun_at(self, touch: float, tare: float) -> LoadingCurve:
        """Return the curve with depths from a touch [m] and without a tare [N], both given in its present zero."""
        return replace(
            self, depth=self.depth - touch, force=self.force - tare, unloading_depth=self.unloading_depth - touch,
            unloading_force=self.unloading_force - tare, touch=self.touch + touch, tare=self.tare + tare,
        )  # fmt: skip

    def reading(self, depth: float) -> float:
        """Return the file's own reading [mm] for a depth [m] from the first touch."""
        return 1e3 * self.inward * (self.touch + depth)

    @property
    def loss(self) -> float | None:
        """Return the share of the work that unloading does not return, None if the unloading is incomplete."""
        inside, depth = self.depth > 0, self.unloading_depth
        if len(depth) < MIN_ROWS or depth.min() > 0.2 * self.depth.max():
            return None
        spent = _work(self.depth[inside], self.force[inside])
        returned = -_work(depth, np.maximum(self.unloading_force, 0))
        return min(max(1 - returned / spent, 0.0), 1.0) if spent > 0 else None

    @property
    def damping_ratio(self) -> float | None:
        """Return the damping ratio z of a linear body with this loss, as a hint only.

        A cycle from 0 to a depth X loses pi c w (X/2)^2 of the work k X^2 / 2; with c w = 2 z k this share is pi z.
        """
        return None if self.loss is None else self.loss / math.pi


def prepare(measurement: Measurement, answers: Answers | None = None) -> LoadingCurve:
    """Return the press of a recording, still with the file's own zero.

    Raises:
        Undecided: unclear signs, several different cycles, or a possible tear.
        DimpleError: there is no press in the recording.
    """
    answers, remarks = answers or Answers(), Remarks()
    depth, force = _without_spikes(measurement, remarks)
    if np.ptp(depth) == 0 or np.ptp(force) == 0:
        raise DimpleError("The depth or the force is the same in every row, so there is no press to fit.")
    depth, force, inward = oriented(depth, force, answers, remarks)
    depth, force = _in_range(depth, force, inward, answers, remarks)
    cycles = find_cycles(depth)
    if not cycles:
        raise DimpleError("The depth never increases: the file holds only unloading and no press.")
    cycles = _long_enough(cycles, depth, remarks)
    if len(cycles) > 8 and len(depth) / len(cycles) < 4 * MIN_ROWS:
        raise DimpleError(
            "The depth reverses {cycles} times in {rows} rows: the rows are not in the order of measurement, or the "
            "depth is in another column.",
            cycles=len(cycles),
            rows=len(depth),
        )
    curves = [_curve(depth, force, cycle, inward) for cycle in cycles]
    curve = curves[_choose(curves, answers, remarks)]
    if (at := tear(curve.force)) is not None and answers.until_mm is None:
        raise Undecided(_torn(curve, at))
    remarks.notes += curve.remarks.notes
    remarks.warnings += curve.remarks.warnings
    return replace(curve, remarks=remarks)


def _without_spikes(measurement: Measurement, remarks: Remarks) -> tuple[Floats, Floats]:
    depth, force = measurement.depth, measurement.force
    wrong = spikes(depth) | spikes(force)
    if wrong.any():
        said = "{count} rows differ strongly from their neighbors and were left out, the first of them row {row}."
        remarks.warn(said, count=int(wrong.sum()), row=int(wrong.argmax()) + 1)
    return depth[~wrong], force[~wrong]


def _in_range(depth: Floats, force: Floats, inward: int, answers: Answers, remarks: Remarks) -> tuple[Floats, Floats]:
    """Return the rows down to the depth that the user gave."""
    keep = depth <= (math.inf if answers.until_mm is None else inward * answers.until_mm / 1e3)
    if (rows := int(keep.sum())) < MIN_ROWS:
        raise DimpleError(
            "Only {rows} rows lie in the given range; a fit needs at least {least}.", rows=rows, least=MIN_ROWS
        )
    if rows < len(keep):
        remarks.note("{rows} rows outside the given range were left out.", rows=len(keep) - rows)
    return depth[keep], force[keep]


def _long_enough(cycles: list[Cycle], depth: Floats, remarks: Remarks) -> list[Cycle]:
    """Leave out brief touches: less than half as deep as the deepest press, or with under a tenth of the most rows."""
    shallowest, deepest = float(depth.min()), max(float(depth[cycle.peak]) for cycle in cycles)
    deep = [cycle for cycle in cycles if depth[cycle.peak] - shallowest >= (deepest - shallowest) / 2]
    least = max(MIN_ROWS, max(cycle.rows for cycle in deep) // 10)
    whole = [cycle for cycle in deep if cycle.rows >= least] or deep
    if len(whole) < len(cycles):
        peaks = ", ".join(f"{1e3 * depth[cycle.peak]:.4g}" for cycle in cycles if cycle not in whole)
        remarks.note("Touches to {peaks} mm were left out, because they are shallow or have few rows.", peaks=peaks)
    return whole


def _curve(depth: Floats, force: Floats, cycle: Cycle, inward: int) -> LoadingCurve:
    """Return one press with the file's own zero, without rows of dwelling or of adhesion."""
    remarks = Remarks()
    x, f = depth[cycle.start : cycle.peak + 1], force[cycle.start : cycle.peak + 1]
    stands = still(x)
    if stands.any():
        remarks.note("{dwelt} rows in which the depth did not change were left out.", dwelt=int(stands.sum()))
    x, f = x[~stands], f[~stands]
    if len(x) < MIN_ROWS:
        raise DimpleError("The press has only {rows} rows; a fit needs at least {least}.", rows=len(x), least=MIN_ROWS)
    pulled, depth_of_dip = dip(x, f), float(f[0] - f.min())
    if pulled.any() or depth_of_dip > max(2 * CLEAR * roughness(f), SLIGHT * float(np.ptp(f))):
        said = "The force dips by {dip:.3g} N before the press, as if the tip stuck; these {rows} rows were left out."
        remarks.warn(said, dip=depth_of_dip, rows=int(pulled.sum()))
    back = slice(cycle.peak, cycle.end + 1)
    return LoadingCurve(
        depth=x[~pulled], force=f[~pulled], unloading_depth=depth[back], unloading_force=force[back], inward=inward,
        remarks=remarks,
    )  # fmt: skip


def _torn(curve: LoadingCurve, at: int) -> Question:
    tear_mm = curve.reading(float(curve.depth[at] + curve.depth[at + 1]) / 2)
    text = Message(
        "The force drops from {force:.4g} N at {at:.4g} mm and does not recover: did the specimen tear? Down to "
        "which depth should it be fitted?",
        force=curve.force[at],
        at=tear_mm,
    )
    falls = f"{tear_mm:.7g}", "where the force begins to fall"
    deepest = f"{curve.reading(float(curve.depth[-1])):.7g}", "the deepest row: no tear, the object behaves like this"
    return Question("until_mm", text, falls, deepest, default=falls[0])


def _choose(curves: list[LoadingCurve], answers: Answers, remarks: Remarks) -> int:
    """Return the index of the cycle to fit: the user's choice, else the first if the others agree with it."""
    if answers.cycle is not None:
        if not 1 <= answers.cycle <= len(curves):
            raise DimpleError(
                "There is no cycle {cycle}: the file holds {presses}.", cycle=answers.cycle, presses=len(curves)
            )
        return answers.cycle - 1
    if len(curves) == 1:
        return 0
    apart = 100 * max(_difference(curves[0], other) for other in curves[1:])
    if apart <= _AGREE:
        said = "{presses} presses agree within {apart:.1f} % of full scale; the first is fitted."
        remarks.note(said, presses=len(curves), apart=apart)
        return 0
    text = Message(
        "The file holds {presses} presses that differ by up to {apart:.0f} % of full scale. Which one is to be fitted?",
        presses=len(curves),
        apart=apart,
    )
    label = "{depth:.4g} mm deep, up to {force:.4g} N"
    labels = (Message(label, depth=1e3 * each.depth.max(), force=each.force.max()) for each in curves)
    raise Undecided(Question("cycle", text, *((str(i), each) for i, each in enumerate(labels, 1))))


def _difference(first: LoadingCurve, other: LoadingCurve) -> float:
    """Return the RMS difference of two presses over their common depths, as a share of full scale."""
    shallowest = max(first.depth.min(), other.depth.min())
    grid = np.linspace(shallowest, min(first.depth.max(), other.depth.max()), 100)
    a, b = (np.interp(grid, np.maximum.accumulate(s.depth), s.force) for s in (first, other))
    return float(np.sqrt(((a - b) ** 2).mean()) / max(np.ptp(a), 1e-300))


def _work(depth: Floats, force: Floats) -> float:
    return float(((force[1:] + force[:-1]) / 2 * np.diff(depth)).sum())
