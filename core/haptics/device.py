"""Haptic devices behind one protocol: the Haptic Master through its servo, an emulated one, mouse or tablet."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Protocol

from ..errors import DimpleError
from .contact_model import Contact
from .mailbox import FROM_SERVO, TO_SERVO, Mailbox
from .messages import REPORT_SIZE, Link, Order, Report, Tip, pack_order, unpack_report
from .process import end, start
from .safety import LEASE, Arming
from .vectors import ZERO, Vector, along

PORT_WAIT = 10.0  # [s] at most for the emulator to make its port
SERVO_SILENT = 1.0  # [s] the servo writes every 2 ms; one that has not for so long hangs


class Device(Protocol):
    """Do what a device does. Contacts rather than forces are written: a force held for a frame is not stable."""

    def open(self) -> None:
        """Connect; `read` tells how that went."""

    def read(self) -> Report:
        """Return where its fingertips are, and how it stands; never wait."""

    def write(self, contacts: Sequence[Contact | None]) -> None:
        """Let its fingertips feel."""

    def arm(self) -> None:
        """Ask for force."""

    def disarm(self) -> None:
        """End all force."""

    def hold(self, until: float) -> None:
        """Hold the dead-man key until a time of `time.perf_counter` [s]; the device's own button does as well."""

    def renew(self) -> None:
        """Say that whoever ordered is still there: a key that is held is so for no longer than LEASE without a word."""

    def close(self) -> None:
        """Let go of it; closing twice does nothing."""


@dataclass(slots=True)
class HapticMaster:
    """Run a Haptic Master on a serial port, or what speaks like one, by a servo process.

    port: its path.  baud: None is the device file's.  spec_path: device file, None is the Haptic Master's.
    held_until: the dead-man key is, as long as this is written to or renewed [s]; 0 leaves it to the device's button.
    log: where the servo writes each answer.
    """

    port: str
    baud: int | None = None
    spec_path: Path | None = None
    held_until: float = 0.0
    log: Path | None = None
    process: subprocess.Popen[bytes] | None = None
    _box: Mailbox | None = None
    _seen: int = 0
    _heard: float = 0.0  # when the servo wrote last [s]
    _order: Order = field(default_factory=Order)
    _report: Report = field(default_factory=Report)
    _errors: IO[bytes] | None = None

    def open(self) -> None:
        """Start the servo.

        Raises:
            DimpleError: there is no Python or no pyserial to start it with, or the system refuses.
        """
        self.close()
        try:
            self._run()
        except BaseException as error:
            self.close()
            if isinstance(error, OSError):
                raise DimpleError(f"The device cannot be opened: {error}.") from None
            raise

    def _run(self) -> None:
        self._heard = time.perf_counter()
        self._box, self._seen, self._order, self._report = Mailbox(), 0, Order(), Report()
        options = ["--baud", str(self.baud)] if self.baud else []
        options += ["--device", str(self.spec_path)] if self.spec_path else []
        options += ["--log", str(self.log)] if self.log else []
        self._errors = tempfile.TemporaryFile()
        self.process = start(["servo", self.port, "--mailbox", str(self._box.path), *options], self._errors)

    def read(self) -> Report:
        """Return where its fingertips are, and how it stands."""
        if self._box:
            self._seen, letter = self._box.read(FROM_SERVO, REPORT_SIZE, self._seen)
            if letter:
                self._report, self._heard = unpack_report(letter), time.perf_counter()
        running = self.process is not None and self.process.poll() is None
        if not running and self._report.link in (Link.OPENING, Link.READY):
            self._lose(f"The servo process ended ({_last_words(self._errors)}). Connect and arm again.")
        elif self._report.link is Link.READY and time.perf_counter() - self._heard > SERVO_SILENT:
            self._lose("The servo process does not answer, so the device has no force. Disconnect, then connect again.")
        return self._report

    def write(self, contacts: Sequence[Contact | None]) -> None:
        """Let its fingertips feel."""
        self._post(replace(self._order, contacts=tuple(contacts)))

    def arm(self) -> None:
        """Ask for force."""
        self._post(replace(self._order, arm=self._order.arm + 1))

    def disarm(self) -> None:
        """End all force."""
        self._post(replace(self._order, disarm=self._order.disarm + 1))

    def hold(self, until: float) -> None:
        """Hold the dead-man key until a time [s]."""
        self.held_until = until
        self.renew()

    def renew(self) -> None:
        """Say that whoever ordered is still there."""
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
        self._report = replace(self._report, link=Link.LOST, arming=Arming.OFF, message=why)


@dataclass(slots=True)
class Emulated(HapticMaster):
    """Run an emulated Haptic Master in a process of its own, behind a pseudo-terminal, and the servo as for a real one.

    options: more words for `python -m core emulator`.  hand: JSON of what holds it, see `hand.load_hand`; "" is a hand
    at rest.
    """

    port: str = ""
    options: tuple[str, ...] = ()
    hand: str = ""
    emulator: subprocess.Popen[bytes] | None = None
    _folder: Path | None = None

    def _run(self) -> None:
        """Start the emulator, then the servo.

        Raises:
            DimpleError: this system has no pseudo-terminals, or the emulator does not start.
        """
        self._folder = Path(tempfile.mkdtemp(prefix="dimple-"))
        port = self._folder / "device"
        options = [*self.options, *(["--device", str(self.spec_path)] if self.spec_path else [])]
        if self.hand:
            path = self._folder / "hand.json"
            path.write_text(self.hand, encoding="utf-8")
            options += ["--hand", str(path)]
        with tempfile.TemporaryFile() as errors:
            self.emulator = start(["emulator", "--pty", str(port), "--lifeline", *options], errors)
            until = time.perf_counter() + PORT_WAIT
            while not port.exists():
                if self.emulator.poll() is not None or time.perf_counter() > until:
                    raise DimpleError(f"The emulated device did not start ({_last_words(errors)}).")
                time.sleep(0.01)
        self.port = str(port)
        HapticMaster._run(self)

    def close(self) -> None:
        """End servo and emulator."""
        HapticMaster.close(self)
        if self.emulator:
            end(self.emulator)
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
        self.emulator = self._folder = None


@dataclass(slots=True)
class Pointer:
    """Let mouse or tablet be a device of one fingertip without force: its pressure is the depth.

    radius: of the fingertip, depth: at full pressure [m].
    """

    radius: float = 0.010
    depth: float = 0.015
    _at: Vector | None = None

    def point(self, surface: Vector, outward: Vector, pressure: float) -> None:
        """Take what the pointer is on [m], the unit way out there, and the pen's pressure 0..1."""
        self._at = along(surface, outward, self.radius - min(max(pressure, 0.0), 1.0) * self.depth)

    def open(self) -> None:
        """Do nothing: it is always there."""

    def read(self) -> Report:
        """Return where the fingertip is."""
        return Report(link=Link.READY, tips=(Tip(position=self._at or ZERO, masked=self._at is None),))

    def write(self, contacts: Sequence[Contact | None]) -> None:
        """Do nothing: it has no force."""

    def arm(self) -> None:
        """Do nothing."""

    def disarm(self) -> None:
        """Do nothing."""

    def hold(self, until: float) -> None:
        """Do nothing."""

    def renew(self) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Forget where it was."""
        self._at = None


def _last_words(errors: IO[bytes] | None) -> str:
    """Return why a process ended: the last line of what it wrote."""
    if errors is None:
        return "killed"
    errors.seek(0)
    lines = errors.read().decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else "killed"
