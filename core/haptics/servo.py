"""The servo: it answers each STATE of the device with torques. Pure: bytes and a time in, bytes out.

The device keeps the beat, so the servo needs no timer. What it renders are contacts, evaluated at the fingertip's
newest place, and every force passes the finger's Guard.
"""

from __future__ import annotations

import math

from ..errors import DimpleError
from . import kinematics, wire
from .contact_model import FADE_BEGINS, Contact, is_sane, stiffness_cap
from .finger import Finger
from .losses import LOSS_DISARMS, LOSS_WARNS, Losses
from .messages import Link, Order, Report, Tip
from .safety import LEASE, STATE_GAP, STATE_LOST, Arming, BadNumbers, Guard, Limits, Switch
from .sensors import FAILED_TICKS
from .spec import Spec, check_info
from .vectors import ZERO, Vector, is_finite, length

HELLO_EVERY, HELLO_WAIT = 0.1, 1.0  # [s] to ask; without an answer there is no device
PING_EVERY = 0.25  # [s]
FIRST_DELAY = 2e-3  # [s] taken for the delay until it is measured: two ticks
MOST_DT = 0.005  # [s] a step of time for slew and damping, however long the silence was
BUTTON = 1  # State.buttons: the device's dead-man switch

FAULTS = {
    wire.FAULT_WATCHDOG: "The device heard nothing for 100 ms and stopped its motors. Arm it again.",
    wire.FAULT_SENSOR: "An angle sensor of the device gives readings that cannot be. Check its cables.",
    wire.FAULT_SPEED: "A fingertip of the device was faster than any hand. Arm it again.",
    wire.FAULT_ARM_REFUSED: "The device did not arm: let go of the object and arm it again.",
    wire.FAULT_LINK: "The device lost too many frames on the line. Check the cable.",
}
NO_ANSWER = "Nothing answers within 1 s. Check port, baud rate ({baud}) and power of the {name}."
MUTE = "The device answers but streams no positions. Switch it off and on, then connect again."
SILENT = "The device is silent: the connection is lost. When it is back, arm it again."
WAS_SILENT = "The device was silent for more than 100 ms. Arm it again."
STOOD_STILL = "Device or computer stood still for more than 100 ms, or the device's clock is wrong. Arm it again."
TOO_FAST = "A fingertip was faster than 1.5 m/s. Arm the device again."
BAD_FORCE = "The simulation gave forces that are not numbers. Reset it and arm the device again."
LOSSY = "{share:.0%} of the frames are lost on the line. Check the cable."


