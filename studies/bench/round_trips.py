"""How a device measures its link, on its own clock: which answers came, how late, and which were refused."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import Final

from core.device import wire
from core.device.limits import LOSS_DISARMS
from core.device.spec import Spec

RECENT: Final = 1000  # STATEs in the percentiles: ten that wait too long move the 99th, one does not
OLDEST_ECHO: Final = 5  # [ticks] an answer to an older STATE is refused
LOSS_TICKS: Final = 1000  # ticks that are counted together; a share lost of more than LOSS_DISARMS disarms,
LOSS_FEW: Final = 50  # unless there were so few


class RoundTrips:
    """Counts of the STATEs of a session and of their answers.

    session: its number.
    seq, ack: sequence numbers of the last STATE and of the last CMD taken.
    ticks: since the session began.
    heard: ticks until the last answer came.
    answered: STATEs that were answered.
    in_time: those answered within a tick.
    stale: answers refused for their age, or because they came twice.
    lost: CMDs missing in their sequence.
    taken: CMDs taken.
    rtts: how long the last STATEs waited for an answer to them, or to a newer one [s].
    """

    def __init__(self, spec: Spec, session: int) -> None:
        self.session, self.seq, self.ack = session, 0xFFFF, 0
        self.ticks = self.heard = self.answered = self.in_time = self.stale = self.lost = self.taken = 0
        self.rtts: deque[float] = deque(maxlen=RECENT)
        self._tick = spec.tick
        self._sent: dict[int, float] = {}  # seq: when it was sent [s], of STATEs that may still be answered
        self._loss = [0, 0]  # of the count under way: lost, taken

    def send(self, now: float) -> int:
        """Return the sequence number of the STATE of this tick."""
        self.seq = self.seq + 1 & 0xFFFF
        self.ticks += 1
        self._sent[self.seq] = now
        self._sent.pop(self.seq - OLDEST_ECHO - 1 & 0xFFFF, None)
        return self.seq

    def take(self, command: wire.Command, now: float) -> bool:
        """Tell whether a CMD is new and answers a STATE young enough; count it either way."""
        sent = self._sent.get(command.echo)
        if sent is None or (self.taken and not wire.seq_newer(command.seq, self.ack)):
            self.stale += 1
            return False
        if sent >= 0:  # the first answer to this STATE
            self.answered, self.heard = self.answered + 1, self.ticks
            self.in_time += now - sent <= self._tick
            for seq, sent in self._sent.items():  # those the host passed over have waited until now as well
                if sent >= 0 and not wire.seq_newer(seq, command.echo):
                    self.add_round_trip(now - sent)
                    self._sent[seq] = -1.0
        lost = (command.seq - self.ack - 1 & 0xFFFF) if self.taken else 0
        self.lost, self.taken, self.ack = self.lost + lost, self.taken + 1, command.seq
        self._loss = [self._loss[0] + lost, self._loss[1] + 1]
        return True

    def add_round_trip(self, seconds: float) -> None:
        """Record how long a STATE waited for its answer [s]."""
        self.rtts.append(seconds)

    def loses_too_much(self) -> bool:
        """Tell, once in LOSS_TICKS, whether too many CMDs were lost since the last time."""
        if self.ticks % LOSS_TICKS:
            return False
        (lost, taken), self._loss = self._loss, [0, 0]
        return lost + taken >= LOSS_FEW and lost > LOSS_DISARMS * (lost + taken)


def percentiles(trips: Iterable[float]) -> tuple[float, float, float]:
    """Return the median, the 99th percentile and the maximum of some round trips, 0 where there are none."""
    order = sorted(trips) or [0.0]
    return order[len(order) // 2], order[99 * len(order) // 100], order[-1]
