"""A body with a rig and shape keys: the press follows them, the bake equals it, and the mesh never changes."""

import hashlib
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.point_cache import cache_of, read_point_cache

Add = Callable[..., Any]
Shown = Callable[[Any], np.ndarray]
KINDS = {
    "FLOAT_VECTOR": ("vector", 3, np.float32), "FLOAT2": ("vector", 2, np.float32), "FLOAT": ("value", 1, np.float32),
    "INT32_2D": ("value", 2, np.int32), "INT16_2D": ("value", 2, np.int16), "INT": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, bool),
}  # fmt: skip


def walker(bpy: ModuleType, add: Add, rings: int = 12, around: int = 12, name: str = "Walker") -> Any:
    """Return a leg of 400 mm, keyframed: an armature bends its knee and walks on, and a shape key fattens its calf."""
    z, turn = np.linspace(0, 4, rings), np.arange(around) * 2 * np.pi / around
    ring = np.stack([0.5 * np.cos(turn), 0.5 * np.sin(turn)], axis=1)
    points = [(*xy, height) for height in z for xy in ring] + [(0, 0, 0), (0, 0, 4)]
    at = np.arange(rings * around).reshape(rings, around)
    low, high = at[:-1], at[1:]
    quads = np.stack([low, np.roll(low, -1, 1), np.roll(high, -1, 1), high], axis=-1).reshape(-1, 4).tolist()
    ends = [(b, a, rings * around) for a, b in zip(at[0], np.roll(at[0], -1), strict=True)]
    ends += [(a, b, rings * around + 1) for a, b in zip(at[-1], np.roll(at[-1], -1), strict=True)]
    obj = add(points, [*quads, *[[int(i) for i in each] for each in ends]], name)
    obj.dimple.size_mm = 400
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Calf")
    for vertex, point in enumerate(points):
        key.data[vertex].co = (*(np.array(point[:2]) * (1.2 if point[2] < 1.5 else 1.0)), point[2])
    key.value = 0.0
    key.keyframe_insert("value", frame=1)
    key.value = 1.0
    key.keyframe_insert("value", frame=8)
    rig = armature(bpy, obj, f"{name} Rig")
    for frame, angle, way in ((1, 0.0, 0.0), (8, 0.6, 0.3)):
        bone = rig.pose.bones["Thigh"]
        bone.rotation_mode, bone.rotation_euler = "XYZ", (angle, 0, 0)
        bone.keyframe_insert("rotation_euler", frame=frame)
        rig.location.y = way
        rig.keyframe_insert("location", frame=frame)
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.context.scene.frame_set(1)
    return obj


def armature(bpy: ModuleType, obj: Any, name: str) -> Any:
    """Return an armature with a calf and a thigh, which share the knee, and let it deform an object."""
    data = bpy.data.armatures.new(name)
    rig = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    calf, thigh = data.edit_bones.new("Calf"), data.edit_bones.new("Thigh")
    calf.head, calf.tail, thigh.head, thigh.tail = (0, 0, 0), (0, 0, 2), (0, 0, 2), (0, 0, 4)
    bpy.ops.object.mode_set(mode="OBJECT")
    groups = [obj.vertex_groups.new(name=each) for each in ("Calf", "Thigh")]
    for vertex in obj.data.vertices:
        share = float(np.clip((vertex.co.z - 1.5) / 1.0, 0, 1))
        for group, weight in zip(groups, (1 - share, share), strict=True):
            group.add([vertex.index], weight, "REPLACE")
    obj.modifiers.new("Armature", "ARMATURE").object = rig
    rig.select_set(False)
    return rig


