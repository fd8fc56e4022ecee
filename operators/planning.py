"""How an object is simulated: as the artist chose, or as the planner did.

The choice is kept with the object, so that a bake simulates what the preview did, and a render farm what was sent to
it. Another version of numpy may round differently and plan again.
"""

from __future__ import annotations

import math
import zlib
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import bpy
import numpy as np

from ..core.base import DimpleError
from ..core.reduction.contact import in_contact
from ..core.reduction.decision import decide
from ..core.reduction.grading import share_of
from ..core.reduction.planner import Maker, Plan, carry_out, plan_full_mesh, plan_proxy
from ..core.reduction.proxy import build_proxy, mean_spacing, painted, with_constants
from ..core.session import MAX_FINGERS
from ..core.steps import Parts, at_once
from . import contact, timeline

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..core.body.model import Model
    from ..core.mesh.surface import Mesh
    from ..core.reduction.grading import Pressed
    from ..core.reduction.proxy import Proxy
    from ..core.session import Session

CONTACT = 2.0  # times a step alone: with a fifth of the vertices touching (dev.py contact)
HASTE = 1.01  # times as fast as the paths say: more is another motion
KEPT = 4  # choices: bodies that are alike are planned once


class Choice(NamedTuple):
    """What was chosen for a body: its proxy, the vertices it was made with (0 for the full mesh), why, how many times
    faster than its fingertips it is simulated, and how little moves what rests [m].
    """

    proxy: Proxy | None
    vertices: int
    reason: str
    faster: int = 1
    slack: float = 0.0


_choices: dict[str, Choice] = {}
_moving: list[tuple[Mesh, Proxy | None]] = []  # what was chosen for the last meshes, whatever their materials are


def proxy_for(
    scene: bpy.types.Scene,
    obj: bpy.types.Object,
    model: Model,
    moving: Proxy | None = None,
    pressed: Pressed | None = None,
) -> tuple[Proxy | None, str]:
    """Return the proxy of an object, None for the full mesh, and the reason where the choice is new.

    Args:
        moving: what moves in place of this very model already.
        pressed: where the fingertips will press, if that is known.

    Raises:
        DimpleError: the proxy that was asked for cannot be made.
    """
    found: tuple[Proxy | None, str] = at_once(planning_for(scene, obj, model, moving, pressed))
    return found


def planning_for(
    scene: bpy.types.Scene,
    obj: bpy.types.Object,
    model: Model,
    moving: Proxy | None = None,
    pressed: Pressed | None = None,
) -> Parts:
    """Plan an object in parts; see `proxy_for`."""
    settings, now = obj.dimple, key(scene, obj, model, pressed)
    build = partial(_proxy, moving, records=(settings.plan_cells, settings.plan_cells_graded))
    known, old = settings.plan_key == now, _choices.get(now)
    if old:
        proxy = with_constants(old.proxy, model) if old.proxy else None  # gravity and ground are its own
        made = old._replace(proxy=proxy)
    elif known:
        vertices = settings.plan_vertices
        fine = pressed.where if pressed and settings.plan_graded else None
        proxy = (yield 0.6, partial(build, model, vertices, fine)) if vertices else None
        made = Choice(proxy, vertices, settings.plan_reason, settings.plan_faster, settings.plan_slack)
    else:
        try:
            reason, make = choosing(scene, obj, pressed)(model)
            settings.plan_key, settings.plan_reason = "", reason  # to be read while a proxy is made
            chosen = yield 0.6, partial(make, build)
        except DimpleError as error:
            way_out = ""
            if settings.simulated == "PROXY" and not settings.self_contact:
                way_out = " Choose another number, or Automatic, in Physics > Dimple."
            raise DimpleError(f'"{obj.name}": {str(error).rstrip(".")}.{way_out}') from error
        made = Choice(chosen.proxy, chosen.asked, chosen.reason, chosen.faster, chosen.slack)
    _choices[now] = made
    _moving[:] = [(model.mesh, made.proxy), *_moving[: KEPT - 1]]
    while len(_choices) > KEPT:
        del _choices[next(iter(_choices))]
    settings.plan_key, settings.plan_vertices, settings.plan_reason = now, made.vertices, made.reason
    settings.plan_faster, settings.plan_slack = made.faster, made.slack
    settings.plan_graded = bool(made.proxy and made.proxy.pressed)
    # a poke and a play by keyframes keep one each
    name = "plan_cells_graded" if (made.proxy.pressed if made.proxy else pressed) else "plan_cells"
    record = made.proxy.record if made.proxy else ""
    if getattr(settings, name) != record:
        setattr(settings, name, record)
    return made.proxy, f'"{obj.name}": {made.reason}' if made.proxy and not known else ""


def follow(
    scene: bpy.types.Scene, obj: bpy.types.Object, session: Session, pressed: Pressed | None = None
) -> None:
    """Let a session be simulated as its object was planned.

    Args:
        pressed: what it was planned for.
    """
    session.set_slack(obj.dimple.plan_slack)
    set_clock(scene, session, obj.dimple.plan_faster, pressed)


