"""Classify the modifiers of an object, and find ours."""

from __future__ import annotations

from typing import Any

import bpy

from ..names import BAKED_PRESS, PRESS

# modifiers of a rig, which places the surface: the body follows it
CARRYING = frozenset({"ARMATURE", "LATTICE", "CURVE", "MESH_DEFORM", "SURFACE_DEFORM", "HOOK"})
# modifiers that move vertices and do not change their number
_DEFORMING = CARRYING | {
    "CAST", "CORRECTIVE_SMOOTH", "DISPLACE", "LAPLACIANDEFORM", "LAPLACIANSMOOTH", "MESH_CACHE", "MESH_SEQUENCE_CACHE",
    "SHRINKWRAP", "SIMPLE_DEFORM", "SMOOTH", "WARP", "WAVE",
}  # fmt: skip


def shows(modifier: bpy.types.Modifier, kind: str) -> bool:
    """Return whether a modifier is ours, with a node group whose name begins with `kind`."""
    return modifier.type == "NODES" and modifier.node_group is not None and modifier.node_group.name.startswith(kind)


def is_cache(modifier: bpy.types.Modifier) -> bool:
    """Return whether a modifier plays one of our bakes."""
    return shows(modifier, BAKED_PRESS)


def is_shaped(body: bpy.types.Object) -> bool:
    """Return whether shape keys or modifiers change the shape at rest of a mesh."""
    others = [each for each in body.modifiers if each.show_viewport and not shows(each, PRESS)]
    return bool(body.data.shape_keys) or bool(others)


def is_deformed(body: bpy.types.Object) -> bool:
    """Return whether shape keys or deforming modifiers move the vertices of a mesh."""
    return bool(body.data.shape_keys) or any(each.type in _DEFORMING and each.show_viewport for each in body.modifiers)


def bones_of(body: bpy.types.Object) -> list[tuple[Any, Any]]:
    """Return head and tail, in the scene, of each bone that deforms an object."""
    rigs = [each.object for each in body.modifiers if each.type == "ARMATURE" and each.show_viewport and each.object]
    return [
        (rig.matrix_world @ bone.head, rig.matrix_world @ bone.tail)
        for rig in rigs for bone in rig.pose.bones if bone.bone.use_deform
    ]  # fmt: skip


def is_carried(body: bpy.types.Object) -> bool:
    """Return whether a rig places an object: then the body follows it, pinned or not."""
    return any(each.type in CARRYING and each.show_viewport for each in body.modifiers)
