"""Keep identifications in a folder, each under a name made of everything it was found from.

A name stands for one mesh, material, tip, place and depth, bit for bit, so what is kept under it never goes stale. Mass
and damping are no part of it: the press waits for rest, with a mass and a damping of its own.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from ..base import Bools, DimpleError, Floats
from ..material import Indenter, Material, ModelConstants
from ..mesh.surface import Mesh
from .identify import Identification

VERSION = 12  # of the method: another one identifies anew


def key(mesh: Mesh, material: Material, indenter: Indenter, deepest: float, *where: Floats | Bools) -> str:
    """Return a name for what is identified.

    Args:
        where: what the tip is put at a place by, or finds its own by.
    """
    at_rest = asdict(replace(material, constants=None, mass=1.0, density=None, damping_ratio=1.0))
    del at_rest["pressure"]  # the press is without
    numbers = at_rest | asdict(indenter) | {"deepest": deepest, "version": VERSION}
    digest = hashlib.sha256(json.dumps(numbers, sort_keys=True).encode())
    for array in (mesh.rest_positions, mesh.triangles, *where):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:32]


def remember(folder: str | Path, name: str, found: Identification) -> None:
    """Write an identification into a folder.

    Raises:
        DimpleError: the folder cannot be written.
    """
    record = asdict(found) | {name: getattr(found, name).tolist() for name in _ARRAYS}
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        (Path(folder) / f"{name}.json").write_text(json.dumps(record), encoding="utf-8")
    except OSError as error:
        raise DimpleError(f"{folder} cannot be written: {error.strerror or error}.") from None


def recall(folder: str | Path, name: str) -> Identification | None:
    """Return a remembered identification, None where there is none that can be read."""
    try:
        record = json.loads((Path(folder) / f"{name}.json").read_text(encoding="utf-8"))
        given = record["material"]
        constants = given["constants"] | {"pieces": tuple(map(tuple, given["constants"]["pieces"]))}
        indenter = Indenter(**given["indenter"])
        material = Material(**given | {"constants": ModelConstants(**constants), "indenter": indenter})
        arrays = {name: np.array(record[name], np.float64) for name in _ARRAYS}
        return Identification(**record | arrays | {"material": material, "notes": tuple(record["notes"])})
    except (OSError, ValueError, KeyError, TypeError):  # lost or damaged: identify again
        return None


_ARRAYS = ("depths", "wanted", "simulated")
