"""A device reduced to what the servo sees of it: STATEs at given places, and the forces that come back."""

from dataclasses import dataclass, field, replace

from core.device import wire
from core.device.limits import LEASE
from core.device.orders import pack_order, unpack_order
from core.device.rendered_surface import Law, Surface
from core.device.servo import Servo
from core.device.spec import Spec
from core.vectors import ZERO, Vector, length
from studies.bench.numbers import info

SESSION = 7
TICK = 1e-3


def wall(now: float = 0.0, *, k: float = 600.0, force: float = 0.0) -> Surface:
    """Return a smooth wall of a stiffness [N/m] whose body is below z = 0; force: raised until that acts there [N]."""
    at = (0.0, 0.0, force / k)
    return Surface(place=at, normal=(0.0, 0.0, 1.0), anchor=None, law=Law(k, k, 1.0, 1.0), friction=0.0, stamp=now)


@dataclass
class BenchDevice:
    """Stream STATEs into a servo, one a millisecond.

    at: the three fingertips [m].  mode, status, buttons: of the next STATE.  obedient: ARM makes it ARMED at once.
    """

    spec: Spec = field(default_factory=Spec)
    at: list[Vector] = field(default_factory=lambda: [(0.0, 0.0, 0.01)] * 3)
    now: float = 100.0
    seq: int = 0
    mode: int = wire.IDLE
    masked: int = 0
    buttons: int = 0
    obedient: bool = True
    words: tuple[int, ...] | None = None  # instead of what the places give
    fresh: bool = True  # the simulation posts its surfaces again, 60 times a second
    held: bool = True  # and the dead-man key with them
    lag: int = 1  # ticks until a force answers a position
    looks: int = 0  # Blender renews the key between them too, once in so many ticks
    forces: list[Vector] = field(default_factory=lambda: [ZERO] * 3)
    heard: list[wire.Frame] = field(default_factory=list)
    acks: dict[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.servo = Servo(nonce=5)
        self._decoder = wire.Decoder()
        self.exchange(b"")
        self.exchange(wire.encode(info(self.spec, 5, SESSION)))

    def exchange(self, data: bytes) -> None:
        """Send bytes to the servo and take its answer."""
        for frame in self._decoder.feed(self.servo.step(self.now, data)):
            self.heard.append(frame)
            if isinstance(frame, wire.Command):
                self.acks[frame.echo] = frame.seq
                if frame.flags & wire.CLEAR and self.mode == wire.FAULT:
                    self.mode = wire.IDLE
                self.forces = [self._force(i, frame) for i in range(3)]
            elif isinstance(frame, wire.Arm) and self.obedient:
                self.mode = wire.ARMED
            elif isinstance(frame, wire.Disarm):
                self.mode = wire.IDLE
                self.forces = [ZERO] * 3

    def state(self) -> wire.DeviceState:
        """Return the STATE of now."""
        self.seq = (self.seq + 1) & 0xFFFF
        words = self.words or tuple(word for i in range(3) for word in self.state_words(i))
        status = self.mode | self.masked
        ack = self.acks.get(self.seq - self.lag, 0)
        return wire.DeviceState(SESSION, self.seq, ack, round(self.now * 1e6) & 0xFFFFFFFF, words, self.buttons, status)

    def tick(self, times: int = 1) -> None:
        """Let milliseconds pass with a STATE each."""
        for _ in range(times):
            self.now += TICK
            if self.looks and self.seq % self.looks == 0:
                self.hold()
            if self.fresh and self.seq % 16 == 0:
                self.hold()
                self.set_surfaces(*(c and replace(c, stamp=self.now) for c in self.servo.order.surfaces))
            self.exchange(wire.encode(self.state()))

    def pause(self, seconds: float) -> None:
        """Let time pass without a STATE; the servo looks at the clock every millisecond."""
        for _ in range(round(seconds / TICK)):
            self.now += TICK
            self.exchange(b"")

    def set_surfaces(self, *surfaces: Surface | None) -> None:
        """Give the servo surfaces."""
        self.servo.order = replace(self.servo.order, surfaces=tuple(surfaces))

    def arm(self) -> None:
        """Ask the servo to arm."""
        self.servo.order = replace(self.servo.order, arm=self.servo.order.arm + 1)

    def hold(self) -> None:
        """Send an order with the dead-man key, as a message: its surfaces equal those before, and are other objects."""
        order = replace(self.servo.order, held_until=self.now + LEASE if self.held else 0.0)
        self.servo.order = unpack_order(pack_order(order))

    def armed(self) -> "BenchDevice":
        """Arm, and let the ramp pass."""
        self.hold()
        self.arm()
        self.tick(700)
        return self

    def pressing(self, depth: float = 0.005, k: float = 600.0) -> "BenchDevice":
        """Press the first fingertip into a wall, armed."""
        self.set_surfaces(wall(self.now, k=k))
        self.armed()
        for i in range(101):
            self.at[0] = (0.0, 0.0, 0.01 - i / 100 * (0.01 + depth))
            self.tick()
        self.tick(100)
        return self

    @property
    def strongest(self) -> float:
        """Return the largest force of a fingertip [N]."""
        return max(map(length, self.forces))

    def _force(self, i: int, command: wire.Command) -> Vector:
        if not command.flags & wire.ENABLE or not command.flags & wire.DEADMAN:
            return ZERO
        x, y, z = (word * wire.FORCE_STEP for word in command.force[3 * i : 3 * i + 3])
        return x, y, z

    def state_words(self, i: int) -> tuple[int, int, int]:
        """Return the words of a finger's place."""
        x, y, z = (round(part / wire.PLACE_STEP) for part in self.at[i])
        return x, y, z


def note(device: BenchDevice) -> str:
    """Return the note of the servo's report."""
    return device.servo.report().note


def disarmed(device: BenchDevice) -> bool:
    """Tell whether nothing acts, and nothing will without a new request."""
    return device.servo.report().arming.name == "OFF" and device.strongest == 0.0


__all__ = ["SESSION", "TICK", "BenchDevice", "disarmed", "note", "wall"]
