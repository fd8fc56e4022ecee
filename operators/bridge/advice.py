"""Advice on a body whose press may not be what the artist expects."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from ...core.message import Message
from ..reporting import Note
from . import modifier_kinds, press_modifier, sizing

if TYPE_CHECKING:
    from ...core.body.model import Model
    from ...core.mesh.surface import Mesh
    from .object_link import ObjectLink


def on_body(body: bpy.types.Object, mesh: Mesh, scene: bpy.types.Scene, link: ObjectLink) -> tuple[str, ...]:
    """Return advice on a body: its rig, effects of the scene that do not act, missing files, size and resolution."""
    notes, size = [], mesh.size
    if modifier_kinds.is_carried(body):
        notes.append(Note("A rig moves the body: its shape at rest follows the rig."))
    if any(each.field and each.field.type != "NONE" for each in scene.objects):
        notes.append(Note("Wind and other force fields of the scene do not act on the body."))
    for bake in filter(modifier_kinds.is_cache, body.modifiers):
        if not all(path.exists() for path, _ in press_modifier.files(bake)):
            notes.append(Message('The file that "{name}" plays is gone: bake again.', name=bake.name))
    for tip in sizing.fingertips(scene):
        if tip and (tip.hide_viewport or tip.name not in bpy.context.view_layer.objects):
            notes.append(
                Message('The fingertip "{name}" is disabled in the viewport, so it does not move.', name=tip.name)
            )
    radius, edge = scene.dimple.finger_radius_mm / 1e3, float(np.median(mesh.rest_lengths))
    if link.cuts:
        notes.append(Note(
            "The mesh is coarse for the fingertip: it is subdivided to {vertices:,} vertices.", vertices=len(link.rest)
        ))  # fmt: skip
    if radius < size / 100:
        notes.append(Message(
            "The body is {size:.3g} m across, over 100 times the radius of the fingertip. Set Physical Size to "
            "Custom Size in Physics > Dimple.",
            size=size
        ))  # fmt: skip
    elif edge > 2 * radius:
        notes.append(Message(
            "The edges of the mesh are {edge:.3g} mm long, and the fingertip is only {radius:.3g} mm wide. For a "
            "visible dent, subdivide the mesh or use a larger fingertip.",
            edge=1e3 * edge, radius=2e3 * radius
        ))  # fmt: skip
    return tuple(notes)


def on_sway(model: Model, wanted: tuple[float, float, float] | None) -> tuple[str, ...]:
    """Return a sentence if a body that should sway does not: it says why."""
    if not wanted or model.sway:
        return ()
    if not model.mesh.pressurable:
        return ("It cannot sway, because its mesh encloses no volume: close the mesh.",)
    return ("It does not sway, because nothing holds it: pin a part of it, or give it a rig.",)


def on_fill(model: Model) -> tuple[str, ...]:
    """Return a sentence on which fill acts, if the materials differ, or on a pressure that has no effect."""
    fills, inside = {(each.fill, each.pressure) for each in model.materials}, model.pressure
    if not model.mesh.pressurable and any(pressure for _, pressure in fills):
        return ("Pressure has no effect, because the mesh encloses no volume: close the mesh.",)
    if len(fills) < 2 or not model.mesh.pressurable:
        return ()
    return (Message(
        "Its materials differ in fill or pressure. Those of the largest area act: {fill}, {kpa:g} kPa.",
        fill=Message(inside.fill), kpa=inside.rest_pressure / 1e3
    ),)  # fmt: skip
