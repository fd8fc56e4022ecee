"""An emulated hand on an emulated device: where it wants its three fingertips to be, and how firmly."""

from __future__ import annotations

import json
import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from core.errors import DimpleError
from core.message import Message
from core.vectors import ZERO, Vector

STIFFNESS, DAMPING = 400.0, 4.0  # (A) [N/m], [N s/m] of a gripping finger
Keyframe = tuple[float, float, float, float]  # time [s], place [m] in the device's frame
REST: Final[tuple[Keyframe, ...]] = ((0.0, *ZERO),)
# of the poking hand: distance from the middle, above and below the middle of the workspace [m]; times [s]
APART, ABOVE, BELOW = 0.015, 0.010, -0.012
BEGIN, MOVE, HOLD, EVERY, UNTIL = 1.5, 0.25, 0.5, 1.5, 300.0
SIDES: Final = ((-1.0, 0.0), (0.5, -0.866), (0.5, 0.866))  # of their blocks


@dataclass(frozen=True, slots=True, kw_only=True)
class EmulatedHand:
    """A hand: the path of each fingertip, straight from keyframe to keyframe, through a spring and a damper.

    tips: keyframes of each fingertip.
    stiffness: [N/m], None: the tip is where the hand wants it, whatever the motors do.
    damping: [N s/m].
    from_arm: times are counted from the beginning of the device's ramp, else from its start.
    """

    tips: tuple[tuple[Keyframe, ...], ...] = (REST, REST, REST)
    stiffness: float | None = STIFFNESS
    damping: float = DAMPING
    from_arm: bool = True

    def target(self, finger: int, time: float) -> tuple[Vector, Vector]:
        """Return place [m] and velocity [m/s] wanted of a fingertip at a time [s]."""
        keys = self.tips[finger]
        i = bisect_right(keys, time, key=lambda key: key[0])
        if i == 0 or i == len(keys):
            return keys[max(i - 1, 0)][1:], ZERO
        (t0, x0, y0, z0), (t1, x1, y1, z1) = keys[i - 1], keys[i]
        rate = 1 / (t1 - t0)
        vx, vy, vz = (x1 - x0) * rate, (y1 - y0) * rate, (z1 - z0) * rate
        s = time - t0
        return (x0 + vx * s, y0 + vy * s, z0 + vz * s), (vx, vy, vz)


def load_hand(path: Path) -> EmulatedHand:
    """Return the hand of a JSON file: {"tips": [[[t, x, y, z], ...] x 3], "stiffness", "damping", "from": "arm"}.

    Raises:
        DimpleError: the file cannot be read, or is not a hand.
    """
    try:
        file: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        stiffness = file.get("stiffness", STIFFNESS)
        hand = EmulatedHand(
            tips=tuple(_keyframes(keys) for keys in file["tips"]),
            stiffness=None if stiffness is None else float(stiffness),
            damping=float(file.get("damping", DAMPING)),
            from_arm={"arm": True, "start": False}[file.get("from", "arm")],
        )
        if len(hand.tips) != 3 or not (hand.stiffness or 0) >= 0 <= hand.damping:
            raise ValueError(Message("it takes three tips, and a stiffness and a damping of at least 0"))
    except OSError as error:
        raise DimpleError(
            "The hand {path} cannot be read: {error}.", path=path, error=error.strerror or error
        ) from None
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise DimpleError("{path} is not a hand ({error}).", path=path, error=error) from None
    return hand


def _keyframes(keys: Sequence[Sequence[float]]) -> tuple[Keyframe, ...]:
    frames = tuple((float(t), float(x), float(y), float(z)) for t, x, y, z in keys)
    if not frames or not all(math.isfinite(number) for frame in frames for number in frame):
        raise ValueError(Message("a tip has no keyframes, or one that is not made of numbers"))
    if any(a[0] >= b[0] for a, b in zip(frames, frames[1:], strict=False)):
        raise ValueError(Message("the times of a tip do not rise"))
    return frames


def poking_hand() -> EmulatedHand:
    """Return a hand to try a device with: each finger in turn goes down, stays, goes up."""
    tips = []
    for i, (x, y) in enumerate(SIDES):
        at = APART * x, APART * y
        keys = [(0.0, *at, ABOVE)]
        for k in range(i, int(UNTIL / EVERY), len(SIDES)):
            begin = BEGIN + EVERY * k
            for time, z in ((0.0, ABOVE), (MOVE, BELOW), (MOVE + HOLD, BELOW), (2 * MOVE + HOLD, ABOVE)):
                keys.append((begin + time, *at, z))
        tips.append(tuple(keys))
    return EmulatedHand(tips=tuple(tips))
