"""Objects as artists have them: scaled, parented, with modifiers, shape keys, shared meshes, several at once."""

import math
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

Add = Callable[..., Any]
Bits = Callable[[Any], bytes]
Shown = Callable[[Any], np.ndarray]
PRESS: dict[str, Any] = {"depth_mm": 16.5, "press_s": 0.1, "hold_s": 0.0, "release_s": 0.0, "keep": True}


def world(obj: Any, local: np.ndarray) -> np.ndarray:
    matrix = np.array(obj.matrix_world)
    return local @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.fixture
def dent(bpy: ModuleType, shown: Shown) -> Callable[[Any], np.ndarray]:
    """Return a function that presses an object from above and keeps the dent: moves (n, 3) in mm of the real body."""

    def press(obj: Any, **changes: Any) -> np.ndarray:
        bpy.context.view_layer.update()
        before = world(obj, shown(obj))
        assert bpy.ops.dimple.poke(**{**PRESS, **changes}) == {"FINISHED"}
        size = np.ptp(before, axis=0).max()
        return (world(obj, shown(obj)) - before) / size * 165

    return press


def test_a_press_dents_the_body_where_and_as_deep_as_it_is_told(ball: Add, dent: Callable[..., Any]) -> None:
    moves = dent(ball())
    assert -moves[:, 2].min() == pytest.approx(16.5, abs=1.5)
    assert np.abs(moves).max() < 20


@pytest.mark.parametrize(
    "place",
    [
        {"scale": (-1, 1, 1)},
        {"scale": (30, 30, 30), "location": (100, -50, 7), "rotation_euler": (0, 0, -2)},
    ],
    ids=["mirrored", "all at once"],
)
def test_scale_place_and_turn_do_not_change_the_press(
    ball: Add, dent: Callable[..., Any], place: dict[str, Any]
) -> None:
    expected = np.sort(dent(ball("Plain"))[:, 2])
    moved = ball("Moved")
    for name, value in place.items():
        setattr(moved, name, value)
    # symmetric about the vertical but for its triangles
    assert np.sort(dent(moved)[:, 2]) == pytest.approx(expected, abs=1.0)


@pytest.mark.parametrize("mirror", [1, -1])
def test_an_open_mesh_faces_the_way_it_looks_also_where_it_is_mirrored(
    bpy: ModuleType, add: Add, mirror: float
) -> None:
    """A closed one is turned right side out anyway."""
    from bl_ext.user_default.dimple import Body

    obj = add([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])
    obj.scale.x = mirror
    model = Body.from_object(obj).session.model
    a, b, c = model.mesh.rest_positions[model.mesh.triangles].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_a_parent_and_its_scale_are_seen_through(bpy: ModuleType, ball: Add, dent: Callable[..., Any]) -> None:
    parent, obj = bpy.data.objects.new("Parent", None), ball()
    bpy.context.collection.objects.link(parent)
    parent.scale, parent.location = (3, 3, 3), (1, 2, 3)
    obj.parent = parent
    moves = dent(obj)
    assert -moves[:, 2].min() == pytest.approx(16.5, abs=1.5)


def test_the_press_of_a_body_as_modelled_is_in_metres_of_the_scene(
    bpy: ModuleType, ball: Add, dent: Callable[..., Any]
) -> None:
    obj = ball()
    obj.dimple.size_mode = "REAL"
    bpy.context.scene.unit_settings.scale_length = 0.0825  # so the ball is 165 mm wide
    assert -dent(obj)[:, 2].min() == pytest.approx(16.5, abs=1.5)


@pytest.mark.parametrize("keep", [True, False])
def test_linked_duplicates_keep_their_mesh_while_one_is_pressed(
    bpy: ModuleType, ball: Add, coordinates: Bits, shown: Shown, keep: bool
) -> None:
    obj = ball()
    twin = obj.copy()
    bpy.context.collection.objects.link(twin)
    twin.select_set(False)
    before, mesh = coordinates(obj), obj.data
    bpy.ops.dimple.poke(**{**PRESS, "keep": keep})
    assert twin.data == obj.data == mesh and coordinates(obj) == before == shown(twin).tobytes()
    assert (shown(obj).tobytes() != before) == keep


