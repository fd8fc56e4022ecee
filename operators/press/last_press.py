"""The last press by hand on each body, kept after its session ends so that Key This Press can repeat it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy

if TYPE_CHECKING:
    from ...core.poke.stroke import Way
    from .sessions import LiveBody


@dataclass(frozen=True, slots=True, kw_only=True)
class LivePress:
    """A press by hand."""

    uid: int  # session_uid of the object that was pressed
    name: str  # name of that object
    scale: float  # physical metres per scene unit
    start: float  # time at which it began, by the clock of the session [s]
    frame: float | None  # frame of the timeline at its start, None if the timeline was not playing
    ways: dict[int, Way]  # paths of the fingertips, by the number of the finger


presses: dict[int, LivePress] = {}  # by the session_uid of the body, in the order in which they began


def note(context: bpy.types.Context, body: LiveBody) -> None:
    """Record the motion of hand-moved fingertips on a body in its last step."""
    from ..bridge import timeline

    clock, touches, held = body.session.clock, body.frame.touches, {}
    for i, finger in body.held.items():
        touch = touches[i] if i < len(touches) else None
        if touch and (i in body.poked or touch.depth > 0):  # those of a haptic device exist in the air too
            held[i] = finger, touch
    time = clock.ticks * clock.tick
    start = body.hand.take(time, held)
    if start is None:
        return
    scene, frame = context.scene, None
    if timeline.is_playing(context):
        frame = scene.frame_current_final - (time - start) / timeline.frame_s(scene)
    uid = body.link.uid
    presses.pop(uid, None)
    presses[uid] = LivePress(
        uid=uid, name=body.name, scale=body.link.scale, start=start, frame=frame, ways=body.hand.ways
    )  # fmt: skip


def last(scene: bpy.types.Scene, body: bpy.types.Object | None) -> LivePress | None:
    """Return the last press on a body, or if it has none the last press on any body of the scene."""
    if body and body.session_uid in presses:
        return presses[body.session_uid]
    here = {obj.session_uid for obj in scene.objects}
    return next((press for press in reversed(presses.values()) if press.uid in here), None)
