"""A Haptic Master that is not there: firmware, motors, linkage, hand and line, on a clock that is handed in.

    emulator = Emulator(load_spec())
    bytes_to_host = emulator.step(now, bytes_from_host)

Times inside are counted from the first step.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Final

from . import kinematics, wire
from .faults import ON_THE_LINE, Fault
from .firmware import Firmware
from .hand import Hand
from .line import Line
from .plant import Tip
from .spec import Spec
from .vectors import ZERO, Vector

NOISE: Final = 4093  # readings until the noise comes again; a prime, so that joints and ticks do not fall in step
JUMP: Final = 0.3  # [rad] of the fault adc-jump
Row = tuple[float, ...]  # time [s], mode, three positions [m], three forces [N]


class Emulator:
    """Emulate a device.

    Args:
        spec: what it is.  hand: what holds it.  faults: what goes wrong.  seed: of all chance.
        baud: of the line, None: the spec's, 0: bytes take no time.
        trace: a list to which each tick adds a row: time, mode, true positions and forces of the three tips.

    tips: position and velocity of the fingertips.  forces: of the motors at the tips [N].  unplugged: the line is gone.
    """

    def __init__(
        self,
        spec: Spec,
        *,
        hand: Hand | None = None,
        faults: Sequence[Fault] = (),
        seed: int = 0,
        baud: int | None = None,
        trace: list[Row] | None = None,
    ) -> None:
        dice = random.Random(seed)
        self.baud = baud = spec.baud if baud is None else baud
        self.spec, self.hand, self.unplugged, self.trace = spec, hand or Hand(), False, trace
        version = next((int(fault.value) for fault in faults if fault.name == "version"), wire.PROTOCOL[0])
        protocol = (version, wire.PROTOCOL[1])
        self.firmware = Firmware(spec, baud=baud, session=dice.randrange(255), protocol=protocol)
        self.tips = [Tip(self.hand.target(i, -math.inf)[0]) for i in range(wire.FINGERS)]
        self.forces: list[Vector] = [ZERO] * wire.FINGERS
        self.decoder = wire.Decoder()
        self._faults = tuple(faults)
        spoils = [fault for fault in faults if fault.name in ON_THE_LINE]
        self._in = Line(baud, [fault for fault in spoils if fault.way != "out"], random.Random(seed + 1))
        self._out = Line(baud, [fault for fault in spoils if fault.way != "in"], random.Random(seed + 2))
        self._blocks = kinematics.blocks(spec)
        self._noise = [dice.gauss(0, spec.adc_noise) * (1 << 16 - spec.adc_bits) for _ in range(NOISE)]
        self._frozen: dict[int, list[int]] = {}  # finger: its readings when it froze
        self._rest = b""  # of a frame from the host
        self._begin: float | None = None  # [s] on the clock of step
        self._ticks = 0
        self._begun: tuple[float, int] | None = None  # the tick under way [s], and the mode then
        self._script: float | None = None if self.hand.from_arm else 0.0  # when the hand's time began [s]
        self._angles = self._sense()

    def step(self, now: float, incoming: bytes) -> bytes:
        """Live up to a time [s]; take the host's bytes, which set off now; return those that have come to the host."""
        if self._begin is None:
            self._begin = now
        now -= self._begin
        self._live(now)
        if self.unplugged:
            return b""
        *frames, self._rest = (self._rest + incoming).split(b"\0")
        for frame in frames:
            self._in.send(now, frame + b"\0")
        self._live(now)
        outgoing = self._out.take(now)
        if not outgoing:
            self._settle()
        return outgoing

    def _settle(self) -> None:
        """Let motors and hand move the fingertips over the tick that has begun, and sense where they are at its end.

        Once the State has left: no host waits for what only an emulator has to compute.
        """
        if self._begun is None:
            return
        (now, mode), self._begun = self._begun, None
        if self._acts("stall", now):  # its amplifiers want a pulse each tick, and let go without
            self.firmware.torques = [ZERO] * wire.FINGERS
        else:
            self.firmware.drive(now)
        for i, torque in enumerate(self.firmware.torques):
            self.forces[i] = kinematics.force(self._blocks[i], self._angles[i], torque) if any(torque) else ZERO
        if self.trace is not None:
            places, forces = [tip.position for tip in self.tips], self.forces
            self.trace.append((now, float(mode), *(x for three in (*places, *forces) for x in three)))
        time = -math.inf if self._script is None else now - self._script
        for i, tip in enumerate(self.tips):
            tip.step(self.spec, self.hand, i, time, self.forces[i])
        self._angles = self._sense()

    def next_time(self) -> float:
        """Return when there is something to do [s]: step then, or earlier when bytes come."""
        return (self._begin or 0.0) + min(self._next_tick(), self._in.next_time(), self._out.next_time())

    @property
    def started(self) -> bool:
        """Tell whether it has had its first step."""
        return self._begin is not None

    @property
    def mode(self) -> int:
        """Return wire.IDLE..."""
        return self.firmware.mode

    def _next_tick(self) -> float:
        return self._ticks * self.spec.tick

    def _live(self, now: float) -> None:
        """Let happen what happens by now, in order."""
        while not self.unplugged and (time := min(self._next_tick(), self._in.next_time())) <= now:
            self._settle()
            self._hear(time)
            if time == self._next_tick():
                self._tick(time)

    def _hear(self, now: float) -> None:
        for frame in self.decoder.feed(self._in.take(now)):
            if not self._acts("stall", now):
                self._say(self.firmware.receive(frame, now, self.decoder.counts.refused), now)

    def _say(self, frames: list[wire.Frame], now: float) -> None:
        for frame in frames:
            self._out.send(now, wire.encode(frame))

    def _tick(self, now: float) -> None:
        self._ticks += 1
        self.unplugged = self._acts("unplug", now)
        if not self._acts("stall", now):
            self._say(self.firmware.tick(now), now)
        if self._script is None and self.mode == wire.RAMP:
            self._script = now
        self._begun = now, self.mode

    def _sense(self) -> list[Vector]:
        """Let the device read its joints at the next tick; return the true angles there [rad]."""
        angles = [kinematics.inverse(block, tip.position) for block, tip in zip(self._blocks, self.tips, strict=True)]
        scale, noise = 65536 / self.spec.adc_span, self._noise
        at = self._ticks * wire.CHANNELS
        words = [
            min(max(int((q - centre) * scale + 32768 + noise[(at + 3 * i + j) % NOISE]), 0), 0xFFFF)
            for i, three in enumerate(angles)
            for j, (q, centre) in enumerate(zip(three, self.spec.adc_centres, strict=True))
        ]
        for fault in self._faults:
            if fault.name.startswith("adc-"):
                self._mistake(fault, words, self._next_tick())
        if not self._acts("stall", self._next_tick()):
            self.firmware.sense(words)
        return angles

    def _mistake(self, fault: Fault, words: list[int], now: float) -> None:
        finger = int(fault.value) % wire.FINGERS
        three = slice(3 * finger, 3 * finger + 3)
        if not fault.acts(now):
            self._frozen.pop(finger, None)
        elif fault.name == "adc-range":
            words[three] = [0xFFFF] * 3
        elif fault.name == "adc-frozen":
            words[three] = self._frozen.setdefault(finger, words[three])
        else:
            words[three.start] = min(words[three.start] + round(JUMP / self.spec.adc_span * 65536), 0xFFFF)

    def _acts(self, name: str, now: float) -> bool:
        return any(fault.name == name and fault.acts(now) for fault in self._faults)
