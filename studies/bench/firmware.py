"""The firmware of the device: it streams places, takes forces, and keeps the hand safe whatever the host does.

The emulator runs it; it is also the specification of the firmware for anyone who builds a device.
"""

from __future__ import annotations

import math
from typing import Final

from core.device import wire
from core.device.limits import STATE_GAP
from core.vectors import ZERO, Vector, length, scaled

from . import kinematics
from .motors import Motors
from .numbers import EmulatedSpec, info
from .round_trips import RoundTrips
from .sensors import CHANNELS, Sensors

SILENCE: Final = 1.0  # [s] without a host, after which the device falls silent too
ARM_PATIENCE: Final = 1.0  # [s] in which the host must become quiet
FAST_TICKS: Final = 5  # so many in a row over the speed limit are a fault
FAULT_EVERY: Final = 0.1  # [s]
HELD: Final = wire.ENABLE | wire.DEADMAN
ALL_FINGERS: Final = range(wire.FINGERS)


class Firmware:
    """A device: `receive` each frame; `sense`, `tick` and `drive` at each tick.

    mode: wire.IDLE...
    code: of the latched fault, wire.FAULT_NONE...
    torques: of the motors of each finger [N m].
    buttons: bits of a STATE.
    link: counts of the session, or of the last one.
    streaming: STATEs are being sent.
    protocol: its version, major and minor.
    """

    def __init__(self, spec: EmulatedSpec, *, session: int = 0) -> None:
        self.spec, self.mode, self.code = spec, wire.IDLE, wire.FAULT_NONE
        self.torques: list[Vector] = [ZERO] * wire.FINGERS
        self.buttons = 0
        self.link: RoundTrips | None = None
        self.streaming, self.protocol = False, wire.PROTOCOL
        self._last_session = session
        self._blocks, self._sensors = kinematics.blocks(spec), Sensors(spec)
        self._motors = [Motors(spec) for _ in ALL_FINGERS]
        self._words = [0] * CHANNELS
        self._angles: list[Vector] = [ZERO] * wire.FINGERS
        self._tips: list[Vector | None] = [None] * wire.FINGERS
        self._places: list[Vector] = [ZERO] * wire.FINGERS  # the last that were right [m]
        self._velocities: list[Vector] = [ZERO] * wire.FINGERS
        self._fast = [0] * wire.FINGERS
        self._command: wire.Command | None = None
        self._command_at = self._heard = self._arming_since = self._ramp_since = self._fault_sent = 0.0
        self._quiet_since: float | None = None
        self._finger = wire.EVERY_FINGER  # of the fault
        self._hello: wire.Hello | None = None

    # frames of the host

    def receive(self, frame: wire.Frame, now: float) -> list[wire.Frame]:
        """Take a frame at a time [s]; return the answers."""
        if isinstance(frame, wire.Hello):
            return self._greet(frame, now)
        if not self.streaming or self.link is None or frame.session != self.link.session:
            return []
        self._heard = now
        if isinstance(frame, wire.Command):
            if self.link.take(frame, now):
                self._command, self._command_at = frame, now
                if self.mode == wire.FAULT and frame.flags & wire.CLEAR and not any(frame.force):
                    self._clear()
        elif isinstance(frame, wire.Arm):
            return self._arm(now)
        elif isinstance(frame, wire.Disarm):
            self._rest()
        return []

    def _greet(self, hello: wire.Hello, now: float) -> list[wire.Frame]:
        if not hello.major_min <= self.protocol[0] <= hello.major_max:
            return [info(self.spec, hello.nonce, 0, self.protocol)]
        again = self.streaming and self.link is not None and not self.link.taken and hello == self._hello
        if self.link is None or not again:  # asked twice before the first CMD, it is the same session
            self._last_session = self._last_session % 255 + 1
            self.link, self._command, self._hello = self._make_link(self._last_session), None, hello
        self._rest()
        self._heard, self.streaming = now, True
        return [info(self.spec, hello.nonce, self.link.session, self.protocol)]

    def _make_link(self, session: int) -> RoundTrips:
        return RoundTrips(self.spec, session)

    def _arm(self, now: float) -> list[wire.Frame]:
        if self.mode == wire.FAULT or any(self._sensors.bad):
            return [self._fault(wire.FAULT_ARM_REFUSED)]
        if self.mode == wire.IDLE:
            self.mode, self._arming_since, self._quiet_since = wire.ARMING, now, None
        return []

    def _rest(self) -> None:
        """End all force; a latched fault stays."""
        if self.mode != wire.FAULT:
            self.mode = wire.IDLE

    def _clear(self) -> None:
        self._sensors.forget()
        self._fast, self._tips = [0] * wire.FINGERS, [None] * wire.FINGERS
        self.mode, self.code = wire.IDLE, wire.FAULT_NONE

    # at each tick

    def sense(self, words: list[int]) -> None:
        """Take the 16-bit readings of the nine joints at a tick."""
        self._sensors.check(words)
        mask = 0xFFFF << 16 - self.spec.adc_bits & 0xFFFF
        self._words = [word & mask for word in words]
        self._move()

    def tick(self, now: float) -> list[wire.Frame]:
        """Return what is sent to the host at a time [s], before `drive`: no host waits for the motors."""
        if self.streaming and now - self._heard > SILENCE:
            self.streaming = False
            self._rest()
        out = self._check(now)
        if self.link is None or not self.streaming:
            return []
        seq = self.link.send(now)
        return [self._state(seq, now), *out]

    def _move(self) -> None:
        """Follow the tips and their speed."""
        spec = self.spec
        share = spec.tick / (STATE_GAP + spec.tick)
        for i in ALL_FINGERS:
            if self._sensors.bad[i]:
                self._tips[i], self._velocities[i] = None, ZERO
                continue
            q = kinematics.adc_angles(spec, tuple(self._words[3 * i : 3 * i + 3]))
            x, y, z = tip = kinematics.forward(self._blocks[i], q)
            before, (vx, vy, vz) = self._tips[i] or tip, self._velocities[i]
            self._velocities[i] = (
                vx + share * ((x - before[0]) / spec.tick - vx),
                vy + share * ((y - before[1]) / spec.tick - vy),
                vz + share * ((z - before[2]) / spec.tick - vz),
            )
            self._angles[i], self._tips[i], self._places[i] = q, tip, tip

    def _check(self, now: float) -> list[wire.Frame]:
        """Find faults and advance the arming; return the FAULT frames to send."""
        if self.mode == wire.FAULT:
            if now - self._fault_sent < FAULT_EVERY:
                return []
            self._fault_sent = now
            return [self._fault(self.code, self._finger)]
        lossy = self.link is not None and self.link.loses_too_much()
        failed = self._sensors.failed()
        if failed is not None:
            return self._latch(wire.FAULT_SENSOR, now, failed)
        if self.mode == wire.ARMING:
            return self._wait_for_quiet(now)
        if self.mode in (wire.RAMP, wire.ARMED):
            if now - self._command_at > self.spec.latch:
                return self._latch(wire.FAULT_WATCHDOG, now)
            if lossy:
                return self._latch(wire.FAULT_LINK, now)
            for i in ALL_FINGERS:
                self._fast[i] = self._fast[i] + 1 if self._is_fast(i) else 0
                if self._fast[i] >= FAST_TICKS:
                    return self._latch(wire.FAULT_SPEED, now, i)
            if not self._is_held():
                self.mode, self._ramp_since = wire.RAMP, now  # the dead-man switch was released: the ramp begins again
            if self.mode == wire.RAMP and now - self._ramp_since >= self.spec.ramp_time:
                self.mode = wire.ARMED
        return []

    def _wait_for_quiet(self, now: float) -> list[wire.Frame]:
        if not (self._is_held() and now - self._command_at <= self.spec.hold and self._is_quiet()):
            self._quiet_since = None
        elif self._quiet_since is None:
            self._quiet_since = now
        elif now - self._quiet_since >= self.spec.arm_time:
            self.mode, self._ramp_since, self._fast = wire.RAMP, now, [0] * wire.FINGERS
            return []
        if now - self._arming_since > ARM_PATIENCE:
            self.mode = wire.IDLE
            return [self._fault(wire.FAULT_ARM_REFUSED)]
        return []

    def _latch(self, code: int, now: float, finger: int = wire.EVERY_FINGER) -> list[wire.Frame]:
        self.mode, self.code, self._finger, self._fault_sent = wire.FAULT, code, finger, now
        return [self._fault(code, finger)]

    def _fault(self, code: int, finger: int = wire.EVERY_FINGER) -> wire.Fault:
        return wire.Fault(self.link.session if self.link else 0, code, finger, self.link.seq if self.link else 0)

    def _is_held(self) -> bool:
        return self._command is not None and self._command.flags & HELD == HELD

    def _is_quiet(self) -> bool:
        return all(length(self._commanded(i)) < self.spec.arm_force for i in ALL_FINGERS)

    def _is_fast(self, i: int) -> bool:
        return length(self._velocities[i]) > self.spec.tip_speed

    def _commanded(self, i: int) -> Vector:
        """Return the force [N] that the host commands of a finger."""
        if self._command is None:
            return ZERO
        x, y, z = self._command.force[3 * i : 3 * i + 3]
        return scaled((x, y, z), wire.FORCE_STEP)

    # the motors

    def drive(self, now: float) -> None:
        """Set the torques, at the time of the tick [s]."""
        age = self._age(now)
        for i in ALL_FINGERS:
            motors = self._motors[i]
            wanted = None if self._sensors.bad[i] else self._wanted(i, age, now)
            force = motors.zero() if wanted is None else motors.limit(wanted)
            self.torques[i] = self._convert(kinematics.torques(self._blocks[i], self._angles[i], force))

    def _wanted(self, i: int, age: float, now: float) -> Vector | None:
        """Return the force [N] before the limits, None for none at once."""
        if self.mode == wire.FAULT:
            return self._brake(i)
        if self.mode not in (wire.RAMP, wire.ARMED):
            return None
        if age >= self.spec.zero:
            return self._brake(i)
        if not self._is_held():
            return None
        if self._is_fast(i):
            return self._brake(i)
        hold = min(self.spec.hold, 1e-3 * self._command.ttl_ms) if self._command else 0.0
        force = scaled(self._commanded(i), min((self.spec.zero - age) / (self.spec.zero - hold), 1.0))
        if self.mode == wire.ARMED:
            return force
        gain = (now - self._ramp_since) / self.spec.ramp_time
        x, y, z = self._brake(i)
        return gain * force[0] + (1 - gain) * x, gain * force[1] + (1 - gain) * y, gain * force[2] + (1 - gain) * z

    def _brake(self, i: int) -> Vector:
        return scaled(self._velocities[i], -self.spec.brake)

    def _convert(self, torque: Vector) -> Vector:
        """Return the torques [N m] as the converters quantize them; beyond a motor they shorten, and never turn."""
        steps = (1 << self.spec.dac_bits - 1) - 1
        over = max(1.0, *(abs(part) / limit for part, limit in zip(torque, self.spec.torque_limits, strict=True)))
        a, b, c = (
            round(part / over / limit * steps) / steps * limit
            for part, limit in zip(torque, self.spec.torque_limits, strict=True)
        )
        return a, b, c

    def _age(self, now: float) -> float:
        """Return the age of the last CMD [s]."""
        return now - self._command_at if self._command else math.inf

    def _state(self, seq: int, now: float) -> wire.DeviceState:
        a, b, c, d, e, f, g, h, i = (_word(part) for place in self._places for part in place)
        mode = self.mode
        if mode in (wire.RAMP, wire.ARMED) and self._age(now) >= self.spec.zero:
            mode = wire.BRAKE
        status = mode | (wire.LIMITED if any(motors.limited for motors in self._motors) else 0)
        for finger in ALL_FINGERS:
            status |= wire.MASKED << finger if self._sensors.bad[finger] else 0
        session, ack = (self.link.session, self.link.ack) if self.link else (0, 0)
        time = int(1e6 * now) & 0xFFFFFFFF
        return wire.DeviceState(session, seq, ack, time, (a, b, c, d, e, f, g, h, i), self.buttons, status)


def _word(metres: float) -> int:
    return min(max(round(metres / wire.PLACE_STEP), -0x7FFF), 0x7FFF)
