"""Objects with Dimple Collider ticked are met by running bodies, in play and in a bake alike."""

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.point_cache import read_point_cache

Add = Callable[..., Any]
Shown = Callable[[Any], np.ndarray]


@pytest.fixture
def pushed(bpy: ModuleType, scene: Any, ball: Add, add: Add) -> Callable[[], tuple[Any, Any]]:
    """Return a function that adds a soft ball and a cube that is keyframed to go a quarter of the way into it."""

    def make() -> tuple[Any, Any]:
        obj, cube = ball(), add(name="Pusher")
        cube.location = (0, 0, 2.1)
        cube.scale = (0.8, 0.8, 1)
        cube.keyframe_insert("location", frame=1)
        cube.location = (0, 0, 1.5)
        cube.keyframe_insert("location", frame=7)
        cube.dimple.collider = True
        cube.select_set(False)
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        obj.dimple.pinned = True
        scene.dimple.use_gravity = scene.dimple.use_ground = False
        scene.frame_set(1)
        return obj, cube

    return make


def top(points: np.ndarray) -> float:
    middle = np.hypot(points[:, 0], points[:, 1]) < 0.6
    return float(points[middle][:, 2].max())


def test_a_keyframed_cube_pushes_a_soft_ball_and_a_bake_equals_play(
    bpy: ModuleType, scene: Any, pushed: Callable[[], tuple[Any, Any]], coordinates: Callable[[Any], bytes], shown: Any
) -> None:
    obj, _ = pushed()
    before = coordinates(obj)
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=8) == {"FINISHED"}
    assert coordinates(obj) == before
    (path,) = Path(scene.dimple.cache_dir).glob("*.pc2")
    baked = np.frombuffer(before, np.float32).reshape(-1, 3) + read_point_cache(path)[2]
    assert top(baked[-1]) < 0.5 < 0.9 < top(baked[0])
    bpy.ops.dimple.unbake()
    scene.frame_set(1)
    assert bpy.ops.dimple.play(frames=7) == {"FINISHED"}
    assert np.abs(shown(obj) - baked[-1]).max() < 1e-5
    bpy.ops.dimple.reset()
    assert coordinates(obj) == before


def test_without_the_tick_the_cube_goes_through(
    bpy: ModuleType, pushed: Callable[[], tuple[Any, Any]], coordinates: Callable[[Any], bytes], shown: Any
) -> None:
    obj, cube = pushed()
    cube.dimple.collider = False
    before = coordinates(obj)
    assert bpy.ops.dimple.play(frames=7) == {"FINISHED"}
    assert shown(obj).tobytes() == before


def test_what_intersects_at_the_start_is_refused_and_nothing_is_changed(
    bpy: ModuleType, pushed: Callable[[], tuple[Any, Any]], coordinates: Callable[[Any], bytes]
) -> None:
    obj, cube = pushed()
    cube.animation_data_clear()
    cube.location = (0, 0, 1.5)
    before = coordinates(obj)
    with pytest.raises(RuntimeError, match='"Ball" and "Pusher" intersect at'):
        bpy.ops.dimple.play(seconds=0.1)
    assert coordinates(obj) == before


def test_two_bodies_press_each_other_flat_where_they_meet(
    bpy: ModuleType, scene: Any, ball: Add, add: Add, coordinates: Callable[[Any], bytes], shown: Any
) -> None:
    lower, upper = ball("Lower"), ball("Upper")
    upper.location = (0.02, 0, 2.05)
    floor = add([(-3, -3, -1.05), (3, -3, -1.05), (3, 3, -1.05), (-3, 3, -1.05)], [(0, 1, 2, 3)], name="Floor")
    floor.dimple.collider = True
    floor.select_set(False)
    for obj in (lower, upper):
        obj.dimple.pinned = False
        obj.select_set(True)
    scene.dimple.use_gravity, scene.dimple.use_ground = True, False
    assert bpy.ops.dimple.play(seconds=0.3) == {"FINISHED"}
    low, high = shown(lower), shown(upper)
    assert -1.05 < low[:, 2].min() < -0.99
    middle = np.hypot(low[:, 0], low[:, 1]) < 0.3
    assert 0 < (high[:, 2] + 2.05).min() - low[middle][:, 2].max() < 0.1
    bpy.ops.dimple.reset()


