"""Haptic devices behind one protocol: the Haptic Master through its servo, an emulated one, mouse or tablet."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import IO, Protocol

from ..errors import DimpleError
from .contact_model import Contact
from .letters import REPORT_SIZE, Link, Order, Report, Tip, pack_order, unpack_report
from .mailbox import FROM_SERVO, TO_SERVO, Mailbox
from .safety import Arming
from .spec import load_spec
from .vectors import ZERO, Vector, along

START = Path(__file__).with_name("start.py")
END_WAIT = 1.0  # [s] for a process to end by itself
PORT_WAIT = 3.0  # [s] for the emulator to make its port
PROBE = "import sys, mmap, select, tomllib; print('python', *sys.version_info[:2])"


@dataclass(frozen=True, slots=True, kw_only=True)
class Caps:
    """Say what a device can: fingertips, force, rate [1/s], peak and continuous force [N], radius of workspace [m]."""

    tips: int
    has_force: bool
    rate: float
    peak_force: float
    continuous_force: float
    workspace_radius: float


class Device(Protocol):
    """Do what a device does. Contacts rather than forces are written: a force held for a frame is not stable."""

    @property
    def caps(self) -> Caps:
        """Return what it can."""

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

    def hold(self, held: bool) -> None:
        """Hold or release the dead-man key; the device's own button does as well."""

    def close(self) -> None:
        """Let go of it; closing twice does nothing."""


@dataclass(slots=True)
class HapticMaster:
    """Run a Haptic Master on a serial port, or what speaks like one, by a servo process.

    port: its path.  baud: None is the device file's.  spec_path: device file, None is the Haptic Master's.
    held: the dead-man key is; False leaves it to the device's button.  log: where the servo writes each answer.
    """

    port: str
    baud: int | None = None
    spec_path: Path | None = None
    held: bool = True
    log: Path | None = None
    process: subprocess.Popen[bytes] | None = None
    _box: Mailbox | None = None
    _seen: int = 0
    _order: Order = field(default_factory=Order)
    _report: Report = field(default_factory=Report)
    _errors: IO[bytes] | None = None

    @property
    def caps(self) -> Caps:
        """Return what it can."""
        spec = load_spec(self.spec_path)
        return Caps(
            tips=len(spec.block_names), has_force=True, rate=spec.tick_hz, peak_force=spec.peak_force,
            continuous_force=spec.continuous_force, workspace_radius=spec.workspace_radius,
        )  # fmt: skip

    def open(self) -> None:
        """Start the servo.

        Raises:
            DimpleError: there is no Python or no pyserial to start it with.
        """
        self.close()
        self._box, self._seen, self._order, self._report = Mailbox(), 0, Order(held=self.held), Report()
        options = ["--baud", str(self.baud)] if self.baud else []
        options += ["--device", str(self.spec_path)] if self.spec_path else []
        options += ["--log", str(self.log)] if self.log else []
        self._errors = tempfile.TemporaryFile()
        try:
            self.process = start(["servo", self.port, "--mailbox", str(self._box.path), *options], self._errors)
        except DimpleError:
            self.close()
            raise

    def read(self) -> Report:
        """Return where its fingertips are, and how it stands."""
        if self._box:
            self._seen, letter = self._box.read(FROM_SERVO, REPORT_SIZE, self._seen)
            self._report = unpack_report(letter) if letter else self._report
        running = self.process is not None and self.process.poll() is None
        if not running and self._report.link in (Link.OPENING, Link.READY):
            self._report = replace(self._report, link=Link.LOST, arming=Arming.OFF, message=self._end())
        return self._report

    def write(self, contacts: Sequence[Contact | None]) -> None:
        """Let its fingertips feel."""
        self._post(replace(self._order, contacts=tuple(contacts), held=self.held))

    def arm(self) -> None:
        """Ask for force."""
        self._post(replace(self._order, arm=self._order.arm + 1))

    def disarm(self) -> None:
        """End all force."""
        self._post(replace(self._order, disarm=self._order.disarm + 1))

    def hold(self, held: bool) -> None:
        """Hold or release the dead-man key."""
        self.held = held
        if held != self._order.held:
            self._post(replace(self._order, held=held))

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
        self._order = order
        if self._box:
            self._box.post(TO_SERVO, pack_order(order))

    def _end(self) -> str:
        """Return why the servo ended without a word."""
        said = b""
        if self._errors:
            self._errors.seek(0)
            said = self._errors.read().strip()
        last = said.decode(errors="replace").splitlines()[-1:] or ["killed"]
        return f"The servo process ended ({last[0]}). Connect and arm again."


