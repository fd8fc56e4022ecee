"""Part a recording into strokes: where the depth turns, where it dwells, and single rows that are wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Bools, Floats

TURN = 0.1  # of the range of depth: a reversal smaller than this is a tremor
FULL = 0.5  # of the greatest depth: a press less deep is a touch, not a cycle
_BINS = 400  # of the range of depth, for finding dwells
_DWELL = 5  # times the usual rows per bin
_SPIKE = 12.0  # times the usual difference from the neighbours


@dataclass(frozen=True, slots=True)
class Cycle:
    """The rows of one press: loading is start:peak + 1, unloading peak:end + 1 (empty where end == peak)."""

    start: int
    peak: int
    end: int


def find_cycles(depth: Floats) -> list[Cycle]:
    """Return the presses in a depth that grows inward (n,)."""
    turns = _turns(depth, TURN * float(np.ptp(depth)))
    cycles = []
    for i in range(len(turns) - 1):
        start, peak = turns[i], turns[i + 1]
        if depth[peak] > depth[start]:
            cycles.append(Cycle(start, peak, turns[i + 2] if i + 2 < len(turns) else peak))
    return cycles


def _turns(depth: Floats, threshold: float) -> list[int]:
    """Return the rows at which the depth turns by more than a threshold, the first and last row included."""
    turns, best, rising = [0], 0, 0
    for i, value in enumerate(depth.tolist()):
        if rising >= 0 and value > depth[best] or rising <= 0 and value < depth[best]:
            if rising == 0 and abs(value - depth[0]) > threshold:
                rising = 1 if value > depth[0] else -1
                best = i
            elif rising:
                best = i
        elif rising and abs(value - depth[best]) > threshold:
            turns.append(best)
            rising, best = -rising, i
    return [*turns, best] if best != turns[-1] else turns


def moving(depth: Floats) -> Bools:
    """Return which rows of a loading stroke (n,) count: where it dwells only as many as elsewhere are kept."""
    front = np.maximum.accumulate(depth)
    span = float(np.ptp(front)) or 1.0
    place = np.minimum((front - front[0]) / span * _BINS, _BINS - 1).astype(np.int64)
    counts = np.bincount(place, minlength=_BINS)
    usual = float(np.median(counts[counts > 0]))
    order = np.arange(len(depth)) - np.searchsorted(place, place)  # the how-manieth row of its bin
    return (counts[place] <= _DWELL * usual + 5) | (order < usual)


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


def roughness(values: Floats) -> float:
    """Return the standard deviation (n,) of the noise of a smooth curve, from its second differences."""
    second = np.diff(values, 2)
    noise = 1.4826 * float(np.median(np.abs(second))) / np.sqrt(6) if len(second) else 0.0
    steps = np.abs(np.diff(values))
    finest = float(steps[steps > 0].min()) if (steps > 0).any() else 0.0
    return max(noise, min(finest, 0.01 * float(np.ptp(values))) / np.sqrt(12))
