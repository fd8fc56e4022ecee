"""One finger of the servo: from the readings of its sensors to a position, from a force to its torques."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..vectors import ZERO, Vector
from . import kinematics
from .force_guard import Guard
from .kinematics import Block
from .limits import JUMP, RAIL
from .rendered_surface import Contact
from .spec import Spec


@dataclass(slots=True, kw_only=True)
class ServoFinger:
    """One finger.

    block: its linkage.
    guard: its limits.
    contact: with the surface under it.
    angles: of the last reading that was trusted [rad].
    at: its position then [m].
    bad: readings since then that were not trusted.
    """

    block: Block
    guard: Guard
    contact: Contact = field(default_factory=Contact)
    angles: Vector | None = None
    at: Vector = ZERO
    bad: int = 0

    def sense(
        self, spec: Spec, words: tuple[int, ...], masked: bool, ticks: int, time: float, acted: Vector, left: float
    ) -> None:
        """Take a reading.

        Args:
            spec: the device.
            words: of its three joints, see `kinematics.adc_angles`.
            masked: the device itself does not trust it.
            ticks: since the last reading.
            time: of the device [s].
            acted: the force of the motors since the last reading [N].
            left: share of it that is left by now.
        """
        angles = kinematics.adc_angles(spec, words)
        if (
            masked
            or not RAIL <= min(words) <= max(words) < 0x10000 - RAIL
            or self._jumps(angles, spec.tick * max(ticks, 1))
        ):
            self.bad += 1
            self.guard.skip()
            return
        self.at, self.angles, self.bad = kinematics.forward(self.block, angles), angles, 0
        self.guard.move(self.at, time, acted, left)

    def _jumps(self, angles: Vector, dt: float) -> bool:
        if self.angles is None:
            return False
        (a, b, c), (x, y, z) = angles, self.angles
        return max(abs(a - x), abs(b - y), abs(c - z)) > JUMP * dt

    def forget(self) -> None:
        """Trust the next reading wherever it is: no force acts."""
        self.angles, self.bad = None, 0
        self.guard.skip()

    def drive(self, spec: Spec, force: Vector) -> tuple[int, int, int]:
        """Return the torque words for a force [N]; a torque beyond its motor shortens the force, never turns it."""
        if force == ZERO or self.angles is None:
            return (0, 0, 0)
        torques = kinematics.torques(self.block, self.angles, force)
        (x, y, z), (a, b, c) = torques, spec.torque_limits
        over = max(abs(x) / a, abs(y) / b, abs(z) / c)
        if over > 1:
            self.guard.full = True
            torques = x / over, y / over, z / over
        return kinematics.torque_words(spec, torques)
