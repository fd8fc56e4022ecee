"""Emulator and servo with their instruments, as processes of their own."""

from __future__ import annotations

import socket
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Final

from core.haptics.command import run
from core.haptics.device import Emulated, HapticMaster
from core.haptics.process import start

from .emulator import add_emulator
from .logged_servo import add_logged_servo

START: Final = Path(__file__).with_name("start.py")
WRITE_WAIT: Final = 30.0  # [s] at most for trace and log


def main(words: list[str]) -> int:
    """Run one of the two; return its exit code."""
    return run(words, servo=add_logged_servo, emulator=add_emulator)


def start_emulator(words: Sequence[str], errors: IO[bytes] | None = None) -> subprocess.Popen[bytes]:
    """Start an emulator that ends when its standard input closes; words: its options, see `dev.py core emulator`."""
    return start(["emulator", "--lifeline", *words], errors, script=START)


@dataclass(slots=True)
class InstrumentedDevice(Emulated):
    """An emulated device whose emulator and servo are those of this file.

    udp: on the network of this computer: the system hands on what a pseudo-terminal is sent only when it has time.
    emulator_words, servo_words: more options of theirs.
    """

    udp: bool = False
    emulator_words: list[str] = field(default_factory=list)
    servo_words: list[str] = field(default_factory=list)

    def _open(self) -> None:
        if not self.udp:
            Emulated._open(self)
            return
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            number = free.getsockname()[1]
        self._folder = Path(tempfile.mkdtemp(prefix="dimple-"))
        (self._folder / "hand.json").write_text(self.hand, encoding="utf-8")
        words = ["--udp", str(number), "--hand", str(self._folder / "hand.json"), *self.emulator_words]
        self.emulator = start_emulator(words)
        self.port = f"udp:127.0.0.1:{number}"
        HapticMaster._open(self)

    def _start(self, words: list[str], errors: IO[bytes]) -> subprocess.Popen[bytes]:
        if words[0] == "emulator":
            return start_emulator([*words[1:], *self.emulator_words], errors)
        return start([*words, *self.servo_words], errors, script=START)

    def close(self) -> None:
        """End both, once they have written what they measured, which takes seconds on a busy computer."""
        for process in (self.process, self.emulator):
            if process and process.stdin:
                process.stdin.close()
                with suppress(subprocess.TimeoutExpired):
                    process.wait(WRITE_WAIT)
        Emulated.close(self)
