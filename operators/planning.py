"""How an object is simulated: by its own choice, or by the planner's, kept with the object so that a bake moves
what the preview moved, and a farm what was sent to it (the same numpy; another may round and plan anew).
"""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING

import bpy

from ..core.base import DimpleError
from ..core.reduction.planner import Plan, mesh_itself, plan, stand_in
from ..core.reduction.proxy import build_proxy

if TYPE_CHECKING:
    from ..core.body.model import Model
    from ..core.reduction.proxy import Proxy


def proxy_for(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model) -> tuple[Proxy | None, str]:
    """Return the stand-in for an object, None where its mesh itself moves, and the reason if it was chosen just now.

    Raises:
        DimpleError: the stand-in that was asked for cannot be made.
    """
    settings, now = obj.dimple, key(scene, obj, model)
    if settings.plan_key == now:
        return build_proxy(model, settings.plan_vertices) if settings.plan_vertices else None, ""
    window = bpy.context.window  # none in the background
    if window:
        window.cursor_modal_set("WAIT")  # the presses that a choice goes by take some seconds
    try:
        chosen = choose(scene, obj, model)
    except DimpleError as error:
        way_out = " Choose another number, or Automatic, in Physics > Dimple." if settings.moves == "STAND_IN" else ""
        raise DimpleError(f'"{obj.name}": {str(error).rstrip(".")}.{way_out}') from error
    finally:
        if window:
            window.cursor_modal_restore()
    settings.plan_key, settings.plan_vertices, settings.plan_reason = now, chosen.asked, chosen.reason
    return chosen.proxy, f'"{obj.name}": {chosen.reason}' if chosen.proxy else ""


def choose(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model) -> Plan:
    """Return how an object is to be simulated."""
    wanted, radius, budget = obj.dimple.to_plan(), scene.dimple.finger_radius_mm / 1e3, budget_of(scene, obj)
    if wanted["moves"] == "mesh":
        return mesh_itself(model, budget=budget)
    if wanted["moves"] == "stand_in":
        return stand_in(model, wanted["vertices"], radius=radius, budget=budget)
    return plan(
        model, tolerance=wanted["tolerance"], force_tolerance=wanted["force_tolerance"], radius=radius, budget=budget
    )


def budget_of(scene: bpy.types.Scene, obj: bpy.types.Object) -> float:
    """Return an object's part of the time that the simulation may take [s of a second]: bodies share it evenly."""
    others = sum(each != obj and each.type == "MESH" and each.dimple.enabled for each in scene.objects)
    return scene.dimple.frame_budget_percent / 100 / (1 + others)


def key(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model) -> str:
    """Return what a choice depends on: the body with its materials, the tolerances, the fingertip, the budget."""
    law, number = model.matching, 0
    for array in (
        law.rest, model.mesh.triangles, model.mass, model.held, law.k1, law.k2, law.d0, law.damping,
        model.springs.stiffness, model.springs.damping, model.friction,
    ):  # fmt: skip
        number = zlib.crc32(array.tobytes(), number)
    around = (scene.dimple.finger_radius_mm, budget_of(scene, obj))
    words = (model.law_set, model.pressure.fill, *around, *obj.dimple.to_plan().values())
    return f"{zlib.crc32(repr(words).encode(), number):08x}"
