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
from ...core.messages import Message, about
from ...core.recording import PointCache
from ...core.session import step_all
from ..bridge import cache_files, final_mesh, modifiers, scene_objects, timeline, write_back
from ..press import colliders, follow_settings, live_step, props, recorder
from ..press.object_body import ObjectBody
from ..press.progress import READY
from . import shape_keys  # fmt: skip

if TYPE_CHECKING:
    from ...core.world.world import Held
    from ..bridge.scene_objects import Singles


@dataclass(slots=True, kw_only=True, eq=False)
class Baked(ObjectBody):
    """One object of a bake."""

    path: Path = field(init=False)  # destination of the PC2 file
    part: Path = field(init=False)  # path of the unfinished PC2 file
    cache: PointCache | None = None  # the unfinished PC2 file, None for shape keys
    table: recorder.ForceTable = field(init=False)  # the unfinished table of forces
    # frame of each shape key, and its offsets (N, 3) from the shape at rest in that frame
    shapes: list[tuple[int, Singles]] = field(default_factory=list)


@dataclass(frozen=True, slots=True, kw_only=True)
class BakePlan:
    """What to bake."""

    objects: Sequence[bpy.types.Object]  # the bodies
    first: int  # frame
    last: int  # frame, included
    target: str  # "MESH_CACHE", "SHAPE_KEYS", or "FILES", which no object plays
    step: int = 1  # frames from one shape key to the next
    folder: Path | None = None  # of the files; None: the folder for bakes of the scene


def plan_of(
    scene: bpy.types.Scene, objects: Sequence[bpy.types.Object], first: int | None, last: int | None, target: str
) -> BakePlan:
    """Return a plan with the settings of a scene, and with its frames if none are given."""
    return BakePlan(
        objects=objects, first=scene.frame_start if first is None else first,
        last=scene.frame_end if last is None else last, target=target, step=scene.dimple.shape_key_step,
    )  # fmt: skip


def bake(context: bpy.types.Context, plan: BakePlan, messages: list[str]) -> Iterator[float]:
    """Bake, and yield the fraction that is done. Closing the generator cancels the bake without any change.

    Args:
        messages: a list to which sentences for the artist are added.

    Raises:
        DimpleError: an object cannot be baked, the simulation blew up, or a file cannot be written.
    """
    bodies = yield from simulate(context, plan, messages)
    with cache_files.plain_os_errors("The bake"):
        for body in bodies:
            _play(context, plan, body)


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
    with contextlib.ExitStack() as files, cache_files.plain_os_errors("The bake"):
        _check(plan)
        files.callback(go_to, scene, before)
        scene.frame_set(plan.first)
        bodies, each = [], READY / len(plan.objects)
        for done, obj in enumerate(plan.objects):
            opening = beside(_opening(context, plan, obj, messages, files))
            bodies.append((yield from as_share(opening, done * each, each)))
        together = {body.link.uid: (body.obj, body.session, body.link.scale) for body in bodies}
        worlds = colliders.worlds_of(context, together)
        for body in bodies:
            if note := body.session.contact_note:
                messages.append(about(body.name, note))
        poses: props.Poses = {}
        held: dict[tuple[str, bool], tuple[float, Message]] = {}
        files.callback(props.put_back)
        _write(plan, bodies, plan.first)
        _show_props(worlds, plan.first, poses)
        for frame in range(plan.first + 1, plan.last + 1):
            for each in _step(context, bodies, worlds, frame):
                if each.late >= held.get((each.name, each.torn), (0.0,))[0]:
                    said = Message("Frame {frame}: {said}", frame=frame, said=each.said)
                    held[each.name, each.torn] = each.late, said
            _show_props(worlds, frame, poses)
            _write(plan, bodies, frame)
            share = (frame - plan.first) / (plan.last - plan.first)
            yield READY + (0.99 - READY) * share  # the last hundredth is for the files
        for file in [file for body in bodies for file in (body.cache, body.table) if file]:
            file.close()
        messages += [said for _, said in held.values()]
        props.fallen.clear()
        props.keyframe(poses)
        for body in bodies:
            for part, path in _files(body):
                os.replace(part, path)
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
            "Time Stretching is on, and a bake plays by frames that are not stretched. Make Old and New alike in "
            "Output > Frame Range > Time Stretching, and change the frame rate instead."
        )
    for obj in plan.objects:
        scene_objects.check(obj)
        scene_objects.check_writable(obj)
        if plan.target == "SHAPE_KEYS":
            _check_keys(obj)


