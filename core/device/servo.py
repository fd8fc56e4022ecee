"""The servo: it answers each STATE of the device with forces. Pure: bytes and a time in, bytes out.

The device sets the rate, so the servo needs no timer. It evaluates the law at the newest position of each fingertip on
the surface that Blender last sent (rendered_surface.py says why), and every force passes the finger's Guard.
"""

from __future__ import annotations

import math

from ..errors import DimpleError
from ..material import NOTICEABLE_FORCE
from ..message import Message
from ..vectors import ZERO, Vector, is_finite, length
from . import limits, wire
from .force_guard import Arming, Guard, Switch
from .notes import BAD_FORCE, FAULTS, LOSSY, NO_ANSWER, NO_STATES, SILENT, STOOD_STILL, TOO_FAST, WAS_SILENT, YIELDS
from .orders import LinkState, Order, ServoReport, TipState
from .passivity import SentForces
from .received import Received
from .rendered_surface import Surface, is_sane, left_at, stiffness_cap
from .servo_finger import ServoFinger
from .spec import Spec, spec_of

UNCONNECTED = (LinkState.OPENING, LinkState.LOST)


class Servo:
    """The servo of a device.

    order: what Blender requests; replace it whenever it changes.
    link: state of the connection.
    note: "" or a sentence for the artist.
    cap: largest stiffness to render [N/m]; it falls as soon as the delay grows, and rises only while no force acts: a
        wall that stiffens under a finger pushes it out.
    unsent: answers that the line did not accept.
    """

    def __init__(self, *, nonce: int = 1) -> None:
        self.order = Order()
        self.link, self.note, self.unsent = LinkState.OPENING, "", 0
        self._nonce, self._decoder, self._session, self._seq = nonce, wire.Decoder(), -1, 0
        self._began = self._asked = -math.inf
        self._switch, self._received = Switch(), Received()
        self._is_bad = False  # a surface or force was not a number
        self._old_fault = False  # the device's latched fault precedes the request to arm, and may be cleared
        self._device_time = self._answered = 0.0  # of the last STATE, and of the last answer, on the device's clock [s]
        self._begin(Spec(), 0.0)

    def _begin(self, spec: Spec, now: float) -> None:
        """Begin a session at a time [s]: nothing has been heard, and no earlier request is meant for it."""
        guards = [Guard(spec.peak_force, spec.continuous_force) for _ in range(spec.fingers)]
        self.spec, self._fingers = spec, [ServoFinger(guard=guard) for guard in guards]
        self._taken = self.order
        self._surfaces: tuple[Surface | None, ...] = ()
        self._state: wire.DeviceState | None = None
        self._heard = now  # when the last STATE arrived, on our clock [s]
        # since the last answer: the least share of the force that the device let act; time passed normally
        self._left, self._steady = 1.0, True
        self._sent = SentForces(delay=2 * spec.tick)  # until it is measured
        self.cap = self._stiffest()
        self._received.restart()

    def _stiffest(self) -> float:
        """Return the largest stiffness [N/m] that the delay allows."""
        return stiffness_cap(self.spec.viscous, self.spec.tick, self._sent.delay)

    def step(self, now: float, incoming: bytes) -> bytes:
        """Take the bytes that have arrived by a time [s]; return those to send."""
        if self._began == -math.inf:
            self._began = now
        news = False
        for frame in self._decoder.feed(incoming):
            if isinstance(frame, wire.DeviceState):
                news |= self._take_state(frame, now)
            elif isinstance(frame, wire.Info) and frame.nonce == self._nonce and self.link in UNCONNECTED:
                self._take_info(frame, now)
            elif isinstance(frame, wire.Fault) and frame.session == self._session:
                self._take_fault(frame)
        if self.link is not LinkState.READY:
            return self._send_hello(now)
        out = self._take_requests()
        return out + (self._answer(now) if news else self._handle_silence(now))

    def close(self) -> bytes:
        """Return the last frames: no force, and a DISARM."""
        self._stop("")
        if self._session < 0:
            return b""
        return self._command(wire.NO_FORCE) + self._disarm(wire.FAULT_HOST)

    def report(self) -> ServoReport:
        """Return the state of device and link."""
        received = self._received
        warning = Message(LOSSY, share=received.lost_share) if received.lost_share > limits.LOSS_WARNS else ""
        least = min((finger.guard.passivity.share for finger in self._fingers), default=1.0)
        if self._switch.arming is Arming.ON and least < 1 - NOTICEABLE_FORCE[0]:
            warning = warning or YIELDS
        return ServoReport(
            link=self.link, arming=self._switch.arming, states=received.taken, lost=received.missing,
            unsent=self.unsent, wrong=self._decoder.refused, stale=received.stale, rate=received.rate,
            delay=self._sent.delay, cap=self.cap, peak=self.spec.peak_force,
            note=self.note or self._switch.reason or warning,
            tips=tuple(
                TipState(f.at, f.guard.sent, f.guard.passivity.least, f.bad > 0 or not f.known, f.guard.full)
                for f in self._fingers
            ),
        )  # fmt: skip

    def sample(self) -> tuple[float, ...]:
        """Return the number of STATEs taken, the device's time [s], then position [m] and force [N] of each tip."""
        vectors = [vector for finger in self._fingers for vector in (finger.at, finger.guard.sent)]
        vectors += [ZERO] * (2 * wire.FINGERS - len(vectors))
        return (self._received.taken, self._device_time, *(part for vector in vectors for part in vector))

    def _send_hello(self, now: float) -> bytes:
        """Return a HELLO every limits.LOST_TIME until a device answers; give up after limits.ANSWER_TIME."""
        if self.link is LinkState.OPENING and now - self._began > limits.ANSWER_TIME:
            self.link, self.note = LinkState.REFUSED, Message(NO_ANSWER, baud=wire.BAUD)
        if self.link is LinkState.REFUSED or now - self._asked < limits.LOST_TIME:
            return b""
        self._asked = now
        return wire.encode(wire.Hello(self._nonce, wire.PROTOCOL[0], wire.PROTOCOL[0]))

    def _take_info(self, info: wire.Info, now: float) -> None:
        """Take the device's INFO: a new session, in which nothing is armed."""
        try:
            self._begin(spec_of(info), now)
        except DimpleError as error:
            self.link, self.note = LinkState.REFUSED, str(error)
            return
        self.link, self.note, self._session = LinkState.READY, "", info.session

    def _take_state(self, state: wire.DeviceState, now: float) -> bool:
        """Take a STATE: where the fingertips are, and what the last forces did; return False if it is not new."""
        before = self._state
        if state.session != self._session:
            return False
        if before and not wire.seq_newer(state.seq, before.seq):
            self._received.stale += 1
            return False
        ticks = (state.seq - before.seq) & 0xFFFF if before else 1
        dt = ((state.t_us - before.t_us) & 0xFFFFFFFF) * 1e-6 if before else self.spec.tick
        silent, self._heard = now - self._heard if before else 0.0, now
        self._steady &= 0 < dt <= limits.LOST_TIME and silent <= limits.LOST_TIME
        self._device_time += dt
        self._received.take(ticks - 1, now)
        self._sent.measure(state, self.spec.tick)
        self._old_fault &= state.status & wire.MODE == wire.FAULT
        acted, left = self._sent.between(self.spec, before, state, self._device_time)
        self._left = min(self._left, left * (state.status & wire.MODE in (wire.RAMP, wire.ARMED)))
        for i, finger in enumerate(self._fingers):
            masked = bool(state.status & wire.MASKED << i)
            finger.sense(state.place[3 * i : 3 * i + 3], masked, self.spec.tick * ticks, self._device_time, acted[i],
                         left)  # fmt: skip
        self._state = state
        return True

    def _take_requests(self) -> bytes:
        """Take new requests to arm and to disarm; return the frames they need."""
        before, self._taken = self._taken, self.order
        if self.order.disarm != before.disarm:
            return self._end("", wire.FAULT_HOST)
        if self.order.arm != before.arm:
            self._switch.arm()
            self._old_fault = True
        return b""

    def _take_fault(self, fault: wire.Fault) -> None:
        """Disarm on a FAULT of the device; while waiting to arm, an old fault or a late refusal does not count."""
        if self._switch.arming is not Arming.WAITING or not (self._old_fault or fault.code == wire.FAULT_ARM_REFUSED):
            self._stop(FAULTS.get(fault.code, "The device disarmed itself."))

    def _answer(self, now: float) -> bytes:
        """Return the forces for the newest STATE."""
        state, dt = self._state, self._device_time - self._answered
        assert state
        self._answered = self._device_time
        self._take_surfaces(now)
        # a simulation that hangs counts as a released key; quiet is judged only on surfaces that do not yet fade
        oldest = limits.LOST_TIME if self._switch.arming is Arming.WAITING else limits.LEASE
        held = self.order.is_held(now) or bool(state.buttons & wire.DEADMAN_BUTTON)
        held = held and self.order.is_fresh(now, oldest)
        out = self._check()
        device_on = state.status & wire.MODE in (wire.RAMP, wire.ARMED)
        left = min([self._left, *(left_at(now - surface.stamp) for surface in self._surfaces if surface)])
        for finger in self._fingers:
            finger.guard.passivity.left = left
        self._left, self._steady = 1.0, True
        out += self._update_forces(now, min(dt, limits.STATE_GAP), held=held, device_on=device_on)
        words = [word for finger in self._fingers for word in finger.command()]
        flags = wire.ENABLE * (self._switch.arming is not Arming.OFF) | wire.DEADMAN * held
        if self._old_fault and self._switch.arming is Arming.WAITING and state.status & wire.MODE == wire.FAULT:
            flags = wire.CLEAR
        return out + self._command((*words, *wire.NO_FORCE[len(words) :]), flags)

    def _take_surfaces(self, now: float) -> None:
        """Give the fingers the newest surfaces, as stiff as the delay allows; drop one that is not sane."""
        if self.order.surfaces is self._surfaces:
            return
        before, self._surfaces = self._surfaces, self.order.surfaces
        cap = self._stiffest()
        if cap < self.cap or all(finger.guard.sent == ZERO for finger in self._fingers):
            self.cap = cap
        if self._surfaces == before:  # only the key was renewed
            return
        for finger, surface in zip(self._fingers, self._surfaces, strict=False):
            if surface and not is_sane(surface):
                surface, self._is_bad = None, True
            finger.contact.take(surface, finger.at, now, self.cap)

    def _update_forces(self, now: float, dt: float, *, held: bool, device_on: bool) -> bytes:
        """Give each finger its force; return the ARM frame if it is due."""
        wanted: list[Vector] = [finger.contact.force(finger.at, now) for finger in self._fingers]
        self._is_bad |= not all(map(is_finite, wanted))
        asked = self._switch.arming is Arming.ASKED
        gain = self._switch.gain(max(map(length, wanted)), now, held=held, device_on=device_on)
        for finger, force in zip(self._fingers, wanted, strict=True):
            if finger.bad:
                finger.guard.zero()
            else:
                stored = finger.contact.energy(finger.at) if finger.guard.passivity.left < 1 else math.inf
                finger.guard.output(force, gain, dt, stored)
        new = self._switch.arming is Arming.ASKED and not asked
        return wire.encode(wire.Arm(self._session)) if new else b""

    def _check(self) -> bytes:
        """Disarm if a limit is exceeded; return the frame."""
        if not self._steady:
            return self._end(STOOD_STILL, wire.FAULT_LINK)
        if any(finger.bad >= limits.FAILED_TICKS for finger in self._fingers):
            for finger in self._fingers:
                finger.forget()
            return self._end(FAULTS[wire.FAULT_SENSOR], wire.FAULT_SENSOR)
        if any(finger.guard.runs_away for finger in self._fingers):
            return self._end(TOO_FAST, wire.FAULT_SPEED)
        is_bad, self._is_bad = self._is_bad, False
        if is_bad:
            return self._end(BAD_FORCE, wire.FAULT_HOST)
        if self._received.lost_share > limits.LOSS_DISARMS:
            return self._end(FAULTS[wire.FAULT_LINK], wire.FAULT_LINK)
        return b""

    def _handle_silence(self, now: float) -> bytes:
        """Remove the force if no STATE arrives; return the frames for it."""
        silent = now - self._heard
        if self._state is None:
            if silent > limits.ANSWER_TIME:
                self.link, self.note = LinkState.REFUSED, NO_STATES
            return b""
        if silent > limits.LOST_TIME:
            self._stop(WAS_SILENT)
            self.link, self.note = LinkState.LOST, SILENT
            return self._disarm(wire.FAULT_LINK)
        if silent > limits.STATE_GAP and any(finger.guard.sent != ZERO for finger in self._fingers):
            for finger in self._fingers:
                finger.guard.zero()
            return self._command(wire.NO_FORCE, wire.ENABLE)
        return b""

    def _end(self, reason: str, code: int) -> bytes:
        """End all force here and on the device; return the frame for it."""
        if self._switch.arming is Arming.OFF:
            return b""
        self._stop(reason)
        return self._disarm(code)

    def _stop(self, reason: str) -> None:
        self._switch.disarm(reason)
        for finger in self._fingers:
            finger.guard.zero()

    def _disarm(self, code: int) -> bytes:
        return wire.encode(wire.Disarm(self._session, code))

    def _command(self, force: tuple[int, ...], flags: int = 0) -> bytes:
        self._seq = (self._seq + 1) & 0xFFFF
        held = flags & wire.DEADMAN
        forces = tuple([finger.guard.sent for finger in self._fingers]) if held else None
        echo, t_us = (self._state.seq, self._state.t_us) if self._state else (0, 0)
        self._sent.send(self._seq, forces, t_us)
        ttl = round(1e3 * self.spec.hold)
        return wire.encode(wire.Command(self._session, self._seq, echo, force, flags, ttl))
