"""What joins an object to its session, and coordinates from one to the other. Part of the bridge.

A session lives in metres of the real object, on the axes and the origin of Blender's world: p = s M co, with M the
object's matrix and s its physical size over its size in the scene. What is kept here are numbers and session_uids,
never references into Blender's data, which an undo replaces.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..core.base import DimpleError

if TYPE_CHECKING:
    from ..core.mesh.refine import Refinement

PART = 16384  # vertices
Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectLink:
    """What joins an object to its session.

    uid, name: of the object.
    rest: (N, 3) its coordinates at rest, bit for bit.
    scale: physical metres per scene unit.
    matrix: (4, 4) of the object at the start.
    resting: (N, 3) what a frame shows at rest [m].
    rounding: what a vertex at rest may be off it [m].
    slots: of the object's materials that the model has.
    refined: how the surface that is pressed was cut finer than the object's own; None where it was not.
    shaped: shape keys or modifiers make its shape at rest of the coordinates of its mesh.
    follows: that shape can be read at every frame.
    carried: a rig holds it.
    """

    uid: int
    name: str
    rest: Singles
    scale: float
    matrix: Floats
    resting: Singles
    rounding: float
    slots: tuple[int, ...]
    refined: Refinement | None = None
    shaped: bool = False
    follows: bool = True
    carried: bool = False


def get_points(points: Any, count: int, name: str) -> Singles:
    """Read coordinates (count, 3) from a collection of Blender's."""
    coordinates = np.empty(3 * count, np.float32)
    points.foreach_get(name, coordinates)
    return coordinates.reshape(-1, 3)


def check_matrix(name: str, matrix: Floats) -> None:
    """Raise a DimpleError when the matrix (4, 4) of an object has no inverse."""
    longest = np.linalg.norm(matrix[:3, :3], axis=0).max()
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix[:3, :3])) <= 1e-9 * longest**3:
        raise DimpleError(f'"{name}" has a scale of 0, so it is flat or a point. Give it a scale in the sidebar.')


def to_physical(scale: float, matrix: Floats, local: npt.NDArray[Any]) -> Floats:
    """Return points (n, 3) of an object with a matrix as physical ones [m]."""
    return scale * (local.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])


def places(link: ObjectLink, matrix: Floats, rest: Singles) -> Floats:
    """Return where every input vertex of a session (n, 3) [m] is at rest, with its object there in a shape (N, 3)."""
    points = to_physical(link.scale, matrix, rest)
    return link.refined.at_vertices(points) if link.refined else points


def offsets_of(link: ObjectLink, matrix: Floats, rest: Singles, physical: Singles) -> Singles:
    """Return how far (N, 3) points of a session (n, 3) [m] are from the shape at rest (N, 3), in its object's space.

    Part by part, so that what is between stays in the cache: a sixth of the time of `to_local`.
    """
    as_begun = rest is link.rest and np.array_equal(matrix, link.matrix)
    # where a rig moves the shape at rest, that in double precision: rounded, it would be off by more than a vertex is
    resting = link.resting if as_begun else to_physical(link.scale, matrix, rest)
    turn = (np.linalg.inv(matrix)[:3, :3].T / link.scale).astype(resting.dtype)
    offsets = np.empty(resting.shape, np.float32)
    for begin in range(0, len(resting), PART):
        part = slice(begin, begin + PART)
        moved = physical[: len(resting)][part] - resting[part]
        if as_begun:
            moved[(np.abs(moved) <= link.rounding).all(axis=1)] = 0.0
        offsets[part] = moved @ turn
    return offsets


def to_local(link: ObjectLink, matrix: Floats, rest: Singles, physical: Singles) -> Singles:
    """Return the points of a session (n, 3) [m] as coordinates (N, 3) of its object.

    Vertices at rest get their very bits back while the shape at rest (N, 3) is that of the start. Of a surface that
    was cut finer the object's own come first.
    """
    physical = physical[: len(link.rest)]
    inverse = np.linalg.inv(matrix)
    local = (physical @ (inverse[:3, :3].T / link.scale) + inverse[:3, 3]).astype(np.float32)
    if rest is link.rest and np.array_equal(matrix, link.matrix):
        x, y, z = (np.abs(physical - link.resting) <= link.rounding).T
        resting = np.flatnonzero(x & y & z)
        local[resting] = link.rest[resting]
    return local
