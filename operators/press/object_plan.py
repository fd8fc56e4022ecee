"""How an object is simulated: as the artist chose, or as the planner did.

The choice is kept with the object, so that a bake simulates what the preview did, and a render farm what was sent to
it. Another version of numpy may round differently and plan again.
"""

from __future__ import annotations

import zlib
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import bpy
import numpy as np

from ...core.base import DimpleError
from ...core.constants import MAX_FINGERTIPS
from ...core.messages import about, in_a_row, kept, read
from ...core.reduction.proxy import build_proxy, mean_spacing, painted, with_constants
from ...core.reduction.proxy_rule import Maker, Plan, plan, plan_full_mesh, plan_proxy
from ...core.steps import Parts
from . import colliders

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...core.body.model import Model
    from ...core.mesh.surface import Mesh
    from ...core.reduction.proxy import Proxy

CONTACT = 2.0  # times a step alone: with a fifth of the vertices touching (dev.py contact)
KEPT = 4  # choices: bodies that are alike are planned once


class Choice(NamedTuple):
    """What was chosen for a body: its proxy, the vertices it was made with (0 for the full mesh), and why."""

    proxy: Proxy | None
    vertices: int
    reason: str


_choices: dict[str, Choice] = {}
_moving: list[tuple[Mesh, Proxy | None]] = []  # the choices for the last meshes, whatever their materials


def planning_for(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model, moving: Proxy | None = None) -> Parts:
    """Return the proxy of an object, None for the full mesh; in parts.

    Args:
        moving: what moves in place of this very model already.

    Raises:
        DimpleError: the proxy that was asked for cannot be made.
    """
    settings, now = obj.dimple, key(scene, obj, model)
    build = partial(_proxy, moving)
    known, old = settings.plan_key == now, _choices.get(now)
    if old:
        proxy = with_constants(old.proxy, model) if old.proxy else None  # gravity and ground are its own
        made = old._replace(proxy=proxy)
    elif known:
        vertices = settings.plan_vertices
        proxy = (yield 0.6, partial(build, model, vertices)) if vertices else None
        made = Choice(proxy, vertices, read(settings.plan_reason))
    else:
        try:
            chosen = yield 0.6, partial(choosing(scene, obj), model, build)
        except DimpleError as error:
            way_out = ""
            if settings.simulated == "PROXY" and not settings.self_contact:
                way_out = "Choose another number, or Automatic, in Physics > Dimple."
            raise DimpleError(about(obj.name, in_a_row([str(error), way_out]))) from error
        made = Choice(chosen.proxy, chosen.asked, chosen.reason)
    _choices[now] = made
    _moving[:] = [(model.mesh, made.proxy), *_moving[: KEPT - 1]]
    while len(_choices) > KEPT:
        del _choices[next(iter(_choices))]
    settings.plan_key, settings.plan_vertices, settings.plan_reason = now, made.vertices, kept(made.reason)
    return made.proxy


def _proxy(moving: Proxy | None, model: Model, vertices: int) -> Proxy:
    """Return a proxy of a model; one of as many vertices that such a mesh, painted so, had before only needs other
    constants.

    Raises:
        DimpleError: it cannot be made.
    """
    spacing, stiffer = mean_spacing(model.mesh, vertices), painted(model)

    def is_it(proxy: Proxy) -> bool:
        return proxy.spacing == spacing and np.array_equal(proxy.painted, stiffer)

    if moving and is_it(moving):
        return moving
    for mesh, proxy in [*_moving]:
        if proxy and is_it(proxy) and _are_alike(mesh, model.mesh):
            return with_constants(proxy, model)
    return build_proxy(model, vertices)


def _are_alike(mesh: Mesh, other: Mesh) -> bool:
    pairs = (mesh.rest_positions, other.rest_positions), (mesh.triangles, other.triangles)
    return mesh is other or all(np.array_equal(*pair) for pair in pairs)


def choosing(scene: bpy.types.Scene, obj: bpy.types.Object) -> Callable[[Model, Maker], Plan]:
    """Return what plans a model by the settings that its object has now; it raises a DimpleError where nothing can be
    simulated.
    """
    wanted, radius, budget = obj.dimple.to_plan(), scene.dimple.finger_radius_mm / 1e3, budget_of(scene, obj)
    itself = obj.dimple.self_contact

    def by_settings(model: Model, build: Maker) -> Plan:
        because = "For self contact" if itself else ""  # cells may bridge a fold
        if because or wanted["simulated"] == "mesh":
            return plan_full_mesh(model, budget=budget, because=because or "As chosen")
        if wanted["simulated"] == "proxy":
            return plan_proxy(model, wanted["vertices"], radius=radius, budget=budget, build=build)
        return plan(model, radius=radius, budget=budget, build=build)

    return by_settings


def budget_of(scene: bpy.types.Scene, obj: bpy.types.Object) -> float:
    """Return the processor time [s] per second for the steps of one object, contact apart: at rest the others cost
    nothing, and no more than MAX_FINGERTIPS are pressed at a time.
    """
    bodies = 1 + sum(each != obj and each.type == "MESH" and each.dimple.enabled for each in scene.objects)
    share = scene.dimple.frame_budget_percent / 100 / min(bodies, MAX_FINGERTIPS)
    return share / CONTACT if colliders.is_on(scene) else share


class Around(NamedTuple):
    """What the plan of an object depends on besides its model: the fingertip's radius [mm], the budget, and whether
    anything meets, and it itself.
    """

    radius_mm: float
    budget: float
    meets: bool
    itself: bool


def around(scene: bpy.types.Scene, obj: bpy.types.Object) -> Around:
    """Return the inputs of a plan besides the model."""
    budget = budget_of(scene, obj)
    return Around(scene.dimple.finger_radius_mm, budget, colliders.is_on(scene), obj.dimple.self_contact)


def key(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model) -> str:
    """Return a checksum of the inputs of a plan: body, materials, fingertips and budget."""
    law, number = model.matching, 0
    for array in (
        law.rest, model.mesh.triangles, model.mass, model.pinned, law.k1, law.k2, law.d0, law.damping, law.tension,
        model.springs.stiffness, model.springs.damping, model.friction, model.compliance,
    ):  # fmt: skip
        number = zlib.crc32(np.ascontiguousarray(array), number)
    words = (model.pressure.fill, model.rigged, *around(scene, obj), *obj.dimple.to_plan().values())
    return f"{zlib.crc32(repr(words).encode(), number):08x}"
