"""Simulate bodies over a range of frames and write their offsets from the shape at rest, completely or not at all.

Files are written to a temporary folder beside their destination, and moved there at the end.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from ...core import native
from ...core.background_work import Parts, as_share, beside
from ...core.base import DimpleError
from ...core.message import Message, about
from ...core.recording import PointCache
from ...core.session import step_all
from ..bridge import bake_files, final_mesh, object_link, press_modifier, scene_objects, timeline
from ..names import BAKED_PRESS
from ..press import colliders, follow_settings, live_step, props
from ..press.object_body import ObjectBody
from ..press.progress import READY, SLICE_S
from .force_table import ForceTable

if TYPE_CHECKING:
    from ...core.world.world import Held


@dataclass(slots=True, kw_only=True, eq=False)
class Baked(ObjectBody):
    """One object of a bake."""

    path: Path = field(init=False)  # destination of the PC2 file
    part: Path = field(init=False)  # path of the unfinished PC2 file
    cache: PointCache = field(init=False)  # the unfinished PC2 file
    table: ForceTable = field(init=False)  # the unfinished table of forces
    moved: bool = False  # whether anything has moved it


@dataclass(frozen=True, slots=True, kw_only=True)
class BakePlan:
    """What to bake."""

    objects: Sequence[bpy.types.Object]  # the bodies
    first: int  # frame
    last: int  # frame, included
    folder: Path | None = None  # of the files; None: the folder for bakes of the scene


def bake(context: bpy.types.Context, plan: BakePlan, messages: list[str]) -> Iterator[float]:
    """Bake, and yield the fraction that is done. Closing the generator cancels the bake without any change.

    Args:
        messages: a list to which sentences for the artist are added.

    Raises:
        DimpleError: an object cannot be baked, the simulation blew up, or a file cannot be written.
    """
    bodies = yield from simulate(context, plan, messages)
    with bake_files.plain_os_errors("The bake"):
        for body in bodies:
            if obj := object_link.find(body.link.uid, body.link.name):
                press_modifier.remove(obj, BAKED_PRESS)
                bake_files.play(context, obj, body.path, plan.first, body.link.cuts)


def simulate(
    context: bpy.types.Context, plan: BakePlan, messages: list[str]
) -> Generator[float, None, Sequence[Baked]]:
    """Simulate and write the files; yield the fraction that is done, and return the bodies.

    Raises:
        DimpleError: an object cannot be baked, the simulation blew up, or a file cannot be written.
    """
    scene = context.scene
    before = scene.frame_current, scene.frame_subframe
    native.use_cores()
    with contextlib.ExitStack() as files, bake_files.plain_os_errors("The bake"):
        _check(plan)
        files.callback(go_to, scene, before)
        scene.frame_set(plan.first)
        bodies, each = [], READY / len(plan.objects)
        for done, obj in enumerate(plan.objects):
            opening = beside(_opening(context, plan, obj, messages, files), SLICE_S)
            bodies.append((yield from as_share(opening, done * each, each)))
        together = {body.link.uid: (body.obj, body.session, body.link.scale) for body in bodies}
        worlds = colliders.worlds_of(context, together)
        for body in bodies:
            if note := body.session.contact_note:
                messages.append(about(body.name, note))
        poses: props.Poses = {}
        held: dict[tuple[str, bool], tuple[float, Message]] = {}
        files.callback(props.put_back)
        _write(bodies, plan.first)
        _show_props(worlds, plan.first, poses)
        for frame in range(plan.first + 1, plan.last + 1):
            for each in _step(context, bodies, worlds, frame):
                key = each.name, each.torn  # the first frame where it is let go, or that where it is held back most
                if key not in held or (not each.torn and each.late > held[key][0]):
                    held[key] = each.late, Message("Frame {frame}: {said}", frame=frame, said=each.said)
            _show_props(worlds, frame, poses)
            _write(bodies, frame)
            share = (frame - plan.first) / (plan.last - plan.first)
            yield READY + (0.99 - READY) * share  # the last hundredth is for the files
        for file in [file for body in bodies for file in (body.cache, body.table)]:
            file.close()
        messages += [said for _, said in held.values()]
        if not any(body.moved for body in bodies):
            messages.append(
                "Nothing moves the bodies. Let a fingertip reach them (Fingertips > Add Fingertip), or tick Gravity, "
                "Dimple Collider or Sway."
            )
        props.fallen.clear()
        props.keyframe(poses)
        for body in bodies:
            for ending in (".csv", ".pc2"):
                os.replace(body.part.with_suffix(ending), body.path.with_suffix(ending))
    return bodies


def go_to(scene: bpy.types.Scene, frame: tuple[int, float]) -> None:
    """Go to a frame and subframe, unless the scene is there already."""
    if (scene.frame_current, scene.frame_subframe) != frame:
        scene.frame_set(frame[0], subframe=frame[1])


def _check(plan: BakePlan) -> None:
    if plan.last <= plan.first:
        raise DimpleError(
            "The last frame ({last}) must come after the first ({first}).", last=plan.last, first=plan.first
        )
    if (render := bpy.context.scene.render).frame_map_old != render.frame_map_new:
        raise DimpleError(
            "Time Stretching is on, but a bake plays unstretched frames. Set Old and New to the same value in Output "
            "> Frame Range > Time Stretching, and change the frame rate instead."
        )
    for obj in plan.objects:
        scene_objects.check(obj)
        scene_objects.check_writable(obj)


def _opening(
    context: bpy.types.Context, plan: BakePlan, obj: bpy.types.Object, messages: list[str], files: contextlib.ExitStack
) -> Parts:
    """Prepare an object for a bake, in parts; `files` closes its files and deletes the temporary folder at its exit."""
    files.enter_context(final_mesh.attached(context, obj))
    body, notes = yield from Baked.opening(context, obj)
    messages += notes
    body.path = bake_files.bake_path(context, obj, plan.folder)
    folder = plan.folder or files.enter_context(bake_files.unfinished_folder(body.path.parent))
    body.part = folder / body.path.name
    body.cache = PointCache(body.part, len(body.link.rest), plan.first)
    files.callback(_close, body.cache)
    body.table = ForceTable(body.part.with_suffix(".csv"))
    files.callback(_close, body.table)
    body.session.set_fingers(live_step.fingertips(context.scene, body.link.scale))
    body.session.step(0.0)  # the first frame already shows the contacts
    return body


def _close(file: PointCache | ForceTable) -> None:
    """Close a file, and ignore a disk error: if there is one, another is being raised already."""
    with contextlib.suppress(OSError):
        file.close()


def _step(
    context: bpy.types.Context, bodies: Sequence[Baked], worlds: Sequence[colliders.LiveWorld], frame: int
) -> list[Held]:
    """Step to a frame; return the colliders that could not go their way."""
    scene, held = context.scene, []
    for look_s in timeline.looks(scene, frame):
        for body in bodies:
            obj = body.obj
            follow_settings.follow_keyframes(scene, obj, body)
            body.session.set_fingers(live_step.fingertips(scene, body.link.scale))
            body.follow(context, obj)
        for world in worlds:
            colliders.lead_colliders(context, world)
            world.world.step(look_s)
            held += world.world.held
        met = {uid for world in worlds for uid in world.uids}
        alone = [body.session for body in bodies if body.link.uid not in met]
        step_all(alone, [look_s] * len(alone))
        for body in bodies:
            if body.session.frame.note:
                raise DimpleError(
                    '"{name}", frame {frame}: {note}', name=body.link.name, frame=frame, note=body.session.frame.note
                )
    return held


def _show_props(worlds: Sequence[colliders.LiveWorld], frame: int, poses: props.Poses) -> None:
    for world in worlds:
        props.show(world)
        props.note(world, frame, poses)


def _write(bodies: Sequence[Baked], frame: int) -> None:
    for body in bodies:
        offsets = body.offsets()
        body.moved |= bool(offsets.any())
        body.cache.append(offsets)
        body.table.append(frame, body.session.frame.time, body.session)
