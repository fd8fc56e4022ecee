"""A press is on the mesh that is seen: the fingertip's shape, kept and baked, in the viewport and in a render."""

from collections.abc import Callable, Iterator
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.test_rigs import bits, walker

TIP, DEPTH, NEAR = 10.0, 12.0, 1.5  # [mm]
UNDER = 0.6  # of the radius, aside: nearer the skin lies on the fingertip
MODELS = "cube", "uv_sphere", "suzanne", "shell", "walker"


def cube(bpy: ModuleType, _add: Any) -> Any:
    bpy.ops.mesh.primitive_cube_add()
    return (0.2, -0.27, 1.0)


def uv_sphere(bpy: ModuleType, _add: Any) -> Any:
    bpy.ops.mesh.primitive_uv_sphere_add()
    bpy.ops.object.shade_smooth()
    return (0.1, -0.2, 0.97)


def suzanne(bpy: ModuleType, _add: Any) -> Any:
    bpy.ops.mesh.primitive_monkey_add()
    bpy.ops.object.shade_smooth()
    modifier = bpy.context.object.modifiers.new("Smooth", "SUBSURF")
    modifier.levels = modifier.render_levels = 2
    return (0.0, -0.55, 0.75)


def shell(bpy: ModuleType, _add: Any) -> Any:
    """Half a ball, mirrored and solidified."""
    import bmesh

    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24)
    obj, half = bpy.context.object, bmesh.new()
    half.from_mesh(obj.data)
    bmesh.ops.delete(half, geom=[vertex for vertex in half.verts if vertex.co.x < -1e-4], context="VERTS")
    half.to_mesh(obj.data)
    half.free()
    obj.modifiers.new("Mirror", "MIRROR").use_clip = True
    obj.modifiers.new("Solidify", "SOLIDIFY").thickness = 0.08
    return (0.3, -0.2, 0.9)


def rigged(bpy: ModuleType, add: Any) -> Any:
    obj = walker(bpy, add)
    obj.dimple.simulated = "AUTO"
    modifier = obj.modifiers.new("Smooth", "SUBSURF")
    modifier.levels, modifier.render_levels = 1, 3
    return (0.0, -0.5, 1.1)


@pytest.fixture(params=[cube, uv_sphere, suzanne, shell, rigged], ids=MODELS)
def model(bpy: ModuleType, add: Callable[..., Any], scene: Any, request: Any) -> tuple[Any, tuple[float, float, float]]:
    """A model as artists have it, and where it is pressed."""
    at = request.param(bpy, add)
    obj = bpy.context.object
    obj.dimple.size_mode = "CUSTOM"
    bpy.context.view_layer.update()
    return obj, at


@pytest.fixture
def left(bpy: ModuleType, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Any]]:
    """The sessions that have ended."""
    from bl_ext.user_default.dimple.operators.press import sessions

    ended: list[Any] = []
    stop = sessions.stop
    monkeypatch.setattr(
        sessions, "stop", lambda uid, **how: ended.append(sessions.sessions.get(uid)) or stop(uid, **how)
    )
    yield ended


def as_rendered(bpy: ModuleType, obj: Any) -> None:
    for modifier in obj.modifiers:
        if modifier.type == "SUBSURF":
            modifier.levels = modifier.render_levels
    bpy.context.view_layer.update()


def off(points: np.ndarray, centre: np.ndarray, outward: np.ndarray, per_unit: float) -> np.ndarray:
    """Return how far (k,) [mm] the vertices under a fingertip are from its sphere."""
    away = (points - centre) * per_unit
    high = away @ outward
    aside = np.linalg.norm(away - high[:, None] * outward, axis=1)
    under = (aside < UNDER * TIP) & (-1.6 * TIP < high) & (high < 0)
    assert under.sum() > 1
    return np.abs(np.linalg.norm(away[under], axis=1) - TIP)


def test_a_kept_press_has_the_shape_of_the_fingertip_in_viewport_and_render(
    bpy: ModuleType, model: Any, left: list[Any], shown: Callable[[Any], np.ndarray]
) -> None:
    obj, at = model
    before, seen = bits(obj), shown(obj)
    bpy.ops.dimple.poke(depth_mm=DEPTH, press_s=0.2, hold_s=0.2, release_s=0, keep=True, location=at)
    assert bits(obj) == before and obj.modifiers[-1].name == "Pressed"
    (body,) = left
    which = next(number for number, finger in enumerate(body.fingers) if finger)
    centre = np.array(body.fingers[which].position) / body.link.scale
    outward, per_unit = np.array(body.frame.touches[which].outward), 1e3 * body.link.scale
    assert off(shown(obj), centre, outward, per_unit).max() < NEAR
    levels = {each.name: each.levels for each in obj.modifiers if each.type == "SUBSURF"}
    as_rendered(bpy, obj)
    assert off(shown(obj), centre, outward, per_unit).max() < NEAR
    for name, level in levels.items():
        obj.modifiers[name].levels = level
    obj.modifiers.remove(obj.modifiers["Pressed"])
    assert np.array_equal(shown(obj), seen), "without the modifier its shape is back"


