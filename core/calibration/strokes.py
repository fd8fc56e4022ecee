"""The order and the signs of a recording, its strokes, and its outliers, tears, dwells and rows of adhesion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..base import Bools, Floats
from ..message import Message
from .question import Answers, Question, Remarks, Undecided
from .table import MIN_ROWS, SLIGHT

_TURN = 0.1  # share of the range of depth: a smaller reversal is a tremor
CLEAR = 5.0  # times the noise: beyond chance; the largest of 100,000 Gaussian values is about 4.4 times


def oriented(depth: Floats, force: Floats, answers: Answers, remarks: Remarks) -> tuple[Floats, Floats, int]:
    """Return depth (n,) growing inward [m], force (n,) growing with a press [N], and the sign of the file's depth.

    Raises:
        Undecided: the sign of a press is ambiguous.
    """
    first, last = (float(np.median(np.abs(part))) for part in (force[:5], force[-5:]))
    if first > 0.8 * float(np.abs(force).max()) and first > 2 * last and len(turns(depth)) == 2:
        remarks.warn(
            "The file begins with its largest force, so its rows were read from the last to the first.\nIf they are "
            "in the order of measurement, the file holds only the unloading, which is softer than the press."
        )
        depth, force = depth[::-1], force[::-1]
    force = _pressing_sign(force, answers, remarks)
    inward = _inward(depth, force)
    if inward < 0:
        remarks.note("The depth decreases as the force grows, so its sign was reversed.")
    return inward * depth, force, inward


def _pressing_sign(force: Floats, answers: Answers, remarks: Remarks) -> Floats:
    """Return the force with pressing positive."""
    start, low, high = float(np.median(force[:5])), float(force.min()), float(force.max())
    up, down = high - start, start - low
    falls = down > up
    unsure = min(up, down) > 0.5 * max(up, down) or falls != (force[np.abs(force).argmax()] < 0)
    if answers.press is None and unsure:
        positive = Message("from {start:.4g} N up to {force:.4g} N", start=start, force=high)
        negative = Message("from {start:.4g} N down to {force:.4g} N", start=start, force=low)
        text = "The force both rises and falls from its first value. Which sign is a press?"
        raise Undecided(Question("press", text, ("positive", positive), ("negative", negative)))
    if answers.press == "negative" or (answers.press is None and falls):
        remarks.note("The force is negative during the press, so its sign was reversed.")
        return -force
    return force


def _inward(depth: Floats, force: Floats) -> int:
    """Return the sign of a depth that grows inward: that of its stronger correlation with the force."""
    peak, enough, trend = int(force.argmax()), min(2 * MIN_ROWS, len(force) // 2), 0.0
    for x, f in ((depth[side], force[side]) for side in (slice(peak + 1), slice(peak, None))):
        if len(x) >= enough and min(np.ptp(x), np.ptp(f)) > 0:  # a tear weakens the correlation
            trend = max(trend, float(np.corrcoef(x, f)[0, 1]), key=abs)
    return 1 if trend > 0 else -1


class Cycle(NamedTuple):
    """The rows of one press: loading is start:peak + 1, unloading peak:end + 1 (no unloading if end == peak)."""

    start: int
    peak: int
    end: int

    @property
    def rows(self) -> int:
        """Return the number of rows of loading."""
        return self.peak - self.start + 1


def find_cycles(depth: Floats) -> list[Cycle]:
    """Return the presses in a recording of depth (n,), growing inward."""
    found = turns(depth)
    ends = [*found[2:], found[-1]]
    return [Cycle(a, b, end) for a, b, end in zip(found, found[1:], ends, strict=False) if depth[b] > depth[a]]


def turns(depth: Floats) -> list[int]:
    """Return the first row, the turning points of a depth (n,) without tremors, and its last extreme."""
    found, best, rising, threshold = [0], 0, 0, _TURN * float(np.ptp(depth))
    for i, value in enumerate(depth.tolist()):
        if rising >= 0 and value > depth[best] or rising <= 0 and value < depth[best]:
            if rising == 0 and abs(value - depth[0]) > threshold:
                rising = 1 if value > depth[0] else -1
                best = i
            elif rising:
                best = i
        elif rising and abs(value - depth[best]) > threshold:
            found.append(best)
            rising, best = -rising, i
    return [*found, best] if best != found[-1] else found


def still(depth: Floats) -> Bools:
    """Return which rows (n,) of a loading stroke to leave out because the depth stands still until the next row.

    The last row of a dwell stays: its force is the one to which the object has relaxed.
    """
    steps = np.diff(depth)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    return np.append(steps < usual / 5, False)


def spikes(values: Floats) -> Bools:
    """Return which rows (n,) are outliers: single values far from both neighbours, while these agree."""
    found = np.zeros(len(values), bool)
    if len(values) < 12:
        return found
    middle = values[1:-1] - (values[2:] + values[:-2]) / 2
    usual = 1.4826 * float(np.median(np.abs(middle - np.median(middle))))
    least = CLEAR * max(usual, 0.002 * float(np.ptp(np.sort(values)[2:-2])))
    found[1:-1] = np.abs(middle) > np.maximum(least, 2 * np.abs(values[2:] - values[:-2]))
    return found


def tear(force: Floats) -> int | None:
    """Return the row of the largest force (n,) of a stroke if the force later stays below half of it, else None."""
    peak = int(force.argmax())
    tail = force[peak + 1 :]
    first = float(np.median(force[:3]))
    return peak if len(tail) > 2 and tail[len(tail) // 2 :].max() < (first + force[peak]) / 2 else None


def dip(depth: Floats, force: Floats) -> Bools:
    """Return which rows (n,) of a stroke show a pull before the press, because the object sticks to the tip."""
    noise, lowest = roughness(force), int(force.argmin())
    rest = float(np.median(force[: max(3, lowest // 4)]))
    depressed = rest - float(force[lowest])
    found = np.zeros(len(force), bool)
    if lowest < 6 or depressed < max(CLEAR * noise, SLIGHT * float(np.ptp(force))) or depth[lowest] <= depth[0]:
        return found
    level = force >= rest
    before, after = np.flatnonzero(level[:lowest]), np.flatnonzero(level[lowest:])
    if len(after) and len(before) > 2 and after[0] > (lowest - before[-1]) // 2:  # else the cell drifts
        found[before[-1] + 1 : lowest + after[0]] = True
    return found


def roughness(values: Floats) -> float:
    """Return the standard deviation of the noise of a smooth curve (n,), from its second differences."""
    second = np.diff(values, 2)
    noise = 1.4826 * float(np.median(np.abs(second))) / np.sqrt(6) if len(second) else 0.0
    steps = np.abs(np.diff(values))
    finest = float(steps[steps > 0].min()) if (steps > 0).any() else 0.0
    return max(noise, min(finest, 0.01 * float(np.ptp(values))) / np.sqrt(12))