def _check_keys(obj: bpy.types.Object) -> None:
    """Raise a DimpleError if an object cannot have the shape keys of a bake."""
    keys = obj.data.shape_keys
    if obj.data.library:
        raise DimpleError(
            '"{name}" has a mesh of another file. Make it local first: Object > Relations.', name=obj.name
        )
    if keys and not keys.use_relative:
        raise DimpleError('"{name}" has absolute shape keys. Switch its shape keys to Relative first.', name=obj.name)
    if keys and obj.show_only_shape_key:
        raise DimpleError('"{name}" shows one shape key only. Switch Solo Active Shape Key off first.', name=obj.name)
    if others := [each.name for each in obj.modifiers if each.show_viewport and not modifiers.is_cache(each)]:
        raise DimpleError(
            '"{name}" shows what its modifier "{others}" makes of its mesh, and shape keys move the mesh before '
            "that. Bake to a Mesh Cache, or export.",
            name=obj.name, others=others[0]
        )  # fmt: skip


def _opening(
    context: bpy.types.Context, plan: BakePlan, obj: bpy.types.Object, messages: list[str], files: contextlib.ExitStack
) -> Parts:
    """Prepare an object for a bake, in parts; `files` closes its files and deletes the temporary folder at its exit."""
    files.enter_context(final_mesh.unbaked(obj))
    files.enter_context(final_mesh.attached(context, obj))
    body, notes = yield from Baked.opening(context, obj)
    if plan.target == "SHAPE_KEYS" and body.link.cuts:
        raise DimpleError(
            '"{name}" is too coarse for shape keys. Subdivide it, bake to a Mesh Cache, or export.', name=obj.name
        )
    messages += notes
    if plan.target == "SHAPE_KEYS" and write_back.is_shared(obj.data):
        messages.append(Message(
            '"{name}" shares its mesh with other objects: its shape keys go on a copy of its own.', name=obj.name
        ))  # fmt: skip
    body.path = cache_files.bake_path(context, obj, plan.folder)
    folder = plan.folder or files.enter_context(cache_files.unfinished_folder(body.path.parent))
    body.part = folder / body.path.name
    if plan.target != "SHAPE_KEYS":
        body.cache = PointCache(body.part, len(body.link.rest), plan.first)
        files.callback(recorder.quietly, body.cache.close)
    body.table = recorder.ForceTable(body.part.with_suffix(".csv"))
    files.callback(recorder.quietly, body.table.close)
    body.session.set_fingers(live_step.fingertips(context.scene, body.link.scale))
    body.session.step(0.0)  # the first frame already shows the contacts
    return body


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


def _write(plan: BakePlan, bodies: Sequence[Baked], frame: int) -> None:
    for body in bodies:
        if body.cache:
            body.cache.append(body.offsets())
        elif (frame - plan.first) % plan.step == 0 or frame == plan.last:
            body.shapes.append((frame, body.offsets()))
        body.table.append(frame, body.session.frame.time, body.session)


def _files(body: Baked) -> list[tuple[Path, Path]]:
    """Return the temporary path and the destination of each file of a body."""
    endings = [".csv", *([".pc2"] if body.cache else [])]
    return [(body.part.with_suffix(ending), body.path.with_suffix(ending)) for ending in endings]


def _play(context: bpy.types.Context, plan: BakePlan, body: Baked) -> None:
    obj = scene_objects.find(body.link.uid, body.link.name)
    if obj is None:
        return
    if plan.target == "MESH_CACHE":
        shape_keys.remove(obj)
        cache_files.attach_cache(context, obj, str(body.path), plan.first, body.link.cuts)
    elif plan.target == "SHAPE_KEYS":
        cache_files.detach_cache(obj)
        shape_keys.add(obj, body.shapes)
        cache_files.add_curves(obj, body.path)
