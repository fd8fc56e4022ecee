"""A press from a script: find the place that it presses, and run it frame by frame without a window."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

from ...core.base import DimpleError
from ...core.message import Message
from ...core.poke import Hit, Kind, PokeEvent, PokeState, fingers, on_event
from ...core.vectors import Vector, along
from ..bridge import scene_objects, timeline
from ..reporting import report, say
from . import live_step, poke_input, polls, sessions
from .object_body import ObjectBody

FORCE_N = 5.0  # [N] force of the press if none is given
DOWN: Vector = (0.0, 0.0, -1.0)


def press_once(operator: bpy.types.Operator, context: bpy.types.Context) -> None:
    """Press, hold and release by the operator's properties; show every frame."""
    polls.check_numbers(
        operator, "location", "direction", "radius_mm", "depth_mm", "force_n", "press_s", "hold_s", "release_s"
    )
    state = PokeState(
        radius=(operator.radius_mm or context.scene.dimple.finger_radius_mm) / 1e3, depth=operator.depth_mm / 1e3,
        force=operator.force_n or FORCE_N, by_force=operator.force_n > 0, press_s=operator.press_s,
        release_s=operator.release_s, active=(operator.finger or context.scene.dimple.active_finger) - 1,
    )  # fmt: skip
    with sessions.ending_on_error():
        _, messages, wrong = live_step.start_all(context)
        place = operator.location if operator.properties.is_property_set("location") else None
        state = pressed(sessions.sessions, state, place, operator.direction)
        deepest, strongest = run(context, state, operator.hold_s, messages)
        sessions.stop_all(restore=not operator.keep)
    report(operator, [*wrong, *messages])
    say(operator, {"INFO"}, Message(
        "Pressed {deepest:.1f} mm deep with up to {strongest:.2f} N", deepest=deepest * 1e3, strongest=strongest
    ))  # fmt: skip


def pressed(
    bodies: Mapping[int, ObjectBody], state: PokeState, place: Sequence[float] | None, direction: Sequence[float]
) -> PokeState:
    """Return a state whose active fingertip begins to press at a place of the scene.

    Args:
        place: [scene units] the surface nearest to it along the direction is pressed. None: the middle of the highest
            points of the first body.
        direction: direction of the fingertip's motion; 0: straight into the surface nearest to the place.

    Raises:
        DimpleError: no surface lies along that direction, or the depth of the press exceeds the size of the body.
    """
    # a given direction overrides the scene's setting for the mouse
    state = replace(state, along_normal=not any(direction))
    event = aimed(bodies, None if place is None else tuple(place), tuple(direction))
    assert event.hit
    body = bodies[event.hit.body]
    size = body.session.model.mesh.size
    if not state.by_force and state.depth > size:
        raise DimpleError(
            '"{name}" is {size:.4g} mm across, so a press of {depth:.4g} mm would go through it. Use a smaller depth.',
            name=body.name, size=1e3 * size, depth=1e3 * state.depth
        )  # fmt: skip
    return on_event(state, event)


def aimed(bodies: Mapping[int, ObjectBody], place: Vector | None, direction: Vector) -> PokeEvent:
    """Return the event that presses the surface nearest to a place along a direction; see `pressed`."""
    length = math.hypot(*direction)
    if not length and place is not None:
        return PokeEvent(kind=Kind.PRESS, hit=_nearest(bodies, place), view=DOWN)
    inward: Vector = tuple(c / length for c in direction) if length else DOWN
    if place is None:
        place = _top(next(iter(bodies.values())))
    found = []
    for uid, body in bodies.items():
        size = body.session.model.mesh.size / body.link.scale
        away = 2 * size + math.dist(place, body.to_world(tuple(map(float, body.session.positions().mean(axis=0)))))
        # cast rays from outside the body and from nearby, so that a place in a hollow presses the wall next to it
        starts = [along(place, inward, -share * away) for share in (1.0, 1e-3, 1e-5)]
        found += [poke_input.nearest(start, inward, {uid: body}, {}) for start in starts]
    hits = [(math.dist(bodies[hit.body].to_world(hit.point), place), i, hit) for i, hit in enumerate(found) if hit]
    if not hits:
        at = ", ".join(f"{c:.3g}" for c in place)
        raise DimpleError("No surface lies along the direction of the press at ({at}). Choose another location.", at=at)
    return PokeEvent(kind=Kind.PRESS, hit=min(hits)[2], view=inward)


def _top(body: ObjectBody) -> Vector:
    used = body.session.positions()[np.unique(body.triangles)].astype(np.float64)
    high = used[used[:, 2] >= used[:, 2].max() - scene_objects.LEVEL * np.ptp(used, axis=0).max()]
    middle = body.to_world(tuple(high.mean(axis=0).tolist()))  # of a ring, this is not on the surface
    return body.to_world(_nearest({body.link.uid: body}, middle).point)


def _nearest(bodies: Mapping[int, ObjectBody], place: Vector) -> Hit:
    """Return the point of the bodies' surfaces at rest that is nearest to a place of the scene, with its normal."""
    found = []
    for uid, body in bodies.items():
        at = np.array(place) * body.link.scale
        mesh = body.session.model.mesh
        tree = BVHTree.FromPolygons(mesh.rest_positions.tolist(), mesh.triangles.tolist())
        point, normal, _, away = tree.find_nearest(at)
        found.append((away / body.link.scale, Hit(point=tuple(point), normal=tuple(normal), body=uid)))
    return min(found, key=lambda each: each[0])[1]


def run(context: bpy.types.Context, state: PokeState, hold_s: float, messages: list[str]) -> tuple[float, float]:
    """Run a press that has begun, frame by frame; return the greatest depth [m] and force [N]."""
    active, deepest, strongest = state.active, 0.0, 0.0
    tip = state.tips[active]
    assert tip
    body = sessions.sessions[tip.body]
    for seconds, begins in ((state.press_s + hold_s, None), (state.release_s, PokeEvent(kind=Kind.RELEASE))):
        if begins and seconds > 0:  # else the fingertip stays pressed in
            state = on_event(state, begins)
        for step_s, now in frames(context.scene, state, seconds):
            state = now
            pressing = {uid: fingers(state, uid) for uid in sessions.sessions}
            messages += live_step.advance(context, step_s, pressed=pressing)
            if body.link.uid not in sessions.sessions or body.frame.note:
                raise DimpleError(messages[-1])
            if len(body.frame.depths):
                deepest = max(deepest, float(body.frame.depths[active]))
                strongest = max(strongest, float(body.frame.pushes[active]))
    return deepest, strongest


def frames(scene: bpy.types.Scene, state: PokeState | None, seconds: float) -> Iterator[tuple[float, PokeState | None]]:
    """Split a time [s] into frames, of which the last may be shorter; yield the length [s] and fingertips of each."""
    dt = timeline.frame_s(scene)
    whole = math.floor(seconds / dt + 1e-9)
    left = seconds - whole * dt
    for step_s in [dt] * whole + ([left] if left > 1e-9 else []):
        state = state and on_event(state, PokeEvent(kind=Kind.TICK, amount=step_s))
        yield step_s, state
