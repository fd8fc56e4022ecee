"""The files of a running session: its table of forces, and its recording."""

from __future__ import annotations

import contextlib
import csv
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.messages import Message, in_a_row
from ...core.recording import PointCache
from ..messages import beyond_end

if TYPE_CHECKING:
    from ...core.session import Session
    from ..bridge.scene_objects import Singles
    from .object_body import ObjectBody

FINGERS = 3


class ForceTable:
    """Write one line a frame: force and friction [N], depth [mm], pressure [Pa], volume [m3], energy [J]; steps.

    work_j is what the fingertips have put in by the law, elastic_j what the skin's shape holds, kinetic_j its motion.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", buffering=1, newline="", encoding="utf-8")  # a line is the system's once written
        self._rows = csv.writer(self._file)
        columns = ["frame", "time_s"]
        for number in range(1, FINGERS + 1):
            columns += [f"force_{number}_n", f"friction_{number}_n", f"depth_{number}_mm"]
        columns += ["pressure_pa", "volume_m3", "rest_volume_m3", "work_j", "elastic_j", "kinetic_j", "steps"]
        self._rows.writerow(columns)
        self._of: tuple[object, object] | None = None  # where and as what the energies were last computed
        self._energies = 0.0, 0.0

    def append(self, number: float, time_s: float, session: Session) -> None:
        """Add the line of one frame of the animation."""
        from ...core.fields import energies

        frame, row = session.frame, list[float]()
        for i in range(FINGERS):
            push = depth = friction = 0.0
            if i < len(frame.touches):
                push, depth = float(frame.pushes[i]), float(frame.depths[i])
                friction = max(float((frame.finger_forces[i] ** 2).sum()) - push**2, 0.0) ** 0.5
            row += [push, friction, depth * 1e3]
        now = session.positions(), session.model  # of what sleeps the very same
        if self._of is None or any(a is not b for a, b in zip(now, self._of, strict=True)):
            self._of, self._energies = now, energies(session)
        numbers = [
            time_s, *row, frame.pressure, frame.volume, frame.rest_volume, frame.work, *self._energies,
            frame.total_steps,
        ]  # fmt: skip
        self._rows.writerow([f"{number:g}", *(f"{value:.9g}" for value in numbers)])

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class Recorder:
    """Record a live session at the frame rate of the scene, whatever the rhythm of the steps.

    Args:
        path: the PC2 file; the table of forces goes beside it.
        start_frame: the frame of the animation that is now.
        fps: frames per second.
        body: what is recorded.
    """

    def __init__(self, path: Path, start_frame: int, fps: float, body: ObjectBody) -> None:
        self._path, self._start_frame, self._fps = path, start_frame, fps
        self._began = self._time = body.frame.time
        self._offsets = offsets = body.offsets()
        with contextlib.ExitStack() as self._files:
            self._cache = open_file(self._files, path, lambda name: PointCache(name, len(offsets), start_frame))
            self._table = open_file(self._files, path.with_suffix(".csv"), ForceTable)
            self.append(self._time, offsets, body.session)
            self._files = self._files.pop_all()

    @property
    def take(self) -> tuple[str, int]:
        """Return the path of the PC2 file and its first frame."""
        return str(self._path), self._start_frame

    def append(self, time: float, offsets: Singles, session: Session) -> None:
        """Take in the state of a session at a time [s]; frames in between are interpolated.

        Raises:
            OSError: the disk refuses; what was written before is kept.
        """
        if time < self._time:  # the session was put back to rest: its clock began again
            self._began -= self._time - time
            self._time = time
        span = time - self._time
        while (due := self._began + self._cache.samples / self._fps) <= time + 1e-9:
            self._table.append(self._start_frame + self._cache.samples, due - self._began, session)
            share = 1.0 if time - due < 1e-9 else max((due - self._time) / span, 0.0)
            self._cache.append(offsets if share == 1 else self._offsets + (offsets - self._offsets) * share)
        self._time, self._offsets = time, offsets

    @property
    def frames(self) -> int:
        """Return how many frames there are so far."""
        return self._cache.samples

    def summary(self, name: str, scene_end: int) -> str:
        """Return the sentence for the artist on a recording of an object that has ended."""
        last = self._start_frame + self.frames - 1
        said = Message(
            'Recorded {frames} frames of "{name}" to {path}: when its session has ended, it plays them from frame '
            "{first} to {last}.",
            frames=self.frames, name=name, path=self._path.name, first=self._start_frame, last=last
        )  # fmt: skip
        return in_a_row([said, *beyond_end(last, scene_end)])

    def close(self) -> None:
        """Close the files.

        Raises:
            OSError: the disk refuses; the files are closed all the same.
        """
        try:
            self._cache.close()
        finally:
            self._table.close()

    def discard(self) -> None:
        """Close the files and delete them."""
        self._files.close()

    def cut_short(self, name: str, error: OSError) -> str:
        """Return the sentence for the artist when the disk refuses the recording of an object."""
        return Message(
            'The recording of "{name}" has ended early: {error} ({path}). What was recorded until then is kept.',
            name=name, error=error.strerror, path=self._path
        )  # fmt: skip


def open_file(files: contextlib.ExitStack, path: Path, make: Callable[[Path], Any]) -> Any:
    """Open a file that is closed and deleted when `files` are, unless it has another name by then.

    Raises:
        OSError: it cannot be made.
    """
    files.callback(quietly, path.unlink)
    opened = make(path)
    files.callback(quietly, opened.close)
    return opened


def quietly(action: Callable[[], None]) -> None:
    """Do what may fail on a disk that is full, where an error is on its way already."""
    with contextlib.suppress(OSError):
        action()
