"""A press by hand as the paths of its fingertips, and the reduction of these paths to a few keyframes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ..base import Floats, Ints
from ..native.motion import Touch
from ..session.fingertip import Finger
from ..vectors import Vector, along


class Sample(NamedTuple):
    """A fingertip at a time [s]: its centre (3,) [m] and radius [m]."""

    time: float
    centre: Vector
    radius: float


@dataclass(slots=True, eq=False)
class Way:
    """The path of a fingertip, from its first to its last touch of the surface at rest.

    outward: unit normal of the surface at the first touch.
    samples: in order of time.
    """

    outward: Vector
    samples: list[Sample]


@dataclass(slots=True, eq=False)
class Hand:
    """A recorder of the fingertips that press one body by hand.

    ways: paths of the latest press, by number of the finger. A press begins when the first fingertip comes down, and
        ends when the last one is lifted.
    """

    ways: dict[int, Way] = field(default_factory=dict)
    _down: dict[int, Touch] = field(default_factory=dict)
    _time: float = 0.0

    def take(self, time: float, held: Mapping[int, tuple[Finger, Touch]]) -> float | None:
        """Record a step of the session.

        Args:
            time: time at the end of the step [s].
            held: the fingertips that press by hand, by number, with their contact.

        Returns:
            The time at which a press began in this step [s], None if none did.
        """
        if time < self._time:  # the session was put back to rest
            self._down.clear()
            self._time = 0.0
        before, self._time = self._time, time
        for i in [i for i in self._down if i not in held]:
            samples = self.ways[i].samples
            samples.append(Sample(time, _touching(self._down.pop(i)), samples[-1].radius))
        begins = bool(held) and not self._down
        if begins:
            self.ways = {}
        for i, (finger, touch) in held.items():
            if i not in self._down or finger.fresh_contact:
                self.ways[i] = Way(touch.outward, [Sample(before, _touching(touch), finger.radius)])
            self.ways[i].samples.append(Sample(time, touch.centre, finger.radius))
            self._down[i] = touch
        return before if begins else None


def _touching(touch: Touch) -> Vector:
    """Return the centre (3,) [m] of a fingertip moved outward until it just touches the surface at rest."""
    return along(touch.centre, touch.outward, touch.depth)


def keys(way: Way, start: float, frame: float, frame_s: float, tolerance: float) -> tuple[Ints, Floats]:
    """Return keyframes for a path, to be interpolated linearly.

    Args:
        start: a time of the session [s].
        frame: the frame shown at that time.
        frame_s: duration of a frame [s].
        tolerance: largest deviation from the path at any frame [m].

    Returns:
        Frames (n,), and centre and radius (n, 4) [m] at each.
    """
    samples = np.array([(each.time, *each.centre, each.radius) for each in way.samples])
    at = frame + (samples[:, 0] - start) / frame_s
    frames = np.arange(math.floor(at[0] + 1e-6), math.ceil(at[-1] - 1e-6) + 1)
    places = np.stack([np.interp(frames, at, column) for column in samples.T[1:]], axis=1)
    kept = corners(places, tolerance)
    return frames[kept], places[kept]


def corners(places: Floats, tolerance: float) -> Sequence[int]:
    """Return which places (n, d) at equal intervals to keep, so that linear interpolation gives the others."""
    kept, ends = [0], [len(places) - 1]
    while ends:
        first, last = kept[-1], ends[-1]
        share = np.linspace(0, 1, last - first + 1)[:, None]
        off = np.linalg.norm(places[first : last + 1] - places[first] - share * (places[last] - places[first]), axis=1)
        if off.max() > tolerance:
            ends.append(first + int(off.argmax()))
        elif ends.pop() > first:
            kept.append(last)
    return kept
