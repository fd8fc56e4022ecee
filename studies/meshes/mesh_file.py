"""Meshes from files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from core.base import DimpleError, Floats, Ints

SUFFIXES = (".obj", ".stl", ".ply", ".off", ".glb")


def load_triangles(path: str | Path) -> tuple[Floats, Ints]:
    """Read the vertices and triangles of a mesh as they are in a file.

    Raises:
        DimpleError: it cannot be read, or has no faces.
    """
    import trimesh

    if Path(path).suffix.lower() not in SUFFIXES:
        raise DimpleError(f"{path} is none of {', '.join(SUFFIXES)}. Export the mesh as one of them.")
    try:
        loaded = trimesh.load(str(path), force="mesh", process=False)
    except OSError as error:
        raise DimpleError(f"{path} cannot be read: {error.strerror or error}.") from None
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, NotImplementedError) as error:
        raise DimpleError(f"{path} is damaged, or no mesh: {error}.") from None
    if not isinstance(loaded, trimesh.Trimesh) or not len(loaded.faces):
        raise DimpleError(f"{path} has no faces, so there is nothing to press.")
    return np.asarray(loaded.vertices, np.float64), np.asarray(loaded.faces, np.int64)
