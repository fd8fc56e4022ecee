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
    """A CSV table, a line per frame: force, friction [N], depth [mm], pressure [Pa], volume [m3], work [J], steps."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", buffering=1, newline="", encoding="utf-8")  # written line by line
        self._rows = csv.writer(self._file)
        columns = ["frame", "time_s"]
        for number in range(1, FINGERS + 1):
            columns += [f"force_{number}_n", f"friction_{number}_n", f"depth_{number}_mm"]
        columns += ["pressure_pa", "volume_m3", "rest_volume_m3", "work_j", "steps"]
        self._rows.writerow(columns)

    def append(self, number: float, time_s: float, session: Session) -> None:
        """Add the line of one frame of the animation."""
        frame, row = session.frame, list[float]()
        for i in range(FINGERS):
            push = depth = friction = 0.0
            if i < len(frame.touches):
                push, depth = float(frame.pushes[i]), float(frame.depths[i])
                friction = max(float((frame.finger_forces[i] ** 2).sum()) - push**2, 0.0) ** 0.5
            row += [push, friction, depth * 1e3]
        numbers = [time_s, *row, frame.pressure, frame.volume, frame.rest_volume, frame.work, frame.total_steps]
        self._rows.writerow([f"{number:g}", *(f"{value:.9g}" for value in numbers)])

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class Recorder:
    """Record a live session at the frame rate of the scene, whatever the lengths of the steps.

    Args:
        path: the PC2 file; the table of forces is written next to it.
        start_frame: frame of the animation that the current state becomes.
        fps: frames per second.
        body: the body to record.
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
        """Record the state of a session at a time [s]; frames since the last state are interpolated.

        Raises:
            OSError: writing fails; what was written before is kept.
        """
        if time < self._time:  # the session was put back to rest, and its clock restarted
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
        """Return the number of frames recorded so far."""
        return self._cache.samples

    def summary(self, name: str, scene_end: int) -> str:
        """Return the sentence for the artist on the finished recording of an object."""
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
            OSError: writing fails; the files are closed all the same.
        """
        try:
            self._cache.close()
        finally:
            self._table.close()

    def discard(self) -> None:
        """Close and delete the files."""
        self._files.close()

    def cut_short(self, name: str, error: OSError) -> str:
        """Return the sentence for the artist on a recording of an object that a disk error has ended."""
        return Message(
            'The recording of "{name}" has ended early: {error} ({path}). What was recorded until then is kept.',
            name=name, error=error.strerror, path=self._path
        )  # fmt: skip


def open_file(files: contextlib.ExitStack, path: Path, make: Callable[[Path], Any]) -> Any:
    """Open a file that is closed and deleted when `files` closes, unless it has been renamed by then.

    Raises:
        OSError: the file cannot be made.
    """
    files.callback(quietly, path.unlink)
    opened = make(path)
    files.callback(quietly, opened.close)
    return opened


def quietly(action: Callable[[], None]) -> None:
    """Call an action and ignore disk errors, because another error is already being raised."""
    with contextlib.suppress(OSError):
        action()
