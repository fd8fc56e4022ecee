"""Part a recording into strokes: where the depth turns, where it dwells, and single rows that are wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Bools, Floats

TURN = 0.1  # of the range of depth: a reversal smaller than this is a tremor
FULL = 0.5  # of the greatest depth: a press less deep is a touch, not a cycle
_BINS = 400  # of the range of depth, for finding dwells
_DWELL = 5  # times the usual rows per bin
_FEW = 3  # rows
_TORN = 0.5  # of the largest force: what is left when it is torn, at most
_RISE = 0.01  # of the range of force: less is no preload and no adhesion
_SPIKE = 12.0  # times the usual difference from the neighbours


@dataclass(frozen=True, slots=True)
class Cycle:
    """The rows of one press: loading is start:peak + 1, unloading peak:end + 1 (empty where end == peak)."""

    start: int
    peak: int
    end: int


def find_cycles(depth: Floats) -> list[Cycle]:
    """Return the presses in a depth that grows inward (n,)."""
    found = turns(depth, TURN)
    cycles = []
    for i in range(len(found) - 1):
        start, peak = found[i], found[i + 1]
        if depth[peak] > depth[start]:
            cycles.append(Cycle(start, peak, found[i + 2] if i + 2 < len(found) else peak))
    return cycles


def turns(depth: Floats, share: float) -> list[int]:
    """Return the rows at which the depth turns by more than a share of its range, the first and last row included."""
    found, best, rising, threshold = [0], 0, 0, share * float(np.ptp(depth))
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


def tear(force: Floats) -> int | None:
    """Return the row of the largest force (n,) of a stroke that stays below half of it from soon after on, or None."""
    peak = int(force.argmax())
    tail = force[peak + 1 :]
    first = float(np.median(force[:_FEW]))
    if len(tail) < _FEW or tail[len(tail) // 2 :].max() - first > _TORN * (force[peak] - first):
        return None
    return peak


def standing(depth: Floats) -> int:
    """Return how many rows (n,) of a stroke stand at its beginning before the depth moves."""
    steps = np.diff(depth)
    least = 0.2 * float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    return int((depth > depth[0] + least).argmax())


def rises(force: Floats, first: Floats) -> bool:
    """Return whether the force rises within the first rows of a stroke by more than noise."""
    return bool(first[-1] - first[0] > max(8 * roughness(force), _RISE * float(np.ptp(force))))


def dip(depth: Floats, force: Floats) -> Bools:
    """Return which rows (n,) of a stroke are pulled at before they are pressed: a tip that the object sticks to."""
    noise, span = roughness(force), float(np.ptp(force))
    lowest = int(force.argmin())
    rest = float(np.median(force[: max(_FEW, lowest // 4)]))
    depressed = rest - float(force[lowest])
    found = np.zeros(len(force), bool)
    if lowest < 2 * _FEW or depressed < max(8 * noise, _RISE * span) or depth[lowest] <= depth[0]:
        return found
    level = force > rest - max(3 * noise, 0.02 * depressed)
    before, after = np.flatnonzero(level[:lowest]), np.flatnonzero(level[lowest:])
    if len(before) < _FEW or not len(after):
        return found
    found[before[-1] + 1 : lowest + after[0]] = True
    return found


def roughness(values: Floats) -> float:
    """Return the standard deviation (n,) of the noise of a smooth curve, from its second differences."""
    second = np.diff(values, 2)
    noise = 1.4826 * float(np.median(np.abs(second))) / np.sqrt(6) if len(second) else 0.0
    steps = np.abs(np.diff(values))
    finest = float(steps[steps > 0].min()) if (steps > 0).any() else 0.0
    return max(noise, min(finest, 0.01 * float(np.ptp(values))) / np.sqrt(12))
