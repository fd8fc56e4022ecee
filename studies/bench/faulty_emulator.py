"""An emulated device with injected faults and instruments: a trace of each tick, and round trips of a whole session."""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Sequence
from typing import Final

from core.device import wire
from core.vectors import ZERO, Vector

from .emulator import Emulator
from .faults import ON_THE_LINE, InjectedFault
from .firmware import Firmware
from .hand import EmulatedHand
from .line import EmulatedLine
from .numbers import EmulatedSpec
from .round_trips import RoundTrips

JUMP: Final = 0.3  # [rad] of the fault adc-jump
TraceRow = tuple[float, ...]  # time [s], mode, three positions [m], three forces [N]


class FaultyLine(EmulatedLine):
    """A line with faults.

    Args:
        baud: bits a second; 0: bytes take no time.
        faults: those of this direction.
        dice: for them.
    """

    def __init__(self, baud: int, faults: Sequence[InjectedFault], dice: random.Random) -> None:
        super().__init__(baud)
        self._faults, self._dice = faults, dice
        self._delayed: list[bytes] = []  # a frame that comes after the next one

    def send(self, now: float, frame: bytes) -> None:
        """Put a frame on the line at a time [s], or what the faults make of it."""
        start, frames = now, [frame]
        for fault in self._faults:
            if fault.acts(now):
                frames = self._spoil(fault, frames)
                start += fault.value if fault.name == "delay" else 0.0
                start = max(start, fault.stop) if fault.name == "stale" else start
        for each in frames:
            super().send(start, each)

    def _spoil(self, fault: InjectedFault, frames: list[bytes]) -> list[bytes]:
        if fault.name == "flip":
            return [self._flip(frame, fault.value) for frame in frames]
        if fault.name == "wrong-baud":
            return [self._dice.randbytes(len(frame)) for frame in frames]
        if fault.name in ("delay", "stale") or self._dice.random() >= fault.value:
            return [*frames, *self._release()] if fault.name == "reorder" else frames
        if fault.name == "garbage":
            return [self._dice.randbytes(self._dice.randint(1, 60)), *frames]
        if fault.name == "truncate":
            return [frame[: self._dice.randrange(len(frame) + 1)] for frame in frames]
        if fault.name == "duplicate":
            return [*frames, *frames]
        if fault.name == "reorder":
            released, self._delayed = self._delayed, frames
            return released
        return []  # drop

    def _release(self) -> list[bytes]:
        delayed, self._delayed = self._delayed, []
        return delayed

    def _flip(self, frame: bytes, rate: float) -> bytes:
        # the distance to the next error is geometric: one die a frame where nearly none is hit
        at = self._gap(rate)
        bits = 8 * len(frame)
        if at >= bits:
            return frame
        number = int.from_bytes(frame, "little")
        while at < bits:
            number ^= 1 << at
            at += 1 + self._gap(rate)
        return number.to_bytes(len(frame), "little")

    def _gap(self, rate: float) -> int:
        if not 0 < rate < 1:
            return 0 if rate else 1 << 60
        return int(math.log(1.0 - self._dice.random()) / math.log1p(-rate))


class SessionRoundTrips(RoundTrips):
    """Counts of the recent round trips, and of those of the whole session.

    trips: how many took so long [us].
    """

    def __init__(self, spec: EmulatedSpec, session: int) -> None:
        super().__init__(spec, session)
        self.trips: Counter[int] = Counter()

    def add_round_trip(self, seconds: float) -> None:
        """Record how long a STATE waited for its answer [s]."""
        super().add_round_trip(seconds)
        self.trips[min(round(1e6 * seconds), 0xFFFF)] += 1


