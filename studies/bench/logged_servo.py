"""The servo process with a log of each answer. Standard library only, like the servo itself."""

from __future__ import annotations

import argparse
from pathlib import Path

from core.device import servo_process
from core.device.servo import Servo
from core.device.servo_process import add_options
from core.errors import DimpleError

LogRow = tuple[float, ...]  # time of the device [us], then position [m] and force [N] of each tip


class LoggedServo(Servo):
    """A servo that keeps what it took and gave.

    log: a row for each STATE answered.
    """

    def __init__(self, *, nonce: int = 1) -> None:
        super().__init__(nonce=nonce)
        self.log: list[LogRow] = []

    def step(self, now: float, incoming: bytes) -> bytes:
        """Take the bytes that came in at a time [s]; return those to send, and log them."""
        out = super().step(now, incoming)
        if out and self._state:
            vectors = [vector for finger in self._fingers for vector in (finger.at, finger.guard.sent)]
            self.log.append((self._state.t_us, *(part for vector in vectors for part in vector)))
        return out


def add_logged_servo(command: argparse.ArgumentParser) -> None:
    """Add the options of the servo, and the log's."""
    add_options(command)
    command.set_defaults(run=run_logged_servo)
    command.add_argument("--log", type=Path, metavar="OUT.csv", required=True, help="write each answer")


def run_logged_servo(options: argparse.Namespace) -> int:
    """Run the servo; write its log at the end, however it ends."""
    made: list[LoggedServo] = []

    def make(*, nonce: int) -> LoggedServo:
        made.append(LoggedServo(nonce=nonce))
        return made[-1]

    try:
        return servo_process.run(make, options)
    finally:
        write_log(options.log, [row for servo in made for row in servo.log])


def write_log(path: Path, log: list[LogRow]) -> None:
    """Write a log as CSV.

    Raises:
        DimpleError: it cannot be written.
    """
    try:
        path.write_text("".join(",".join(map(repr, row)) + "\n" for row in log), encoding="utf-8")
    except OSError as error:
        raise DimpleError(f"The servo's log {path} cannot be written: {error.strerror}.") from None
