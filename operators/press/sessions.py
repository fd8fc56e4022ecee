"""The running sessions, and the worlds in which they are stepped together.

`sessions` holds a LiveBody for every object that is being pressed, by the object's session_uid, which survives undo
and renaming.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import bpy

from ..reporting import LOG
from .modal_runs import close_run, runs
from .object_body import ObjectBody

if TYPE_CHECKING:
    from ...core.background_work import Parts
    from ...core.poke.stroke import Hand
    from ...core.session import Finger
    from ..bridge.body_model import Settings
    from ..bridge.object_link import Singles
    from .colliders import LiveWorld


def _hand() -> Hand:
    from ...core.poke.stroke import Hand

    return Hand()


@dataclass(slots=True, kw_only=True, eq=False)
class LiveBody(ObjectBody):
    """One object that is being pressed live."""

    seen: Settings | None = None  # settings when they were last compared; the session may have refused them
    hand: Hand = field(default_factory=_hand)  # recorder of the press by hand
    refused: str = ""  # why the last change of settings was refused, or ""
    change: Generator[float, None, list[str]] | None = None  # change of settings that is under way in a thread
    painted_at: float = 0.0  # simulated time at which painted weights were last read [s]
    fingers: tuple[Finger | None, ...] = (None, None, None)  # the fingertips to be drawn, in the session's space
    poked: frozenset[int] = frozenset()  # indices of the poke's fingertips
    # the fingertips that a hand moves, by index: those of the poke and of the haptic device
    held: dict[int, Finger] = field(default_factory=dict)
    lead: float = 0.0  # simulated time by which it is ahead of the slowest session [s]
    done: float = 0.0  # simulated time done in the last step, the previous lead included [s]
    shown: Singles | None = None  # the offsets that its object shows, None if unknown
    objects: int = 0  # number of objects in the file at the last search for duplicates

    @property
    def running(self) -> bool:
        """Return whether simulated time runs."""
        return any(not run.paused for run in runs)


sessions: dict[int, LiveBody] = {}
worlds: list[LiveWorld] = []  # each holds sessions that are stepped together
disarming: list[Callable[[], None]] = []  # functions that end the haptic device's force; `haptic_fingertips` adds one


def get(obj: bpy.types.Object | None) -> LiveBody | None:
    """Return the running body of an object, or None."""
    return sessions.get(obj.session_uid) if obj else None


def fingertip_objects(scene: bpy.types.Scene) -> set[bpy.types.Object | None]:
    """Return the objects that are fingertips, which press and are not pressed; the set may contain None."""
    from ..bridge.sizing import fingertips

    return set(fingertips(scene))


def start(obj: bpy.types.Object, context: bpy.types.Context) -> tuple[LiveBody, list[str]]:
    """Start the session of an object unless it has one; return its body, and sentences for the artist.

    Raises:
        DimpleError: the object cannot be pressed, with the reason and what to do; nothing was changed.
    """
    from ...core.background_work import at_once

    return at_once(starting(obj, context))


def starting(obj: bpy.types.Object, context: bpy.types.Context) -> Parts:
    """Start the session of an object in parts; see `start`. If closed early, it changes nothing."""
    if body := get(obj):
        return body, []
    from ..bridge import final_mesh, scene_objects, sizing, write_back

    scene_objects.check(obj)
    scene_objects.check_writable(obj)
    write_back.rescue(sessions)  # the object may be a duplicate that still shows the press of a live body
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
    """Step sessions together in these worlds from now on, and wake the sessions of worlds that are dropped."""
    for left in worlds:
        if left not in now:
            for session in left.world.sessions:
                session.wake()
    worlds[:] = now


def stop(uid: int, *, restore: bool = True, undoing: bool = False) -> None:
    """End a session, and restore the rest shape or keep the shape that is shown.

    Args:
        restore: restore the rest shape.
        undoing: Blender is undoing a step, which has put the props where they belong.
    """
    body = sessions.pop(uid, None)
    if body is None:
        return
    set_worlds(())  # the next step rebuilds them from the remaining sessions
    from ..bridge import final_mesh, object_link, write_back
    from . import props

    if not sessions and restore and not undoing:
        props.put_back()
    elif not sessions:
        props.fallen.clear()
    obj = object_link.find(uid, body.name)
    if obj and not restore and write_back.is_intact(obj, body.link):
        write_back.keep(bpy.context, obj, body.link, body.offsets())
    if obj:
        final_mesh.detach(obj)
    write_back.rescue(sessions)


def stop_all(*, restore: bool = True) -> None:
    """Disarm the haptic device, then end all sessions and the operators that drive them."""
    disarm()
    for run in list(runs):
        close_run(run)
    for uid in list(sessions):
        stop(uid, restore=restore)


def disarm() -> None:
    """End all force of the haptic device."""
    for each in disarming:
        each()


@contextmanager
def ending_on_error() -> Iterator[None]:
    """End all sessions on any exception, and log it, so that no timer and no pressed mesh stays behind."""
    try:
        yield
    except BaseException as error:
        LOG.exception("%s: everything was ended", type(error).__name__)
        stop_all()
        raise
