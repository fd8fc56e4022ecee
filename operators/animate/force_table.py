"""The table of forces that lies beside a bake."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

from ...core.constants import MAX_FINGERTIPS

if TYPE_CHECKING:
    from ...core.session import Session


class ForceTable:
    """A CSV table, a line per frame: force, friction [N], depth [mm], pressure [Pa], volume [m3], work [J], steps."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", buffering=1, newline="", encoding="utf-8")  # written line by line
        self._rows = csv.writer(self._file)
        columns = ["frame", "time_s"]
        for number in range(1, MAX_FINGERTIPS + 1):
            columns += [f"force_{number}_n", f"friction_{number}_n", f"depth_{number}_mm"]
        columns += ["pressure_pa", "volume_m3", "rest_volume_m3", "work_j", "steps"]
        self._rows.writerow(columns)

    def append(self, number: float, time_s: float, session: Session) -> None:
        """Add the line of one frame of the animation."""
        frame, row = session.frame, list[float]()
        for i in range(MAX_FINGERTIPS):
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