def set_clock(scene: bpy.types.Scene, session: Session, faster: int = 1, pressed: Pressed | None = None) -> None:
    """Let the body of a session be simulated some times faster than fingertips that press slowly, as it was planned.

    Args:
        pressed: what it was planned for.
    """
    if faster > 1 or session.clock.faster > 1:
        slow = HASTE * pressed.speed if pressed else math.inf
        session.set_clock(timeline.tick_s(scene, faster), faster=faster, slow=slow)


def _proxy(
    moving: Proxy | None,
    model: Model,
    vertices: int,
    pressed: Pressed | None = None,
    *,
    records: tuple[str, str] = ("", ""),
) -> Proxy:
    """Return a proxy of a model; one of as many vertices that such a mesh, painted so and pressed there, had before
    only needs other constants, and of those that the file was saved with there are records.

    Args:
        records: of the even and of the graded one.

    Raises:
        DimpleError: it cannot be made.
    """
    spacing = mean_spacing(model.mesh, vertices / (share_of(model.mesh, pressed) if pressed else 1.0))
    stiffer = painted(model)

    def is_it(proxy: Proxy) -> bool:
        same = proxy.spacing == spacing and proxy.pressed == pressed
        return same and np.array_equal(proxy.painted, stiffer)

    if moving and is_it(moving):
        return moving
    for mesh, proxy in [*_moving]:
        if proxy and is_it(proxy) and _are_alike(mesh, model.mesh):
            return with_constants(proxy, model)
    return build_proxy(model, vertices, pressed, records[bool(pressed)])


def _are_alike(mesh: Mesh, other: Mesh) -> bool:
    pairs = (mesh.rest_positions, other.rest_positions), (mesh.triangles, other.triangles)
    return mesh is other or all(np.array_equal(*pair) for pair in pairs)


def choosing(
    scene: bpy.types.Scene, obj: bpy.types.Object, pressed: Pressed | None = None
) -> Callable[[Model], tuple[str, Callable[[Maker], Plan]]]:
    """Return what decides how a model is simulated, by the settings that its object has now.

    That returns why, "" where the settings say it, and what makes it; it raises a DimpleError where nothing can be
    simulated.
    """
    wanted, radius, budget = obj.dimple.to_plan(), scene.dimple.finger_radius_mm / 1e3, budget_of(scene, obj)
    tolerance, force_tolerance = wanted["tolerance"], wanted["force_tolerance"]
    meets, itself = contact.is_on(scene), obj.dimple.self_contact

    def by_settings(model: Model) -> tuple[str, Callable[[Maker], Plan]]:
        # cells may bridge a fold; and what carries the skin of a proxy knows one shape at rest
        because = "For self contact" if itself else "For its rig" if model.rigged else ""
        if wanted["simulated"] == "mesh" or because:
            return "", lambda build: plan_full_mesh(model, budget=budget, because=because)

        def met(chosen: Plan) -> Plan:
            return in_contact(model.mesh, chosen, radius) if meets else chosen

        if wanted["simulated"] == "proxy":
            vertices = wanted["vertices"]
            return "", lambda build: met(plan_proxy(model, vertices, radius=radius, budget=budget, build=build))
        decided = decide(
            model, tolerance=tolerance, force_tolerance=force_tolerance, radius=radius, budget=budget, pressed=pressed,
            alone=not meets,
        )  # fmt: skip
        return decided.reason, lambda build: met(carry_out(decided, build))

    return by_settings


def budget_of(scene: bpy.types.Scene, obj: bpy.types.Object) -> float:
    """Return the processor time [s] per second for the steps of one object, contact apart: at rest the others cost
    nothing, and no more than MAX_FINGERS are pressed at a time.
    """
    bodies = 1 + sum(each != obj and each.type == "MESH" and each.dimple.enabled for each in scene.objects)
    share = scene.dimple.frame_budget_percent / 100 / min(bodies, MAX_FINGERS)
    return share / CONTACT if contact.is_on(scene) else share


class Around(NamedTuple):
    """What the plan of an object depends on besides its model: the fingertip's radius [mm], the budget, and whether
    anything meets, and it itself.
    """

    radius_mm: float
    budget: float
    meets: bool
    itself: bool


def around(scene: bpy.types.Scene, obj: bpy.types.Object) -> Around:
    """Return what the plan of an object depends on besides its model."""
    budget = budget_of(scene, obj)
    return Around(scene.dimple.finger_radius_mm, budget, contact.is_on(scene), obj.dimple.self_contact)


def key(scene: bpy.types.Scene, obj: bpy.types.Object, model: Model, pressed: Pressed | None = None) -> str:
    """Return a checksum of what the plan depends on: body, materials, tolerances, fingertips and budget."""
    law, number = model.matching, 0
    for array in (
        law.rest, model.mesh.triangles, model.mass, model.pinned, law.k1, law.k2, law.d0, law.damping, law.tension,
        model.springs.stiffness, model.springs.damping, model.friction, model.compliance,
    ):  # fmt: skip
        number = zlib.crc32(np.ascontiguousarray(array), number)
    words = (model.law_set, model.pressure.fill, model.rigged, *around(scene, obj), *obj.dimple.to_plan().values())
    words += (pressed,) if pressed else ()
    return f"{zlib.crc32(repr(words).encode(), number):08x}"
