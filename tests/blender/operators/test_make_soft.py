"""Make Soft takes a bare mesh to its first press, and does not change the mesh itself."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

Bits = Callable[[Any], bytes]
PRESS: dict[str, Any] = {"force_n": 4.0, "press_s": 0.1, "hold_s": 0.2, "release_s": 0.0, "keep": True}


@pytest.fixture
def bare(bpy: ModuleType, empty_file: ModuleType) -> Any:
    """A cube two metres wide and without a material."""
    bpy.ops.mesh.primitive_cube_add()
    return bpy.context.object


def test_a_bare_cube_is_ready_for_its_first_press_and_keeps_its_mesh(
    bpy: ModuleType, bare: Any, coordinates: Bits, shown: Any
) -> None:
    before = coordinates(bare)
    assert bpy.ops.dimple.make_soft() == {"FINISHED"}
    assert bare.active_material.name == "Soft" and bare.dimple.material == "object_2_vinyl_air"
    assert "Sakama" in bare.active_material.dimple.provenance
    assert bare.dimple.enabled and bare.dimple.size_mode == "CUSTOM" and bare.dimple.size_mm == 165
    assert bare.dimple.plan_reason, "it is planned already"
    bpy.ops.dimple.poke(**PRESS)
    seen = shown(bare)
    assert seen[np.hypot(seen[:, 0], seen[:, 1]) < 0.1][:, 2].max() < 1.0 - 0.02
    assert coordinates(bare) == before


def test_a_metaball_becomes_a_body_under_its_own_name(bpy: ModuleType, empty_file: ModuleType) -> None:
    bpy.ops.object.metaball_add()
    name = bpy.context.object.name
    assert bpy.ops.dimple.make_soft() == {"FINISHED"}
    assert bpy.context.object.name == name and bpy.context.object.type == "MESH" and bpy.context.object.dimple.enabled


def test_a_text_without_characters_is_refused_and_stays_flat(bpy: ModuleType, empty_file: ModuleType) -> None:
    bpy.ops.object.text_add()
    bpy.context.object.data.body = ""
    with pytest.raises(RuntimeError, match="has no faces"):
        bpy.ops.dimple.make_soft()
    assert bpy.context.object.type == "FONT" and bpy.context.object.data.extrude == 0.0


def test_what_the_artist_has_set_is_left_as_it_is(bpy: ModuleType, ball: Any) -> None:
    obj = ball(subdivisions=4)
    obj.active_material = bpy.data.materials.new("Own")
    obj.active_material.dimple.K1, obj.active_material.dimple.spread_mm = 2.0, 20.0
    obj.dimple.enabled, obj.dimple.size_mm = True, 90.0
    bpy.ops.dimple.make_soft()
    assert obj.active_material.name == "Own" and obj.active_material.dimple.K1 == 2.0 and obj.dimple.size_mm == 90.0
    assert obj.active_material.dimple.spread_mm == 20.0


def test_the_first_dent_is_as_plain_on_a_small_body_as_on_a_large_one(bpy: ModuleType, ball: Any) -> None:
    """Two fingertips from its centre, each sinks by a similar share of the depth."""
    from bl_ext.user_default.dimple import Body

    wide = []
    for size_mm in (165.0, 30.0, 600.0):
        obj = ball(subdivisions=4)
        obj.dimple.size_mm = size_mm
        bpy.ops.dimple.make_soft()
        radius = bpy.context.scene.dimple.finger_radius_mm / 1e3
        body = Body.from_object(obj)
        rest = body.positions()
        body.press(depth=1.5 * radius)
        body.step(0.5)
        far = body.link.scale * np.hypot(rest[:, 0], rest[:, 1]) / radius
        sunk = body.link.scale * (rest - body.positions())[:, 2] / body.depth
        wide.append(sunk[(far > 1.5) & (far < 2.5) & (rest[:, 2] > 0)].mean())
    assert 0.05 < min(wide) and max(wide) < 0.4, wide


def test_what_cannot_be_pressed_is_said(bpy: ModuleType, add: Any) -> None:
    add(faces=[])
    with pytest.raises(RuntimeError, match="has no faces"):
        bpy.ops.dimple.make_soft()


def broken(bpy: ModuleType) -> Any:
    """Return a ball with a doubled vertex, a loose one, a face that looks inward and a hole."""
    import bmesh

    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=0.05)
    obj, made = bpy.context.object, bmesh.new()
    made.from_mesh(obj.data)
    made.faces.ensure_lookup_table()
    bmesh.ops.delete(made, geom=[made.faces[100]], context="FACES_ONLY")
    made.faces.ensure_lookup_table()
    made.faces[7].normal_flip()
    face = made.faces[300]
    bmesh.ops.split(made, geom=[face])
    made.verts.new((0.0, 0.0, 0.3))
    made.to_mesh(obj.data)
    made.free()
    return obj


def test_a_broken_mesh_is_left_as_it_is_and_what_is_wrong_with_it_is_said(
    bpy: ModuleType, empty_file: ModuleType, coordinates: Bits, capfd: pytest.CaptureFixture[str]
) -> None:
    obj = broken(bpy)
    before = coordinates(obj)
    bpy.ops.dimple.make_soft()
    assert coordinates(obj) == before
    assert "Holes closed for the pressure only: 1." in capfd.readouterr().out


@pytest.mark.parametrize(
    ("painted", "chosen", "taken"), [("Pin", "", "Pin"), ("Belt", "", ""), ("Pin", "Belt", "Belt")]
)
def test_make_soft_takes_a_vertex_group_named_pin_unless_another_is_chosen(
    bpy: ModuleType, bare: Any, painted: str, chosen: str, taken: str
) -> None:
    for name in filter(None, {painted, chosen}):
        bare.vertex_groups.new(name=name).add([0, 1, 2, 3], 1.0, "ADD")
    bare.dimple.pin_group = chosen
    bpy.ops.dimple.make_soft()
    assert bare.dimple.pinned and bare.dimple.pin_group == taken


def test_undo_takes_all_of_it_back(bpy: ModuleType, bare: Any, coordinates: Bits) -> None:
    before = coordinates(bare)
    bpy.ops.ed.undo_push(message="Before")
    bpy.ops.dimple.make_soft()
    bpy.ops.ed.undo_push(message="Make Soft")
    bpy.ops.ed.undo()
    cube = bpy.data.objects["Cube"]
    assert coordinates(cube) == before and cube.active_material is None and not cube.dimple.enabled
