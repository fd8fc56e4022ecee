"""Which of its own angle sensors a device trusts. A finger whose sensor is wrong has no force."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from core.device.limits import FAILED_TICKS
from core.device.wire import FINGERS

from .numbers import EmulatedSpec

RAIL: Final = 0x0100  # of 16 bits, at either end of a converter: a wire is disconnected
JUMP: Final = 20.0  # [rad/s] of a joint: 6 m/s at the tip, four times the speed limit
CHANNELS: Final = 3 * FINGERS  # three joints each
FROZEN_TICKS: Final = 50  # readings have noise; so many alike in a row have none


class Sensors:
    """The check of the readings of three fingers, 16 bits before they are cut to the converter's own.

    bad: of each finger, impossible readings in a row.
    """

    def __init__(self, spec: EmulatedSpec) -> None:
        self.bad = [0] * FINGERS
        self._jump = round(JUMP * spec.tick / spec.adc_span * 65536)
        self._noise = spec.adc_noise > 0
        self.forget()

    def forget(self) -> None:
        """Trust the next reading: the fault was cleared."""
        self._good: list[int | None] = [None] * CHANNELS
        self._last, self._same = [-1] * CHANNELS, [0] * CHANNELS
        self.bad = [0] * FINGERS

    def check(self, words: Sequence[int]) -> None:
        """Take the readings of a tick."""
        for finger in range(FINGERS):
            first = 3 * finger
            wrong = [self._is_wrong(c, words[c]) for c in (first, first + 1, first + 2)]
            self.bad[finger] = self.bad[finger] + 1 if any(wrong) else 0

    def failed(self) -> int | None:
        """Return the first finger whose sensor has failed."""
        return next((finger for finger in range(FINGERS) if self.bad[finger] >= FAILED_TICKS), None)

    def _is_wrong(self, channel: int, word: int) -> bool:
        self._same[channel] = self._same[channel] + 1 if word == self._last[channel] else 0
        self._last[channel] = word
        if not RAIL <= word < 0x10000 - RAIL or (self._noise and self._same[channel] >= FROZEN_TICKS):
            return True
        good = self._good[channel]
        if good is not None and abs(word - good) > self._jump:
            return True
        self._good[channel] = word
        return False