def test_that_bodies_of_different_scale_do_not_collide_is_said(
    bpy: ModuleType, ball: Add, add: Add, sessions: Any
) -> None:
    wall, small, large = add(name="Wall"), ball(), ball()
    wall.location.x, large.location.x, large.dimple.size_mm = 6, 3, 300.0
    wall.select_set(False)
    small.select_set(True)
    for is_on in (False, True):
        wall.dimple.collider = is_on
        bpy.ops.dimple.play(seconds=0.05)
        notes = [each.session.contact_note for each in sessions.sessions.values()]
        assert [bool(re.match("Bodies of different scale", note)) for note in notes] == [is_on] * 2
        bpy.ops.dimple.reset()


def test_faces_that_pass_through_others_of_their_mesh_are_left_out_of_self_contact_and_that_is_said(
    bpy: ModuleType, scene: Any, sessions: Any, coordinates: Callable[[Any], bytes]
) -> None:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=10, radius=1.0)
    eye = bpy.context.object
    eye.location = (1.2, 0, 0)
    bpy.ops.object.transform_apply(location=True)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=10, radius=1.0)
    obj = bpy.context.object
    eye.select_set(True)
    bpy.ops.object.join()
    bpy.ops.dimple.make_soft()
    obj.dimple.self_contact, before = True, coordinates(obj)
    assert bpy.ops.dimple.play(seconds=0.05) == {"FINISHED"}
    (live,) = sessions.sessions.values()
    assert re.search(r"passes through itself at \(.+\) mm: \d+ pairs of faces", live.session.contact_note)
    bpy.ops.dimple.reset()
    assert coordinates(obj) == before


