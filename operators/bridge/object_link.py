"""What joins an object to its session, and coordinates from one to the other.

A session lives in metres of the real object, on the axes and the origin of Blender's world: p = s M co, with M the
object's matrix and s its physical size over its size in the scene. What is kept here are numbers and session_uids,
never references into Blender's data, which an undo replaces.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.base import LARGEST, DimpleError

PART = 16384  # vertices
Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectLink:
    """What joins an object to its session."""

    uid: int  # of the object
    name: str  # of the object
    rest: Singles  # (N, 3) its final mesh at rest, bit for bit
    own: Singles  # (n, 3) the coordinates of its own mesh, bit for bit
    scale: float  # physical metres per scene unit
    matrix: Floats  # (4, 4) of the object at the start
    resting: Singles  # (N, 3) what a frame shows at rest [m]
    rounding: float  # what a vertex at rest may be off it [m]
    slots: tuple[int, ...]  # of the object's materials that the model has
    cuts: int = 0  # how often its final mesh is subdivided
    shaped: bool = False  # shape keys or modifiers make the final mesh of its own
    rigged: bool = False  # they hold it, or move it where it is pinned
    bones: Floats | None = None  # (b, 2, 3) ends of the bones that deform it, at the start [m]


def find(uid: int, name: str = "") -> bpy.types.Object | None:
    """Return the object with a session_uid, looked for first under the name it had."""
    named = bpy.data.objects.get(name)
    if named and named.session_uid == uid:
        return named
    return next((candidate for candidate in bpy.data.objects if candidate.session_uid == uid), None)


def get_points(points: Any, count: int, name: str) -> Singles:
    """Read coordinates (count, 3) from a collection of Blender's."""
    coordinates = np.empty(3 * count, np.float32)
    points.foreach_get(name, coordinates)
    return coordinates.reshape(-1, 3)


def check_matrix(name: str, matrix: Floats) -> None:
    """Raise a DimpleError when the matrix (4, 4) of an object has no inverse."""
    longest = np.linalg.norm(matrix[:3, :3], axis=0).max()
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix[:3, :3])) <= 1e-9 * longest**3:
        raise DimpleError(
            '"{name}" has a scale of 0, so it is flat or a point. Give it a scale in the sidebar.', name=name
        )


def to_physical(scale: float, matrix: Floats, local: npt.NDArray[Any]) -> Floats:
    """Return points (n, 3) of an object with a matrix as physical ones [m]."""
    return scale * (local.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])


def scale_of_body(scene: bpy.types.Scene, body: bpy.types.Object, rest: Singles, matrix: Floats) -> float:
    """Return physical metres per scene unit of a body with a shape at rest (N, 3).

    Raises:
        DimpleError: it has no size.
    """
    name, size = body.name, body.dimple.to_params()["size"]
    if not np.isfinite(rest).all():
        bad = np.flatnonzero(~np.isfinite(rest).all(axis=1))
        raise DimpleError(
            '"{name}": vertex {vertex} has a coordinate that is not a number ({count} such vertices). Delete or move '
            "them.",
            name=name, vertex=bad[0], count=len(bad)
        )  # fmt: skip
    check_matrix(name, matrix)
    axes = np.linalg.norm(matrix[:3, :3], axis=0)
    largest = float((np.array([np.ptp(along) for along in rest.T]) * axes).max())  # axis by axis is far faster
    if largest <= 0:
        raise DimpleError('"{name}": all vertices lie in one point. Give the mesh a size.', name=name)
    if size is not None and not size <= LARGEST:
        raise DimpleError(
            '"{name}": a Custom Size of {size:.3g} mm is too large. Lower it in Physics > Dimple.',
            name=name, size=1e3 * size
        )  # fmt: skip
    return float(scene.unit_settings.scale_length) if size is None else size / largest


def offsets_of(link: ObjectLink, matrix: Floats, rest: Singles, physical: Singles) -> Singles:
    """Return how far (N, 3) points of a session (N, 3) [m] are from the shape at rest (N, 3), in its object's space.

    Exactly 0 at rest, while the shape at rest is that of the start. Part by part, so that what is between stays in the
    cache.
    """
    as_begun = rest is link.rest and np.array_equal(matrix, link.matrix)
    # where a rig moves the shape at rest, that in double precision: rounded, it would be off by more than a vertex is
    resting = link.resting if as_begun else to_physical(link.scale, matrix, rest)
    turn = (np.linalg.inv(matrix)[:3, :3].T / link.scale).astype(resting.dtype)
    offsets = np.empty(resting.shape, np.float32)
    for begin in range(0, len(resting), PART):
        part = slice(begin, begin + PART)
        moved = physical[part] - resting[part]
        if as_begun:
            moved[(np.abs(moved) <= link.rounding).all(axis=1)] = 0.0
        offsets[part] = moved @ turn
    return offsets