class FaultyFirmware(Firmware):
    """A firmware that stalls, whose sensors fail, and which may be of another version."""

    def __init__(self, spec: EmulatedSpec, faults: Sequence[InjectedFault], *, session: int) -> None:
        super().__init__(spec, session=session)
        self._faults = faults
        self._next_tick = 0.0  # [s]
        self._frozen: dict[int, list[int]] = {}  # finger: its readings when it froze
        for fault in faults:
            if fault.name == "version":
                self.protocol = (int(fault.value), wire.PROTOCOL[1])

    def receive(self, frame: wire.Frame, now: float) -> list[wire.Frame]:
        """Take a frame; a device that stalls takes none."""
        return [] if self._stalls(now) else super().receive(frame, now)

    def tick(self, now: float) -> list[wire.Frame]:
        """Return what is sent at a tick; a device that stalls sends nothing."""
        return [] if self._stalls(now) else super().tick(now)

    def drive(self, now: float) -> None:
        """Set the torques; the amplifiers need a pulse each tick, and without it they have none."""
        self._next_tick = (round(now / self.spec.tick) + 1) * self.spec.tick
        if self._stalls(now):
            self.torques = [ZERO] * wire.FINGERS
        else:
            super().drive(now)

    def sense(self, words: list[int]) -> None:
        """Take the readings of the next tick, wrong where a sensor fails."""
        for fault in self._faults:
            if fault.name.startswith("adc-"):
                self._spoil(fault, words)
        if not self._stalls(self._next_tick):
            super().sense(words)

    def _make_link(self, session: int) -> RoundTrips:
        return SessionRoundTrips(self.spec, session)

    def _spoil(self, fault: InjectedFault, words: list[int]) -> None:
        finger = int(fault.value) % wire.FINGERS
        three = slice(3 * finger, 3 * finger + 3)
        if not fault.acts(self._next_tick):
            self._frozen.pop(finger, None)
        elif fault.name == "adc-range":
            words[three] = [0xFFFF] * 3
        elif fault.name == "adc-frozen":
            words[three] = self._frozen.setdefault(finger, words[three])
        else:
            words[three.start] = min(words[three.start] + round(JUMP / self.spec.adc_span * 65536), 0xFFFF)

    def _stalls(self, now: float) -> bool:
        return any(fault.name == "stall" and fault.acts(now) for fault in self._faults)


class FaultyEmulator(Emulator):
    """An emulated device with faults and a trace.

    Args:
        spec: the numbers of the device.
        hand: what holds it, None for a hand at rest.
        faults: what goes wrong.
        seed: of all chance.
        baud: of the line, None: the spec's, 0: bytes take no time.
        trace: a list to which each tick adds a row: time, mode, true positions and forces of the three tips.
    """

    def __init__(
        self,
        spec: EmulatedSpec,
        *,
        hand: EmulatedHand | None = None,
        faults: Sequence[InjectedFault] = (),
        seed: int = 0,
        baud: int | None = None,
        trace: list[TraceRow] | None = None,
    ) -> None:
        self.faults, self.trace, self._seed = tuple(faults), trace, seed
        self._mode = wire.IDLE  # at the tick under way
        super().__init__(spec, hand=hand, seed=seed, baud=baud)

    def _make_firmware(self, session: int) -> Firmware:
        return FaultyFirmware(self.spec, self.faults, session=session)

    def _make_lines(self) -> tuple[EmulatedLine, EmulatedLine]:
        spoils = [fault for fault in self.faults if fault.name in ON_THE_LINE]
        into = [fault for fault in spoils if fault.way != "out"]
        out = [fault for fault in spoils if fault.way != "in"]
        return (
            FaultyLine(self.baud, into, random.Random(self._seed + 1)),
            FaultyLine(self.baud, out, random.Random(self._seed + 2)),
        )

    def _tick(self, now: float) -> None:
        if any(fault.name == "unplug" and fault.acts(now) for fault in self.faults):
            self.unplugged = True  # never set back here: a signal may have set it a moment ago
        super()._tick(now)
        self._mode = self.mode

    def _move(self, now: float) -> None:
        if self.trace is not None:
            vectors: list[Vector] = [*(tip.position for tip in self.tips), *self.forces]
            self.trace.append((now, float(self._mode), *(part for vector in vectors for part in vector)))
        super()._move(now)
