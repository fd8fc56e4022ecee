"""Which force acts on the fingertips: that of the command which the device acknowledged, however late ours came."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from .spec import Spec
from .vectors import ZERO, Vector
from .wire import FINGERS, DeviceState

Forces = tuple[Vector, ...]
REMEMBERED: Final = 256  # commands: more than a device can acknowledge late
NO_FORCE: Final[Forces] = (ZERO,) * FINGERS


@dataclass(slots=True)
class ActingForces:
    """The forces of the last commands, and which of them acts.

    sent: by the sequence numbers of their commands [N].
    since: when the device first acknowledged the command that acts, on its clock [s].
    """

    sent: dict[int, Forces] = field(default_factory=dict)
    since: float = 0.0

    def send(self, seq: int, forces: Forces) -> None:
        """Take the forces [N] of a command that is sent."""
        self.sent.pop(seq - REMEMBERED & 0xFFFF, None)
        self.sent[seq] = forces

    def between(self, spec: Spec, before: DeviceState | None, state: DeviceState, now: float) -> tuple[Forces, float]:
        """Return the forces [N] that acted from a STATE to the next, and the share of them that is left at its end.

        now: of the second STATE, on the device's clock [s].
        """
        acted = self.sent.get(before.ack, NO_FORCE) if before else NO_FORCE
        left = spec.left(now - self.since)
        if before is None or state.ack != before.ack:
            self.since = now
        return acted, left
