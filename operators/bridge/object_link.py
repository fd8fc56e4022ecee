"""The link between an object and its session, and the transformation of coordinates between them.

A session uses metres of the real object, with the axes and the origin of Blender's world: p = s M co, where M is the
object's matrix and s its physical size divided by its size in the scene. A link stores numbers and session_uids, never
references to Blender's data, which an undo replaces.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.base import LARGEST, DimpleError, Floats, Singles, row_parts


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectLink:
    """The link between an object and its session."""

    uid: int  # session_uid of the object
    name: str  # of the object
    rest: Singles  # (N, 3) coordinates of its final mesh at rest, bit for bit
    own: Singles  # (n, 3) coordinates of its own mesh, bit for bit
    scale: float  # physical metres per scene unit
    matrix: Floats  # (4, 4) of the object at the start
    resting: Singles  # (N, 3) positions in a frame at rest [m]
    rounding: float  # largest deviation from `resting` that counts as rounding [m]
    slots: tuple[int, ...]  # material slots of the object that the model uses
    cuts: int = 0  # number of subdivisions of its final mesh
    shaped: bool = False  # shape keys or modifiers change the shape at rest of its own mesh
    rigged: bool = False  # a rig places it, or it is pinned and deformed
    bones: Floats | None = None  # (b, 2, 3) ends of the bones that deform it, at the start [m]


def find(uid: int, name: str = "") -> bpy.types.Object | None:
    """Return the object with a session_uid, None if it is gone; the object with its last name is tried first."""
    named = bpy.data.objects.get(name)
    if named and named.session_uid == uid:
        return named
    return next((candidate for candidate in bpy.data.objects if candidate.session_uid == uid), None)


def get_points(points: Any, count: int, name: str) -> Singles:
    """Read coordinates (count, 3) from a collection of Blender data."""
    coordinates = np.empty(3 * count, np.float32)
    points.foreach_get(name, coordinates)
    return coordinates.reshape(-1, 3)


def check_matrix(name: str, matrix: Floats) -> None:
    """Raise a DimpleError if the matrix (4, 4) of an object has no inverse."""
    longest = np.linalg.norm(matrix[:3, :3], axis=0).max()
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix[:3, :3])) <= 1e-9 * longest**3:
        raise DimpleError(
            '"{name}" has a scale of 0, so it is flat or a point. Set its scale in the sidebar.', name=name
        )


def to_physical(scale: float, matrix: Floats, local: npt.NDArray[Any]) -> Floats:
    """Return points (n, 3) in the space of an object with a matrix as points of its session [m]."""
    return scale * (local.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3])


def scale_of_body(scene: bpy.types.Scene, body: bpy.types.Object, rest: Singles, matrix: Floats) -> float:
    """Return physical metres per scene unit of a body with a shape at rest (N, 3).

    Raises:
        DimpleError: its coordinates, scale or size cannot be used.
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
    largest = float((np.array([np.ptp(along) for along in rest.T]) * axes).max())  # much faster axis by axis
    if largest <= 0:
        raise DimpleError('"{name}": all vertices are at the same point. Move them apart.', name=name)
    if size is not None and not size <= LARGEST:
        raise DimpleError(
            '"{name}": a Custom Size of {size:.3g} mm is too large. Lower it in Physics > Dimple.',
            name=name, size=1e3 * size
        )  # fmt: skip
    return float(scene.unit_settings.scale_length) if size is None else size / largest


def offsets_of(link: ObjectLink, matrix: Floats, rest: Singles, physical: Singles) -> Singles:
    """Return the offsets (N, 3) of points of a session (N, 3) [m] from the shape at rest (N, 3), in its object's space.

    They are exactly 0 at rest while the shape at rest is that of the start. They are computed in parts, whose
    intermediate results stay in the cache.
    """
    as_begun = rest is link.rest and np.array_equal(matrix, link.matrix)
    # a shape at rest that a rig moves stays in double precision: rounding it would add spurious offsets
    resting = link.resting if as_begun else to_physical(link.scale, matrix, rest)
    turn = (np.linalg.inv(matrix)[:3, :3].T / link.scale).astype(resting.dtype)
    offsets = np.empty(resting.shape, np.float32)
    for part in row_parts(len(resting), 2):
        moved = physical[part] - resting[part]
        if as_begun:
            moved[(np.abs(moved) <= link.rounding).all(axis=1)] = 0.0
        offsets[part] = moved @ turn
    return offsets
