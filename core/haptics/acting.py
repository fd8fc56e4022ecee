"""Which force acts on the fingertips: that of the command which the device acknowledged, however late ours came.

The device ramps its force by itself where its dead-man switch was released, be it by a command after a silence.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from ..vectors import ZERO, Vector, scaled
from .spec import Spec
from .wire import ARMED, FINGERS, MODE, RAMP, DeviceState

Forces = tuple[Vector, ...]
REMEMBERED: Final = 256  # commands: more than a device can acknowledge late
NO_FORCE: Final[Forces] = (ZERO,) * FINGERS


@dataclass(slots=True)
class ActingForces:
    """The forces of the last commands, and which of them acts.

    sent: by the sequence numbers of their commands [N]; of those that release the dead-man switch none.
    since: when the device first acknowledged the command that acts, on its clock [s].
    ramp_since: when its ramp began, if it ramps, on its clock [s].
    """

    sent: dict[int, Forces] = field(default_factory=dict)
    since: float = 0.0
    ramp_since: float = 0.0

    def send(self, seq: int, forces: Forces | None) -> None:
        """Take the forces [N] of a command that is sent, None where it releases the dead-man switch."""
        self.sent.pop(seq - REMEMBERED & 0xFFFF, None)
        if forces:
            self.sent[seq] = forces

    def restarts_ramp(self, before: DeviceState | None, state: DeviceState) -> bool:
        """Tell whether the device's ramp began anew since the STATE before."""
        was_armed = before is not None and before.status & MODE == ARMED
        return state.status & MODE == RAMP and (was_armed or state.ack not in self.sent)

    def between(self, spec: Spec, before: DeviceState | None, state: DeviceState, now: float) -> tuple[Forces, float]:
        """Return the forces [N] that acted from a STATE to the next, and the share of them that is left at its end.

        now: of the second STATE, on the device's clock [s].
        """
        acted = self.sent.get(before.ack, NO_FORCE) if before else NO_FORCE
        if before and before.status & MODE == RAMP:
            gain = min((now - self.ramp_since) / spec.ramp_time, 1.0)
            acted = tuple([scaled(force, gain) for force in acted])
        left = spec.left(now - self.since)
        if before is None or state.ack != before.ack:
            self.since = now
        if state.status & MODE != RAMP or state.ack not in self.sent:
            self.ramp_since = now
        return acted, left
