"""A map of softness from pokes of one object: x, y, z, depth and force, as robots record them.

At each place, the measured force divided by that of the material's law is the relative stiffness there. A vertex gets
the mean of the nearest places; predicting each place from the others (cross-validation) gives the error of the map.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..base import DimpleError, Floats
from ..constants import SLACK
from ..material import Material
from ..mesh.surface import Mesh
from ..message import Message
from .known_words_and_units import UNITS, unit_of
from .question import Answers, Remarks
from .reader import find_dialect, load_lines
from .table import Table, find_table

_NEAREST = 4  # places averaged for a vertex: on a square grid, the corners of the cell round it
_FEWEST = 2 * _NEAREST  # places that a map needs
_FAR = 0.1  # share of the size: pokes farther than this from the surface belong to another object
_PER_WEIGHT = 2 * math.log(4.0)  # change of log stiffness per unit of weight: 1 is four times as soft as 0.5
_AXES = ("x", "y", "z")


@dataclass(frozen=True, slots=True, kw_only=True)
class Pokes:
    """Pokes of one object: places (p, 3) [m], depths (p,) [m] and forces (p,) [N]."""

    places: Floats
    depths: Floats
    forces: Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class PokeMap:
    """Softness over a mesh.

    weights: (n,) painted softness: 0.5 as the material, 1 four times softer, 0 four times stiffer.
    places: number of different places.
    pokes: number of pokes.
    error: RMS error of the force at each place as predicted from the others, as a share of the force.
    without: the same error if all places have one softness.
    outside: share of the vertices whose softness exceeds the range of a map.
    """

    weights: Floats
    places: int
    pokes: int
    error: float
    without: float
    outside: float

    @property
    def text(self) -> str:
        """Return a sentence about the pokes and the error of the map."""
        return Message(
            "{pokes} pokes at {places} places. When each place is predicted from the others, the force is off by "
            "{error:.1%} RMS, and by {without:.1%} with one softness for all.",
            pokes=self.pokes,
            places=self.places,
            error=self.error,
            without=self.without,
        )


def read_pokes(path: str | Path) -> Pokes:
    """Read a table of pokes; without units, lengths are in mm and forces in N. Rows without contact are left out.

    Raises:
        Undecided: the file is ambiguous.
        DimpleError: the file cannot be read, or lacks a column; the message says which.
    """
    lines = load_lines(path, remarks := Remarks())
    table = find_table(lines, find_dialect(lines), Answers(), remarks)
    columns = _columns(table)
    if missing := [name for name in (*_AXES, "depth", "force") if name not in columns]:
        raise DimpleError(
            "{name} is not a table of pokes: it has no column {missing}.", name=Path(path).name, missing=tuple(missing)
        )
    found = np.stack([_in_si(table, at, name) for name, at in columns.items()], axis=1)
    by = dict(zip(columns, found[np.isfinite(found).all(axis=1)].T, strict=True))
    hard = np.abs(by["force"]) >= np.abs(by["force"]).max() / 2  # these rows decide the signs of both
    depth, force = (by[name] * (-1 if by[name][hard].sum() < 0 else 1) for name in ("depth", "force"))
    pressed = (depth > 0) & (force > 0)
    if not pressed.any():
        raise DimpleError("No poke has a depth and a force greater than 0. Are these the right columns?")
    places = np.stack([by[axis] for axis in _AXES], axis=1)
    return Pokes(places=places[pressed], depths=depth[pressed], forces=force[pressed])


def map_pokes(
    mesh: Mesh, material: Material, pokes: Pokes, progress: Callable[[float], object] = lambda _: None
) -> PokeMap:
    """Compute the softness over a mesh.

    Args:
        mesh: at the size and the place of the poked object [m].
        material: its law is compared with the measured forces.
        progress: is called with the fraction of the vertices that is done.

    Raises:
        DimpleError: the places are too few or not on this object, or one softness predicts as well as a map.
    """
    _check(mesh, pokes)
    law = np.array([material.law(depth) for depth in pokes.depths.tolist()])
    places, logs = _at_places(pokes.places, pokes.forces, law, SLACK * mesh.size)
    if len(places) < _FEWEST:
        raise DimpleError(
            "A map needs pokes at {least} or more different places; this file has {places}.",
            least=_FEWEST,
            places=len(places),
        )
    left_out = (_near_means(places, places, logs, _NEAREST + 1) * (_NEAREST + 1) - logs) / _NEAREST
    flat = (logs.sum() - logs) / (len(logs) - 1)
    error, without = (float(np.sqrt((np.expm1(guess - logs) ** 2).mean())) for guess in (left_out, flat))
    if error >= without:
        raise DimpleError(
            "One softness is as good as a map. When each place is predicted from the others, the force is off by "
            "{error:.1%} with a map and by {without:.1%} without one.",
            error=error,
            without=without,
        )
    mean = _near_means(mesh.rest_positions, places, logs, _NEAREST, progress)
    weights = 0.5 - mean / _PER_WEIGHT
    return PokeMap(
        weights=np.clip(weights, 0.0, 1.0), places=len(places), pokes=len(law),
        error=error, without=without, outside=float(((weights < 0) | (weights > 1)).mean()),
    )  # fmt: skip


def _columns(table: Table) -> dict[str, int]:
    """Return the column of each quantity: x, y and z by these names, depth and force by the known words."""
    found: dict[str, int] = {}
    for at, name in enumerate(table.names):
        word = name.strip().lower()
        what = word if word in _AXES else table.role(at)
        if what in (*_AXES, "depth", "force") and at in table.numeric:
            found.setdefault(what, at)
    return found


def _in_si(table: Table, at: int, name: str) -> Floats:
    usual = "N" if name == "force" else "mm"
    _, to_si = UNITS[usual] if table.kind(at) != UNITS[usual][0] else unit_of(table.units[at]) or UNITS[usual]
    return np.asarray(table.numbers[:, at] * to_si)


def _near_means(
    points: Floats, places: Floats, logs: Floats, count: int, progress: Callable[[float], object] = lambda _: None
) -> Floats:
    """Return the means (n,) of `logs` (p,) at the `count` places (p, 3) nearest to each of the points (n, 3)."""
    means = np.empty(len(points))
    squares = (places**2).sum(axis=1) / 2
    for part in np.array_split(np.arange(len(points)), len(points) // 2000 + 1):  # 2,000 rows at a time
        distances = squares - points[part] @ places.T
        progress(part[0] / len(points))
        means[part] = logs[np.argpartition(distances, count - 1, axis=1)[:, :count]].mean(axis=1)
    return means


def _at_places(places: Floats, forces: Floats, law: Floats, same: float) -> tuple[Floats, Floats]:
    """Return distinct places (q, 3) [m] and the logarithm of the relative stiffness at each (q,).

    Pokes closer together than about `same` [m] are one measurement: a least-squares fit of forces (p,) to `law` (p,).
    """
    _, which, counts = np.unique(np.round(places / same), axis=0, return_inverse=True, return_counts=True)
    which = which.reshape(-1)
    ratio = np.bincount(which, weights=forces * law) / np.bincount(which, weights=law**2)
    return np.stack([np.bincount(which, weights=axis) / counts for axis in places.T], axis=1), np.log(ratio)


def _check(mesh: Mesh, pokes: Pokes) -> None:
    """Raise a DimpleError if the pokes are not near the surface."""
    sample = range(0, len(pokes.places), max(len(pokes.places) // 200, 1))
    points = np.concatenate([mesh.rest_positions[~mesh.loose], mesh.rest_positions[mesh.triangles].mean(axis=1)])
    away = np.array([math.sqrt(((points - pokes.places[i]) ** 2).sum(axis=1).min()) for i in sample])
    reach = _FAR * mesh.size + float(np.median(mesh.rest_lengths))
    if np.median(away) > reach:
        raise DimpleError(
            "The pokes lie {distance:.3g} mm from the surface. Their x, y and z must be positions on the object as "
            "it stands in the scene, at its physical size.",
            distance=1e3 * float(np.median(away)),
        )
