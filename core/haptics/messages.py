"""What Blender and the servo tell each other, as bytes of a mailbox."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import Enum

from .contact_model import MOST_AHEAD, Contact
from .safety import LEASE, Arming
from .vectors import ZERO, Vector

TIPS = 3
_ORDER = struct.Struct("<IId")  # arm, disarm, held until
_CONTACT = struct.Struct("<B14d")
_REPORT = struct.Struct("<dBBB6I6dBB")
_TIP = struct.Struct("<BB7d")
_TEXT = 400  # bytes of the message
ORDER_SIZE = _ORDER.size + TIPS * _CONTACT.size
REPORT_SIZE = _REPORT.size + TIPS * _TIP.size + _TEXT


class Link(Enum):
    """Name how the connection is."""

    OPENING = 0
    READY = 1
    LOST = 2  # the line: connect again; or the device fell silent, and is READY when it answers again, not armed
    REFUSED = 3  # of another protocol, another baud rate, in use...


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """Hold what Blender wants of the servo.

    arm, disarm: counters; one more is one request more.  held_until: the dead-man key is held so long on the clock of
    both [s]; it must be said anew within LEASE.  contacts: up to three.
    """

    arm: int = 0
    disarm: int = 0
    held_until: float = 0.0
    contacts: tuple[Contact | None, ...] = ()

    def is_held(self, now: float) -> bool:
        """Tell whether the dead-man key is held; a time too far ahead is none of this clock."""
        return 0 < self.held_until - now <= LEASE + MOST_AHEAD

    def is_fresh(self, now: float, oldest: float) -> bool:
        """Tell whether the simulation posted all contacts within so long [s]; a stamp that is no number is no time."""
        return all(c is None or -MOST_AHEAD <= now - c.stamp <= oldest for c in self.contacts)


@dataclass(frozen=True, slots=True, kw_only=True)
class Tip:
    """Hold a fingertip of the device: position [m], force sent to it [N], lowest observed energy [J]; its sensor is
    believed no more (masked); its force had to be cut (full)."""

    position: Vector = ZERO
    force: Vector = ZERO
    least_energy: float = 0.0
    masked: bool = False
    full: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Hold what the servo says of the device.

    time: of the newest STATE [s].  states: taken.  lost: missing in their sequence.  unsent: answers that the line did
    not take.  wrong: refused by their check.  stale: older than the newest.  late: answered after the next had begun.
    rate: [1/s].  delay_p50, delay_p99: from the STATE to its answer's arrival [s]; wire: what of it the bytes took on
    the line.
    cap: largest stiffness to render [N/m].  peak: force of a fingertip [N].
    buttons, status: bits of the device.  message: "" or a sentence for the person.
    """

    time: float = 0.0
    link: Link = Link.OPENING
    arming: Arming = Arming.OFF
    tips: tuple[Tip, ...] = ()
    states: int = 0
    lost: int = 0
    unsent: int = 0
    wrong: int = 0
    stale: int = 0
    late: int = 0
    rate: float = 0.0
    delay_p50: float = 0.0
    delay_p99: float = 0.0
    wire: float = 0.0
    cap: float = 0.0
    peak: float = 0.0
    buttons: int = 0
    status: int = 0
    message: str = ""


def pack_order(order: Order) -> bytes:
    """Return an order as bytes."""
    parts = [_ORDER.pack(order.arm & 0xFFFFFFFF, order.disarm & 0xFFFFFFFF, order.held_until)]
    for i in range(TIPS):
        c = order.contacts[i] if i < len(order.contacts) else None
        numbers = (*c.force, *c.at, *c.normal, c.k_n, c.k_t, c.gap, c.friction, c.stamp) if c else (0.0,) * 14
        parts.append(_CONTACT.pack(c is not None, *numbers))
    return b"".join(parts)


def unpack_order(letter: bytes) -> Order:
    """Return the order in a letter."""
    arm, disarm, held_until = _ORDER.unpack_from(letter)
    contacts: list[Contact | None] = []
    for i in range(TIPS):
        given, *v = _CONTACT.unpack_from(letter, _ORDER.size + i * _CONTACT.size)
        contacts.append(
            Contact(
                force=(v[0], v[1], v[2]), at=(v[3], v[4], v[5]), normal=(v[6], v[7], v[8]),
                k_n=v[9], k_t=v[10], gap=v[11], friction=v[12], stamp=v[13],
            ) if given else None
        )  # fmt: skip
    return Order(arm=arm, disarm=disarm, held_until=held_until, contacts=tuple(contacts))


def pack_report(report: Report) -> bytes:
    """Return a report as bytes."""
    r = report
    parts = [
        _REPORT.pack(
            r.time, r.link.value, r.arming.value, len(r.tips), r.states, r.lost, r.unsent, r.wrong, r.stale,
            r.late, r.rate, r.delay_p50, r.delay_p99, r.wire, r.cap, r.peak, r.buttons, r.status,
        )
    ]  # fmt: skip
    for i in range(TIPS):
        tip = r.tips[i] if i < len(r.tips) else Tip()
        parts.append(_TIP.pack(tip.masked, tip.full, *tip.position, *tip.force, tip.least_energy))
    parts.append(r.message.encode()[:_TEXT].ljust(_TEXT, b"\0"))
    return b"".join(parts)


def unpack_report(letter: bytes) -> Report:
    """Return the report in a letter."""
    (time, link, arming, count, states, lost, unsent, wrong, stale, late, rate, p50, p99, wire, cap, peak, buttons,
     status) = _REPORT.unpack_from(letter)  # fmt: skip
    tips = []
    for i in range(count):
        masked, full, *v = _TIP.unpack_from(letter, _REPORT.size + i * _TIP.size)
        tips.append(
            Tip(
                position=(v[0], v[1], v[2]), force=(v[3], v[4], v[5]), least_energy=v[6],
                masked=bool(masked), full=bool(full),
            )
        )  # fmt: skip
    return Report(
        time=time, link=Link(link), arming=Arming(arming), tips=tuple(tips), states=states, lost=lost, unsent=unsent,
        wrong=wrong, stale=stale, late=late, rate=rate, delay_p50=p50, delay_p99=p99, wire=wire, cap=cap, peak=peak,
        buttons=buttons, status=status, message=letter[-_TEXT:].rstrip(b"\0").decode(errors="ignore"),
    )  # fmt: skip
