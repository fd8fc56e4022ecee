"""Emulator and servo with their instruments, as processes of their own."""

from __future__ import annotations

import argparse
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Final

from core.device.device import Device
from core.device.process import end, start
from core.errors import DimpleError

from .command import add_emulator
from .logged_servo import add_logged_servo

START: Final = Path(__file__).with_name("start.py")
PORT_WAIT: Final = 10.0  # [s] at most for the emulator to make its port
START_TIME: Final = 1.0  # [s] until a service listens: unlike a device, it is not asked again
WRITE_WAIT: Final = 30.0  # [s] at most for trace and log


def main(words: list[str]) -> int:
    """Run the process that the first word names; return its exit code."""
    parser = argparse.ArgumentParser(prog="start.py")
    commands = parser.add_subparsers(required=True)
    add_logged_servo(commands.add_parser("servo"))
    add_emulator(commands.add_parser("emulator"))
    options = parser.parse_args(words)
    try:
        return int(options.run(options))
    except DimpleError as error:
        print(error, file=sys.stderr)
        return 2


def start_emulator(
    words: Sequence[str], errors: IO[bytes] | None = None, *, secret: str = ""
) -> subprocess.Popen[bytes]:
    """Start an emulator that ends when its standard input closes; words: its options, see `dev.py core emulator`."""
    return start(["emulator", "--lifeline", *words], errors, script=START, secret=secret)


@dataclass(slots=True)
class EmulatedDevice(Device):
    """An emulated device in a process of its own, and the servo as for a real one, both with instruments.

    hand: JSON of what holds it, see `hand.load_hand`; "": a hand that pokes.
    line: "pty"; "udp", on the network of this computer: the system hands on what a pseudo-terminal is sent only when it
        has time; or "haply", behind Haply's service.
    emulator_words, servo_words: more options of theirs.
    emulator: its process.
    """

    port: str = ""
    hand: str = ""
    line: str = "pty"
    emulator_words: list[str] = field(default_factory=list)
    servo_words: list[str] = field(default_factory=list)
    emulator: subprocess.Popen[bytes] | None = None
    _folder: Path | None = None

    def _open(self) -> None:
        self._folder = Path(tempfile.mkdtemp(prefix="dimple-"))
        words = list(self.emulator_words)
        if self.hand:
            (self._folder / "hand.json").write_text(self.hand, encoding="utf-8")
            words += ["--hand", str(self._folder / "hand.json")]
        if self.line != "pty":
            number = _free_port()
            self.port, self.secret = f"{self.line}:127.0.0.1:{number}", secrets.token_hex(16)
            self.emulator = start_emulator([f"--{self.line}", str(number), *words], secret=self.secret)
            if self.line == "haply":
                self.port = f"haply:{number}"
                time.sleep(START_TIME)
        else:
            self.port = str(self._folder / "device")
            self.emulator = start_emulator(["--pty", self.port, *words])
            _wait_for(Path(self.port), self.emulator)
        Device._open(self)

    def _start(self, words: list[str], errors: IO[bytes]) -> subprocess.Popen[bytes]:
        if not self.servo_words:
            return Device._start(self, words, errors)
        return start(["servo", *self.servo_words, *words], errors, script=START, secret=self.secret)

    def close(self) -> None:
        """End both, once they have written what they measured, which takes seconds on a busy computer."""
        for process in (self.process, self.emulator):
            if process and process.stdin:
                process.stdin.close()
                with suppress(subprocess.TimeoutExpired):
                    process.wait(WRITE_WAIT)
        Device.close(self)
        if self.emulator:
            end(self.emulator)
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
        self.emulator = self._folder = None


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def _wait_for(port: Path, emulator: subprocess.Popen[bytes]) -> None:
    until = time.perf_counter() + PORT_WAIT
    while not port.exists():
        if emulator.poll() is not None or time.perf_counter() > until:
            raise DimpleError("The emulated device did not start.")
        time.sleep(0.01)
