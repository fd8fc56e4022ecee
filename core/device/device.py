"""A haptic device as Blender sees it: a servo process of its own runs it, whatever its line."""

from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import IO

from ..errors import DimpleError
from ..message import Message
from .force_guard import Arming
from .limits import ANSWER_TIME, LEASE
from .mailbox import FROM_SERVO, TO_SERVO, Mailbox
from .orders import LinkState, Order, ServoReport, pack_order, unpack_report
from .process import end, start
from .rendered_surface import Surface


@dataclass(slots=True)
class Device:
    """A haptic device. It receives surfaces, not forces: a force held for a frame of Blender is not stable.

    port: path of the serial port, udp:HOST:PORT, or haply:PORT.
    secret: shared with a device on the network.
    anywhere: allow devices on other computers too.
    held_until: time until which the dead-man key counts as held, as long as orders are sent [s]; 0: not held.
    process: the servo process.
    """

    port: str
    secret: str = ""
    anywhere: bool = False
    held_until: float = 0.0
    process: subprocess.Popen[bytes] | None = None
    _box: Mailbox | None = None
    _seen: int = 0
    _sampled: int = 0
    _heard: float = 0.0  # when the servo last wrote [s]
    _order: Order = field(default_factory=Order)
    _report: ServoReport = field(default_factory=ServoReport)
    _errors: IO[bytes] | None = None

    def open(self) -> None:
        """Start the servo; `read` then reports the outcome.

        Raises:
            DimpleError: Python or pyserial is missing, or the system refuses.
        """
        self.close()
        try:
            self._open()
        except BaseException as error:
            self.close()
            if isinstance(error, OSError):
                raise DimpleError("The device cannot be opened: {error}.", error=error) from None
            raise

    def _open(self) -> None:
        self._heard = time.perf_counter()
        self._box, self._seen, self._sampled, self._order = Mailbox(), 0, 0, Order()
        self._report = ServoReport()
        self._errors = tempfile.TemporaryFile()
        words = ["--mailbox", str(self._box.path), *(["--anywhere"] if self.anywhere else [])]
        words += ["--", self.port]  # so that no name of a port is taken for an option
        self.process = self._start(words, self._errors)

    def _start(self, words: list[str], errors: IO[bytes]) -> subprocess.Popen[bytes]:
        """Start the servo process; a study overrides this to record more."""
        return start(words, errors, secret=self.secret)

    def read(self) -> ServoReport:
        """Return the positions of its fingertips, and its state, without waiting."""
        if self._box:
            self._seen, message = self._box.read(FROM_SERVO, self._seen)
            if message:
                self._report, self._heard = unpack_report(message), time.perf_counter()
        running = self.process is not None and self.process.poll() is None
        if not running and self._report.link in (LinkState.OPENING, LinkState.READY):
            self._lose(Message("The servo process ended ({why}). Connect and arm again.", why=_last_line(self._errors)))
        elif self.process and self._report.link is LinkState.READY and time.perf_counter() - self._heard > ANSWER_TIME:
            self.process.kill()  # while its line is open, a service may hold its last force
            self._lose("The servo process does not answer, so the device has no force. Disconnect, then connect again.")
        return self._report

    def samples(self) -> list[tuple[float, ...]]:
        """Return what the servo measured and rendered since the last call.

        Each row has the time [s], then the position (3,) [m] and the force (3,) [N] of each fingertip.
        """
        self._sampled, found = self._box.samples(self._sampled) if self._box else (0, [])
        return found

    def write(self, surfaces: Sequence[Surface | None]) -> None:
        """Set the surface under each of its fingertips."""
        self._post(replace(self._order, surfaces=tuple(surfaces)))

    def arm(self) -> None:
        """Request force."""
        self._post(replace(self._order, arm=self._order.arm + 1))

    def disarm(self) -> None:
        """End all force."""
        self._post(replace(self._order, disarm=self._order.disarm + 1))

    def hold(self, until: float) -> None:
        """Hold the dead-man key until a time [s of time.perf_counter]; the device's own button also counts.

        It is held for no longer than LEASE after the last call of any method that sends an order.
        """
        self.held_until = until
        self.renew()

    def renew(self) -> None:
        """Send the last order again to renew the key's lease."""
        self._post(self._order)

    def close(self) -> None:
        """End the servo, which ends all force and frees the port; a second call does nothing."""
        if self.process:
            end(self.process)
        if self._box:
            self._box.close()
        if self._errors:
            self._errors.close()
        self.process = self._box = self._errors = None

    def _post(self, order: Order) -> None:
        self._order = replace(order, held_until=min(self.held_until, time.perf_counter() + LEASE))
        if self._box:
            self._box.post(TO_SERVO, pack_order(self._order))

    def _lose(self, why: str) -> None:
        self._report = self._report._replace(link=LinkState.LOST, arming=Arming.OFF, note=why)


def _last_line(errors: IO[bytes] | None) -> str:
    """Return why a process ended: the last line that it wrote."""
    if errors is None:
        return "killed"
    errors.seek(0)
    lines = errors.read().decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else "killed"
