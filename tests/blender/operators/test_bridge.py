"""What the bridge reads of an object: its materials, its vertex groups, and what it notes about them."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np

Add = Callable[..., Any]


def read(bpy: ModuleType, obj: Any) -> Any:
    from bl_ext.user_default.dimple.operators.bridge import scene_objects

    return scene_objects.read_body(bpy.context, obj)[1]


def test_a_body_without_a_material_has_the_constants_of_one_that_nobody_has_touched(bpy: ModuleType, ball: Add) -> None:
    from bl_ext.user_default.dimple.core.material import DEFAULT_MATERIAL

    bare, dressed = ball("Bare"), ball("Dressed")
    dressed.data.materials.append(bpy.data.materials.new("New"))
    (found,) = read(bpy, bare).materials
    assert read(bpy, dressed).materials == (found,) and found == DEFAULT_MATERIAL


def test_weights_are_those_of_the_group_and_0_outside_it(bpy: ModuleType, ball: Add) -> None:
    from bl_ext.user_default.dimple.operators.bridge import final_mesh

    obj, wanted = ball(), np.zeros(42)
    groups = [obj.vertex_groups.new(name=name) for name in ("Other", "Soft", "Empty")]
    groups[0].add(list(range(30)), 1.0, "ADD")
    for i in range(0, 42, 3):
        wanted[i] = i / 64
        groups[1].add([i], i / 64, "ADD")
    assert (final_mesh.weights(bpy.context, obj, "Soft", 0) == wanted).all()
    assert not final_mesh.weights(bpy.context, obj, "Empty", 0).any()
    bare = ball("Bare")
    bare.vertex_groups.new(name="Soft")
    assert not final_mesh.weights(bpy.context, bare, "Soft", 0).any()


def two_fills(bpy: ModuleType, obj: Any, share: int) -> Any:
    for name, fill in (("Air", "AIR"), ("Water", "LIQUID")):
        material = bpy.data.materials.new(name)
        material.dimple.fill = fill
        obj.data.materials.append(material)
    for polygon in obj.data.polygons[:share]:
        polygon.material_index = 1
    return read(bpy, obj)


def test_of_several_fills_the_one_with_the_most_area_acts_and_a_note_says_so(bpy: ModuleType, ball: Add) -> None:
    words = "Its materials differ in fill or pressure. Those of the largest area act: {}, 0 kPa."
    for name, share, fill in (("Airy", 20, "air"), ("Wet", 60, "liquid")):
        model = two_fills(bpy, ball(name), share)
        assert model.pressure.fill == fill and words.format(fill) in model.notes


def test_of_a_solid_the_skin_gives_way(bpy: ModuleType, ball: Add) -> None:
    obj = ball()
    obj.data.materials.append(bpy.data.materials.new("Rubber"))
    assert not read(bpy, obj).compliance.any()
    obj.active_material.dimple.fill = "SOLID"
    model = read(bpy, obj)
    assert model.pressure.fill == "solid" and (model.compliance > 0).all()


def test_one_fill_or_none_that_can_act_needs_no_note(bpy: ModuleType, ball: Add, add: Add) -> None:
    assert not any("materials differ" in note for note in read(bpy, ball()).notes)
    sheet = add(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)], [(0, 1, 2, 3), (1, 4, 5, 2)], "Sheet"
    )
    assert not any("materials differ" in note for note in two_fills(bpy, sheet, 1).notes)
    sheet.active_material.dimple.pressure_kpa = 3.0
    assert "Pressure has no effect, because the mesh encloses no volume: close the mesh." in read(bpy, sheet).notes


def test_of_several_pressures_the_one_on_the_most_area_acts_and_a_note_says_so(bpy: ModuleType, ball: Add) -> None:
    obj = ball()
    two_fills(bpy, obj, 60)
    for each, value in zip(obj.data.materials, (3.0, 7.5), strict=True):
        each.dimple.fill, each.dimple.pressure_kpa = "AIR", value
    model = read(bpy, obj)
    assert model.pressure.rest_pressure == 7500
    assert "Its materials differ in fill or pressure. Those of the largest area act: air, 7.5 kPa." in model.notes