@pytest.fixture
def keyed(ball: Add) -> Any:
    """A ball with a shape key at half its way, and another that a vertex group masks."""
    obj = ball()
    obj.shape_key_add(name="Basis")
    for name in ("Wide", "Tall"):
        key = obj.shape_key_add(name=name)
        key.value = 0.5
        for i, point in enumerate(obj.data.vertices):
            key.points[i].co = (point.co.x * 1.4, point.co.y, point.co.z * (1.2 if name == "Tall" else 1))
    group = obj.vertex_groups.new(name="Top")
    group.add([v.index for v in obj.data.vertices if v.co.z > 0], 0.75, "ADD")
    obj.data.shape_keys.key_blocks["Tall"].vertex_group = "Top"
    return obj


def key_bits(obj: Any) -> dict[str, bytes]:
    bits = {}
    for key in obj.data.shape_keys.key_blocks:
        numbers = np.empty(3 * len(key.points), np.float32)
        key.points.foreach_get("co", numbers)
        bits[f"{key.name} {key.value:.3f}"] = numbers.tobytes()
    return bits


def test_shape_keys_are_pressed_as_they_are_mixed_and_put_back(
    bpy: ModuleType, keyed: Any, coordinates: Bits, shown: Shown
) -> None:
    before, bits, seen, active = coordinates(keyed), key_bits(keyed), shown(keyed).copy(), keyed.active_shape_key_index
    bpy.ops.dimple.poke(**{**PRESS, "keep": False})
    assert key_bits(keyed) == bits and coordinates(keyed) == before and keyed.active_shape_key_index == active
    assert np.array_equal(shown(keyed), seen)


def test_a_kept_press_leaves_shape_keys_as_they_are(
    bpy: ModuleType, keyed: Any, dent: Callable[..., Any], shown: Shown
) -> None:
    bits, seen = key_bits(keyed), shown(keyed).copy()
    moves = dent(keyed)
    assert -moves[:, 2].min() > 8
    assert bits == key_bits(keyed)
    keyed.modifiers.remove(keyed.modifiers["Pressed"])
    assert np.array_equal(shown(keyed), seen)


def test_several_selected_objects_run_at_once(bpy: ModuleType, ball: Add, coordinates: Bits, shown: Any) -> None:
    bodies = []
    for i in range(3):
        obj = ball(f"Ball {i}")
        obj.location.x, obj.dimple.pinned = 3 * i, False
        bodies.append(obj)
    for obj in bodies:
        obj.select_set(True)
    bpy.context.scene.dimple.use_gravity = True
    before = [coordinates(obj) for obj in bodies]
    bpy.ops.dimple.play(seconds=0.1)
    heights = [float(shown(obj)[:, 2].mean()) for obj in bodies]
    assert heights == pytest.approx([heights[0]] * 3, abs=1e-5)
    assert heights[0] < -0.4
    bpy.ops.dimple.reset()
    assert [coordinates(obj) for obj in bodies] == before


def test_materials_of_several_slots_press_differently(bpy: ModuleType, ball: Add, dent: Callable[..., Any]) -> None:
    from bl_ext.user_default.dimple import Body

    obj = ball()
    for name, factor in (("Soft", 1), ("Hard", 8)):
        material = bpy.data.materials.new(name)
        material.dimple.K1 *= factor
        obj.data.materials.append(material)
    for polygon in obj.data.polygons:
        polygon.material_index = int(polygon.center.x > 0)
    model = Body.from_object(obj).session.model
    assert [material.K1 for material in model.materials] == pytest.approx([610, 4880])
    assert (np.bincount(model.mesh.triangle_material) == 40).all()


def test_a_press_along_a_direction_meets_the_side_it_is_aimed_at(
    bpy: ModuleType, ball: Add, dent: Callable[..., Any]
) -> None:
    moves = dent(ball(), location=(1, 0, 0.2), direction=(-1, 0, 0))
    assert -moves[:, 0].min() == pytest.approx(16.5, abs=2)
    bpy.data.objects["Ball"].select_set(False)
    moves = dent(ball("Other"), location=(0, -1.02, 0))
    assert moves[:, 1].max() == pytest.approx(16.5, abs=2)


def test_a_preset_sets_constants_size_and_source(bpy: ModuleType, ball: Add) -> None:
    from bl_ext.user_default.dimple.core.everyday_presets import OBJECTS
    from bl_ext.user_default.dimple.core.material import Material

    for preset in OBJECTS:
        obj = ball()
        obj.dimple.material = preset.name
        settings = obj.active_material.dimple
        assert Material(**settings.to_params()) == preset.material
        assert settings.provenance == preset.provenance
        assert math.isclose(obj.dimple.to_params()["size"], preset.size)
    with pytest.raises(TypeError, match="object_1_nylon_air"):
        obj.dimple.material = "marble"
