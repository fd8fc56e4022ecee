"""An emulated Haptic Master: firmware, motors, linkage, hand and serial line on an injected clock.

    emulator = Emulator(load_emulated())
    bytes_to_host = emulator.step(now, bytes_from_host)

Times inside are counted from the first step. Nothing goes wrong here: faults are injected by faulty_emulator.py.
"""

from __future__ import annotations

import math
import random
from typing import Final

from core.device import wire
from core.vectors import ZERO, Vector

from . import kinematics, linkage
from .firmware import Firmware
from .hand import EmulatedHand
from .line import EmulatedLine
from .numbers import EmulatedSpec
from .sensors import CHANNELS
from .tip import EmulatedTip

NOISE: Final = 4093  # readings until the noise repeats; a prime, so that joints and ticks do not fall in step


class Emulator:
    """An emulated device.

    Args:
        spec: the numbers of the device.
        hand: what holds it, None for a hand at rest.
        seed: of the noise and of the session numbers.
        baud: of the line, None: the spec's, 0: bytes take no time.

    Attributes:
        tips: position and velocity of the fingertips.
        forces: of the motors at the tips [N].
        unplugged: the line is gone.
    """

    def __init__(
        self, spec: EmulatedSpec, *, hand: EmulatedHand | None = None, seed: int = 0, baud: int | None = None
    ) -> None:
        dice = random.Random(seed)
        self.spec, self.hand, self.unplugged = spec, hand or EmulatedHand(), False
        self.baud = spec.baud if baud is None else baud
        self.firmware = self._make_firmware(dice.randrange(255))
        self.tips = [EmulatedTip(self.hand.target(i, -math.inf)[0]) for i in range(wire.FINGERS)]
        self.forces: list[Vector] = [ZERO] * wire.FINGERS
        self.decoder = wire.Decoder()
        self._in, self._out = self._make_lines()
        self._blocks = kinematics.blocks(spec)
        self._noise = [dice.gauss(0, spec.adc_noise) * (1 << 16 - spec.adc_bits) for _ in range(NOISE)]
        self._rest = b""  # of a frame from the host
        self._begin: float | None = None  # [s] on the clock of step
        self._ticks = 0
        self._begun: float | None = None  # the tick under way [s]
        self._script: float | None = None if self.hand.from_arm else 0.0  # when the hand's time began [s]
        self._angles = self._sense()

    def step(self, now: float, incoming: bytes) -> bytes:
        """Run up to a time [s]; take the host's bytes, which leave it now; return those that have reached the host."""
        if self._begin is None:
            self._begin = now
        now -= self._begin
        self._run(now)
        if self.unplugged:
            return b""
        *frames, self._rest = (self._rest + incoming).split(b"\0")
        for frame in frames:
            self._in.send(now, frame + b"\0")
        self._run(now)
        outgoing = self._out.take(now)
        if not outgoing:
            self._settle()
        return outgoing

    def next_time(self) -> float:
        """Return when there is something to do [s]: step then, or earlier when bytes come."""
        return (self._begin or 0.0) + min(self._next_tick(), self._in.next_time(), self._out.next_time())

    @property
    def started(self) -> bool:
        """Tell whether it has had its first step."""
        return self._begin is not None

    @property
    def mode(self) -> int:
        """Return the mode of the firmware: wire.IDLE..."""
        return self.firmware.mode

    def _make_firmware(self, session: int) -> Firmware:
        return Firmware(self.spec, session=session)

    def _make_lines(self) -> tuple[EmulatedLine, EmulatedLine]:
        """Return the line to the device and the line to the host."""
        return EmulatedLine(self.baud), EmulatedLine(self.baud)

    def _next_tick(self) -> float:
        return self._ticks * self.spec.tick

    def _run(self, now: float) -> None:
        """Process everything that happens up to now, in order."""
        while not self.unplugged and (time := min(self._next_tick(), self._in.next_time())) <= now:
            self._settle()
            self._receive(time)
            if time == self._next_tick():
                self._tick(time)

    def _receive(self, now: float) -> None:
        for frame in self.decoder.feed(self._in.take(now)):
            self._send(self.firmware.receive(frame, now), now)

    def _send(self, frames: list[wire.Frame], now: float) -> None:
        for frame in frames:
            self._out.send(now, wire.encode(frame))

    def _tick(self, now: float) -> None:
        self._ticks += 1
        self._send(self.firmware.tick(now), now)
        if self._script is None and self.mode == wire.RAMP:
            self._script = now
        self._begun = now

    def _settle(self) -> None:
        """Let motors and hand move the fingertips over the tick that has begun, and sense where they are at its end.

        This runs once the STATE has left: no host waits for what only an emulator has to compute.
        """
        if self._begun is None:
            return
        now, self._begun = self._begun, None
        self.firmware.drive(now)
        for i, torque in enumerate(self.firmware.torques):
            self.forces[i] = linkage.force(self._blocks[i], self._angles[i], torque) if any(torque) else ZERO
        self._move(now)
        self._angles = self._sense()

    def _move(self, now: float) -> None:
        time = -math.inf if self._script is None else now - self._script
        for i, tip in enumerate(self.tips):
            tip.step(self.spec, self.hand, i, time, self.forces[i])

    def _sense(self) -> list[Vector]:
        """Let the firmware read its joints at the next tick; return the true angles there [rad]."""
        angles = [linkage.inverse(block, tip.position) for block, tip in zip(self._blocks, self.tips, strict=True)]
        scale, noise = 65536 / self.spec.adc_span, self._noise
        at = self._ticks * CHANNELS
        self.firmware.sense([
            min(max(int((q - centre) * scale + 32768 + noise[(at + 3 * i + j) % NOISE]), 0), 0xFFFF)
            for i, three in enumerate(angles)
            for j, (q, centre) in enumerate(zip(three, self.spec.adc_centres, strict=True))
        ])  # fmt: skip
        return angles
