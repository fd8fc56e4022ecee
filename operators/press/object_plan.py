"""The choice between mesh and proxy for an object: the artist's, or the planner's within the scene's time budget."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import bpy

from ...core.background_work import Parts
from ...core.base import DimpleError
from ...core.constants import MAX_FINGERTIPS
from ...core.message import about, in_a_row, kept
from ...core.reduction.proxy_rule import Plan, plan, plan_full_mesh, plan_proxy
from ..bridge.object_link import find
from . import colliders

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...core.body.model import Model

CONTACT = 2.0  # [cost of a step without contact] cost of a step with a fifth of the vertices touching (dev.py contact)


def planning_for(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model) -> Parts:
    """Return the proxy of an object, None for the full mesh, in parts; the object's panel states the reason.

    Costs are computed, not timed, so a bake or a render farm makes the same choice as the preview.

    Raises:
        DimpleError: the object cannot be simulated as chosen.
    """
    uid, name, settings = obj.session_uid, obj.name, obj.dimple.to_plan()
    try:
        chosen = yield 0.6, partial(choosing(scene, obj), model)
    except DimpleError as error:
        way_out = ""
        if settings["simulated"] == "proxy" and not settings["self_contact"]:
            way_out = "Choose another number, or Automatic, in Physics > Dimple."
        raise DimpleError(about(name, in_a_row([str(error), way_out]))) from error
    if now := find(uid, name):  # an undo meanwhile may have replaced the object
        now.dimple.plan_reason = kept(chosen.reason)
    return chosen.proxy


def choosing(scene: bpy.types.Scene, obj: bpy.types.Object) -> Callable[[Model], Plan]:
    """Return a function that plans a model by the current settings of its object, and raises a DimpleError if no plan
    is possible.
    """
    wanted, (radius_mm, budget) = obj.dimple.to_plan(), around(scene, obj)
    radius = radius_mm / 1e3

    def by_settings(model: Model) -> Plan:
        because = "For self contact" if wanted["self_contact"] else ""  # cells may bridge a fold
        if because or wanted["simulated"] == "mesh":
            return plan_full_mesh(model, budget=budget, because=because or "As chosen")
        if wanted["simulated"] == "proxy":
            return plan_proxy(model, wanted["vertices"], radius=radius, budget=budget)
        return plan(model, radius=radius, budget=budget)

    return by_settings


def around(scene: bpy.types.Scene, obj: bpy.types.Object) -> tuple[float, float]:
    """Return what a plan depends on besides its object: the radius of the fingertips [mm], and the processor time per
    simulated second [s] for the object's steps, without the share of contact.

    Bodies at rest cost nothing, and no more than MAX_FINGERTIPS bodies are pressed at a time.
    """
    bodies = 1 + sum(each != obj and each.type == "MESH" and each.dimple.enabled for each in scene.objects)
    share = scene.dimple.frame_budget_percent / 100 / min(bodies, MAX_FINGERTIPS)
    return scene.dimple.finger_radius_mm, share / CONTACT if colliders.is_on(scene) else share