@dataclass(slots=True)
class Emulated:
    """Run an emulated Haptic Master in a process of its own, behind a pseudo-terminal and the same servo.

    options: more words for `python -m core emulator`.  hand: JSON of what holds it, see `hand.load_hand`; "" is a hand
    at rest.
    """

    options: tuple[str, ...] = ()
    hand: str = ""
    master: HapticMaster = field(default_factory=lambda: HapticMaster(""))
    process: subprocess.Popen[bytes] | None = None
    _folder: Path | None = None

    @property
    def caps(self) -> Caps:
        """Return what it can."""
        return self.master.caps

    def open(self) -> None:
        """Start the emulator, then the servo.

        Raises:
            DimpleError: this system has no pseudo-terminals, or the emulator does not start.
        """
        self.close()
        self._folder = Path(tempfile.mkdtemp(prefix="dimple-"))
        port = self._folder / "device"
        options = list(self.options)
        if self.hand:
            path = self._folder / "hand.json"
            path.write_text(self.hand, encoding="utf-8")
            options += ["--hand", str(path)]
        self.process = start(["emulator", "--pty", str(port), "--lifeline", *options], None)
        until = time.perf_counter() + PORT_WAIT
        while not port.exists():
            if self.process.poll() is not None or time.perf_counter() > until:
                self.close()
                raise DimpleError("The emulated device did not start. It runs on Linux and macOS.")
            time.sleep(0.01)
        self.master.port = str(port)
        self.master.open()

    def read(self) -> Report:
        """Return where its fingertips are, and how it stands."""
        return self.master.read()

    def write(self, contacts: Sequence[Contact | None]) -> None:
        """Let its fingertips feel."""
        self.master.write(contacts)

    def arm(self) -> None:
        """Ask for force."""
        self.master.arm()

    def disarm(self) -> None:
        """End all force."""
        self.master.disarm()

    def hold(self, held: bool) -> None:
        """Hold or release the dead-man key."""
        self.master.hold(held)

    def close(self) -> None:
        """End servo and emulator."""
        self.master.close()
        if self.process:
            end(self.process)
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
        self.process = self._folder = None


@dataclass(slots=True)
class Pointer:
    """Let mouse or tablet be a device of one fingertip without force: its pressure is the depth.

    radius: of the fingertip, depth: at full pressure [m].
    """

    radius: float = 0.010
    depth: float = 0.015
    _at: Vector | None = None

    @property
    def caps(self) -> Caps:
        """Return what it can."""
        return Caps(tips=1, has_force=False, rate=60, peak_force=0, continuous_force=0, workspace_radius=1.0)

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

    def hold(self, held: bool) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Forget where it was."""
        self._at = None


def start(words: Sequence[str], errors: IO[bytes] | None) -> subprocess.Popen[bytes]:
    """Start a process of `command.main` whose life hangs on its standard input.

    Raises:
        DimpleError: there is no Python or no pyserial to start it with.
    """
    serial = importlib.util.find_spec("serial")
    if serial is None or serial.origin is None:
        raise DimpleError("pyserial is not installed, so no serial device can be used. Install the extension's zip.")
    folder = str(Path(serial.origin).parents[1])
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return subprocess.Popen(
        [python(), "-I", "-S", str(START), folder, *words],
        stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=errors or subprocess.DEVNULL, env=clean,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0) | getattr(subprocess, "HIGH_PRIORITY_CLASS", 0),
    )  # fmt: skip


def end(process: subprocess.Popen[bytes]) -> None:
    """Close the lifeline of a process and see it end; one that does not is killed."""
    if process.stdin:
        process.stdin.close()
    try:
        process.wait(END_WAIT)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


@lru_cache(maxsize=1)
def python() -> str:
    """Return a Python to start processes with: Blender's own.

    Raises:
        DimpleError: none is found.
    """
    for path in _candidates():
        try:
            said = subprocess.run([path, "-I", "-S", "-c", PROBE], capture_output=True, timeout=10, check=False).stdout
        except (OSError, subprocess.TimeoutExpired):
            continue
        if said.startswith(b"python 3"):
            return path
    raise DimpleError("Blender's Python was not found, so no device can be run. Install Blender from blender.org.")


def _candidates() -> Iterator[str]:
    """Yield where a Python may be: sys.executable is None, or Blender itself, where Blender was built so."""
    name = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    for path in (sys.executable, getattr(sys, "_base_executable", None)):
        if path and "python" in Path(path).name.lower():
            yield path
    for prefix in dict.fromkeys((sys.prefix, sys.exec_prefix, sys.base_prefix)):
        for place in (f"bin/{name}", "bin/python3", "bin/python.exe", "python.exe"):
            if (Path(prefix) / place).is_file():
                yield str(Path(prefix) / place)
