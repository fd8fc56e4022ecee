"""The running sessions: the mutable module state of the extension, but for the connection to the haptic device.

`sessions` holds a LiveBody for every object that is being pressed, by the object's session_uid, which survives undo
and renaming.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import bpy

from ..core.messages import about
from .messages import Note
from .modal_runs import close_run, runs

if TYPE_CHECKING:
    import numpy as np

    from ..core.session import Finger, Frame, Session
    from ..core.steps import Parts
    from ..core.stroke import Hand
    from .bridge import ObjectLink, Singles
    from .contact import LiveWorld
    from .planning import Around
    from .recorder import Recorder
    from .settings import Settings



@dataclass(slots=True, kw_only=True, eq=False)
class LiveBody:
    """One object that is being pressed: its session, and what joins that to Blender.

    link: the object at rest.
    session: what moves it.
    settings: what the session was read from.
    seen: the settings it had when they were looked at last; the session may have refused them.
    refused: "" or why.
    change: of a large body to other settings, under way in a thread.
    changed_at: when they were changed last, None where they were planned for [s].
    around: what it was planned for besides its settings, None before its first step.
    matrix, rest: (4, 4) of the object and (N, 3) its shape at rest when it was last stepped.
    triangles: (t, 3) of the vertices of the final mesh, outward.
    painted_at: when weights that are painted were read last [s].
    fingers: the fingertips to be drawn, in the session's space.
    poked: which fingertips are the poke's.
    held: the fingertips of a hand, by number: the poke's and the haptic device's.
    hand: what they have done.
    lead: simulated time that it is ahead of the slowest of those that run with it [s].
    done: how far it came in the last step, that lead included [s].
    recorder: of the recording under way.
    take: path and first frame of the last recording.
    shown: what its object shows: link, matrix, shape at rest and positions; None where that is not known.
    objects: how many there were in the file when duplicates were looked for last.
    """

    link: ObjectLink
    session: Session
    settings: Settings
    seen: Settings
    matrix: np.ndarray
    rest: Singles
    triangles: np.ndarray
    hand: Hand
    refused: str = ""
    change: Generator[float, None, list[str]] | None = None
    changed_at: float | None = None
    around: Around | None = None
    painted_at: float = 0.0
    fingers: tuple[Finger | None, ...] = (None, None, None)
    poked: frozenset[int] = frozenset()
    held: dict[int, Finger] = field(default_factory=dict)
    lead: float = 0.0
    done: float = 0.0
    recorder: Recorder | None = None
    take: tuple[str, int] | None = None
    shown: tuple[object, ...] | None = None
    objects: int = 0

    @property
    def name(self) -> str:
        """Return the name of the object."""
        return self.link.name

    @property
    def frame(self) -> Frame:
        """Return what the session showed last."""
        return self.session.frame

    @property
    def running(self) -> bool:
        """Tell whether time runs."""
        return any(not run.paused for run in runs)

    @property
    def recording(self) -> bool:
        """Tell whether frames are being recorded."""
        return self.recorder is not None

    def to_world(self, point: tuple[float, float, float]) -> tuple[float, float, float]:
        """Return a point of the session [m] in the scene."""
        x, y, z = (float(c) / self.link.scale for c in point)
        return x, y, z


sessions: dict[int, LiveBody] = {}
worlds: list[LiveWorld] = []  # the sessions that are stepped together
disarming: list[Callable[[], None]] = []  # what ends all force of the haptic device: `haptic` adds itself


def get(obj: bpy.types.Object | None) -> LiveBody | None:
    """Return the session of an object."""
    return sessions.get(obj.session_uid) if obj else None


def fingertip_objects(scene: bpy.types.Scene) -> set[bpy.types.Object | None]:
    """Return the objects that are fingertips; they press and are not pressed."""
    return {getattr(scene.dimple, f"finger_{number}") for number in (1, 2, 3)}


def start(obj: bpy.types.Object, context: bpy.types.Context) -> tuple[LiveBody, list[str]]:
    """Start the session of an object, or return the one it has; and sentences for the artist.

    Raises:
        DimpleError: it cannot be pressed, with the reason and what to do; nothing was changed.
    """
    from ..core.steps import at_once

    found: tuple[LiveBody, list[str]] = at_once(starting(obj, context))
    return found


def starting(obj: bpy.types.Object, context: bpy.types.Context) -> Parts:
    """Start the session of an object in parts; see `start`. Closed, nothing was changed."""
    if body := get(obj):
        return body, []
    from ..core.mesh.surface import input_vertices
    from ..core.session import Session
    from ..core.stroke import Hand
    from . import bridge, bridge_write, final_mesh, planning, sizing, timeline
    from .settings import settings_of

    bridge.check(obj)
    bridge.check_writable(obj)
    bridge_write.rescue(sessions)  # a duplicate of a body that is live shows its press
    size = sizing.settle_size(context.scene, obj)
    try:
        final_mesh.attach(context, obj)
        link, model = yield from bridge.reading_body(context, obj)
        proxy = yield from planning.planning_for(context.scene, obj, model)
        session = yield 0.9, partial(Session, model, proxy=proxy, tick=timeline.tick_s(context.scene))
    except BaseException:
        final_mesh.detach(obj)
        if size:
            obj.dimple.property_unset("size_mode")
        raise
    messages = [*filter(None, [size]), *(about(obj.name, note) for note in model.notes)]
    first = input_vertices(model.mesh)
    settings = settings_of(context.scene, obj)
    body = sessions[link.uid] = LiveBody(
        link=link, session=session, settings=settings, seen=settings,
        matrix=link.matrix, rest=link.rest, triangles=first[model.mesh.triangles], hand=Hand(),
    )  # fmt: skip
    obj.dimple.enabled = True
    return body, messages


def set_worlds(now: Sequence[LiveWorld]) -> None:
    """Let sessions be stepped together in these worlds from now on; those of a world that is left wake."""
    for left in worlds:
        if left not in now:
            for session in left.world.sessions:
                session.wake()
    worlds[:] = now


def stop(uid: int, *, restore: bool = True, undoing: bool = False) -> list[str]:
    """End a session; put the rest shape back, or keep the shape that shows.

    Args:
        undoing: Blender undoes: no undo step is pushed.

    Returns:
        Sentences for the artist: what went wrong with a recording.
    """
    body = sessions.pop(uid, None)
    if body is None:
        return []
    set_worlds(())  # made anew of those that are left
    from ..core.base import DimpleError
    from . import bridge, bridge_write, cache_files, final_mesh, props

    if not sessions and restore and not undoing:
        props.put_back()
    elif not sessions:
        props.fallen.clear()
    obj = bridge.find(uid, body.name)
    if obj and not restore and bridge_write.is_intact(obj, body.link):
        local = bridge.offsets_of(body.link, body.matrix, body.rest, body.session.positions())
        bridge_write.keep(bpy.context, obj, body.link, local)
    if obj:
        final_mesh.detach(obj)
    bridge_write.rescue(sessions)
    messages = end_recording(body)  # after the mesh: whatever the disk does, that is safe
    if obj and body.take:
        try:
            with cache_files.plain_os_errors("Recording"):
                cache_files.attach_cache(bpy.context, obj, *body.take, body.link.cuts)
        except DimpleError as error:
            messages.append(str(error))
        if not undoing:
            bridge_write.remember("Record")  # else an undo of what came before would take the take along
    return messages


def end_recording(body: LiveBody) -> list[str]:
    """End the recording of a body, if there is one; the object plays it once its session has ended.

    Returns:
        Sentences for the artist: what was recorded, or went wrong.
    """
    if body.recorder is None:
        return []
    recorder, body.recorder = body.recorder, None
    body.take = recorder.take
    try:
        recorder.close()
    except OSError as error:
        return [recorder.cut_short(body.name, error)]
    return [Note(recorder.summary(body.name, bpy.context.scene.frame_end))]


def stop_all(*, restore: bool = True) -> list[str]:
    """End every session and everything that drives them; the haptic device is disarmed first.

    Returns:
        Sentences for the artist.
    """
    disarm()
    for run in list(runs):
        close_run(run)
    return [sentence for uid in list(sessions) for sentence in stop(uid, restore=restore)]


def disarm() -> None:
    """End all force of the haptic device."""
    for each in disarming:
        each()


@contextmanager
def ending_on_error() -> Iterator[None]:
    """End everything when something unforeseen is raised: no timer, no pressed mesh may stay behind it."""
    try:
        yield
    except BaseException:
        stop_all()
        raise
