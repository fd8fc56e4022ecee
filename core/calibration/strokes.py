"""Part a recording into strokes: where the depth turns or stands, and rows that are wrong, torn or pulled at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Bools, Floats

_TURN = 0.1  # of the range of depth: a reversal smaller than this is a tremor
_SPIKE = 12.0  # times the usual difference from the neighbours
_CLEAR = 8.0  # times the noise: a force that is pulled, in any of 100,000 rows
SLIGHT = 0.01  # of a range: what instruments are off by


@dataclass(frozen=True, slots=True)
class Cycle:
    """The rows of one press: loading is start:peak + 1, unloading peak:end + 1 (empty where end == peak)."""

    start: int
    peak: int
    end: int

    @property
    def rows(self) -> int:
        """Return how many rows of loading there are."""
        return self.peak - self.start + 1


def find_cycles(depth: Floats) -> list[Cycle]:
    """Return the presses in a depth that grows inward (n,)."""
    found = turns(depth)
    ends = [*found[2:], found[-1]]
    return [Cycle(a, b, end) for a, b, end in zip(found, found[1:], ends, strict=False) if depth[b] > depth[a]]


def turns(depth: Floats) -> list[int]:
    """Return the rows at which the depth turns for good, the first and the last row included."""
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
    """Return which rows (n,) of a loading stroke are one with the next, for the depth stands: the last of them counts.

    What it says is what the force has come to.
    """
    steps = np.diff(depth)
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    return np.append(steps < usual / 5, False)


def spikes(values: Floats) -> Bools:
    """Return which single rows (n,) stand apart from both neighbours while those agree with one another."""
    found = np.zeros(len(values), bool)
    if len(values) < 12:
        return found
    middle = values[1:-1] - (values[2:] + values[:-2]) / 2
    usual = 1.4826 * float(np.median(np.abs(middle - np.median(middle))))
    least = _SPIKE * max(usual, 0.002 * float(np.ptp(np.sort(values)[2:-2])))
    found[1:-1] = np.abs(middle) > np.maximum(least, 2 * np.abs(values[2:] - values[:-2]))
    # the ends have one neighbour: go on from the next two
    found[0] = abs(values[0] - 2 * values[1] + values[2]) > 2 * least and not found[1:3].any()
    found[-1] = abs(values[-1] - 2 * values[-2] + values[-3]) > 2 * least and not found[-3:-1].any()
    return found


def tear(force: Floats) -> int | None:
    """Return the row of the largest force (n,) of a stroke that stays below half of it from soon after on, or None."""
    peak = int(force.argmax())
    tail = force[peak + 1 :]
    first = float(np.median(force[:3]))
    return peak if len(tail) > 2 and tail[len(tail) // 2 :].max() < (first + force[peak]) / 2 else None


def dip(depth: Floats, force: Floats) -> Bools:
    """Return which rows (n,) of a stroke are pulled at before they are pressed: a tip that the object sticks to."""
    noise, lowest = roughness(force), int(force.argmin())
    rest = float(np.median(force[: max(3, lowest // 4)]))
    depressed = rest - float(force[lowest])
    found = np.zeros(len(force), bool)
    if lowest < 6 or depressed < max(_CLEAR * noise, SLIGHT * float(np.ptp(force))) or depth[lowest] <= depth[0]:
        return found
    level = force > rest - max(3 * noise, 0.02 * depressed)
    before, after = np.flatnonzero(level[:lowest]), np.flatnonzero(level[lowest:])
    if len(before) > 2 and len(after):
        found[before[-1] + 1 : lowest + after[0]] = True
    return found


def roughness(values: Floats) -> float:
    """Return the standard deviation (n,) of the noise of a smooth curve, from its second differences."""
    second = np.diff(values, 2)
    noise = 1.4826 * float(np.median(np.abs(second))) / np.sqrt(6) if len(second) else 0.0
    steps = np.abs(np.diff(values))
    finest = float(steps[steps > 0].min()) if (steps > 0).any() else 0.0
    return max(noise, min(finest, 0.01 * float(np.ptp(values))) / np.sqrt(12))