class Servo:
    """Run a device.

    order: what Blender wants; replace it whenever it changes.  link, message: for Blender.  cap: largest stiffness to
    render [N/m]; it falls as soon as the delay grows, and rises only while nothing is touched: a wall that stiffens
    under a finger pushes it out.  unsent: answers that the line did not take.
    """

    def __init__(self, spec: Spec, *, nonce: int = 1) -> None:
        self.spec, self.order = spec, Order()
        self.link, self.message = Link.OPENING, ""
        self._nonce, self._taken = nonce, Order()
        self._contacts: tuple[Contact | None, ...] = ()
        self._decoder, self._session, self._seq = wire.Decoder(), -1, 0
        self._began = self._asked = self._pinged = -math.inf
        limits = Limits(spec.peak_force, spec.continuous_force)
        self._fingers = [Finger(block=block, guard=Guard(limits)) for block in kinematics.blocks(spec)]
        self._switch, self._bad, self._losses = Switch(), BadNumbers(), Losses()
        self._old_fault = False  # what the device has latched is from before it was to arm, and may be cleared
        self._state: wire.State | None = None
        self._heard = self._device_time = 0.0  # when the last STATE came, and when the device says it was [s]
        self._measured: wire.Report | None = None
        self.unsent = 0
        self.cap = stiffness_cap(spec.viscous, spec.tick, FIRST_DELAY)

    @property
    def delay(self) -> float:
        """Return the delay t_d [s] from sensor to motor: the device takes what has come at its next tick."""
        if self._measured is None:
            return FIRST_DELAY
        tick = self.spec.tick
        return max(math.ceil(self._measured.rtt_p99_us * 1e-6 / tick), 1) * tick

    @property
    def device_time_us(self) -> int:
        """Return when the device sensed what was answered last [us], -1 before the first STATE."""
        return self._state.t_us if self._state else -1

    @property
    def tips(self) -> list[tuple[Vector, Vector]]:
        """Return position [m] and force [N] of each fingertip."""
        return [(finger.at, finger.guard.sent) for finger in self._fingers]

    def step(self, now: float, incoming: bytes) -> bytes:
        """Take what came in, at a time [s]; return what goes out."""
        if self._began == -math.inf:
            self._began = now
        newest = None
        for frame in self._decoder.feed(incoming):
            if isinstance(frame, wire.State):
                newest = self._newer(frame, newest, now)
            elif isinstance(frame, wire.Info) and frame.nonce == self._nonce and self.link in (Link.OPENING, Link.LOST):
                self._meet(frame, now)
            elif isinstance(frame, wire.Fault) and frame.session == self._session:
                self._heed(frame)
            elif isinstance(frame, wire.Report) and frame.session == self._session and frame.answered:
                self._measured = frame
        if self.link is not Link.READY:
            return self._call(now)
        out = self._obey()
        return out + (self._answer(newest, now) if newest else self._miss(now)) + self._ping(now)

    def close(self) -> bytes:
        """Return the last words: no force, and the end of it."""
        self._stop("")
        if self._session < 0:
            return b""
        return self._command(wire.NO_TORQUE) + self._disarm(wire.FAULT_HOST)

    def report(self) -> Report:
        """Return how it stands."""
        counts, measured, state, losses = self._decoder.counts, self._measured, self._state, self._losses
        warning = LOSSY.format(share=losses.share) if losses.share > LOSS_WARNS else ""
        return Report(
            time=self._heard, link=self.link, arming=self._switch.arming, states=losses.taken, lost=losses.missing,
            unsent=self.unsent, wrong=counts.refused, stale=losses.stale, late=measured.late if measured else 0,
            rate=losses.rate, delay_p50=measured.rtt_p50_us * 1e-6 if measured else 0.0,
            delay_p99=measured.rtt_p99_us * 1e-6 if measured else 0.0,
            wire=measured.wire_us * 1e-6 if measured else 0.0,
            cap=self.cap, peak=self._fingers[0].guard.limits.peak,
            message=self.message or self._switch.reason or warning,
            buttons=state.buttons if state else 0, status=state.status if state else 0,
            tips=tuple(
                Tip(
                    position=f.at, force=f.guard.sent, least_energy=f.guard.passivity.least,
                    masked=f.bad > 0 or f.angles is None, full=f.guard.full,
                )
                for f in self._fingers
            ),
        )  # fmt: skip

    def _call(self, now: float) -> bytes:
        """Say HELLO until somebody answers, or nobody did."""
        if self.link is Link.OPENING and now - self._began > HELLO_WAIT:
            self.link, self.message = Link.REFUSED, NO_ANSWER.format(baud=self.spec.baud, name=self.spec.name)
        if self.link is Link.REFUSED or now - self._asked < HELLO_EVERY:
            return b""
        self._asked = now
        return wire.encode(wire.Hello(self._nonce, wire.PROTOCOL[0], wire.PROTOCOL[0]))

    def _meet(self, info: wire.Info, now: float) -> None:
        """Take the device's answer: a new session, in which nothing is armed."""
        try:
            check_info(self.spec, info)
        except DimpleError as error:
            self.link, self.message = Link.REFUSED, str(error)
            return
        for finger in self._fingers:
            finger.forget()
        self.link, self.message, self._session = Link.READY, "", info.session
        self._state, self._measured, self._heard = None, None, now
        self._taken = self.order  # what was asked for before is not meant for this session
        self._losses.restart(now)

    def _newer(self, state: wire.State, newest: wire.State | None, now: float) -> wire.State | None:
        """Return the newer of two STATEs; the older one is dropped."""
        last = newest or self._state
        if state.session != self._session:
            return newest
        if last and not wire.seq_newer(state.seq, last.seq):
            self._losses.stale += 1
            return newest
        self._losses.take((state.seq - last.seq - 1) & 0xFFFF if last else 0, now)
        self._old_fault &= state.status & wire.MODE == wire.FAULT
        return state

    def _obey(self) -> bytes:
        """Take new requests to arm and to disarm."""
        before, self._taken = self._taken, self.order
        if self.order.disarm != before.disarm:
            return self._end("", wire.FAULT_HOST)
        if self.order.arm != before.arm:
            self._switch.arm()
            self._old_fault = True
        return b""

    def _heed(self, fault: wire.Fault) -> None:
        """Take the device's word that something is wrong; while waiting, old stories and late refusals are none."""
        if self._switch.arming is not Arming.WAITING or not (self._old_fault or fault.code == wire.FAULT_ARM_REFUSED):
            self._stop(FAULTS.get(fault.code, "The device disarmed itself."))

    def _answer(self, state: wire.State, now: float) -> bytes:
        """Return the torques for a STATE."""
        silent, before = now - self._heard, self._state
        self._state, self._heard = state, now
        ticks = (state.seq - before.seq) & 0xFFFF if before else 1
        dt = ((state.t_us - before.t_us) & 0xFFFFFFFF) * 1e-6 if before else self.spec.tick
        steady = 0 < dt <= STATE_LOST and (silent <= STATE_LOST or before is None)
        self._device_time += dt
        for i, finger in enumerate(self._fingers):
            words = state.adc[3 * i], state.adc[3 * i + 1], state.adc[3 * i + 2]
            finger.sense(self.spec, words, bool(state.status & wire.MASKED << i), ticks, self._device_time)
        self._take_contacts(now)
        # a simulation that stands still is a key let go; the quiet is judged by contacts that have not begun to fade
        oldest = FADE_BEGINS if self._switch.arming is Arming.WAITING else LEASE
        held = (self.order.is_held(now) or bool(state.buttons & BUTTON)) and self.order.is_fresh(now, oldest)
        out = self._watch(steady) + self._push(state, now, min(dt, MOST_DT), held)
        a, b, c = (finger.drive(self.spec, finger.guard.sent) for finger in self._fingers)
        flags = wire.ENABLE * (self._switch.arming is not Arming.OFF) | wire.DEADMAN * held
        if self._old_fault and self._switch.arming is Arming.WAITING and state.status & wire.MODE == wire.FAULT:
            flags = wire.CLEAR
        return out + self._command((*a, *b, *c), flags)

    def _take_contacts(self, now: float) -> None:
        """Let the fingers feel the newest contacts, as stiff as the delay allows; what is no number is no contact."""
        if self.order.contacts is self._contacts:
            return
        before, self._contacts = self._contacts, self.order.contacts
        cap = stiffness_cap(self.spec.viscous, self.spec.tick, self.delay)
        if cap < self.cap or all(finger.guard.sent == ZERO for finger in self._fingers):
            self.cap = cap
        if self._contacts == before:  # only the key was renewed
            return
        for finger, contact in zip(self._fingers, self._contacts, strict=False):
            if contact and not is_sane(contact):
                contact = None
                self._bad.count(now)
            finger.feel.take(contact, finger.at, now, self.cap)

    def _push(self, state: wire.State, now: float, dt: float, held: bool) -> bytes:
        """Give each finger its force; return what else there is to say."""
        wanted: list[Vector] = [finger.feel.force(finger.at, now, self.cap) for finger in self._fingers]
        for force in wanted:
            if not is_finite(force):
                self._bad.count(now)
        asked = self._switch.arming is Arming.ASKED
        device_on = state.status & wire.MODE in (wire.RAMP, wire.ARMED)
        gain = self._switch.gain(max(map(length, wanted)), now, held=held, device_on=device_on)
        for finger, force in zip(self._fingers, wanted, strict=True):
            if finger.bad:
                finger.guard.zero()
            else:
                finger.guard.output(force, gain, dt)
        new = self._switch.arming is Arming.ASKED and not asked
        return wire.encode(wire.Arm(self._session)) if new else b""

    def _watch(self, steady: bool) -> bytes:
        """Look for what must end all force; steady: time went on as it does, here and on the device."""
        if not steady:
            return self._end(STOOD_STILL, wire.FAULT_LINK)
        if any(finger.bad >= FAILED_TICKS for finger in self._fingers):
            for finger in self._fingers:
                finger.forget()
            return self._end(FAULTS[wire.FAULT_SENSOR], wire.FAULT_SENSOR)
        if any(finger.guard.runs_away for finger in self._fingers):
            return self._end(TOO_FAST, wire.FAULT_SPEED)
        if self._bad.too_many():
            return self._end(BAD_FORCE, wire.FAULT_HOST)
        if self._losses.share > LOSS_DISARMS:
            return self._end(FAULTS[wire.FAULT_LINK], wire.FAULT_LINK)
        return b""

    def _miss(self, now: float) -> bytes:
        """Take the force away where no STATE comes."""
        silent = now - self._heard
        if self._state is None:
            if silent > HELLO_WAIT:
                self.link, self.message = Link.REFUSED, MUTE
            return b""
        if silent > STATE_LOST:
            self._stop(WAS_SILENT)
            self.link, self.message = Link.LOST, SILENT
            return self._disarm(wire.FAULT_LINK)
        if silent > STATE_GAP and any(finger.guard.sent != ZERO for finger in self._fingers):
            for finger in self._fingers:
                finger.guard.zero()
            return self._command(wire.NO_TORQUE, wire.ENABLE)
        return b""

    def _end(self, reason: str, code: int) -> bytes:
        """End all force here and on the device."""
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

    def _command(self, torque: wire.Nine, flags: int = 0) -> bytes:
        self._seq = (self._seq + 1) & 0xFFFF
        echo = self._state.seq if self._state else 0
        ttl = round(1e3 * self.spec.hold)
        return wire.encode(wire.Command(self._session, self._seq, echo, torque, flags, ttl))

    def _ping(self, now: float) -> bytes:
        if now - self._pinged < PING_EVERY:
            return b""
        self._pinged = now
        return wire.encode(wire.Ping(self._session, self._seq))
