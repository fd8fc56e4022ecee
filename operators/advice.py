"""Notes for the artist before a press that may surprise."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

if TYPE_CHECKING:
    from ..core.body.model import Model
    from ..core.mesh.surface import Mesh

_MOVING = {"ARMATURE", "LATTICE", "CURVE", "MESH_DEFORM", "SURFACE_DEFORM", "HOOK", "SIMPLE_DEFORM", "DISPLACE"}


def on_body(body: bpy.types.Object, mesh: Mesh, scene: bpy.types.Scene) -> tuple[str, ...]:
    """Return sentences on what about a body may surprise the artist."""
    notes, size = [], mesh.size
    moving = [modifier.name for modifier in body.modifiers if modifier.type in _MOVING and modifier.show_viewport]
    if moving:
        notes.append(f'The modifier "{moving[0]}" moves the surface after the press: aim at the mesh before it.')
    radius, edge = scene.dimple.finger_radius_mm / 1e3, float(np.median(mesh.rest_lengths))
    if radius < size / 100:
        notes.append(
            f"The body is {size:.3g} m large and the fingertip tiny beside it. "
            "Set the size it stands for in Physics > Dimple."
        )
    elif edge > 2 * radius:
        notes.append(
            f"The edges of the mesh are {1e3 * edge:.3g} mm long, the fingertip {2e3 * radius:.3g} mm wide: "
            "subdivide the mesh, or take a larger fingertip, to see a dent and to trust the force."
        )
    return tuple(notes)


def on_fill(model: Model) -> tuple[str, ...]:
    """Return a sentence on which fill acts, where the materials of a closed body have several."""
    fills = sorted({material.fill for material in model.materials})
    if len(fills) < 2 or model.law_set == "paper" or not model.mesh.pressurable:
        return ()
    return (f"Its materials have different fills ({', '.join(fills)}): {model.pressure.fill} acts, on the most area.",)
