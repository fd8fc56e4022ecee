"""What is to be exported; and what an exporter gets: an object, selected alone, playing or with keyframed shape keys.

Each context manager puts the object back exactly as it was.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np
import numpy.typing as npt

from ...core.recording import PointCache, open_point_cache
from ..bridge import cache_files, final_mesh, keyframes, modifiers, offset

Singles = npt.NDArray[np.float32]
UV_MAP = "dimple_vertex"


class KeyedShape(NamedTuple):
    """A shape key: its name, coordinates (vertices, 3), and its value at some frames."""

    name: str
    shape: Singles
    frames: Sequence[int]
    values: Sequence[float]


class Keys(NamedTuple):
    """The shape keys of a clip, and how far a vertex is off where they are played, at the most."""

    shapes: list[KeyedShape]
    error: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ExportPlan:
    """What to export."""

    objects: Sequence[bpy.types.Object]  # the bodies
    formats: Sequence[str]  # keys of `formats.FORMATS`, in the order in which they are written
    folder: Path  # where the files go; it is made
    first: int  # frame
    last: int  # frame, included
    begin: int | None = None  # frame at which the simulation begins at rest; None is the first
    step: int = 1  # frames from one shape key to the next
    # how far a vertex may be off where shape keys are few, as a share of the object's size; 0 for a shape key every
    # `step` frames
    key_error: float = 0.0
    simulate: bool = False  # also objects that play a bake or a recording
    overwrite: bool = False  # files that are there
    normals: bool = True  # write how the surface is shaded


@dataclass(slots=True, kw_only=True, eq=False)
class Clip:
    """An object and its animation."""

    obj: bpy.types.Object
    plan: ExportPlan  # frames and options
    # the PC2 file of offsets that it is to play, its first frame, and how often its final mesh is subdivided; None
    # where it plays already
    plays: tuple[Path, float, int] | None = None
    table: Path | None = None  # of forces, beside what it plays
    simulated: dict[str, Any] | None = None  # how, where it was for this
    # (frames, vertices, 3) coordinates of its final mesh; none where no format asks
    samples: Singles = field(default_factory=lambda: np.empty((0, 0, 3), np.float32))
    made: Keys | None = None  # the shape keys, once they are

    @property
    def frames(self) -> int:
        """Return how many frames there are."""
        return self.plan.last - self.plan.first + 1

    def keys(self) -> Keys:
        """Return the shape keys; they are made once."""
        self.made = self.made or (self._few() if self.plan.key_error else self._each())
        return self.made

    def _each(self) -> Keys:
        """Return a shape key for every few frames; from one to the next a straight line leads."""
        from ...core.recording.basis import error_between

        plan = self.plan
        frames = sorted({*range(plan.first, plan.last + 1, plan.step), plan.last})
        at = [frame - plan.first for frame in frames]
        near = [frames[max(number - 1, 0) : number + 2] for number in range(len(frames))]
        shapes = [
            KeyedShape(f"Frame {frame:04d}", self.samples[where], some, [float(each == frame) for each in some])
            for frame, where, some in zip(frames, at, near, strict=True)
        ]
        return Keys(shapes, error_between(self.samples, at))

    def _few(self) -> Keys:
        """Return the few shapes of which every frame is a sum."""
        from ...core.recording.basis import reduce

        basis = reduce(self.samples, self.plan.key_error * float(np.ptp(self.samples[0], axis=0).max()))
        frames = list(range(self.plan.first, self.plan.last + 1))
        shapes = [
            KeyedShape(f"Shape {number:03d}", self.samples[0] + shape, frames, weights)
            for number, (shape, weights) in enumerate(zip(basis.shapes, basis.weights.T, strict=True), start=1)
        ]
        return Keys(shapes, basis.error)


@contextlib.contextmanager
def ranged(scene: bpy.types.Scene, first: int, last: int) -> Iterator[None]:
    """Let a scene have these frames, and show the first; most exporters ask the scene."""
    before = scene.frame_start, scene.frame_end, scene.use_preview_range
    now = scene.frame_current, scene.frame_subframe
    scene.use_preview_range = False
    scene.frame_start, scene.frame_end = first, last  # Blender keeps the end behind the start, whatever it was
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
    """Select one object alone; one that is hidden is shown."""
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
    """Select the object of a clip, playing that in place of its own bake."""
    obj = clip.obj
    if clip.plays is None:
        with selected(context, obj):
            yield
        return
    ours = [modifier for modifier in obj.modifiers if modifiers.is_cache(modifier)]
    before = [(modifier, modifier.show_viewport, modifier.show_render) for modifier in ours]
    with selected(context, obj):
        try:
            for modifier in ours:
                modifier.show_viewport = modifier.show_render = False
            cache_files.play(context, obj, *clip.plays)
            yield
        finally:
            for modifier in [each for each in obj.modifiers if modifiers.is_cache(each) and each not in ours]:
                obj.modifiers.remove(modifier)
            offset.sweep_data()
            for modifier, viewport, render in before:
                modifier.show_viewport, modifier.show_render = viewport, render


def seen(context: bpy.types.Context, clip: Clip, path: Path) -> Singles:
    """Return the coordinates (frames, vertices, 3) that an object shows while it plays; they go to a file.

    Raises:
        OSError: the disk refuses.
        DimpleError: it does not show as many vertices in each frame.
    """
    first, last, cache = clip.plan.first, clip.plan.last, None
    with ranged(context.scene, first, last), playing(context, clip), contextlib.ExitStack() as files:
        for frame in range(first, last + 1):
            context.scene.frame_set(frame)
            mesh = clip.obj.evaluated_get(context.evaluated_depsgraph_get()).data
            cache = cache or files.enter_context(PointCache(path, len(mesh.vertices), first))
            cache.append(final_mesh.points_of(mesh))
    _, samples = open_point_cache(path)
    return samples


@contextlib.contextmanager
def keyed(context: bpy.types.Context, clip: Clip, keys: Sequence[KeyedShape]) -> Iterator[None]:
    """Give an object its final mesh with keyframed shape keys, in place of its own mesh and its modifiers."""
    obj = clip.obj
    with playing(context, clip):
        graph = context.evaluated_depsgraph_get()
        copy = bpy.data.meshes.new_from_object(
            obj.evaluated_get(graph), preserve_all_data_layers=True, depsgraph=graph
        )
    mesh, name = obj.data, obj.data.name
    before = obj.active_shape_key_index, obj.show_only_shape_key
    shaping = [(each, each.show_viewport, each.show_render) for each in obj.modifiers]
    if not mesh.library:  # its name is written to the file
        mesh.name = f"{name[:50]}.dimple"
    copy.name = name
    obj.data = copy
    obj.show_only_shape_key = False
    action = bpy.data.actions.new("Dimple")
    for modifier, *_ in shaping:  # the keys include their effect
        modifier.show_viewport = modifier.show_render = False
    try:
        _add_keys(obj, clip.samples[0], keys, action)
        with selected(context, obj):
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
    """Give an object its final mesh as in the first frame, with a last UV map that has a place a vertex."""
    with keyed(context, clip, []):
        clip.obj.shape_key_clear()
        mesh = clip.obj.data
        while len(mesh.uv_layers) > 1:  # ours is to be the second one
            mesh.uv_layers.remove(mesh.uv_layers[-1])
        if not mesh.uv_layers:
            mesh.uv_layers.new(name="UVMap")
        corners = uv[final_mesh.corners_of(mesh)]
        mesh.uv_layers.new(name=UV_MAP, do_init=False).uv.foreach_set("vector", corners.ravel())
        yield


def _add_keys(obj: bpy.types.Object, rest: Singles, keys: Sequence[KeyedShape], action: bpy.types.Action) -> None:
    obj.shape_key_clear()
    obj.data.vertices.foreach_set("co", rest.ravel())
    obj.shape_key_add(name="Basis", from_mix=False)
    data = obj.data.shape_keys
    slot = action.slots.new("KEY", "Dimple")
    bag = keyframes.bag_in(action, slot)
    for name, shape, frames, values in keys:
        key = obj.shape_key_add(name=name, from_mix=False)
        key.points.foreach_set("co", shape.ravel())
        key.slider_min = -1.0  # as a weight of a basis can be
        keyframes.draw(bag, f'key_blocks["{name}"].value', frames, values)
    animation = data.animation_data_create()
    animation.action, animation.action_slot = action, slot
