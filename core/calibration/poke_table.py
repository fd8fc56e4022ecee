"""Read a table of pokes: x, y, z, depth and force in any order, with or without units, as robots record them."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np

from ..base import DimpleError
from .load import load_lines
from .poke_map import Pokes

_NAMES = {
    "x": ("x",), "y": ("y",), "z": ("z",),
    "depth": ("depth", "indentation", "displacement", "d", "変位", "押込み量"),
    "force": ("force", "load", "f", "fz", "荷重", "力"),
}  # fmt: skip
_LENGTHS = {"mm": 1e-3, "m": 1.0, "cm": 1e-2, "um": 1e-6, "µm": 1e-6, "in": 0.0254}
_FORCES = {"n": 1.0, "mn": 1e-3, "kn": 1e3, "gf": 9.80665e-3, "kgf": 9.80665, "lbf": 4.4482216}
_UNIT = re.compile(r"[\[(（]\s*([^\])）]+?)\s*[\])）]\s*$|_([a-zµ]+)$", re.IGNORECASE)


def read_pokes(path: str | Path) -> Pokes:
    """Read a table of pokes; lengths are in mm and forces in N where its headers name no unit.

    Raises:
        DimpleError: it cannot be read, or lacks a column; the message says which.
    """
    lines, _, _ = load_lines(path)
    rows = [row for row in csv.reader(lines, delimiter=max(",;\t", key="".join(lines[:50]).count)) if row]
    at = next((i for i, row in enumerate(rows) if len(_columns(row)) == len(_NAMES)), None)
    if at is None:
        best = max((_columns(row) for row in rows), key=len, default={})
        missing = ", ".join(name for name in _NAMES if name not in best)
        raise DimpleError(
            "{name} is no table of pokes: there is no column {missing}.", name=Path(path).name, missing=missing
        )
    columns = _columns(rows[at])
    values = []
    for row in rows[at + 1 :]:
        try:
            values.append([float(row[column]) * unit for column, unit in columns.values()])
        except (ValueError, IndexError):  # a remark, a row of units, a row cut off
            continue
    found = np.array(values).reshape(-1, len(columns))
    found = found[np.isfinite(found).all(axis=1)]
    if not len(found):
        raise DimpleError("{name} holds no pokes below its headers.", name=Path(path).name)
    by = dict(zip(columns, found.T, strict=True))
    depth, force = np.abs(by["depth"]), by["force"] * (-1 if np.median(by["force"]) < 0 else 1)
    return Pokes(places=np.stack([by["x"], by["y"], by["z"]], axis=1), depths=depth, forces=force)


def _columns(row: list[str]) -> dict[str, tuple[int, float]]:
    """Return for each name the column that has it and its unit in SI."""
    found: dict[str, tuple[int, float]] = {}
    for number, cell in enumerate(row):
        header = cell.strip().lower()
        match = _UNIT.search(header)
        unit, bare = ((match[1] or match[2]).strip(), header[: match.start()].strip()) if match else ("", header)
        for name, names in _NAMES.items():
            units, usual = (_FORCES, "n") if name == "force" else (_LENGTHS, "mm")
            if bare in names and name not in found and (unit or usual) in units:
                found[name] = number, units[unit or usual]
    return {name: found[name] for name in _NAMES if name in found}
