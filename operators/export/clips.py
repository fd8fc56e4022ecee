"""The export plan, and what an exporter gets: the final mesh of one object, alone in a scene that is deleted later."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
import numpy.typing as npt

from ...core.base import DimpleError, Singles
from ...core.recording import PointCache, open_point_cache
from ...core.recording.basis import Basis, distinct, reduce
from ...core.recording.split import split
from ..bridge import bake_files, final_mesh, keyframes, press_modifier, rendered_mesh, scene_objects

SHEAR = 1e-4  # cosine between two axes below which they count as perpendicular: less is invisible on any object


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportPlan:
    """What to export."""

    objects: Sequence[bpy.types.Object]  # the bodies
    formats: Sequence[str]  # keys of `formats.FORMATS`, in the order in which they are written
    folder: Path  # for the files; made if missing
    first: int  # first frame; a simulation begins there, at rest
    last: int  # last frame, inclusive
    # largest error of a vertex with few shape keys, as a share of the object's size; 0: one shape key for each frame
    key_error: float = 0.0
    rendered: bool = False  # evaluate modifiers as for a render, not as for the viewport
    overwrite: bool = False  # replace existing files


@dataclass(slots=True, kw_only=True, eq=False)
class Clip:
    """An object and its animation."""

    obj: bpy.types.Object
    plan: ExportPlan  # frames and options
    # PC2 file of offsets to play, its first frame, and how often its final mesh is subdivided; None if the object plays
    # already
    plays: tuple[Path, float, int] | None = None
    table: Path | None = None  # CSV of forces that belongs to the animation


@dataclass(slots=True, eq=False)
class Seen:
    """What an object shows in each frame of its clip."""

    clip: Clip
    mesh: bpy.types.Mesh  # the final mesh at the first frame
    matrices: npt.NDArray[np.float64]  # (frames, 4, 4) of the object in the scene
    path: Path  # PC2 file of `samples`
    samples: Singles  # (frames, vertices, 3) coordinates of the final mesh
    # if a format needs them, normals (frames, n, 3) of vertices that are split at sharp edges
    normals: Singles | None = None
    split_of: npt.NDArray[np.intp] | None = None  # (corners,) the split vertex of each corner of the faces
    vertex_of: npt.NDArray[np.int32] | None = None  # (n,) the vertex of each split vertex
    made: Basis | None = None  # the shape keys, once they are chosen

    def keys(self) -> Basis:
        """Return which frames become shape keys, and their values in each frame; they are chosen once."""
        size = float(np.ptp(self.samples[0], axis=0).max())
        error = self.clip.plan.key_error * size
        self.made = self.made or (reduce(self.samples, self.normals, error) if error else distinct(self.samples))
        return self.made


@contextlib.contextmanager
def _playing(context: bpy.types.Context, clip: Clip) -> Iterator[None]:
    """Let an object play its clip, shown and with the modifiers of the plan; restore it and the frame later."""
    obj, scene = clip.obj, context.scene
    hidden, hidden_here, now = obj.hide_viewport, obj.hide_get(), (scene.frame_current, scene.frame_subframe)
    with contextlib.ExitStack() as shown:
        shown.callback(lambda: scene.frame_set(now[0], subframe=now[1]))
        shown.callback(obj.hide_set, hidden_here)
        shown.callback(setattr, obj, "hide_viewport", hidden)
        obj.hide_viewport = False
        obj.hide_set(False)
        if clip.plays:
            made = bake_files.play(context, obj, *clip.plays)
            shown.callback(press_modifier.sweep_data)
            shown.callback(obj.modifiers.remove, made)
        if clip.plan.rendered:
            shown.enter_context(rendered_mesh.as_rendered(obj))
        yield


@contextlib.contextmanager
def seen(context: bpy.types.Context, clip: Clip, folder: Path) -> Iterator[Seen]:
    """Play a clip once and give what is seen, in files in a folder.

    Raises:
        OSError: the disk refuses.
        DimpleError: the number of vertices changes between frames.
    """
    plan, mesh, matrices = clip.plan, None, []  # type: ignore[var-annotated]
    shaded = "VAT" in plan.formats or plan.key_error > 0
    stem = bake_files.file_name(clip.obj.name)  # a file of its own, since a mapped one cannot be overwritten on Windows
    paths, caches = [folder / f"seen_{stem}.pc2", folder / f"normals_{stem}.pc2"][: 1 + shaded], []  # type: ignore[var-annotated]
    try:
        with _playing(context, clip), contextlib.ExitStack() as files:
            for frame in range(plan.first, plan.last + 1):
                context.scene.frame_set(frame)
                now = final_mesh.evaluated(context, clip.obj)
                if mesh is None:
                    graph = context.evaluated_depsgraph_get()
                    mesh = bpy.data.meshes.new_from_object(
                        clip.obj.evaluated_get(graph), preserve_all_data_layers=True, depsgraph=graph
                    )
                    counts = len(now.vertices), len(now.loops)
                    caches = [
                        files.enter_context(PointCache(*each, plan.first)) for each in zip(paths, counts, strict=False)
                    ]
                caches[0].append(final_mesh.points_of(now))
                for cache in caches[1:]:
                    cache.append(final_mesh.get_points(now.corner_normals, len(now.loops), "vector"))
                matrices.append(np.array(clip.obj.matrix_world))
        found = Seen(clip, mesh, np.array(matrices), paths[0], open_point_cache(paths[0])[1])
        if shaded:
            corners, (_, normals) = final_mesh.corners_of(mesh), open_point_cache(paths[1])
            begins, found.split_of = split(corners, normals)
            found.vertex_of, found.normals = corners[begins], normals[:, begins]
        yield found
    finally:
        if mesh:
            bpy.data.meshes.remove(mesh)


@contextlib.contextmanager
def staged(
    context: bpy.types.Context, seen: Seen, *, first: int = 0, metres: bool = True
) -> Iterator[bpy.types.Object]:
    """Put the mesh of a clip alone into a scene of its own, where it moves as its object does.

    Args:
        first: the frame at which it begins there.
        metres: the unit of the scene is a metre; else it is that of the artist's scene.
    """
    body, before = seen.clip.obj, context.scene
    unit = scene_objects.metres_per_unit(before) if metres else 1.0
    names = [(each, each.name) for each in (body, body.data)]
    actions, scene, mesh = set(bpy.data.actions), bpy.data.scenes.new("Dimple"), seen.mesh.copy()
    try:
        for each, _ in names:  # the copies have their names, which are written to the file
            if not each.library:
                each.name = ".Dimple"
        obj = bpy.data.objects.new(names[0][1], mesh)
        mesh.name = names[1][1]
        scene.collection.objects.link(obj)
        for slot, given in zip(obj.material_slots, body.material_slots, strict=False):
            slot.link, slot.material = given.link, given.material
        scene.render.fps, scene.render.fps_base = before.render.fps, before.render.fps_base
        scene.frame_end = first + len(seen.samples) - 1
        scene.frame_start = first  # in this order: the end is never before the start
        _move(obj, np.array([unit, unit, unit, 1])[:, None] * seen.matrices, first)
        with context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
            scene.frame_set(first)
            yield obj
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.meshes.remove(mesh)  # and the object with it
        bpy.data.batch_remove(set(bpy.data.actions) - actions)
        for each, name in names:
            if not each.library:
                each.name = name


def check_shear(obj: bpy.types.Object, matrices: npt.NDArray[np.float64]) -> None:
    """Raise a DimpleError if matrices (frames, 4, 4) of an object shear it."""
    axes = matrices[:, :3, :3] / np.linalg.norm(matrices[:, :3, :3], axis=1, keepdims=True)
    if np.abs(axes.transpose(0, 2, 1) @ axes - np.eye(3)).max() > SHEAR:
        raise DimpleError('"{name}" is sheared by the scale of its parents. Apply that scale.', name=obj.name)


def _move(obj: bpy.types.Object, matrices: npt.NDArray[np.float64], first: int) -> None:
    """Give an object these matrices (frames, 4, 4) from a frame on."""
    from mathutils import Matrix

    check_shear(obj, matrices)
    obj.rotation_mode = "QUATERNION"
    parts = [Matrix(each).decompose() for each in matrices]
    for (_, before, _), (_, turn, _) in itertools.pairwise(parts):
        turn.make_compatible(before)
    obj.location, obj.rotation_quaternion, obj.scale = parts[0]
    if (matrices != matrices[0]).any():
        bag = _animated(obj)
        for path, values in zip(("location", "rotation_quaternion", "scale"), zip(*parts, strict=True), strict=True):
            for axis, column in enumerate(zip(*values, strict=True)):
                keyframes.draw(bag, path, range(first, first + len(column)), column, axis)


def _animated(owner: bpy.types.ID) -> bpy.types.ActionChannelbag:
    """Return the empty channel bag of an owner in a new action."""
    animation, action = owner.animation_data_create(), bpy.data.actions.new("Dimple")
    slot = action.slots.new(owner.id_type, "Dimple")
    animation.action, animation.action_slot = action, slot
    return keyframes.bag_in(action, slot)


def add_cache(obj: bpy.types.Object, seen: Seen) -> None:
    """Let an object that is staged from the first frame of the clip on play what is seen."""
    modifier = obj.modifiers.new("Dimple", "MESH_CACHE")
    modifier.cache_format, modifier.filepath = "PC2", str(seen.path)
    modifier.frame_start = seen.clip.plan.first


def add_keys(obj: bpy.types.Object, seen: Seen) -> None:
    """Give an object that is staged from frame 0 on keyframed shape keys."""
    keys = seen.keys()
    if not keys.chosen:
        return
    obj.shape_key_add(name="Basis", from_mix=False)
    bag = _animated(obj.data.shape_keys)
    for place, values in zip(keys.chosen, keys.weights.T, strict=True):
        key = obj.shape_key_add(name=f"Frame {seen.clip.plan.first + place:04d}", from_mix=False)
        key.points.foreach_set("co", seen.samples[place].ravel())
        keyframes.draw(bag, f'key_blocks["{key.name}"].value', range(len(values)), values.tolist())
