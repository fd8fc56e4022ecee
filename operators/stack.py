"""Where among the modifiers of an object a press is, and what those before it do."""

from __future__ import annotations

import bpy

from .names import CACHE

# where these move the surface they hold it too: the body goes where they go
CARRYING = frozenset({"ARMATURE", "LATTICE", "CURVE", "MESH_DEFORM", "SURFACE_DEFORM", "HOOK"})
# these move vertices, or read them, and leave them as many as they are
_DEFORMING = CARRYING | {
    "CAST", "CORRECTIVE_SMOOTH", "DISPLACE", "LAPLACIANDEFORM", "LAPLACIANSMOOTH", "MESH_CACHE", "MESH_SEQUENCE_CACHE",
    "SHRINKWRAP", "SIMPLE_DEFORM", "SMOOTH", "VERTEX_WEIGHT_EDIT", "VERTEX_WEIGHT_MIX", "VERTEX_WEIGHT_PROXIMITY",
    "WARP", "WAVE",
}  # fmt: skip


def is_cache(modifier: bpy.types.Modifier) -> bool:
    """Tell whether a modifier plays a bake of ours."""
    return modifier.type == "MESH_CACHE" and modifier.name.startswith(CACHE)


def place_in_stack(body: bpy.types.Object) -> int:
    """Return where among the modifiers a press is: after those that shape the mesh, before those that add to it."""
    for place, modifier in enumerate(body.modifiers):
        if modifier.type not in _DEFORMING or is_cache(modifier):
            return place
    return len(body.modifiers)


def shaping(body: bpy.types.Object) -> list[bpy.types.Modifier]:
    """Return the modifiers that shape what is pressed."""
    return [each for each in body.modifiers[: place_in_stack(body)] if each.show_viewport]


def is_shaped(body: bpy.types.Object) -> bool:
    """Tell whether shape keys or modifiers make the shape at rest of the coordinates of a mesh."""
    return bool(body.data.shape_keys or shaping(body))


def is_carried(body: bpy.types.Object) -> bool:
    """Tell whether a rig holds an object: then it goes where that goes, pinned or not."""
    return any(each.type in CARRYING for each in shaping(body))
