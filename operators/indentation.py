"""What a virtual indentation presses: the body in its real size, the tip that measured it, and the place."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from ..core.base import DimpleError
from ..core.calibration.indent import Site, find_site
from ..core.calibration.place import measuring_site
from ..core.material import Indenter
from . import bridge, bridge_model, calibration
from .names import MAPS

if TYPE_CHECKING:
    from ..core.material import Material
    from ..core.mesh.surface import Mesh
    from .bridge import Floats, ObjectLink


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """A body that is to be pressed.

    link: to its object.
    mesh: in its real size [m].
    uid: session_uid of its material.
    material: constants of that material.
    fingerprint: what the model constants that are found depend on.
    indenter: the tip.
    site: where the tip goes in.
    deepest: how deep it goes [m].
    notes: messages for the artist.
    """

    link: ObjectLink
    mesh: Mesh
    uid: int
    material: Material
    fingerprint: dict[str, float | str]
    indenter: Indenter
    site: Site
    deepest: float
    notes: tuple[str, ...]


def set_up(
    context: bpy.types.Context,
    body: bpy.types.Object,
    place: str,
    depth_mm: float,
    tip: Indenter | None = None,
    *,
    identify: str = "WAIT",
) -> Bench:
    """Prepare a body to be pressed; change nothing.

    Args:
        body: a mesh object with a material.
        place: "TOP", straight down on the middle, or "CURSOR", where the 3D cursor is nearest to the surface.
        depth_mm: 0 is as deep as the material was measured.
        tip: None is the one that measured the material.
        identify: as for `bridge.read_body`.

    Raises:
        DimpleError: it cannot be pressed there, with the reason and what to do.
    """
    material = body.active_material
    if material is None:
        raise DimpleError(f'"{body.name}" has no material. Give it one: calibrate, or choose one of the presets.')
    link, model = bridge.read_body(context, body, baked=False, identify=identify)
    settings, mesh = material.dimple, model.mesh
    tip = tip or Indenter(shape=settings.tip.lower(), radius=settings.tip_radius_mm / 1e3)
    pinned = model.pinned[mesh.source]
    slot = link.slots.index(body.active_material_index) if body.active_material_index in link.slots else None
    constants = bridge_model.constants_on(mesh, material) if slot is None else model.materials[slot]
    measured = calibration.deepest(settings, constants.x0)
    try:
        if place == "TOP":
            site = measuring_site(mesh, replace(constants, indenter=tip), measured, pinned=pinned)
        else:
            above, inward = _at_cursor(context, link, mesh)
            site = find_site(mesh, tip, pinned=pinned, above=above, inward=inward)
    except DimpleError as error:
        elsewhere = " Press At: 3D Cursor puts the tip elsewhere." if place == "TOP" else ""
        raise DimpleError(f'"{body.name}": {error}{elsewhere}') from error
    return Bench(
        link=link,
        mesh=mesh,
        uid=material.session_uid,
        material=constants,
        fingerprint=calibration.fingerprint(settings, mesh),
        indenter=tip,
        site=site,
        deepest=depth_mm / 1e3 or measured,
        notes=_notes(body),
    )


def find_material(uid: int) -> bpy.types.Material:
    """Return the material with a session_uid.

    Raises:
        DimpleError: it is gone.
    """
    found = next((each for each in bpy.data.materials if each.session_uid == uid), None)
    if found is None:
        raise DimpleError("The material is gone, so nothing was written.")
    return found


def _at_cursor(context: bpy.types.Context, link: ObjectLink, mesh: Mesh) -> tuple[Floats, Floats]:
    """Return the point (3,) [m] of the surface nearest to the 3D cursor, and the way in."""
    from mathutils.bvhtree import BVHTree

    cursor = link.scale * np.array(context.scene.cursor.location)
    tree = BVHTree.FromPolygons(mesh.rest_positions.tolist(), mesh.triangles.tolist())
    point, normal, _, _ = tree.find_nearest(cursor.tolist())
    return np.array(point), -np.array(normal)


def _notes(body: bpy.types.Object) -> tuple[str, ...]:
    notes = []
    if len({slot.material for slot in body.material_slots}) > 1:
        notes.append("The object has several materials: it was pressed as if all of it were the active one.")
    if any(getattr(body.dimple, f"{name}_group") for name, _, _ in MAPS):
        notes.append("The object has painted constants: it was pressed as if nothing were painted.")
    return tuple(notes)


def described(bench: Bench) -> dict[str, Any]:
    """Return what was pressed, as a part of a record; lengths in mm."""
    return {
        "object": bench.link.name, "tip": bench.indenter.shape, "tip_radius": 1e3 * bench.indenter.radius,
        "size": 1e3 * bench.mesh.size, "fingerprint": bench.fingerprint,
    }  # fmt: skip