def bits(obj: Any) -> str:
    """Return a checksum of all that a mesh holds: topology, attributes with UV, weights, shape keys and values."""
    mesh, sums = obj.data, hashlib.sha256()
    for attribute in sorted(mesh.attributes, key=lambda each: each.name):
        sums.update(f"{attribute.name} {attribute.data_type} {attribute.domain}".encode())
        field, width, kind = KINDS[attribute.data_type]
        numbers = np.empty(width * len(attribute.data), kind)
        attribute.data.foreach_get(field, numbers)
        sums.update(numbers.tobytes())
    sums.update(repr([tuple(each.vertices) for each in mesh.polygons]).encode())
    weights = [[(group.group, group.weight) for group in vertex.groups] for vertex in mesh.vertices]
    sums.update(repr((len(mesh.edges), len(mesh.loops), [each.name for each in obj.vertex_groups], weights)).encode())
    for key in mesh.shape_keys.key_blocks if mesh.shape_keys else ():
        numbers = np.empty(3 * len(key.data), np.float32)
        key.data.foreach_get("co", numbers)
        value = None if mesh.shape_keys.animation_data else key.value  # what is keyframed depends on the frame
        sums.update(repr((key.name, value, key.mute)).encode() + numbers.tobytes())
    return sums.hexdigest()


def fingertip(bpy: ModuleType, scene: Any, matrices: dict[int, Any]) -> Any:
    """Return a fingertip that is keyframed to places by frame."""
    tip = bpy.data.objects.new("Fingertip", None)
    scene.collection.objects.link(tip)
    for frame, place in matrices.items():
        tip.location = place
        tip.keyframe_insert("location", frame=frame)
    scene.dimple.finger_1 = tip
    return tip


def skin(bpy: ModuleType, obj: Any, vertex: int) -> Callable[[int, float], np.ndarray]:
    """Return a function of frame and depth [scene units]: where a fingertip presses the skin at a vertex so deep."""

    def place(frame: int, depth: float, radius: float = 0.1) -> np.ndarray:
        bpy.context.scene.frame_set(frame)
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        at = evaluated.data.vertices[vertex]
        matrix = np.array(evaluated.matrix_world)
        normal = matrix[:3, :3] @ np.array(at.normal)
        return matrix[:3, :3] @ np.array(at.co) + matrix[:3, 3] + (radius - depth) * normal

    return place


@pytest.fixture
def walking(bpy: ModuleType, scene: Any, add: Add) -> Any:
    """A walking leg with a fingertip that goes with its calf, and presses 15 mm deep from frame 4 on."""
    obj = walker(bpy, add)
    place = skin(bpy, obj, 3 * 12)
    fingertip(bpy, scene, {frame: place(frame, 0.15 * min(max(frame - 2, 0), 2) / 2) for frame in range(1, 13)})
    scene.frame_set(1)
    return obj


def dent(obj: Any, seen: np.ndarray, vertex: int = 36) -> float:
    """Return how far a vertex is pushed out of its shape at rest [scene units]."""
    from bl_ext.user_default.dimple.operators.press import sessions

    return float(np.linalg.norm(seen[vertex] - sessions.get(obj).rest[vertex]))


def test_the_press_follows_a_walking_rig_and_the_mesh_stays_bit_for_bit(
    bpy: ModuleType, sessions: Any, scene: Any, walking: Any, shown: Shown
) -> None:
    before = bits(walking)
    start = shown(walking)
    assert bpy.ops.dimple.play(frames=8) == {"FINISHED"}
    live = sessions.get(walking)
    assert live.session.model.rigged
    seen, far = shown(walking), live.rest
    assert np.abs(far - start).max() > 0.5, "the rig has bent and fattened the leg"
    assert 0.1 < dent(walking, seen) < 0.25, "the press is where the skin has gone"
    away = np.linalg.norm(seen - far, axis=1)
    assert np.median(away) < 0.03, "and the rest of the leg is where its rig has put it"
    assert live.frame.depths[0] == pytest.approx(0.015, rel=0.35)
    assert bits(walking) == before, "while it is pressed"
    bpy.ops.dimple.reset()
    assert bits(walking) == before
    assert [each.type for each in walking.modifiers] == ["ARMATURE"] and not bpy.data.node_groups
    assert {each.name for each in bpy.data.objects} == {"Walker", "Walker Rig", "Fingertip"}


