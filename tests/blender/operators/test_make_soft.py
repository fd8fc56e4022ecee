"""Make Soft takes a bare mesh to its first press, and does not change the mesh itself."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

Bits = Callable[[Any], bytes]
TIP, FORCE = 0.01, 15.0  # [m], [N]
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
    assert bare.active_material.name == "Stress ball" and bare.active_material.dimple.K1 == pytest.approx(0.9)
    assert bare.dimple.enabled and bare.dimple.size_mode == "CUSTOM" and bare.dimple.size_mm == 165
    assert bare.dimple.plan_reason, "it is planned already"
    bpy.ops.dimple.poke(**PRESS)
    seen = shown(bare)
    assert seen[np.hypot(seen[:, 0], seen[:, 1]) < 0.1][:, 2].max() < 1.0 - 0.02
    assert coordinates(bare) == before


@pytest.mark.once
@pytest.mark.parametrize("K1", [pytest.param(0.3, marks=pytest.mark.slow), 3.0])
def test_a_press_by_force_is_as_deep_as_the_law_says_on_a_vertex_and_beside_it(
    bpy: ModuleType, bare: Any, sessions: Any, K1: float
) -> None:
    from bl_ext.user_default.dimple.core.session import Finger
    from bl_ext.user_default.dimple.operators.press import live_step

    bpy.ops.dimple.make_soft()
    body, _ = sessions.start(bare, bpy.context)
    bare.active_material.dimple.K1 = K1
    live_step.advance(bpy.context, 1e-3)
    law, mesh = body.session.model.materials[0].law, body.session.model.mesh
    edge = float(np.median(mesh.rest_lengths))
    for aside in ((0.0, 0.0), (0.5, 0.0), (0.5, 0.5)):  # of an edge: on a vertex, an edge and a face
        at = (edge * aside[0], edge * aside[1], mesh.size / 2 + TIP)
        for force, seconds in ((0.0, 0.3), (FORCE, 1.0)):
            body.session.set_fingers([Finger(at, TIP, force)])
            body.session.step(seconds)
        assert law(0.95 * body.frame.depths[0]) < FORCE < law(1.05 * body.frame.depths[0]), (aside, body.frame)
    sessions.stop_all()


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
    obj.active_material.dimple.K1 = 2.0
    obj.dimple.enabled, obj.dimple.size_mm = True, 90.0
    bpy.ops.dimple.make_soft()
    assert obj.active_material.name == "Own" and obj.active_material.dimple.K1 == 2.0 and obj.dimple.size_mm == 90.0


def test_a_material_that_nobody_has_set_becomes_that_of_a_bare_mesh(bpy: ModuleType, bare: Any) -> None:
    bare.active_material = bpy.data.materials.new("Material")  # as Blender's default cube has one
    bpy.ops.dimple.make_soft()
    assert bare.active_material.name == "Material" and bare.active_material.dimple.K1 == pytest.approx(0.9)
    bare.active_material.dimple.property_unset("K1")
    bpy.ops.dimple.make_soft()
    assert bare.active_material.dimple.K1 == pytest.approx(0.61), "set once, it is the artist's"


def test_what_cannot_be_pressed_is_said(bpy: ModuleType, add: Any) -> None:
    add(faces=[])
    with pytest.raises(RuntimeError, match="has no faces"):
        bpy.ops.dimple.make_soft()


def test_undo_takes_all_of_it_back(bpy: ModuleType, bare: Any, coordinates: Bits) -> None:
    before = coordinates(bare)
    bpy.ops.ed.undo_push(message="Before")
    bpy.ops.dimple.make_soft()
    bpy.ops.ed.undo_push(message="Make Soft")
    bpy.ops.ed.undo()
    cube = bpy.data.objects["Cube"]
    assert coordinates(cube) == before and cube.active_material is None and not cube.dimple.enabled
