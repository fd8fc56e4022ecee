"""A mesh that is too coarse for the fingertip is no trap: a bare primitive answers a click by the law."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import pytest

KNEE_MM = 16.3
BESIDE = (0.15, -0.27, 1.0)  # where a hand may click: not on the very middle, where there is a vertex
MIDDLE = (0.0, 0.0, 1.0)
DOWN = (0.0, 0.0, -1.0)
CLICKS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("cube", {}), ("plane", {"location": MIDDLE}), ("uv_sphere", {"location": MIDDLE, "direction": DOWN}),
    ("torus", {"location": (1.0, 0.17, 0.25), "direction": DOWN}),
    ("cone", {"location": (0.5, 0.0, 0.0), "direction": (-1.0, 0.0, -0.5)}),
    ("cylinder", {"location": (1.0, 0.0, 0.2), "direction": (-1.0, 0.0, 0.0)}),
)  # fmt: skip
PRESS: dict[str, Any] = {"depth_mm": KNEE_MM, "press_s": 0.2, "hold_s": 0.3, "release_s": 0.0, "location": BESIDE}


@pytest.fixture
def bare(empty_file: ModuleType) -> Callable[[str], Any]:
    """Return a function that adds one of Blender's primitives, as it comes."""

    def add(name: str) -> Any:
        getattr(empty_file.ops.mesh, f"primitive_{name}_add")()
        return empty_file.context.object

    return add


@pytest.fixture
def frames(bpy: ModuleType, monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The frames that sessions end with."""
    from bl_ext.user_default.dimple.operators.press import sessions

    seen: list[Any] = []
    stop = sessions.stop
    monkeypatch.setattr(sessions, "stop", lambda uid, **how: seen.append(sessions.sessions[uid]) or stop(uid, **how))
    return seen


def assert_by_law(body: Any) -> None:
    """Assert that the one fingertip on a body is answered by the law of its material."""
    frame, (material,) = body.frame, body.session.model.materials
    assert frame.depths.max() > 0.002
    assert frame.pushes.max() == pytest.approx(material.law(float(frame.depths.max())), rel=0.01)


@pytest.mark.parametrize(
    ("name", "where"), [CLICKS[0], *(pytest.param(*each, marks=pytest.mark.once) for each in CLICKS[1:])]
)
def test_a_click_on_a_bare_primitive_answers_the_law(
    bpy: ModuleType, bare: Callable[[str], Any], frames: list[Any], coordinates: Callable[[Any], bytes],
    name: str, where: dict[str, Any],
) -> None:  # fmt: skip
    obj = bare(name)
    before = coordinates(obj)
    assert bpy.ops.dimple.poke(**(PRESS | where)) == {"FINISHED"}
    frame = frames[0].frame
    assert_by_law(frames[0])
    assert frame.depths[0] * 1e3 == pytest.approx(KNEE_MM, rel=0.02) or where.get("direction")
    assert coordinates(obj) == before and obj.dimple.size_mode == "CUSTOM"
    if name in ("cube", "uv_sphere"):  # air gives way a little: the dent is 0.1 to 0.3 percent of it
        assert frame.volume == pytest.approx(frame.rest_volume, rel=0.004)


def test_the_force_does_not_depend_on_what_is_simulated(
    bpy: ModuleType, bare: Callable[[str], Any], frames: list[Any]
) -> None:
    bare("cube").dimple.simulated = "MESH"
    assert bpy.ops.dimple.poke(**PRESS) == {"FINISHED"}
    assert_by_law(frames[0])


def test_a_liquid_keeps_its_volume_in_a_primitive_of_few_vertices(
    bpy: ModuleType, bare: Callable[[str], Any], frames: list[Any]
) -> None:
    """A cone of 34 vertices pressed as it is cannot: 30 percent of its volume lie under the one that is pressed."""
    assert len(bare("cone").data.vertices) < 200
    bpy.context.object.dimple.material = "object_3_vinyl_water"
    assert bpy.ops.dimple.poke(**(PRESS | {"location": (0.0, 0.0, 1.0), "direction": (0.0, 0.0, -1.0)})) == {"FINISHED"}
    assert frames[0].session.model.pressure.fill == "liquid"
    assert frames[0].frame.volume == pytest.approx(frames[0].frame.rest_volume, rel=0.005)
    assert frames[0].frame.depths[0] > 0.005


def test_the_artist_hears_at_what_size_and_with_how_many_vertices_it_is_pressed(
    bpy: ModuleType, bare: Callable[[str], Any], capfd: pytest.CaptureFixture[str]
) -> None:
    bare("cube")
    bpy.ops.dimple.poke(depth_mm=2.0, press_s=0.02, hold_s=0.0, release_s=0.0)
    said = capfd.readouterr().out
    assert "2 m across as modeled" in said and "it is subdivided to 6,146 vertices" in said and "Warning" not in said


def test_a_size_or_a_mesh_that_was_chosen_is_kept(bpy: ModuleType, bare: Callable[[str], Any]) -> None:
    from bl_ext.user_default.dimple.operators.bridge import scene_objects

    obj = bare("cube")
    obj.dimple.size_mode, obj.dimple.simulated = "REAL", "MESH"
    link, model = scene_objects.read_body(bpy.context, obj)
    assert model.mesh.size == pytest.approx(2.0) and link.cuts == 0 and len(model.mass) == 8
    bpy.ops.dimple.poke(depth_mm=2.0, press_s=0.02, hold_s=0.0, release_s=0.0)
    assert obj.dimple.size_mode == "REAL"


def test_flat_text_becomes_a_body_in_one_click_and_an_undo_takes_it_back(
    bpy: ModuleType, empty_file: ModuleType, frames: list[Any]
) -> None:
    bpy.ops.object.text_add()
    bpy.ops.ed.undo_push(message="Text")
    with pytest.raises(RuntimeError, match="Make Soft converts it"):
        bpy.ops.dimple.poke(depth_mm=1.0)
    assert bpy.ops.dimple.make_soft() == {"FINISHED"}
    obj = bpy.context.object
    assert obj.type == "MESH" and obj.dimensions.z == pytest.approx(0.3, rel=1e-3) and obj.dimple.enabled
    obj.data.calc_loop_triangles()
    top = max((each for each in obj.data.loop_triangles if each.normal.z > 0.99), key=lambda each: each.area)
    where = {"location": tuple(obj.matrix_world @ top.center), "direction": DOWN, "depth_mm": 3.0}
    assert bpy.ops.dimple.poke(**(PRESS | where)) == {"FINISHED"}
    assert_by_law(frames[0])
    bpy.ops.ed.undo_push(message="Make Soft")
    bpy.ops.ed.undo()
    assert bpy.data.objects["Text"].type == "FONT" and bpy.data.objects["Text"].data.extrude == 0
