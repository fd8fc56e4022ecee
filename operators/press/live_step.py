"""One step of all running sessions, shared by poke, play and the scripted press."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import bpy

from ...core import native
from ...core.background_work import Parts, at_once
from ...core.base import DimpleError
from ...core.constants import MAX_FINGERTIPS
from ...core.message import about, in_a_row
from ...core.session import Finger, step_all
from ..bridge import bake_files, object_link, sizing, timeline
from ..reporting import gathered
from . import (
    colliders,
    fingertip_objects,
    follow_settings,
    haptic_fingertips,
    last_press,
    props,
    sessions,
    showing,
)
from .modal_runs import ModalRun
from .sessions import LiveBody

if TYPE_CHECKING:
    from ...core.world import World

LONGEST_S = 0.1  # [s] longest step: after a hiccup of Blender, simulated time falls behind instead of jumping
SHORTEST_S = 0.002  # [s] shortest step, and smallest budget of wall time


def candidates(context: bpy.types.Context) -> list[bpy.types.Object]:
    """Return the objects to press: the selected meshes, else the bodies of selected fingertips, else one other object.

    Raises:
        DimpleError: nothing is selected.
    """
    fingers = sessions.fingertip_objects(context.scene)
    chosen = [*context.selected_objects, *([context.object] if context.object else [])]
    others = [obj for obj in chosen if obj not in fingers]
    if meshes := [obj for obj in others if obj.type == "MESH" and obj.select_get()]:
        return list(dict.fromkeys(meshes))
    bodies = [fingertip_objects.body_of(obj, context.scene) for obj in chosen if obj in fingers]
    if pressed := list(dict.fromkeys(filter(None, bodies))):
        return pressed
    if others:
        return others[:1]
    if context.selected_objects:
        raise DimpleError("Only a fingertip is selected. Select the mesh to press.")
    raise DimpleError("Nothing is selected. Select a mesh to press it.")


def start_all(context: bpy.types.Context) -> tuple[list[LiveBody], list[str], list[str]]:
    """Start a session on every candidate.

    Returns:
        The bodies, sentences for the artist, and the errors of objects that were left out.

    Raises:
        DimpleError: none of them can be pressed.
    """
    return at_once(starting_all(context))


def starting_all(context: bpy.types.Context) -> Parts:
    """Start a session on every candidate, in parts; see `start_all`. If closed early, it starts none."""
    bodies, messages, wrong, before = [], [], [], set(sessions.sessions)
    try:
        for obj in candidates(context):
            try:
                body, notes = yield from sessions.starting(obj, context)
            except DimpleError as error:
                wrong.append(str(error))
            else:
                bodies.append(body)
                messages += notes
        if not bodies:
            raise DimpleError(in_a_row(gathered(wrong)))
        if crossing := _meet(context):
            raise DimpleError(crossing[0])
    except BaseException:
        for uid in set(sessions.sessions) - before:
            sessions.stop(uid)
        raise
    return bodies, messages, wrong


def advance(
    context: bpy.types.Context,
    dt: float,
    *,
    budget: float | None = None,
    pressed: Mapping[int, Sequence[Finger | None]] = {},
    shown: bool = True,
) -> list[str]:
    """Step every session and show it.

    Args:
        dt: simulated time [s].
        budget: wall time for all of them [s]; if preparing them takes longer than this, the excess is deducted.
        pressed: fingertips of a poke by body; they take precedence over the haptic device's, and these over objects.
        shown: show the result; otherwise it is seen after a later step.

    Returns:
        Sentences for the artist: sessions that ended, or were put back to rest.
    """
    settings = context.preferences.addons.get(bake_files.PACKAGE)
    native.use_cores(settings.preferences.cores / 100 if settings else 1.0)
    messages = [*haptic_fingertips.read(), *showing.end_changed(context.view_layer)]
    began = time.perf_counter()
    for uid, body in list(sessions.sessions.items()):
        messages += _trying(uid, prepare, context, body, pressed.get(uid, ()))
    if budget:  # changing constants takes time, and a frame must not take that time and the full budget too
        late = time.perf_counter() - began - budget
        budget = min(budget, max(budget - late, SHORTEST_S))
    messages += _meet(context)
    share = budget / len(sessions.sessions) if budget and sessions.sessions else budget  # budget of one body
    for group in _groups():
        messages += _run(group, dt, share and share * len(group[0]))
    for world in sessions.worlds:
        props.show(world)
    for uid, body in list(sessions.sessions.items()):
        messages += _trying(uid, finish, body, shown)
        last_press.note(context, body)
    slowest = min((body.lead for body in sessions.sessions.values()), default=0.0)
    for body in sessions.sessions.values():
        body.done, body.lead = body.lead, body.lead - slowest  # the others wait for the slowest: all share one clock
    haptic_fingertips.write(context.scene)
    return messages


def advance_to(context: bpy.types.Context, frame: int) -> list[str]:
    """Advance from the previous frame of the timeline to this one, as a bake does, and show it; see `advance`."""
    messages, last = [], timeline.looks_a_frame(context.scene)
    for look, step_s in enumerate(timeline.looks(context.scene, frame), start=1):
        messages += advance(context, step_s, shown=look == last)
    return messages


def _trying(uid: int, do: Callable[..., list[str]], *arguments: Any) -> list[str]:
    """Call a function that acts on a session; if it fails, end the session and return the reason."""
    try:
        return do(*arguments)
    except DimpleError as error:
        sessions.stop(uid)
        return [str(error)]


def _meet(context: bpy.types.Context) -> list[str]:
    """Update the worlds and move their colliders; on an error end all sessions and return the reason."""
    if not colliders.is_on(context.scene):
        sessions.set_worlds(())
        return []
    bodies = {
        uid: (obj, body.session, body.link.scale)
        for uid, body in sessions.sessions.items()
        if (obj := object_link.find(uid, body.name))  # else its session is about to end
    }
    try:
        sessions.set_worlds(colliders.worlds_of(context, bodies, sessions.worlds))
        for world in sessions.worlds:
            colliders.lead_colliders(context, world)
    except DimpleError as error:
        for uid in list(sessions.sessions):
            sessions.stop(uid)
        return [str(error)]
    return []


def _groups() -> list[tuple[list[LiveBody], World | None]]:
    """Return the running bodies in groups that are stepped together, each with its world, None without contact."""
    together = [([sessions.sessions[uid] for uid in each.uids], each.world) for each in sessions.worlds]
    met = {uid for each in sessions.worlds for uid in each.uids}
    return [*together, ([body for uid, body in sessions.sessions.items() if uid not in met], None)]


def _run(group: tuple[list[LiveBody], World | None], dt: float, budget: float | None) -> list[str]:
    bodies, world = group
    left = [max(dt - body.lead, 0.0) for body in bodies]
    try:
        if world:
            world.step(min(left), budget=budget)
        else:
            step_all([body.session for body in bodies], left, budget=budget)
    except DimpleError as error:
        for body in bodies:
            sessions.stop(body.link.uid)
        return [str(error)]
    for body in bodies:
        body.lead += body.frame.steps * body.session.clock.tick
    return []


def prepare(context: bpy.types.Context, body: LiveBody, pressed: Sequence[Finger | None]) -> list[str]:
    """Bring settings, pins and fingertips of a session up to date; return sentences for the artist."""
    obj, link = body.obj, body.link
    messages = follow_settings.follow(context, obj, body)
    if body.link is not link:
        pressed = ()  # these fingertips are in metres of the old scale
        sessions.disarm()  # the new scale may suddenly put the body under a fingertip of the haptic device
    body.follow(context, obj)
    device = haptic_fingertips.fingertips(context.scene, body)
    fingers = merged(device or fingertips(context.scene, link.scale), pressed)
    body.held = {i: finger for i, finger in enumerate(merged(device, pressed)) if finger}
    before, body.poked = body.poked, frozenset(i for i, finger in enumerate(pressed) if finger)
    # a fingertip that passes between poke and device is lifted first, so that it does not jump through the body, which
    # the device would render
    body.session.set_fingers([None if i in before ^ body.poked else finger for i, finger in enumerate(fingers)])
    body.session.set_fingers(fingers)
    return messages


def finish(body: LiveBody, shown: bool = True) -> list[str]:
    """Take the new state of a session, and show it; return a sentence for the artist if it was put back to rest."""
    body.fingers = merged(body.session.placed, ())
    if shown:
        showing.show(body.obj, body)
    if not body.frame.note:
        return []
    sessions.disarm()  # the body jumped back to rest, possibly onto a fingertip of the device
    return [about(body.name, body.frame.note)]


def fingertips(scene: bpy.types.Scene, scale: float) -> list[Finger | None]:
    """Return the fingertip objects of a scene in a session's space."""
    def finger(obj: bpy.types.Object) -> Finger:
        place = tuple(scale * c for c in obj.matrix_world.translation)
        return Finger(place, sizing.radius_of(obj, scene, scale))

    return [finger(obj) if obj else None for obj in sizing.fingertips(scene)]


def merged(fingers: Sequence[Finger | None], pressed: Sequence[Finger | None]) -> tuple[Finger | None, ...]:
    """Return the fingertips of a session: for each number that of the poke if there is one, else that of `fingers`."""
    first, second = ([*some, *([None] * MAX_FINGERTIPS)][:MAX_FINGERTIPS] for some in (pressed, fingers))
    return tuple(poked or finger for poked, finger in zip(first, second, strict=True))


def ask(scene: bpy.types.Scene, run: ModalRun, wall: float) -> tuple[float, float]:
    """Return the simulated time [s] to request after a wall time, and the budget of wall time for it [s].

    If the computer cannot keep up, time runs slower and fingertips move only as far as time will be simulated.
    """
    wall = min(wall, LONGEST_S)
    return min(wall, run.step_s), max(scene.dimple.frame_budget_percent / 100 * wall, SHORTEST_S)


def adapt(run: ModalRun, asked: float) -> None:
    """Set the longest next step to twice the time that the slowest session has simulated, within the limits."""
    done = min((body.done for body in sessions.sessions.values()), default=asked)
    run.step_s = min(max(2 * done, SHORTEST_S), LONGEST_S)
