"""The specification of a haptic device, as it reports it; a device whose numbers are not safe is refused."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import DimpleError
from ..message import Message
from . import wire
from .limits import HARD_CEILING, LOST_TIME, STATE_GAP, TOP_SPEED, ZERO_TIME


@dataclass(frozen=True, slots=True, kw_only=True)
class Spec:
    """The specification of a device in SI units; until it reports its own, that of the Haptic Master is assumed.

    fingers: number of fingertips, one to three.
    peak_force, continuous_force: largest force at a fingertip, momentary and sustained (10 s rms) [N].
    viscous: friction at a fingertip [N s/m]; it limits the stiffness that can be rendered.
    tick_hz: rate of its positions [1/s].
    hold, zero, latch: ages of the last command [s]: up to `hold` its force is held, by `zero` it is zero and the brake
        acts, and at `latch` a fault occurs that lasts until it is cleared and the device armed again.
    tip_speed: a faster fingertip is a fault [m/s].
    """

    fingers: int = wire.FINGERS
    peak_force: float = 10.0
    continuous_force: float = 4.0
    viscous: float = 2.0
    tick_hz: int = 1000
    hold: float = STATE_GAP
    zero: float = ZERO_TIME
    latch: float = LOST_TIME
    tip_speed: float = TOP_SPEED

    def left(self, age: float) -> float:
        """Return the share of a force that still acts at an age of its command [s]."""
        return min(max((self.zero - age) / (self.zero - self.hold), 0.0), 1.0)

    @property
    def tick(self) -> float:
        """Return the period of the device [s]."""
        return 1 / self.tick_hz

    def info(self, nonce: int, session: int) -> wire.Info:
        """Return the INFO of a device with this specification."""
        return wire.Info(
            nonce=nonce, major=wire.PROTOCOL[0], minor=wire.PROTOCOL[1], session=session, fingers=self.fingers,
            tick_hz=self.tick_hz, hold_ms=round(1e3 * self.hold), zero_ms=round(1e3 * self.zero),
            latch_ms=round(1e3 * self.latch), peak_cn=round(100 * self.peak_force),
            continuous_cn=round(100 * self.continuous_force), speed_dms=round(10 * self.tip_speed),
            viscous_cns_m=round(100 * self.viscous),
        )  # fmt: skip


def spec_of(info: wire.Info) -> Spec:
    """Return the specification in a device's INFO.

    Raises:
        DimpleError: it speaks another protocol, or a number is not safe.
    """
    if info.major != wire.PROTOCOL[0]:
        raise DimpleError(
            "The device speaks protocol {major}.{minor}, this Dimple {own_major}.{own_minor}: they do not understand "
            "each other. Update the older of the two.",
            major=info.major, minor=info.minor, own_major=wire.PROTOCOL[0], own_minor=wire.PROTOCOL[1]
        )  # fmt: skip
    spec = Spec(
        fingers=info.fingers, peak_force=info.peak_cn / 100, continuous_force=info.continuous_cn / 100,
        viscous=info.viscous_cns_m / 100, tick_hz=info.tick_hz, hold=info.hold_ms / 1e3, zero=info.zero_ms / 1e3,
        latch=info.latch_ms / 1e3, tip_speed=info.speed_dms / 10,
    )  # fmt: skip
    for what, holds in (
        (Message("it must have one to three fingertips"), 1 <= spec.fingers <= wire.FINGERS),
        (Message("its forces must be above 0 and at most {most:g} N, and the continuous force at most the peak force",
                 most=HARD_CEILING),
         0 < spec.continuous_force <= spec.peak_force <= HARD_CEILING),
        (Message("its timeouts must increase, and be at most {hold:g}, {zero:g} and {latch:g} s",
                 hold=STATE_GAP, zero=ZERO_TIME, latch=LOST_TIME),
         0 < spec.hold < spec.zero < spec.latch
         and spec.hold <= STATE_GAP and spec.zero <= ZERO_TIME and spec.latch <= LOST_TIME),
        (Message("its top speed must be above 0 and at most {most:g} m/s", most=TOP_SPEED),
         0 < spec.tip_speed <= TOP_SPEED),
        (Message("its friction must be at most 20 N s/m"), spec.viscous <= 20),  # it sets the stiffest surface
        # both ends hold a force for 5 ms at most: a slower device would drop it between two ticks
        (Message("its rate must be from 250 to 2000 Hz, and its tick shorter than the time for which it holds a force"),
         250 <= spec.tick_hz <= 2000 and spec.tick < spec.hold),
    ):  # fmt: skip
        if not holds:
            raise DimpleError(
                "The numbers that the device reports are not safe: {what}. Correct its firmware.", what=what
            )
    return spec