def test_the_bake_of_a_walking_rig_equals_its_live_play_bit_for_bit(
    bpy: ModuleType, sessions: Any, scene: Any, walking: Any, shown: Shown
) -> None:
    from bl_ext.user_default.dimple.core.recording import open_point_cache

    live = []
    for frame in range(1, 9):
        bpy.ops.dimple.play(frames=1)
        body = sessions.get(walking)
        live.append((frame + 1, body.session.positions().copy(), shown(walking)))
    bpy.ops.dimple.reset()
    scene.frame_set(1)
    before = bits(walking)
    bpy.ops.dimple.bake(frame_start=1, frame_end=9)
    assert bits(walking) == before
    assert [each.name for each in walking.modifiers] == ["Armature", "Dimple"]
    _, baked = open_point_cache(bpy.path.abspath(cache_of(walking).filepath))
    for frame, _, seen in live:
        scene.frame_set(frame)
        assert np.abs(shown(walking) - seen).max() < 1e-6, "what is seen differs by the rounding of an offset"
    bpy.context.scene.frame_set(1)
    bpy.ops.dimple.play(frames=8)
    body = sessions.get(walking)

    assert np.array_equal(body.offsets(), baked[8]), "bit for bit"
    bpy.ops.dimple.reset()


def test_a_rig_that_an_artist_moves_by_hand_takes_a_pressed_body_along(
    bpy: ModuleType, sessions: Any, scene: Any, add: Add, shown: Shown
) -> None:
    obj = walker(bpy, add)
    rig = bpy.data.objects["Walker Rig"]
    bpy.ops.dimple.play(seconds=0.1)
    rig.animation_data_clear()
    rig.pose.bones["Thigh"].rotation_euler = (0.5, 0, 0)
    bpy.ops.dimple.play(seconds=1.0)
    seen, live = shown(obj), sessions.get(obj)
    assert np.abs(live.rest - live.link.rest).max() > 0.5
    assert np.abs(seen - live.rest).max() < 0.02
    bpy.ops.dimple.reset()


@pytest.mark.parametrize("kind", ["SUBSURF", "SOLIDIFY"])
def test_a_press_is_on_top_of_what_a_modifier_makes_of_a_rigged_body(
    bpy: ModuleType, sessions: Any, scene: Any, walking: Any, shown: Shown, kind: str
) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions as running

    walking.modifiers.new("After", kind)
    seen = shown(walking)
    body, _ = running.start(walking, bpy.context)
    assert np.array_equal(body.rest, seen)
    assert [each.name for each in walking.modifiers] == ["Armature", "After", "Dimple Press"]
    bpy.ops.dimple.play(frames=4)
    assert np.abs(body.rest - seen).max() > 0.1, "it has gone along"
    bpy.ops.dimple.reset()


