"""What Blender and the servo tell each other: Blender's order and the servo's report, as rows of numbers."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import islice
from typing import Final

from ..messages import kept, read
from ..vectors import ZERO, Vector
from .limits import LEASE, STATE_GAP
from .safety import Arming
from .surface import Law, Surface
from .wire import FINGERS

TIPS: Final = FINGERS
FACTORS: Final = 33  # of another tip, as other_tip.COUNT
_ORDER: Final = struct.Struct(f"<{3 + TIPS * (17 + FACTORS)}d")
_REPORT: Final = struct.Struct(f"<{13 + TIPS * 9}d")
_NOTE: Final = 1000  # bytes of the note, with its values
ORDER_SIZE, REPORT_SIZE = _ORDER.size, _REPORT.size + _NOTE


class LinkState(Enum):
    """The state of the connection to the device."""

    OPENING = 0
    READY = 1
    LOST = 2  # the line is gone: connect again; or the device fell silent: READY when it answers again, not armed
    REFUSED = 3  # of another protocol, another baud rate, in use...


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """What Blender wants of the servo.

    arm, disarm: counters; one more is one more request.
    held_until: until when the dead-man key counts as held, on the clock of both [s]; to be renewed within LEASE.
    surfaces: up to three.
    """

    arm: int = 0
    disarm: int = 0
    held_until: float = 0.0
    surfaces: tuple[Surface | None, ...] = ()

    def is_held(self, now: float) -> bool:
        """Tell whether the dead-man key is held; a time too far ahead is not of this clock, so it does not count."""
        return 0 < self.held_until - now <= LEASE + STATE_GAP

    def is_fresh(self, now: float, oldest: float) -> bool:
        """Tell whether no surface is older than a time [s]; a stamp that is not a number is not fresh."""
        return all(s is None or -STATE_GAP <= now - s.stamp <= oldest for s in self.surfaces)


@dataclass(frozen=True, slots=True, kw_only=True)
class TipState:
    """A fingertip of the device, as the servo reports it.

    position: [m].
    force: sent to it [N].
    least_energy: lowest observed energy [J].
    masked: its sensor is not trusted.
    full: its force had to be limited.
    """

    position: Vector = ZERO
    force: Vector = ZERO
    least_energy: float = 0.0
    masked: bool = False
    full: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoReport:
    """The state of device and link, as the servo reports it.

    link: state of the connection.
    arming: how far the arming is.
    tips: the fingertips.
    states: STATEs taken.
    lost: missing in their sequence.
    unsent: answers that the line did not take.
    wrong: frames refused by their CRC or form.
    stale: older than the newest.
    rate: STATEs a second [1/s].
    delay_p50, delay_p99: from a STATE to the arrival of its answer [s].
    cap: largest stiffness to render [N/m].
    peak: largest force of a fingertip [N].
    note: "" or a sentence for the artist.
    """

    link: LinkState = LinkState.OPENING
    arming: Arming = Arming.OFF
    tips: tuple[TipState, ...] = ()
    states: int = 0
    lost: int = 0
    unsent: int = 0
    wrong: int = 0
    stale: int = 0
    rate: float = 0.0
    delay_p50: float = 0.0
    delay_p99: float = 0.0
    cap: float = 0.0
    peak: float = 0.0
    note: str = ""


def pack_order(order: Order) -> bytes:
    """Return an order as bytes."""
    numbers: list[float] = [order.arm, order.disarm, order.held_until]
    for surface in (*order.surfaces, *(None,) * TIPS)[:TIPS]:
        numbers += _surface_row(surface) if surface else (0.0,) * (17 + FACTORS)
    return _ORDER.pack(*numbers)


def _surface_row(s: Surface) -> tuple[float, ...]:
    count = len(s.law.factors)
    unused = (0.0,) * (FACTORS - count)
    return (
        1 + (s.anchor is not None), *s.place, *s.normal, *(s.anchor or ZERO), *s.law[:4], s.law.deepest, s.friction,
        s.stamp, *s.law.factors, *unused,
    )  # fmt: skip


def unpack_order(message: bytes) -> Order:
    """Return the order in a message."""
    row = iter(_ORDER.unpack(message))
    arm, disarm, held_until = islice(row, 3)
    surfaces = tuple([_surface(tuple(islice(row, 17 + FACTORS))) for _ in range(TIPS)])
    return Order(arm=int(arm), disarm=int(disarm), held_until=held_until, surfaces=surfaces)


def _surface(row: tuple[float, ...]) -> Surface | None:
    if not row[0]:
        return None
    K1, K2, x0, power, deepest, friction, stamp = row[10:17]
    return Surface(
        place=row[1:4], normal=row[4:7], anchor=row[7:10] if row[0] > 1 else None,  # type: ignore[arg-type]
        law=Law(K1, K2, x0, power, row[17:] if deepest else (), deepest), friction=friction, stamp=stamp,
    )  # fmt: skip


def pack_report(report: ServoReport) -> bytes:
    """Return a report as bytes."""
    r = report
    numbers = [
        r.link.value, r.arming.value, len(r.tips), r.states, r.lost, r.unsent, r.wrong, r.stale, r.rate, r.delay_p50,
        r.delay_p99, r.cap, r.peak,
    ]  # fmt: skip
    for tip in (*r.tips, *(TipState(),) * TIPS)[:TIPS]:
        numbers += [*tip.position, *tip.force, tip.least_energy, tip.masked, tip.full]
    return _REPORT.pack(*numbers) + _note(r.note).ljust(_NOTE, b"\0")


def _note(note: str) -> bytes:
    """Return a note as bytes; of one that is too long, a text without values that is cut off."""
    whole = kept(note).encode()
    return whole if len(whole) <= _NOTE else note.encode()[:_NOTE]


def unpack_report(message: bytes) -> ServoReport:
    """Return the report in a message."""
    row = iter(_REPORT.unpack_from(message))
    link, arming, count, states, lost, unsent, wrong, stale, rate, p50, p99, cap, peak = islice(row, 13)
    tips = tuple([_tip(row) for _ in range(TIPS)])
    return ServoReport(
        link=LinkState(link), arming=Arming(arming), tips=tips[: int(count)], states=int(states), lost=int(lost),
        unsent=int(unsent), wrong=int(wrong), stale=int(stale), rate=rate, delay_p50=p50, delay_p99=p99, cap=cap,
        peak=peak, note=read(message[-_NOTE:].rstrip(b"\0").decode(errors="ignore")),
    )  # fmt: skip


def _tip(row: Iterator[float]) -> TipState:
    x, y, z, fx, fy, fz, energy, masked, full = islice(row, 9)
    return TipState(
        position=(x, y, z), force=(fx, fy, fz), least_energy=energy, masked=bool(masked), full=bool(full)
    )
