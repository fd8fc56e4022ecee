"""The messages in the mailbox: the order of Blender to the servo, and the servo's report, as bytes."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import Enum

from ..messages import kept, read
from ..vectors import ZERO, Vector
from .contact_model import MOST_AHEAD, Contact
from .safety import LEASE, Arming
from .wire import FINGERS

TIPS = FINGERS
_ORDER = struct.Struct("<IId")  # arm, disarm, held until
_CONTACT = struct.Struct("<B14d")
_REPORT = struct.Struct("<BBB5I5d")
_TIP = struct.Struct("<BB7d")
_NOTE = 1000  # bytes of the note, with its values
ORDER_SIZE = _ORDER.size + TIPS * _CONTACT.size
REPORT_SIZE = _REPORT.size + TIPS * _TIP.size + _NOTE


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
    contacts: up to three.
    """

    arm: int = 0
    disarm: int = 0
    held_until: float = 0.0
    contacts: tuple[Contact | None, ...] = ()

    def is_held(self, now: float) -> bool:
        """Tell whether the dead-man key is held; a time too far ahead is not of this clock, so it does not count."""
        return 0 < self.held_until - now <= LEASE + MOST_AHEAD

    def is_fresh(self, now: float, oldest: float) -> bool:
        """Tell whether no contact is older than so long [s]; a stamp that is not a number is not fresh."""
        return all(c is None or -MOST_AHEAD <= now - c.stamp <= oldest for c in self.contacts)


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
    parts = [_ORDER.pack(order.arm & 0xFFFFFFFF, order.disarm & 0xFFFFFFFF, order.held_until)]
    for i in range(TIPS):
        c = order.contacts[i] if i < len(order.contacts) else None
        numbers = (*c.force, *c.at, *c.normal, c.k_n, c.k_t, c.gap, c.friction, c.stamp) if c else (0.0,) * 14
        parts.append(_CONTACT.pack(c is not None, *numbers))
    return b"".join(parts)


def unpack_order(message: bytes) -> Order:
    """Return the order in a message."""
    arm, disarm, held_until = _ORDER.unpack_from(message)
    contacts: list[Contact | None] = []
    for i in range(TIPS):
        given, *v = _CONTACT.unpack_from(message, _ORDER.size + i * _CONTACT.size)
        contacts.append(
            Contact(
                force=(v[0], v[1], v[2]), at=(v[3], v[4], v[5]), normal=(v[6], v[7], v[8]),
                k_n=v[9], k_t=v[10], gap=v[11], friction=v[12], stamp=v[13],
            ) if given else None
        )  # fmt: skip
    return Order(arm=arm, disarm=disarm, held_until=held_until, contacts=tuple(contacts))


def pack_report(report: ServoReport) -> bytes:
    """Return a report as bytes."""
    r = report
    parts = [
        _REPORT.pack(
            r.link.value, r.arming.value, len(r.tips), r.states, r.lost, r.unsent, r.wrong, r.stale,
            r.rate, r.delay_p50, r.delay_p99, r.cap, r.peak,
        )
    ]  # fmt: skip
    for i in range(TIPS):
        tip = r.tips[i] if i < len(r.tips) else TipState()
        parts.append(_TIP.pack(tip.masked, tip.full, *tip.position, *tip.force, tip.least_energy))
    parts.append(_note(r.note).ljust(_NOTE, b"\0"))
    return b"".join(parts)


def _note(note: str) -> bytes:
    """Return a note as bytes; of one that is too long, a text without values that is cut off."""
    whole = kept(note).encode()
    return whole if len(whole) <= _NOTE else note.encode()[:_NOTE]


def unpack_report(message: bytes) -> ServoReport:
    """Return the report in a message."""
    link, arming, count, states, lost, unsent, wrong, stale, rate, p50, p99, cap, peak = _REPORT.unpack_from(message)
    tips = []
    for i in range(count):
        masked, full, *v = _TIP.unpack_from(message, _REPORT.size + i * _TIP.size)
        tips.append(
            TipState(
                position=(v[0], v[1], v[2]), force=(v[3], v[4], v[5]), least_energy=v[6],
                masked=bool(masked), full=bool(full),
            )
        )  # fmt: skip
    return ServoReport(
        link=LinkState(link), arming=Arming(arming), tips=tuple(tips), states=states, lost=lost, unsent=unsent,
        wrong=wrong, stale=stale, rate=rate, delay_p50=p50, delay_p99=p99, cap=cap, peak=peak,
        note=read(message[-_NOTE:].rstrip(b"\0").decode(errors="ignore")),
    )  # fmt: skip
