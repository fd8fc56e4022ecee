"""The running sessions: the mutable module state of the extension, but for the connection to the haptic device.

`sessions` holds a LiveBody for every object that is being pressed, by the object's session_uid, which survives undo
and renaming.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy

from ...core.errors import DimpleError
from ..messages import LOG, Note
from .modal_runs import close_run, runs
from .object_body import ObjectBody

if TYPE_CHECKING:
    from ...core.background_work import Parts
    from ...core.poke.stroke import Hand
    from ...core.session import Finger
    from ..bridge.body_model import Settings
    from ..bridge.scene_objects import Singles
    from .colliders import LiveWorld
    from .recorder import Recorder


def _hand() -> Hand:
    from ...core.poke.stroke import Hand

    return Hand()


@dataclass(slots=True, kw_only=True, eq=False)
class LiveBody(ObjectBody):
    """One object that is being pressed live."""

    seen: Settings | None = None  # the settings it had when they were looked at last; the session may have refused them
    hand: Hand = field(default_factory=_hand)  # what they have done
    refused: str = ""  # "" or why
    change: Generator[float, None, list[str]] | None = None  # of a large body to other settings, under way in a thread
    changed_at: float | None = None  # when they were changed last, None where they were planned for [s]
    # what it was planned for besides its settings, see `object_plan.around`; None before its first step
    around: tuple[float, float] | None = None
    painted_at: float = 0.0  # when weights that are painted were read last [s]
    fingers: tuple[Finger | None, ...] = (None, None, None)  # the fingertips to be drawn, in the session's space
    poked: frozenset[int] = frozenset()  # which fingertips are the poke's
    # the fingertips of a hand, by number: the poke's and the haptic device's
    held: dict[int, Finger] = field(default_factory=dict)
    lead: float = 0.0  # simulated time that it is ahead of the slowest of those that run with it [s]
    done: float = 0.0  # how far it came in the last step, that lead included [s]
    recorder: Recorder | None = None  # of the recording under way
    take: tuple[str, int] | None = None  # path and first frame of the last recording
    shown: Singles | None = None  # the offsets that its object shows, None where they are not known
    objects: int = 0  # how many there were in the file when duplicates were looked for last

    @property
    def running(self) -> bool:
        """Tell whether time runs."""
        return any(not run.paused for run in runs)

    @property
    def recording(self) -> bool:
        """Tell whether frames are being recorded."""
        return self.recorder is not None


sessions: dict[int, LiveBody] = {}
worlds: list[LiveWorld] = []  # the sessions that are stepped together
disarming: list[Callable[[], None]] = []  # what ends all force of the haptic device: `haptic_fingertips` adds itself


def get(obj: bpy.types.Object | None) -> LiveBody | None:
    """Return the session of an object."""
    return sessions.get(obj.session_uid) if obj else None


def fingertip_objects(scene: bpy.types.Scene) -> set[bpy.types.Object | None]:
    """Return the objects that are fingertips; they press and are not pressed."""
    from ..bridge.sizing import fingertips

    return set(fingertips(scene))


def start(obj: bpy.types.Object, context: bpy.types.Context) -> tuple[LiveBody, list[str]]:
    """Start the session of an object, or return the one it has; and sentences for the artist.

    Raises:
        DimpleError: it cannot be pressed, with the reason and what to do; nothing was changed.
    """
    from ...core.background_work import at_once

    return at_once(starting(obj, context))


def starting(obj: bpy.types.Object, context: bpy.types.Context) -> Parts:
    """Start the session of an object in parts; see `start`. Closed, nothing was changed."""
    if body := get(obj):
        return body, []
    from ..bridge import final_mesh, scene_objects, sizing, write_back

    scene_objects.check(obj)
    scene_objects.check_writable(obj)
    write_back.rescue(sessions)  # a duplicate of a body that is live shows its press
    size = sizing.settle_size(context.scene, obj)
    try:
        final_mesh.attach(context, obj)
        body, messages = yield from LiveBody.opening(context, obj)
    except BaseException:
        final_mesh.detach(obj)
        if size:
            obj.dimple.property_unset("size_mode")
        raise
    body.seen, sessions[body.link.uid] = body.settings, body
    obj.dimple.enabled = True
    return body, [*([size] if size else []), *messages]


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
    set_worlds(())  # rebuilt from those that are left
    from ..bridge import cache_files, final_mesh, scene_objects, write_back
    from . import props

    if not sessions and restore and not undoing:
        props.put_back()
    elif not sessions:
        props.fallen.clear()
    obj = scene_objects.find(uid, body.name)
    if obj and not restore and write_back.is_intact(obj, body.link):
        write_back.keep(bpy.context, obj, body.link, body.offsets())
    if obj:
        final_mesh.detach(obj)
    write_back.rescue(sessions)
    messages = end_recording(body)  # after the mesh: whatever the disk does, that is safe
    if obj and body.take:
        try:
            with cache_files.plain_os_errors("Recording"):
                cache_files.attach_cache(bpy.context, obj, *body.take, body.link.cuts)
        except DimpleError as error:
            messages.append(str(error))
        if not undoing:
            write_back.remember("Record")  # else an undo of what came before would take the take along
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
    """End everything when something unforeseen is raised, and log it: no timer, no pressed mesh may stay behind."""
    try:
        yield
    except BaseException as error:
        LOG.exception("%s: everything was ended", type(error).__name__)
        stop_all()
        raise
