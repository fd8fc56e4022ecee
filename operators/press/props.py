"""Props in the scene: shown where they have fallen, and put back exactly when the last session ends."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from mathutils import Matrix

from ..bridge import object_link
from ..bridge.keyframes import curve_bags

if TYPE_CHECKING:
    from .colliders import LiveWorld

Poses = dict[int, list[tuple[int, Matrix]]]  # by session_uid: frames and matrices in the scene
fallen: dict[int, tuple[str, Matrix]] = {}  # the moved props, by session_uid: name and original basis matrix


def show(live: LiveWorld) -> None:
    """Move the objects of a world's props to where the simulation has them."""
    for index, (uid, name, start) in live.props.items():
        obj = object_link.find(uid, name)
        if obj is None:
            continue
        fallen.setdefault(uid, (name, obj.matrix_basis.copy()))
        pose = Matrix(live.world.props[index].pose().tolist())
        pose.translation /= live.scale
        obj.matrix_world = pose @ start


def put_back(*, forget: bool = True) -> None:
    """Put all props back to where they were before anything ran.

    Args:
        forget: the props have ended; else `show` moves them again.
    """
    for uid, (name, basis) in fallen.items():
        if obj := object_link.find(uid, name):
            obj.matrix_basis = basis
    if forget:
        fallen.clear()


def note(live: LiveWorld, frame: int, poses: Poses) -> None:
    """Add the poses of a world's props at a frame."""
    for uid, name, _ in live.props.values():
        if obj := object_link.find(uid, name):
            poses.setdefault(uid, []).append((frame, obj.matrix_world.copy()))


def keyframe(poses: Poses) -> None:
    """Keyframe the poses of props at each frame of a bake, in place of all their keyframes of location and rotation."""
    for uid, way in poses.items():
        obj = object_link.find(uid)
        if obj is None:
            continue
        paths = ("location", _turn(obj))
        for bag in curve_bags(obj):
            for curve in [each for each in bag.fcurves if each.data_path in paths]:
                bag.fcurves.remove(curve)
        for frame, matrix in way:
            obj.matrix_world = matrix
            for path in paths:
                obj.keyframe_insert(path, frame=frame)


def _turn(obj: bpy.types.Object) -> str:
    kinds = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}
    return kinds.get(obj.rotation_mode, "rotation_euler")
