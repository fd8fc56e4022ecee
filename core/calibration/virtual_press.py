"""A virtual press: a round tip presses a body row by row, as an instrument does, and the result is written to a file.

Spreadsheets execute cells that begin like a formula, so text from outside is quoted and never begins like one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ..base import DimpleError, Floats
from ..body.model import Model
from ..mesh.ray import ray_hit
from ..mesh.surface import Mesh
from ..session import Finger, Session
from ..vectors import dot

CLEAR = 0.9  # largest depth as a share of the thickness: deeper, the tip would reach the far side
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "|", "%")
HEADER = ("Distance x (mm)", "Force F (N)")
ROW_S = 0.014  # [s] from one row to the next


def find_site(
    mesh: Mesh, above: Sequence[float] | None = None, inward: Sequence[float] = (0.0, 0.0, -1.0)
) -> tuple[Floats, Floats, float]:
    """Return where a tip meets a body (3,) [m], its direction (3,), and the thickness there [m], inf if it is open.

    Args:
        above: (3,) a point on the path of the tip [m]; None: the middle of the body.
        inward: (3,) direction of the press.

    Raises:
        DimpleError: the tip misses the body.
    """
    x = mesh.rest_positions
    way = np.asarray(inward, np.float64) / np.linalg.norm(inward)
    used = x[~mesh.loose]
    middle = (used.min(axis=0) + used.max(axis=0)) / 2
    start = (middle if above is None else np.asarray(above, np.float64)) - 2 * mesh.size * way
    hit = ray_hit(tuple(start), tuple(way), x, mesh.triangles)
    if hit is None:
        raise DimpleError("The tip misses the object. Move it over the place to be pressed.")
    point = np.array(hit[1])
    beyond = ray_hit(tuple(point + 1e-6 * mesh.size * way), tuple(way), x, mesh.triangles)
    return point, way, beyond[0] if beyond else math.inf


def press_rows(
    model: Model, radius: float, site: tuple[Floats, Floats, float], deepest: float, rows: int
) -> Iterator[tuple[float, float]]:
    """Yield depth [m] and force [N] from the touch on; stop short of the far side, or when the tip loses contact.

    Args:
        radius: radius of the tip [m].
        site: place, direction and thickness, as `find_site` returns them.
        deepest: depth of the last row [m].
        rows: number of rows.
    """
    session, (point, inward, thickness) = Session(model), site
    for depth in (min(deepest, CLEAR * thickness) * np.arange(rows) / (rows - 1)).tolist():
        x, y, z = (point + (depth - radius) * inward).tolist()
        session.set_fingers([Finger((x, y, z), radius)])
        touch = session.step(ROW_S).touches[0]
        if touch is None:
            return
        yield max(touch.depth, 0.0), dot(touch.force, touch.outward)


def write_press(path: str | Path, depth: Floats, force: Floats, *, about: Sequence[str] = ()) -> None:
    """Write a press as CSV.

    Args:
        depth, force: (n,) from the touch [m], [N].
        about: lines of text above the table.

    Raises:
        DimpleError: the file cannot be written.
    """
    lines = [text_cell(line) for line in about]
    lines.append(",".join(map(text_cell, HEADER)))
    lines += [f"{1e3 * x:.5f},{f:.5f}" for x, f in zip(depth.tolist(), force.tolist(), strict=True)]
    try:
        Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    except OSError as error:
        raise DimpleError("{path} cannot be written: {error}.", path=path, error=error.strerror or error) from None


def text_cell(text: str) -> str:
    """Return text as one quoted cell that no spreadsheet interprets as a formula."""
    line = " ".join(text.split())
    if line.startswith(_FORMULA):
        line = "'" + line
    return '"' + line.replace('"', "'") + '"'
