"""The messages between Blender and the servo, as JSON: Blender's order and the servo's report."""

from __future__ import annotations

import json
from dataclasses import dataclass
from enum import Enum
from typing import Any, Final, NamedTuple

from ..message import kept, read
from ..vectors import ZERO, Vector
from .force_guard import Arming
from .limits import LEASE, STATE_GAP
from .rendered_surface import Law, Surface
from .wire import FINGERS

LONGEST_NOTE: Final = 1000  # [characters] with the values: longer than any sentence that an artist reads


class LinkState(Enum):
    """The state of the connection to the device."""

    OPENING = 0
    READY = 1
    LOST = 2  # the line is gone: connect again; or the device is silent: READY once it answers, not armed
    REFUSED = 3  # other protocol, other baud rate, port in use...


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """What Blender requests of the servo.

    arm, disarm: counters of the requests; an increment is a new one.
    held_until: time until which the dead-man key counts as held, on their common clock [s]; to be renewed within LEASE.
    surfaces: one for each of up to three fingertips.
    """

    arm: int = 0
    disarm: int = 0
    held_until: float = 0.0
    surfaces: tuple[Surface | None, ...] = ()

    def is_held(self, now: float) -> bool:
        """Return whether the dead-man key is held; a time too far ahead is of another clock and does not count."""
        return 0 < self.held_until - now <= LEASE + STATE_GAP

    def is_fresh(self, now: float, oldest: float) -> bool:
        """Return whether no surface is older than a time [s]; a stamp that is not a number is not fresh."""
        return all(s is None or -STATE_GAP <= now - s.stamp <= oldest for s in self.surfaces)


class TipState(NamedTuple):
    """A fingertip of the device, as the servo reports it.

    position: [m].
    force: force sent to it [N].
    least_energy: lowest observed balance of energy taken minus given [J].
    masked: its sensor is not trusted.
    full: its force had to be limited.
    """

    position: Vector = ZERO
    force: Vector = ZERO
    least_energy: float = 0.0
    masked: bool = False
    full: bool = False


class ServoReport(NamedTuple):
    """The state of device and link, as the servo reports it.

    states: number of STATEs taken.
    lost: number of STATEs missing in the sequence.
    unsent: answers that the line did not accept.
    wrong: frames refused by their CRC or form.
    stale: STATEs that arrived late or twice.
    rate: rate of the STATEs [1/s].
    delay: mean time from a position to the force that answers it [s].
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
    delay: float = 0.0
    cap: float = 0.0
    peak: float = 0.0
    note: str = ""


def pack_order(order: Order) -> bytes:
    """Return an order as bytes."""
    surfaces = [s and (s.place, s.normal, s.anchor, s.law, s.friction, s.stamp) for s in order.surfaces]
    return json.dumps((order.arm, order.disarm, order.held_until, surfaces)).encode()


def unpack_order(message: bytes) -> Order:
    """Return the order in a message, with a surface or None for each fingertip."""
    arm, disarm, held_until, surfaces = json.loads(message)
    made = [_surface(*each) if each else None for each in (*surfaces, *(None,) * FINGERS)[:FINGERS]]
    return Order(arm=arm, disarm=disarm, held_until=held_until, surfaces=tuple(made))


def _surface(place: Any, normal: Any, anchor: Any, law: Any, friction: float, stamp: float) -> Surface:
    K1, K2, x0, power, factors, deepest = law
    return Surface(
        place=tuple(place), normal=tuple(normal), anchor=tuple(anchor) if anchor else None,
        law=Law(K1, K2, x0, power, tuple(factors), deepest), friction=friction, stamp=stamp,
    )  # fmt: skip


def pack_report(report: ServoReport) -> bytes:
    """Return a report as bytes; a note that is too long is truncated and loses its values."""
    link, arming, *rest, note = report
    said = whole if len(whole := kept(note)) <= LONGEST_NOTE else str.__str__(note)[:LONGEST_NOTE]
    return json.dumps((link.value, arming.value, *rest, said), ensure_ascii=False).encode()


def unpack_report(message: bytes) -> ServoReport:
    """Return the report in a message."""
    link, arming, tips, *rest, note = json.loads(message)
    made = tuple([TipState(tuple(place), tuple(force), *others) for place, force, *others in tips])
    return ServoReport._make([LinkState(link), Arming(arming), made, *rest, read(note)])
