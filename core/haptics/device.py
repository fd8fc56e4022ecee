"""Haptic devices behind one protocol: the Haptic Master through its servo process, and an emulated one to try."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Final, Protocol

from ..errors import DimpleError
from ..messages import Message
from . import pseudo_terminal
from .contact_model import Contact
from .mailbox import FROM_SERVO, TO_SERVO, Mailbox
from .process import end, start
from .safety import LEASE, Arming
from .servo_messages import REPORT_SIZE, LinkState, Order, ServoReport, pack_order, unpack_report

PORT_WAIT: Final = 10.0  # [s] at most for the emulator to make its port
SERVO_SILENT: Final = 1.0  # [s] the servo writes every 2 ms; one that has not written for so long hangs


class Device(Protocol):
    """What every haptic device does. It is given contacts, not forces: a force held for a frame is not stable."""

    def open(self) -> None:
        """Connect; `read` then reports how that went."""

    def read(self) -> ServoReport:
        """Return where its fingertips are, and its state; never wait."""

    def write(self, contacts: Sequence[Contact | None]) -> None:
        """Set the contact to render on each of its fingertips."""

    def arm(self) -> None:
        """Request force."""

    def disarm(self) -> None:
        """End all force."""

    def hold(self, until: float) -> None:
        """Set until when the dead-man key counts as held [s of time.perf_counter]; the device's own button also counts.

        It is held for no longer than LEASE after the last call of any method that sends something.
        """

    def renew(self) -> None:
        """Send the last order again, so that the key's lease is renewed."""

    def close(self) -> None:
        """Release the device; closing twice does nothing."""


@dataclass(slots=True)
class HapticMaster:
    """A Haptic Master on a serial port, or what speaks its protocol, run by a servo process.

    port: path of the serial port.
    spec_path: device file, None for the Haptic Master's.
    held_until: until when the dead-man key counts as held, as long as orders are sent [s]; 0: not held.
    process: the servo.
    """

    port: str
    spec_path: Path | None = None
    held_until: float = 0.0
    process: subprocess.Popen[bytes] | None = None
    _box: Mailbox | None = None
    _seen: int = 0
    _heard: float = 0.0  # when the servo wrote last [s]
    _order: Order = field(default_factory=Order)
    _report: ServoReport = field(default_factory=ServoReport)
    _errors: IO[bytes] | None = None

    def open(self) -> None:
        """Start the servo.

        Raises:
            DimpleError: there is no Python or no pyserial to start it with, or the system refuses.
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
        self._box, self._seen, self._order, self._report = Mailbox(), 0, Order(), ServoReport()
        self._errors = tempfile.TemporaryFile()
        words = ["servo", self.port, "--mailbox", str(self._box.path), *self._device_words()]
        self.process = self._start(words, self._errors)

    def _start(self, words: list[str], errors: IO[bytes]) -> subprocess.Popen[bytes]:
        """Start one of its processes; a study starts one that records more."""
        return start(words, errors)

    def _device_words(self) -> list[str]:
        return ["--device", str(self.spec_path)] if self.spec_path else []

    def read(self) -> ServoReport:
        """Return where its fingertips are, and its state."""
        if self._box:
            self._seen, message = self._box.read(FROM_SERVO, REPORT_SIZE, self._seen)
            if message:
                self._report, self._heard = unpack_report(message), time.perf_counter()
        running = self.process is not None and self.process.poll() is None
        if not running and self._report.link in (LinkState.OPENING, LinkState.READY):
            self._lose(Message("The servo process ended ({why}). Connect and arm again.", why=_last_line(self._errors)))
        elif self._report.link is LinkState.READY and time.perf_counter() - self._heard > SERVO_SILENT:
            self._lose("The servo process does not answer, so the device has no force. Disconnect, then connect again.")
        return self._report

    def write(self, contacts: Sequence[Contact | None]) -> None:
        """Set the contact to render on each of its fingertips."""
        self._post(replace(self._order, contacts=tuple(contacts)))

    def arm(self) -> None:
        """Request force."""
        self._post(replace(self._order, arm=self._order.arm + 1))

    def disarm(self) -> None:
        """End all force."""
        self._post(replace(self._order, disarm=self._order.disarm + 1))

    def hold(self, until: float) -> None:
        """Set until when the dead-man key counts as held [s]."""
        self.held_until = until
        self.renew()

    def renew(self) -> None:
        """Send the last order again."""
        self._post(self._order)

    def close(self) -> None:
        """End the servo, which ends all force and frees the port."""
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
        self._report = replace(self._report, link=LinkState.LOST, arming=Arming.OFF, note=why)


@dataclass(slots=True)
class Emulated(HapticMaster):
    """An emulated Haptic Master in a process of its own behind a pseudo-terminal, and the servo as for a real one.

    hand: JSON of what holds it, see `emulated_hand.load_hand`; "" is a hand at rest.
    emulator: its process.
    """

    port: str = ""
    hand: str = ""
    emulator: subprocess.Popen[bytes] | None = None
    _folder: Path | None = None

    @staticmethod
    def is_supported() -> bool:
        """Tell whether this system can run it: Windows has no pseudo-terminals."""
        return pseudo_terminal.SUPPORTED

    def _open(self) -> None:
        """Start the emulator, then the servo.

        Raises:
            DimpleError: this system has no pseudo-terminals, or the emulator does not start.
        """
        if not self.is_supported():
            raise DimpleError(pseudo_terminal.UNSUPPORTED)
        self._folder = Path(tempfile.mkdtemp(prefix="dimple-"))
        port = self._folder / "device"
        words = ["emulator", "--pty", str(port), *self._device_words()]
        if self.hand:
            path = self._folder / "hand.json"
            path.write_text(self.hand, encoding="utf-8")
            words += ["--hand", str(path)]
        with tempfile.TemporaryFile() as errors:
            self.emulator = self._start(words, errors)
            until = time.perf_counter() + PORT_WAIT
            while not port.exists():
                if self.emulator.poll() is not None or time.perf_counter() > until:
                    raise DimpleError("The emulated device did not start ({why}).", why=_last_line(errors))
                time.sleep(0.01)
        self.port = str(port)
        HapticMaster._open(self)

    def close(self) -> None:
        """End servo and emulator."""
        HapticMaster.close(self)
        if self.emulator:
            end(self.emulator)
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
        self.emulator = self._folder = None


def _last_line(errors: IO[bytes] | None) -> str:
    """Return why a process ended: the last line that it wrote."""
    if errors is None:
        return "killed"
    errors.seek(0)
    lines = errors.read().decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else "killed"