@pytest.fixture
def hand_and_ball(bpy: ModuleType, scene: Any, ball: Add, add: Add) -> tuple[Any, Any]:
    """A soft ball between two fingers of one mesh, whose bones close on it from frame 1 to 7."""
    obj = ball()
    obj.dimple.pinned = False
    scene.dimple.use_gravity = scene.dimple.use_ground = False
    box = [(x, y, z) for x in (-0.1, 0.1) for y in (-0.6, 0.6) for z in (-0.6, 0.6)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    points = [(x + side * 1.2, y, z) for side in (-1, 1) for x, y, z in box]
    fingers = add(points, [*faces, *[tuple(i + 8 for i in face) for face in faces]], "Hand")
    fingers.dimple.collider = True
    data = bpy.data.armatures.new("Bones")
    rig = bpy.data.objects.new("Bones", data)
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, side in (("Left", -1), ("Right", 1)):
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = (side * 1.2, 0, -0.6), (side * 1.2, 0, 0.6)
    bpy.ops.object.mode_set(mode="OBJECT")
    for name, side in (("Left", 0), ("Right", 8)):
        fingers.vertex_groups.new(name=name).add(range(side, side + 8), 1.0, "REPLACE")
        bone = rig.pose.bones[name]
        bone.keyframe_insert("location", frame=1)
        bone.location.x = 0.45 if name == "Left" else -0.45  # along the bone's own axes
        bone.keyframe_insert("location", frame=7)
    fingers.modifiers.new("Armature", "ARMATURE").object = rig
    for other in (rig, fingers):
        other.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    scene.frame_set(1)
    return obj, fingers


def test_a_hand_that_its_bones_close_squeezes_a_ball(
    bpy: ModuleType, sessions: Any, hand_and_ball: tuple[Any, Any], shown: Shown, simulated: Any, scene: Any
) -> None:
    obj, fingers = hand_and_ball
    before = np.ptp(shown(obj), axis=0)
    assert bpy.ops.dimple.play(frames=7) == {"FINISHED"}
    squeezed, jaws = np.ptp(shown(obj), axis=0), shown(fingers)[:, 0]
    gap = jaws[8:].min() - jaws[:8].max()
    assert gap < 0.75 * before[0], "the bones have closed the hand"
    assert 0.9 * gap < squeezed[0] < gap, "and the ball is as wide as its grip, but for the distance of contact"
    assert squeezed[2] > before[2], "it gives way to the sides"
    live = simulated(obj)
    bpy.ops.dimple.reset()
    scene.frame_set(1)
    bpy.ops.dimple.bake(frame_start=1, frame_end=8)
    (path,) = Path(scene.dimple.cache_dir).glob("*.pc2")
    assert np.array_equal(read_point_cache(path)[2][-1], live), "the bake equals the live play"


def test_what_sleeps_on_a_collider_falls_once_that_is_taken_away(
    bpy: ModuleType, sessions: Any, scene: Any, cube: Any, add: Add
) -> None:
    from bl_ext.user_default.dimple.operators.press import live_step

    cube.location, cube.dimple.pinned = (0, 0, 1.02), False
    scene.dimple.use_gravity, scene.dimple.use_ground = True, False
    tables = [add([(-3, -3, z), (3, -3, z), (3, 3, z), (-3, 3, z)], [(0, 1, 2, 3)]) for z in (0, -0.05, -0.1, -0.15)]
    for table in tables:
        table.dimple.collider = True
        table.select_set(False)
    cube.select_set(True)

    def lowest(seconds: float) -> float:
        for _ in range(round(30 * seconds)):
            live_step.advance(bpy.context, 1 / 30)
        return float(body.session.positions()[:, 2].min()) / body.link.scale

    live_step.start_all(bpy.context)
    body = sessions.get(cube)
    tables[0].hide_set(True)  # it still holds the cube
    assert lowest(2) > 0
    for take_away in (
        lambda: setattr(tables[0], "hide_viewport", True),
        lambda: bpy.data.objects.remove(tables[1]),
        lambda: setattr(tables[2].dimple, "collider", False),
        lambda: setattr(tables[3].dimple, "collider", False),  # the last: nothing is left to meet
    ):
        standing = lowest(3)
        assert not body.session.moved
        take_away()
        assert lowest(0.1) < standing - 0.01 and body.session.moved
    sessions.stop_all()


def test_what_meets_something_is_planned_for_twice_the_work_and_with_every_vertex_where_it_meets_itself(
    bpy: ModuleType, sessions: Any, ball: Add, add: Add, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.core.message import read
    from bl_ext.user_default.dimple.core.reduction import proxy_rule
    from bl_ext.user_default.dimple.operators.press import live_step

    monkeypatch.setattr(proxy_rule, "cost_of", lambda model: len(model.mass) / 25_000)
    obj = ball("Fine", 6)
    other = add(name="Other")
    other.location = (50, 0, 0)
    other.select_set(False)
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj

    def after(seconds: float) -> tuple[bool, str]:
        for _ in range(round(30 * seconds)):
            live_step.advance(bpy.context, 1 / 30)
        return sessions.get(obj).session.proxy is None, read(obj.dimple.plan_reason)

    live_step.start_all(bpy.context)
    is_full, before = after(0.1)
    assert is_full and before.startswith("The full mesh runs live")
    other.dimple.collider = True
    assert after(1)[0], "it stays as it was planned at the start"
    obj.dimple.self_contact = True
    is_full, itself = after(1 / 30)
    assert is_full and itself.startswith("For self contact, the full mesh: 10,242 vertices at "), "at once"
    obj.dimple.self_contact = other.dimple.collider = False
    assert after(2) == (True, before)
    sessions.stop_all()
    other.dimple.collider = True
    live_step.start_all(bpy.context)
    is_full, reason = after(0.1)
    assert not is_full and reason.startswith("The full mesh would run at 0.73x real time")
    assert re.search(r" runs live; its dents are within \d\.\d+ mm of the mesh's\.$", reason)
    sessions.stop_all()


@pytest.fixture
def led_down(bpy: ModuleType, scene: Any, add: Add) -> Callable[..., Any]:
    """Return a function that leads a cube of a size, cut or not, down into a soft one; both, and how far it moved."""

    def bake(size: Sequence[float], lowest: float, *, cuts: int = 0, cells: int = 3) -> Any:
        soft, led = add(name="Soft"), add(name="Led")
        for obj, levels in ((soft, cells), (led, cuts)):
            made = obj.modifiers.new("Cuts", "SUBSURF")
            made.subdivision_type, made.levels, made.render_levels = "SIMPLE", levels, levels
        soft.modifiers.new("Triangles", "TRIANGULATE")  # Blender cuts a bent quad along its other diagonal
        led.scale = size
        for frame, height in ((1, 1.02), (20, lowest)):  # of its lowest face; the soft cube reaches from -1 to 1
            led.location = (0, 0, height + size[2])
            led.keyframe_insert("location", frame=frame)
        led.dimple.collider = True
        led.select_set(False)
        soft.select_set(True)
        bpy.context.view_layer.objects.active = soft
        soft.dimple.pinned = True
        scene.dimple.use_gravity = scene.dimple.use_ground = False
        scene.frame_set(1)
        assert bpy.ops.dimple.bake(frame_start=1, frame_end=24) == {"FINISHED"}
        scene.frame_set(24)
        (path,) = Path(scene.dimple.cache_dir).glob("*.pc2")
        return soft, led, read_point_cache(path)[2][-1]

    return bake


@pytest.fixture
def in_the_scene(bpy: ModuleType) -> Callable[[Any], tuple[np.ndarray, np.ndarray]]:
    """Return a function that reads the vertices (n, 3) and the triangles (t, 3) of an object as they are seen."""

    def read(obj: Any) -> tuple[np.ndarray, np.ndarray]:
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        mesh = evaluated.data
        mesh.calc_loop_triangles()
        points = np.array([evaluated.matrix_world @ vertex.co for vertex in mesh.vertices])
        return points, np.array([each.vertices for each in mesh.loop_triangles])

    return read


BLADE, BAR = (0.04, 2.0, 0.4), (0.3, 2.0, 0.3)


@pytest.mark.parametrize(("size", "cuts"), [(BLADE, 0), (BLADE, 3), (BAR, 0)], ids=["blade", "cut", "bar"])
def test_no_face_of_a_baked_body_passes_through_a_led_edge_as_both_are_seen(
    led_down: Callable[..., Any], in_the_scene: Callable[[Any], Any], size: Sequence[float], cuts: int
) -> None:
    from mathutils.bvhtree import BVHTree

    soft, led = (in_the_scene(obj) for obj in led_down(size, 0.4, cuts=cuts, cells=4)[:2])
    trees = [BVHTree.FromPolygons(points.tolist(), faces.tolist()) for points, faces in (soft, led)]
    assert trees[0].overlap(trees[1]) == []
    away = np.abs(soft[0] - (0, 0, 0.4 + size[2])) - size
    assert (away.max(axis=1) > 0).all(), "no vertex is inside"
    below = [trees[0].find_nearest((0, y, 0.4))[3] for y in np.linspace(-0.9, 0.9, 40)]
    assert np.median(below) < 0.05, "skin keeps a tenth of its edges, 0.14, and bridges what is narrower than they are"


@pytest.mark.parametrize("size", [(0.3, 0.3, 0.3), (0.6, 0.6, 0.1)], ids=["box", "plate"])
def test_a_led_cube_of_eight_vertices_goes_into_a_soft_cube_as_deep_as_its_keyframes_say(
    led_down: Callable[..., Any], size: Sequence[float], caplog: pytest.LogCaptureFixture
) -> None:
    deep = np.sort(led_down(size, 0.4)[2][:, 2])
    assert deep[4] == pytest.approx(-0.6, abs=0.08)  # edges of 0.25 touch at 0.025
    assert deep[0] > -0.8, "a fold under it is no deeper than an edge"
    assert "Collider" not in caplog.text


def test_a_bake_says_which_collider_could_not_go_its_way_when_and_where(
    led_down: Callable[..., Any], caplog: pytest.LogCaptureFixture
) -> None:
    led_down((0.6, 0.6, 0.1), -1.5)
    print(caplog.text)
    assert re.search(r'Frame \d+: Collider "Led" .+ at \(.+\) mm', caplog.text)
