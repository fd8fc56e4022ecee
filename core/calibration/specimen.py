"""What is pressed where there is no Blender: a cube, or a mesh from a file, in the size of the real object."""

from __future__ import annotations

from pathlib import Path

from ..base import DimpleError
from ..mesh import Mesh, mesh_from_triangles

SUFFIXES = (".obj", ".stl", ".ply")
_HALVINGS = 4  # of a cube's edges: 1538 vertices


def cube(edge: float, *, halvings: int = _HALVINGS) -> Mesh:
    """Return a cube of an edge [m]: 386 vertices by 3 halvings of its edges, 1538 by 4, 6146 by 5."""
    import trimesh

    box = trimesh.creation.box((edge, edge, edge))
    for _ in range(halvings):
        box = box.subdivide()
    return mesh_from_triangles(box.vertices, box.faces)


def load_mesh(path: str | Path, size: float) -> Mesh:
    """Read a mesh, z up, and scale its longest side to a size [m].

    Raises:
        DimpleError: it cannot be read or pressed.
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
    rough = mesh_from_triangles(loaded.vertices, loaded.faces)
    return mesh_from_triangles(loaded.vertices * (size / rough.size), loaded.faces)
