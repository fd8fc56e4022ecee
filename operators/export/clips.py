"""The export plan, and what an exporter gets: one object, selected alone, playing or with keyframed shape keys.

Each context manager restores the object exactly.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from ...core.recording import PointCache, open_point_cache
from ...core.recording.basis import Basis, distinct, reduce
from ...core.recording.split import split
from ..bridge import cache_files, final_mesh, keyframes, modifiers, offset, rendered_mesh

Singles = npt.NDArray[np.float32]
UV_MAP = "dimple_vertex"


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportPlan:
    """What to export."""

    objects: Sequence[bpy.types.Object]  # the bodies
    formats: Sequence[str]  # keys of `formats.FORMATS`, in the order in which they are written
    folder: Path  # for the files; made if missing
    first: int  # first frame
    last: int  # last frame, inclusive
    begin: int | None = None  # frame at which the simulation starts at rest; None: `first`
    # largest error of a vertex with few shape keys, as a share of the object's size; 0: one shape key for each frame
    key_error: float = 0.0
    rendered: bool = False  # evaluate modifiers as for a render, not as for the viewport
    simulate: bool = False  # also simulate objects that play a bake or a recording
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
    simulated: dict[str, Any] | None = None  # description of the simulation, if it was run for this export
    # coordinates (frames, vertices, 3) of the final mesh; if a format needs them, normals (frames, n, 3) of vertices
    # that are split at sharp edges, and the vertex that each of those was
    samples: Singles = field(default_factory=lambda: np.empty((0, 0, 3), np.float32))
    normals: Singles = field(default_factory=lambda: np.empty((0, 0, 3), np.float32))
    split_of: npt.NDArray[np.intp] = field(default_factory=lambda: np.empty(0, np.intp))  # of each face corner
    vertex_of: npt.NDArray[np.int32] = field(default_factory=lambda: np.empty(0, np.int32))  # of each split vertex
    made: Basis | None = None  # the shape keys, once they are chosen

    def keys(self) -> Basis:
        """Return which frames become shape keys, and their values in each frame; they are chosen once."""
        size = float(np.ptp(self.samples[0], axis=0).max())
        error = self.plan.key_error * size
        self.made = self.made or (reduce(self.samples, self.normals, error) if error else distinct(self.samples))
        return self.made


@contextlib.contextmanager
def _ranged(scene: bpy.types.Scene, first: int, last: int) -> Iterator[None]:
    """Set the frame range of a scene and show its first frame; most exporters take the range from the scene."""
    before = scene.frame_start, scene.frame_end, scene.use_preview_range
    now = scene.frame_current, scene.frame_subframe
    scene.use_preview_range = False
    scene.frame_start, scene.frame_end = first, last  # setting one end may shift the other
    scene.frame_start = first
    scene.frame_set(first)
    try:
        yield
    finally:
        scene.frame_start, scene.frame_end, scene.use_preview_range = before
        scene.frame_start = before[0]
        scene.frame_set(now[0], subframe=now[1])


@contextlib.contextmanager
def selected(context: bpy.types.Context, obj: bpy.types.Object) -> Iterator[None]:
    """Select one object alone; show it if it is hidden."""
    layer = context.view_layer
    before, active = [each for each in layer.objects if each.select_get()], layer.objects.active
    hidden, hidden_here, fixed = obj.hide_viewport, obj.hide_get(), obj.hide_select
    for each in before:
        each.select_set(False)
    obj.hide_viewport = obj.hide_select = False
    obj.hide_set(False)
    obj.select_set(True)
    layer.objects.active = obj
    try:
        yield
    finally:
        obj.select_set(False)
        obj.hide_viewport, obj.hide_select = hidden, fixed
        obj.hide_set(hidden_here)
        for each in before:
            each.select_set(True)
        layer.objects.active = active


@contextlib.contextmanager
def playing(context: bpy.types.Context, clip: Clip) -> Iterator[None]:
    """Select the object of a clip at the first frame, playing the clip in place of its bake, with the plan's modifiers.
    """
    obj = clip.obj
    ours = [modifier for modifier in obj.modifiers if modifiers.is_cache(modifier)] if clip.plays else []
    before = [(modifier, modifier.show_viewport, modifier.show_render) for modifier in ours]
    frames = _ranged(context.scene, clip.plan.first, clip.plan.last)
    with frames, selected(context, obj), contextlib.ExitStack() as shown:
        try:
            for modifier in ours:
                modifier.show_viewport = modifier.show_render = False
            made = cache_files.play(context, obj, *clip.plays) if clip.plays else None
            if clip.plan.rendered:
                shown.enter_context(rendered_mesh.as_rendered(obj))
            yield
        finally:
            shown.close()
            if made:
                obj.modifiers.remove(made)
                offset.sweep_data()
            for modifier, viewport, render in before:
                modifier.show_viewport, modifier.show_render = viewport, render


def look(context: bpy.types.Context, clip: Clip, folder: Path, *, normals: bool) -> None:
    """Give a clip the coordinates that its object shows while it plays, and its normals, in files in a folder.

    Raises:
        OSError: the disk refuses.
        DimpleError: the number of vertices changes between frames.
    """
    first, last, caches = clip.plan.first, clip.plan.last, []  # type: ignore[var-annotated]
    paths = [folder / "seen.pc2", folder / "normals.pc2"][: 1 + normals]
    with playing(context, clip), contextlib.ExitStack() as files:
        for frame in range(first, last + 1):
            context.scene.frame_set(frame)
            mesh = final_mesh.evaluated(context, clip.obj)
            if not caches:
                counts, corners = (len(mesh.vertices), len(mesh.loops)), final_mesh.corners_of(mesh)
                caches = [files.enter_context(PointCache(*each, first)) for each in zip(paths, counts, strict=False)]
            caches[0].append(final_mesh.points_of(mesh))
            for cache in caches[1:]:
                cache.append(final_mesh.get_points(mesh.corner_normals, len(mesh.loops), "vector"))
    _, clip.samples = open_point_cache(paths[0])
    if normals:
        _, of_corners = open_point_cache(paths[1])
        begins, clip.split_of = split(corners, of_corners)
        clip.vertex_of, clip.normals = corners[begins], of_corners[:, begins]


@contextlib.contextmanager
def keyed(context: bpy.types.Context, clip: Clip, keys: Basis | None) -> Iterator[None]:
    """Give an object its final mesh with keyframed shape keys, in place of its own mesh and modifiers."""
    obj = clip.obj
    with playing(context, clip):
        graph = context.evaluated_depsgraph_get()
        copy = bpy.data.meshes.new_from_object(
            obj.evaluated_get(graph), preserve_all_data_layers=True, depsgraph=graph
        )
    mesh, name = obj.data, obj.data.name
    before = obj.active_shape_key_index, obj.show_only_shape_key
    shaping = [(each, each.show_viewport, each.show_render) for each in obj.modifiers]
    if not mesh.library:  # free its name for the copy: it is written to the file
        mesh.name = f"{name[:50]}.dimple"
    copy.name = name
    obj.data = copy
    obj.show_only_shape_key = False
    action = bpy.data.actions.new("Dimple")
    for modifier, *_ in shaping:  # the keys include their effect
        modifier.show_viewport = modifier.show_render = False
    try:
        obj.shape_key_clear()
        copy.vertices.foreach_set("co", clip.samples[0].ravel())
        if keys and keys.chosen:
            _add_keys(clip, keys, action)
        with _ranged(context.scene, clip.plan.first, clip.plan.last), selected(context, obj):
            yield
    finally:
        obj.data = mesh
        bpy.data.meshes.remove(copy)
        bpy.data.actions.remove(action)
        for modifier, viewport, render in shaping:
            modifier.show_viewport, modifier.show_render = viewport, render
        if not mesh.library:
            mesh.name = name
        obj.active_shape_key_index, obj.show_only_shape_key = before


@contextlib.contextmanager
def mapped(context: bpy.types.Context, clip: Clip, uv: Singles) -> Iterator[None]:
    """Give an object its final mesh at the first frame, with a second UV map from the `uv` of split vertices."""
    with keyed(context, clip, None):
        mesh = clip.obj.data
        while len(mesh.uv_layers) > 1:  # the new map must be the second
            mesh.uv_layers.remove(mesh.uv_layers[-1])
        if not mesh.uv_layers:
            mesh.uv_layers.new(name="UVMap", do_init=False)
        corners = uv[clip.split_of]
        mesh.uv_layers.new(name=UV_MAP, do_init=False).uv.foreach_set("vector", corners.ravel())
        yield


def _add_keys(clip: Clip, keys: Basis, action: bpy.types.Action) -> None:
    obj, first = clip.obj, clip.plan.first
    obj.shape_key_add(name="Basis", from_mix=False)
    data = obj.data.shape_keys
    slot = action.slots.new("KEY", "Dimple")
    bag = keyframes.bag_in(action, slot)
    for place, values in zip(keys.chosen, keys.weights.T, strict=True):
        key = obj.shape_key_add(name=f"Frame {first + place:04d}", from_mix=False)
        key.points.foreach_set("co", clip.samples[place].ravel())
        keyframes.draw(bag, f'key_blocks["{key.name}"].value', range(first, clip.plan.last + 1), values.tolist())
    animation = data.animation_data_create()
    animation.action, animation.action_slot = action, slot