def test_a_bake_has_the_shape_of_the_fingertip_in_viewport_and_render(
    bpy: ModuleType, scene: Any, model: Any, shown: Callable[[Any], np.ndarray]
) -> None:
    obj, at = model
    before, per_unit = bits(obj), obj.dimple.size_mm / max(obj.dimensions)
    place, normal = surface(bpy, obj, at)
    tip = bpy.data.objects.new("Tip", None)
    scene.collection.objects.link(tip)
    scene.dimple.finger_1 = tip
    for frame in range(1, 9):
        scene.frame_set(frame)
        there, outward = (np.array(each) for each in moved(bpy, obj, place, normal))
        tip.location = there + (TIP - DEPTH * min(max(frame - 1, 0) / 4, 1)) / per_unit * outward
        tip.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=8) == {"FINISHED"}
    assert bits(obj) == before and obj.modifiers[-1].name == "Dimple"
    scene.frame_set(8)
    centre = np.array(tip.location)
    assert off(shown(obj), centre, outward, per_unit).max() < NEAR
    as_rendered(bpy, obj)
    assert off(shown(obj), centre, outward, per_unit).max() < NEAR
    carriers = [each for each in bpy.data.objects if each.name.startswith(".Dimple")]
    assert not any(each.users_collection for each in carriers)


def surface(bpy: ModuleType, obj: Any, at: Any) -> tuple[int, np.ndarray]:
    """Return the polygon of the final mesh that is nearest to a place, and shares of its corners there."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    _, place, _, polygon = evaluated.closest_point_on_mesh(at)
    corners = np.array([evaluated.data.vertices[i].co for i in evaluated.data.polygons[polygon].vertices])
    away = np.linalg.norm(corners - np.array(place), axis=1)
    return polygon, (1 / np.maximum(away, 1e-6)) / (1 / np.maximum(away, 1e-6)).sum()


def moved(bpy: ModuleType, obj: Any, polygon: int, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return where that place is now in the scene, and its normal."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    face = evaluated.data.polygons[polygon]
    return shares @ np.array([evaluated.data.vertices[i].co for i in face.vertices]), np.array(face.normal)


def test_a_press_is_kept_on_top_of_another_and_applied(
    bpy: ModuleType, scene: Any, shown: Callable[[Any], np.ndarray]
) -> None:
    bpy.ops.mesh.primitive_cube_add()
    obj = bpy.context.object
    press = {"depth_mm": DEPTH, "press_s": 0.1, "hold_s": 0.1, "release_s": 0.0, "keep": True}
    bpy.ops.dimple.poke(**press, location=(0.2, -0.2, 1.0))
    once = shown(obj)
    bpy.ops.dimple.poke(**press, location=(-0.4, 0.4, 1.0))
    twice = shown(obj)
    assert len(once) == len(twice) > 5000 and np.abs(twice - once).max() * 82.5 == pytest.approx(DEPTH, abs=1.0)
    for name in ("Pressed", "Pressed.001"):
        bpy.ops.object.modifier_apply(modifier=name)
    assert np.array_equal(shown(obj), twice) and len(obj.data.vertices) == len(twice)


@pytest.mark.parametrize("kind", ["MULTIRES", "SOFT_BODY"])
def test_a_modifier_that_must_be_first_is_pressed_as_any(
    bpy: ModuleType, scene: Any, shown: Callable[[Any], np.ndarray], kind: str
) -> None:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4)
    obj = bpy.context.object
    obj.modifiers.new("First", kind)
    if kind == "MULTIRES":
        bpy.ops.object.multires_subdivide(modifier="First", mode="CATMULL_CLARK")
    high = shown(obj)[:, 2].max()
    bpy.ops.dimple.poke(depth_mm=8.0, press_s=0.1, hold_s=0.1, release_s=0.0, keep=True)
    assert shown(obj)[:, 2].max() < high - 0.02 and [each.name for each in obj.modifiers] == ["First", "Pressed"]


def test_a_kept_press_is_appended_whole_and_brings_no_object(
    bpy: ModuleType, scene: Any, ball: Callable[..., Any], shown: Callable[[Any], np.ndarray], tmp_path: Any
) -> None:
    obj, path = ball(), str(tmp_path / "kept.blend")
    bpy.ops.dimple.poke(depth_mm=8.0, press_s=0.1, hold_s=0.1, release_s=0.0, keep=True)
    seen = shown(obj)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.append(filepath=f"{path}/Object/Ball", directory=f"{path}/Object/", filename="Ball")
    assert np.array_equal(shown(bpy.data.objects["Ball"]), seen)
    assert [each.name for each in bpy.context.scene.objects] == ["Ball"]


def test_a_surface_that_a_modifier_makes_alone_is_pressed(
    bpy: ModuleType, add: Any, shown: Callable[[Any], Any]
) -> None:
    obj = add(faces=[])
    group = bpy.data.node_groups.new("Cube", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    cube, result = group.nodes.new("GeometryNodeMeshCube"), group.nodes.new("NodeGroupOutput")
    group.links.new(cube.outputs[0], result.inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = group
    bpy.ops.dimple.poke(depth_mm=10.0, press_s=0.1, hold_s=0.1, release_s=0.0, keep=True)
    assert shown(obj)[:, 2].min() == -0.5 and not len(obj.data.polygons)
