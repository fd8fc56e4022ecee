"""The table of forces that lies beside a bake."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

from ...core.constants import MAX_FINGERTIPS

if TYPE_CHECKING:
    from ...core.session import Session


class ForceTable:
    """A CSV table, a line per frame: force, friction [N], depth [mm], pressure [Pa], volume [m3], energy [J], steps.

    work_j is the work of the fingertips by the law; elastic_j and kinetic_j are the energies of the skin and its fill.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", buffering=1, newline="", encoding="utf-8")  # written line by line
        self._rows = csv.writer(self._file)
        columns = ["frame", "time_s"]
        for number in range(1, MAX_FINGERTIPS + 1):
            columns += [f"force_{number}_n", f"friction_{number}_n", f"depth_{number}_mm"]
        columns += ["pressure_pa", "volume_m3", "rest_volume_m3", "work_j", "elastic_j", "kinetic_j", "steps"]
        self._rows.writerow(columns)
        self._of: tuple[object, object] | None = None  # positions and model of the last energies
        self._energies = 0.0, 0.0

    def append(self, number: float, time_s: float, session: Session) -> None:
        """Add the line of one frame of the animation."""
        from ...core.fields import energies

        frame, row = session.frame, list[float]()
        for i in range(MAX_FINGERTIPS):
            push = depth = friction = 0.0
            if i < len(frame.touches):
                push, depth = float(frame.pushes[i]), float(frame.depths[i])
                friction = max(float((frame.finger_forces[i] ** 2).sum()) - push**2, 0.0) ** 0.5
            row += [push, friction, depth * 1e3]
        now = session.positions(), session.model  # for a sleeping body, the same objects as before
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
