"""A plain host: what the shortest driver would be. It answers each STATE with given forces."""

from __future__ import annotations

from collections.abc import Callable

from core.device import wire
from core.vectors import ZERO, Vector
from studies.bench.faults import parse_fault
from studies.bench.faulty_emulator import FaultyEmulator, TraceRow
from studies.bench.hand import EmulatedHand
from studies.bench.numbers import load_emulated

SPEC = load_emulated()
HELD = wire.ENABLE | wire.DEADMAN


def still(finger: int, time: float) -> Vector:
    """No force."""
    return ZERO


class Host:
    """Drive a device: bytes in, bytes out.

    force: of a finger at a time [N].  arms: ask for it when a few States are there.  words: instead of force.
    """

    def __init__(self, force: Callable[[int, float], Vector] = still, *, arms: bool = True, nonce: int = 1) -> None:
        self.force, self.arms, self.nonce, self.flags = force, arms, nonce, HELD
        self.words: wire.Nine | None = None
        self.answers = True
        self.decoder = wire.Decoder()
        self.info: wire.Info | None = None
        self.states: list[wire.DeviceState] = []
        self.faults: list[wire.Fault] = []
        self.sent: dict[int, wire.Command] = {}
        self._seq = 0

    def hello(self) -> bytes:
        return wire.encode(wire.Hello(self.nonce, wire.PROTOCOL[0], wire.PROTOCOL[0]))

    def step(self, now: float, incoming: bytes) -> bytes:
        out, newest = [], None
        for frame in self.decoder.feed(incoming):
            if isinstance(frame, wire.Info):
                self.info = frame
            elif isinstance(frame, wire.DeviceState):
                self.states.append(frame)
                newest = frame
            elif isinstance(frame, wire.Fault):
                self.faults.append(frame)
        if newest and self.info and self.answers:
            out.append(self.answer(newest, now))
            if self.arms and len(self.states) >= 5:
                self.arms = False
                out.append(wire.encode(wire.Arm(self.info.session)))
        return b"".join(out)

    def answer(self, state: wire.DeviceState, now: float) -> bytes:
        words = self.words or tuple(
            min(max(round(part / wire.FORCE_STEP), -0x8000), 0x7FFF) if part == part else 0
            for i in range(wire.FINGERS)
            for part in self.force(i, now)
        )
        self._seq = self._seq + 1 & 0xFFFF
        command = wire.Command(state.session, self._seq, state.seq, words, self.flags, 5)  # type: ignore[arg-type]
        self.sent[command.seq] = command
        return wire.encode(command)


class Presser(Host):
    """Arm, again where it is refused or latched (a busy machine is late), and push up once there is force."""

    def __init__(self, newtons: float) -> None:
        super().__init__(self.push, arms=False)
        self.newtons, self.asked = newtons, -1.0

    @property
    def mode(self) -> int:
        return self.states[-1].status & wire.MODE if self.states else wire.IDLE

    def push(self, finger: int, time: float) -> Vector:
        return (0.0, 0.0, self.newtons if self.mode in (wire.RAMP, wire.ARMED) else 0.0)

    def step(self, now: float, incoming: bytes) -> bytes:
        self.flags = HELD | wire.CLEAR if self.mode == wire.FAULT else HELD
        out = super().step(now, incoming)
        if self.info and self.mode == wire.IDLE and now - self.asked > 0.2:
            self.asked = now
            out += wire.encode(wire.Arm(self.info.session))
        return out


class Table:
    """Stand a host and an emulated device on one clock, in steps of a tenth of a tick."""

    def __init__(
        self,
        force: Callable[[int, float], Vector] = still,
        *faults: str,
        hand: EmulatedHand | None = None,
        arms: bool = True,
    ) -> None:
        self.trace: list[TraceRow] = []
        self.device = FaultyEmulator(
            SPEC, hand=hand, faults=[parse_fault(text) for text in faults], seed=1, trace=self.trace
        )
        self.host, self.now, self._steps = Host(force, arms=arms), 0.0, 0
        self._to_device = self.host.hello()

    def run(self, seconds: float) -> Table:
        """Let time pass [s]."""
        for _ in range(round(seconds * 10 / SPEC.tick)):
            self.now = self._steps * SPEC.tick / 10
            self._steps += 1
            to_host = self.device.step(self.now, self._to_device)
            self._to_device = self.host.step(self.now, to_host)
        return self

    def send(self, frame: wire.Frame) -> Table:
        """Let the host send one frame more."""
        self._to_device += wire.encode(frame)
        return self

    def armed(self) -> Table:
        """Let the host arm the device: 5 states, 50 ms of quiet, 0.5 s of ramp."""
        self.run(0.6)
        assert self.device.mode == wire.ARMED
        return self

    @property
    def session(self) -> int:
        assert self.host.info is not None
        return self.host.info.session

    def forces(self, finger: int = 0) -> list[Vector]:
        """Return the true forces of a finger [N], a tick each."""
        return [row[11 + 3 * finger : 14 + 3 * finger] for row in self.trace]  # type: ignore[misc]

    def modes(self) -> list[int]:
        return [int(row[1]) for row in self.trace]