def test_a_modifier_that_gives_other_vertices_from_frame_to_frame_ends_the_session_with_a_sentence(
    bpy: ModuleType, sessions: Any, scene: Any, walking: Any
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step
    from bl_ext.user_default.dimple.operators.press import sessions as running

    build = walking.modifiers.new("Build", "BUILD")
    build.frame_start, build.frame_duration = 1, 10
    scene.frame_set(5)
    running.start(walking, bpy.context)
    scene.frame_set(6)
    said = live_step.advance(bpy.context, 1 / 24)
    assert len(said) == 1 and "The number must not change" in said[0] and not sessions.sessions
    assert [each.name for each in walking.modifiers] == ["Armature", "Build"]


def test_undo_amid_a_pressed_rig_goes_on_and_leaves_no_trace(
    bpy: ModuleType, sessions: Any, scene: Any, walking: Any
) -> None:
    before = bits(walking)
    bpy.ops.ed.undo_push(message="Before")
    bpy.data.objects.new("Lamp", None)
    bpy.ops.ed.undo_push(message="A lamp")
    bpy.ops.dimple.play(frames=4)
    for _ in range(2):  # the modifier was never pushed: Blender would follow its pointer into what is gone
        bpy.ops.ed.undo()
        assert len(sessions.sessions) == 1
        bpy.ops.dimple.play(seconds=0.02)
        bpy.ops.ed.redo()
        bpy.ops.dimple.play(seconds=0.02)
    bpy.ops.ed.undo_push(message="Amid the press")
    bpy.data.objects.new("Another", None)
    bpy.ops.ed.undo_push(message="Another")
    bpy.ops.ed.undo()
    bpy.ops.dimple.play(seconds=0.02)
    bpy.ops.dimple.reset()
    for step in (bpy.ops.ed.undo, bpy.ops.ed.undo, bpy.ops.ed.redo, bpy.ops.ed.redo):
        step()
        obj = bpy.data.objects["Walker"]
        assert bits(obj) == before and [each.name for each in obj.modifiers] == ["Armature"]
        assert not bpy.data.node_groups


def test_a_local_object_with_a_mesh_of_another_file_is_pressed(
    bpy: ModuleType, sessions: Any, scene: Any, ball: Add, shown: Shown, tmp_path: Any
) -> None:
    ball()
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with bpy.data.libraries.load(path, link=True) as (_, wanted):
        wanted.meshes = ["Ball"]
    obj = bpy.data.objects.new("Local", wanted.meshes[0])
    bpy.context.collection.objects.link(obj)
    obj.dimple.size_mode, obj.dimple.simulated = "CUSTOM", "MESH"
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    before, rest = bits(obj), shown(obj)
    bpy.context.scene.dimple.use_gravity = True
    bpy.ops.dimple.play(seconds=0.05)
    assert np.abs(shown(obj) - rest).max() > 1e-4 and bits(obj) == before
    bpy.ops.dimple.reset()
    assert np.array_equal(shown(obj), rest)


def test_a_rigged_body_is_stopped_by_a_collider_and_the_bake_equals_the_play(
    bpy: ModuleType, sessions: Any, scene: Any, add: Add, shown: Shown, simulated: Any
) -> None:
    """Its rig alone would take it through the wall."""
    obj = walker(bpy, add)
    at = 0.53
    wall = add([(-2, at, -1), (2, at, -1), (2, at, 5), (-2, at, 5)], [(0, 1, 2, 3)], "Wall")
    wall.dimple.collider = True
    wall.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    before = bits(obj)
    scene.frame_set(8)
    assert shown(obj)[:, 1].max() > at + 0.05
    scene.frame_set(1)
    assert bpy.ops.dimple.play(frames=7) == {"FINISHED"}
    assert at - 0.05 < shown(obj)[:, 1].max() < at
    live = simulated(obj)
    bpy.ops.dimple.reset()
    scene.frame_set(1)
    bpy.ops.dimple.bake(frame_start=1, frame_end=8)
    (path,) = Path(scene.dimple.cache_dir).glob("*.pc2")
    assert np.array_equal(read_point_cache(path)[2][-1], live)
    bpy.ops.dimple.unbake()
    scene.frame_set(1)
    assert bits(obj) == before


def test_a_press_follows_a_lattice_that_shears_the_body(
    bpy: ModuleType, sessions: Any, scene: Any, ball: Add, shown: Shown, simulated: Any
) -> None:
    obj = ball(subdivisions=3)
    obj.dimple.simulated = "MESH"
    lattice = bpy.data.objects.new("Cage", bpy.data.lattices.new("Cage"))
    scene.collection.objects.link(lattice)
    obj.modifiers.new("Lattice", "LATTICE").object = lattice
    for corner in lattice.data.points:
        corner.co_deform.x += 0.2 * corner.co.z
    for frame, width in ((1, 2.5), (8, 8.0)):
        lattice.scale = (width, 2.5, 2.5)
        lattice.keyframe_insert("scale", frame=frame)
    top = int(np.argmax(shown(obj)[:, 2]))
    place = skin(bpy, obj, top)
    fingertip(bpy, scene, {frame: place(frame, 0.2 * min(max(frame - 2, 0), 2) / 2) for frame in range(1, 9)})
    scene.frame_set(1)
    start, before = shown(obj), bits(obj)
    assert bpy.ops.dimple.play(frames=7) == {"FINISHED"}
    body, seen, live = sessions.get(obj), shown(obj), simulated(obj)
    assert [each.name for each in obj.modifiers] == ["Lattice", "Dimple Press"]
    assert np.abs(body.rest - start).max() > 0.3, "the lattice has sheared the ball"
    assert np.median(np.linalg.norm(seen - body.rest, axis=1)) < 0.03 and 0.1 < dent(obj, seen, top) < 0.3
    assert bits(obj) == before
    bpy.ops.dimple.reset()
    scene.frame_set(1)
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=8) == {"FINISHED"}
    (path,) = Path(scene.dimple.cache_dir).glob("*.pc2")
    assert np.array_equal(read_point_cache(path)[2][-1], live)
    assert bits(obj) == before
