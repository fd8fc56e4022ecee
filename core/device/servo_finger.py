"""One finger of the servo: turns the device's reports into a position, and a force into a command."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..vectors import ZERO, Vector
from .force_guard import Guard
from .limits import FASTEST
from .rendered_surface import Contact
from .wire import FORCE_STEP, LAST_PLACE, PLACE_STEP


@dataclass(slots=True, kw_only=True)
class ServoFinger:
    """One finger.

    guard: its limits.
    contact: its contact with the surface under it.
    at: last trusted position [m].
    known: whether there is one.
    bad: number of untrusted positions since then.
    """

    guard: Guard
    contact: Contact = field(default_factory=Contact)
    at: Vector = ZERO
    known: bool = False
    bad: int = 0

    def sense(
        self, words: tuple[int, ...], masked: bool, since: float, time: float, acted: Vector, left: float
    ) -> None:
        """Take a position.

        Args:
            words: its three words in a STATE.
            masked: the device itself does not trust it.
            since: time since the last position, by the device's ticks [s].
            time: of the device [s].
            acted: force of the motors since the last position [N].
            left: share of that force that is left by now.
        """
        x, y, z = words
        at = x * PLACE_STEP, y * PLACE_STEP, z * PLACE_STEP
        far = max(abs(a - b) for a, b in zip(at, self.at, strict=True)) if self.known else 0.0
        if masked or far > FASTEST * since or max(map(abs, words)) >= LAST_PLACE:
            self.bad += 1
            self.guard.skip()
            return
        self.at, self.known, self.bad = at, True, 0
        self.guard.move(self.at, time, acted, left)

    def forget(self) -> None:
        """Trust the next position wherever it is, because no force acts."""
        self.known, self.bad = False, 0
        self.guard.skip()

    def command(self) -> tuple[int, int, int]:
        """Return the force that acts as words of a command; it never exceeds the guard's ceiling."""
        x, y, z = self.guard.sent if self.known else ZERO
        return round(x / FORCE_STEP), round(y / FORCE_STEP), round(z / FORCE_STEP)
