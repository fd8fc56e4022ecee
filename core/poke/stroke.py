"""A press by hand as the ways of its fingertips, and those ways as a few keyframes."""

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
    """Where a fingertip is at a time [s]: centre (3,) [m] and radius [m]."""

    time: float
    centre: Vector
    radius: float


@dataclass(slots=True, eq=False)
class Way:
    """The way of a fingertip, from where it touches the surface at rest to where it touches it last.

    outward: unit normal of the surface where it came down.
    samples: in the order of time.
    """

    outward: Vector
    samples: list[Sample]


@dataclass(slots=True, eq=False)
class Hand:
    """Follow the fingertips that a hand leads on one body.

    ways: of the last press, by the number of the finger: it begins with the first fingertip that comes down, and ends
        with the last that is lifted.
    """

    ways: dict[int, Way] = field(default_factory=dict)
    _down: dict[int, Touch] = field(default_factory=dict)
    _time: float = 0.0

    def take(self, time: float, held: Mapping[int, tuple[Finger, Touch]]) -> float | None:
        """Take in a step of the session: its fingertips that a hand presses with, and what they touch.

        Args:
            time: at the end of the step [s].

        Returns:
            When a press began in this step [s], None where none did.
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
    """Return where a fingertip only just touches the surface at rest, outward of where it is."""
    return along(touch.centre, touch.outward, touch.depth)


def keys(way: Way, start: float, frame: float, frame_s: float, tolerance: float) -> tuple[Ints, Floats]:
    """Return the keyframes of a way, which is straight from each to the next.

    Args:
        start: a time of the session [s], and
        frame: the frame that is shown then.
        frame_s: time of a frame [s].
        tolerance: within which the keyframes lead past the place at each frame [m].

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
    """Return which places (n, d) at even times to keep, so that the others lie on straight ways between them."""
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
