"""Apply settings that are changed while a body runs, at its next step.

Weights of vertex groups are read again with any other change, and at short intervals while they are painted.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import bpy

from ...core.background_work import Parts, at_once, beside
from ...core.base import DimpleError
from ...core.message import about, in_a_row
from ..bridge import body_model, object_link, scene_objects, timeline
from ..bridge.body_model import settings_of
from ..names import PAINTING
from . import object_plan

if TYPE_CHECKING:
    from ...core.body.model import Model
    from ..bridge.body_model import Settings
    from .object_body import ObjectBody
    from .sessions import LiveBody

PAINTED_S = 0.2  # [s] simulated time between two readings of weights that are being painted
LARGE = 12_000  # number of vertices above which a frame does not wait for a change
WAIT_S = 0.008  # [s] time that a frame waits for the change of a smaller body, to show it in that frame or soon after


def follow(context: bpy.types.Context, obj: bpy.types.Object, body: LiveBody) -> list[str]:
    """Apply the current settings to a running body; return sentences for the artist.

    A change that cannot be simulated is refused: the body keeps its old settings, and `refused` says why.
    """
    if body.change is None:
        now = settings_of(context.scene, obj)
        painting = obj.mode == PAINTING and body.frame.time >= body.painted_at + PAINTED_S
        if now == body.seen and not painting:
            return []
        body.painted_at = body.frame.time
        refused_before, body.seen, body.refused = body.refused, now, ""
        if now == body.settings and not painting:
            return []
        parts = _changing(context, obj, body, now, refused_before)
        if bpy.app.background or timeline.is_playing(context):
            return at_once(parts)
        body.change = beside(parts, WAIT_S if len(body.session.model.mass) <= LARGE else 0.0)
    try:
        next(body.change)
    except StopIteration as end:
        body.change = None
        return end.value
    return []


def follow_keyframes(scene: bpy.types.Scene, obj: bpy.types.Object, body: ObjectBody) -> None:
    """Apply the settings of this frame to a body that is baked; a proxy stays and only its constants change.

    Raises:
        DimpleError: the settings cannot be simulated.
    """
    from ...core.reduction.proxy import with_constants

    now, session = settings_of(scene, obj), body.session
    if now != body.settings:
        model = at_once(body_model.reading_model(scene, obj, session.model.mesh, body.link))
        session.change(model, proxy=session.proxy and with_constants(session.proxy, model))
        body.settings = now


def _changing(
    context: bpy.types.Context, obj: bpy.types.Object, body: LiveBody, now: Settings, refused_before: str
) -> Parts:
    """Change a body in parts; return sentences for the artist. Undo may replace `obj` after any part."""
    try:
        yield from _change(context, obj, body, now)
    except DimpleError as error:
        body.refused = in_a_row([str(error), "Until then the body keeps its old settings."])
        return [] if refused_before else [body.refused]
    gone = any(had and not has for had, has in zip(body.settings.materials, now.materials, strict=False))
    body.settings = now
    return [about(body.name, "a material was removed: the constants of a new one act in its place.")] if gone else []


def _change(context: bpy.types.Context, obj: bpy.types.Object, body: LiveBody, now: Settings) -> Parts:
    """Change a body in parts, or raise a DimpleError and leave the body unchanged."""
    from ...core.mesh.surface import input_vertices

    session, before = body.session, body.settings
    scale = object_link.scale_of_body(context.scene, obj, body.link.rest, body.link.matrix)
    slots, slots_before = (max(len(each.materials), 1) for each in (now, before))
    again = now.plan != before.plan
    if scale == body.link.scale and slots == slots_before:
        model = yield from body_model.reading_model(context.scene, obj, session.model.mesh, body.link)
        session.change(model, proxy=(yield from _proxy(body, model, again=again)))
        return
    link, model = scene_objects.read_body(context, obj, cuts=body.link.cuts)
    proxy = yield from _proxy(body, model, again=again)
    session.change(model, proxy=proxy, scale=link.scale / body.link.scale)
    body.link, body.matrix, body.rest = link, link.matrix, link.rest
    body.triangles = input_vertices(model.mesh)[model.mesh.triangles]


def _proxy(body: LiveBody, model: Model, *, again: bool) -> Parts:
    """Return the proxy of a changed model, None for the full mesh; plan again if `again` or if the old choice fails."""
    from ...core.reduction.proxy import build_proxy, with_constants

    old = body.session.proxy
    if not again:
        if old is None:
            return None
        try:
            if model.mesh is not body.session.model.mesh:  # the scale or the slots have changed
                return build_proxy(model, len(old.seeds))
            proxy = yield 0.8, partial(with_constants, old, model)
            now = body.session.proxy
            return proxy if now else None  # contact may have dropped the proxy meanwhile
        except DimpleError:  # the proxy does not fit the new pins or laws: plan again
            pass
    return (yield from object_plan.planning_for(bpy.context.scene, body.obj, model))
