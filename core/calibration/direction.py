"""Which way a recording goes: the order of its rows, the sign of a press, and the sign of a depth."""

from __future__ import annotations

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message
from .measurement import Measurement
from .question import Answers, Candidate, Question, Undecided, WrongColumns
from .strokes import turns
from .table import MIN_ROWS

_EVEN, _UNEVEN = 0.05, 0.35  # scatter of the steps of a driven axis, and of what cannot be one


def oriented(
    measurement: Measurement, depth: Floats, force: Floats, answers: Answers, notes: list[str]
) -> tuple[Floats, Floats, int]:
    """Return depth (n,) growing inward [m], force (n,) growing with a press [N], and the sign of the file's depth.

    Raises:
        Undecided: the order of the rows, the sign of a press, or which column is which, is open.
        DimpleError: there is no press in it.
    """
    depth, force = _in_order(depth, force, measurement.timed, answers, notes)
    force = _pressing_sign(force, answers, notes)
    inward = _inward(depth, force, answers)
    if inward < 0:
        notes.append("The depth falls as the force grows and was turned round.")
    _check_columns(measurement, depth, force, answers)
    return inward * depth, force, inward


def _in_order(depth: Floats, force: Floats, timed: bool, answers: Answers, notes: list[str]) -> tuple[Floats, Floats]:
    """Return the rows in the order they were measured; ask where they seem to stand from the last to the first."""
    if answers.order == "reversed":
        notes.append("The rows were turned round, from the last to the first.")
        return depth[::-1], force[::-1]
    first, last = (float(np.median(np.abs(part))) for part in (force[:5], force[-5:]))
    begins_deepest = first > 0.8 * float(np.abs(force).max()) and first > 2 * last and len(turns(depth)) == 2
    if not begins_deepest:
        return depth, force
    if timed or answers.order == "written":
        raise DimpleError("The depth never grows: the file holds unloading only, no press.")
    raise Undecided(
        which_order(
            Message("The file begins with its largest force, {force:.4g} N, and ends with little", force=force[0])
        )
    )


def which_order(why: str) -> Question:
    """Ask in what order the rows stand, with the reason for asking."""
    return Question(
        name="order",
        text=Message("{why}. In what order do its rows stand?", why=why),
        candidates=(
            Candidate(value="reversed", label="from the last to the first"),
            Candidate(value="written", label="as they were measured"),
        ),
        default="reversed",
    )


def _pressing_sign(force: Floats, answers: Answers, notes: list[str]) -> Floats:
    """Return the force with pressing positive."""
    start = float(np.median(force[:5]))
    up, down = float(force.max()) - start, start - float(force.min())
    negative = down > up
    unsure = min(up, down) > 0.5 * max(up, down) or negative != (force[np.abs(force).argmax()] < 0)
    if answers.press is None and unsure:
        raise Undecided(
            Question(
                name="press",
                text="The force goes both ways from where it begins. Which sign is a press?",
                candidates=(
                    Candidate(
                        value="positive",
                        label=Message("from {start:.4g} N up to {force:.4g} N", start=start, force=force.max()),
                    ),
                    Candidate(
                        value="negative",
                        label=Message("from {start:.4g} N down to {force:.4g} N", start=start, force=force.min()),
                    ),
                ),
            )
        )
    if answers.press == "negative" or (answers.press is None and negative):
        notes.append("The force is negative where it presses and was turned round.")
        return -force
    return force


def _inward(depth: Floats, force: Floats, answers: Answers) -> int:
    """Return the sign of a depth that grows inward: with the force, up to the largest of it."""
    if answers.inward is not None:
        return 1 if answers.inward == "positive" else -1
    peak = int(force.argmax())
    for side in (slice(peak + 1), slice(peak, None)):  # beyond it the specimen may be torn
        x, f = depth[side], force[side]
        if len(x) >= max(2 * MIN_ROWS, len(force) // 20) and min(np.ptp(x), np.ptp(f)) > 0:
            trend = float(np.corrcoef(x, f)[0, 1])
            if abs(trend) > 0.5:
                return 1 if trend > 0 else -1
    low, high = np.quantile(depth, [0.05, 0.95])
    agreement = float((force[depth >= high].mean() - force[depth <= low].mean()) / np.ptp(force))
    if abs(agreement) < 0.1:
        raise WrongColumns(
            "The force is no greater at the deepest rows than at the shallowest: these are not a press, or not the "
            "right columns."
        )
    return 1 if agreement > 0 else -1


def _check_columns(measurement: Measurement, depth: Floats, force: Floats, answers: Answers) -> None:
    """Ask where the force advances like a driven axis and the depth does not: the headers may be exchanged."""
    if answers.depth_column or answers.force_column or _scatter(force) >= _EVEN or _scatter(depth) <= _UNEVEN:
        return
    (depth_at, force_at), d, f = measurement.columns, measurement.depth_header, measurement.force_header
    raise Undecided(
        Question(
            name="depth_column",
            text=Message(
                "“{force}” advances evenly, like a driven depth, and “{depth}” does not: are the columns swapped? "
                "Which one is the depth?",
                force=f,
                depth=d,
            ),
            candidates=(
                Candidate(
                    value=str(depth_at),
                    label=Message("{depth}, as the header says (a press driven by its force)", depth=d),
                ),
                Candidate(value=str(force_at), label=Message("{force}: the columns are swapped", force=f)),
            ),
        )
    )


def _scatter(values: Floats) -> float:
    """Return the scatter of the steps of a column against their mean."""
    steps = np.abs(np.diff(values))
    steps = steps[steps > 0]
    return float(steps.std() / steps.mean()) if len(steps) > 3 else 0.0
