"""How an object is simulated: as the artist chose, or as the planner did.

The choice is kept with the object, so that a bake simulates what the preview did, and a render farm what was sent to
it. Another version of numpy may round differently and plan again.
"""

from __future__ import annotations

import math
import time
import zlib
from collections.abc import Callable
from typing import TYPE_CHECKING

import bpy

from ..core.base import DimpleError
from ..core.reduction.planner import Plan, plan, plan_full_mesh, plan_proxy
from ..core.reduction.proxy import build_proxy
from . import contact

if TYPE_CHECKING:
    from ..core.body.model import Model
    from ..core.reduction.proxy import Proxy

USUAL_S = 2.0  # [s] that planning takes, about: nobody knows beforehand how many presses it needs


def proxy_for(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model) -> tuple[Proxy | None, str]:
    """Return the proxy of an object, None for the full mesh, and the reason where the choice is new.

    Raises:
        DimpleError: the proxy that was asked for cannot be made.
    """
    if contact.is_on(scene):
        return None, ""
    settings, now = obj.dimple, key(scene, obj, model)
    if settings.plan_key == now:
        return build_proxy(model, settings.plan_vertices) if settings.plan_vertices else None, ""
    manager = bpy.context.window_manager
    manager.progress_begin(0, 100)  # the presses of the planner take some seconds
    try:
        chosen = choose(scene, obj, model)
    except DimpleError as error:
        way_out = " Choose another number, or Automatic, in Physics > Dimple." if settings.simulated == "PROXY" else ""
        raise DimpleError(f'"{obj.name}": {str(error).rstrip(".")}.{way_out}') from error
    finally:
        manager.progress_end()
    settings.plan_key, settings.plan_vertices, settings.plan_reason = now, chosen.asked, chosen.reason
    return chosen.proxy, f'"{obj.name}": {chosen.reason}' if chosen.proxy else ""


def choose(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model) -> Plan:
    """Plan how an object is simulated, by its settings."""
    wanted, radius, budget = obj.dimple.to_plan(), scene.dimple.finger_radius_mm / 1e3, budget_of(scene, obj)
    if wanted["simulated"] == "mesh":
        return plan_full_mesh(model, budget=budget)
    if wanted["simulated"] == "proxy":
        return plan_proxy(model, wanted["vertices"], radius=radius, budget=budget)
    return plan(
        model, tolerance=wanted["tolerance"], force_tolerance=wanted["force_tolerance"], radius=radius, budget=budget,
        watch=_ticking(),
    )  # fmt: skip


def _ticking() -> Callable[[], None]:
    """Return what shows at the pointer how much of the usual time has gone by."""
    began, manager = time.perf_counter(), bpy.context.window_manager

    def tick() -> None:
        manager.progress_update(round(100 * (1 - math.exp(-(time.perf_counter() - began) / USUAL_S))))

    return tick


def budget_of(scene: bpy.types.Scene, obj: bpy.types.Object) -> float:
    """Return the processor time [s] per second for one object: all bodies of the scene share it evenly."""
    others = sum(each != obj and each.type == "MESH" and each.dimple.enabled for each in scene.objects)
    return scene.dimple.frame_budget_percent / 100 / (1 + others)


def key(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model) -> str:
    """Return a checksum of what the plan depends on: body, materials, tolerances, fingertip and budget."""
    law, number = model.matching, 0
    for array in (
        law.rest, model.mesh.triangles, model.mass, model.held, law.k1, law.k2, law.d0, law.damping, law.tension,
        law.more, law.knees, model.springs.stiffness, model.springs.damping, model.friction,
    ):  # fmt: skip
        number = zlib.crc32(array.tobytes(), number)
    around = (scene.dimple.finger_radius_mm, budget_of(scene, obj))
    words = (model.law_set, model.pressure.fill, *around, *obj.dimple.to_plan().values())
    return f"{zlib.crc32(repr(words).encode(), number):08x}"
