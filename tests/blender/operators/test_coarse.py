"""A mesh that is too coarse for the fingertip is no trap: a bare primitive answers a click as was measured."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

KNEE_MM = 16.3
BESIDE = (0.15, -0.27, 1.0)  # where a hand may click: not on the very middle, where there is a vertex
MIDDLE = (0.0, 0.0, 1.0)
OTHER_CLICKS = ("cube", MIDDLE), ("plane", BESIDE), ("cylinder", BESIDE), ("uv_sphere", BESIDE)
PRESS: dict[str, Any] = {"depth_mm": KNEE_MM, "press_s": 0.2, "hold_s": 0.3, "release_s": 0.0, "location": BESIDE}
NEAR = 0.1  # of the law at its knee, which a round tip rounds


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
    from bl_ext.user_default.dimple.operators import sessions

    seen: list[Any] = []
    stop = sessions.stop
    monkeypatch.setattr(sessions, "stop", lambda uid, **how: seen.append(sessions.sessions[uid]) or stop(uid, **how))
    return seen


def law_of(body: Any) -> float:
    """Return the force [N] of the measured law at the depth of the deepest fingertip."""
    law = body.session.model.materials[0].law
    return float(law(float(body.frame.depths.max())))


@pytest.mark.parametrize(
    ("name", "where"),
    [("cube", BESIDE), ("plane", MIDDLE), *(pytest.param(*each, marks=pytest.mark.once) for each in OTHER_CLICKS)],
)
def test_a_click_on_a_bare_primitive_answers_the_law(
    bpy: ModuleType, bare: Callable[[str], Any], frames: list[Any], coordinates: Callable[[Any], bytes],
    name: str, where: tuple[float, float, float],
) -> None:  # fmt: skip
    obj = bare(name)
    before = coordinates(obj)
    assert bpy.ops.dimple.poke(**(PRESS | {"location": where})) == {"FINISHED"}
    frame = frames[0].frame
    force = float(np.linalg.norm(frame.finger_forces, axis=1).max())
    assert force == pytest.approx(law_of(frames[0]), rel=NEAR / 2)
    assert coordinates(obj) == before and obj.dimple.size_mode == "CUSTOM"
    if name != "plane":  # air gives way a little: the dent is 0.1 to 0.3 percent of it
        assert frame.volume == pytest.approx(frame.rest_volume, rel=0.004)


@pytest.mark.parametrize("depth_mm", [5.0, pytest.param(KNEE_MM, marks=pytest.mark.once)])
def test_a_click_on_the_pole_of_a_uv_sphere_answers_the_law(
    bpy: ModuleType, bare: Callable[[str], Any], frames: list[Any], depth_mm: float
) -> None:
    """Its neighbours are farther away than those of any other vertex: it answered 0.72 of the law at 5 mm."""
    bare("uv_sphere")
    pole = {"location": (0.0, 0.0, 1.0), "direction": (0.0, 0.0, -1.0), "depth_mm": depth_mm}
    assert bpy.ops.dimple.poke(**(PRESS | pole)) == {"FINISHED"}
    frame = frames[0].frame
    force = float(np.linalg.norm(frame.finger_forces, axis=1).max())
    print(f"{force:.2f} N for {law_of(frames[0]):.2f} N at {depth_mm:g} mm")
    assert force == pytest.approx(law_of(frames[0]), rel=NEAR)


@pytest.mark.parametrize("name", ["cube", *(pytest.param(n, marks=pytest.mark.once) for n in ("cone", "cylinder"))])
def test_a_liquid_keeps_its_volume_in_a_primitive_of_few_vertices(
    bpy: ModuleType, bare: Callable[[str], Any], frames: list[Any], name: str
) -> None:
    """A cone of 34 vertices pressed as it is cannot: 30 percent of its volume lie under the one that is pressed."""
    assert len(bare(name).data.vertices) < 200
    bpy.ops.dimple.apply_preset(preset="object_3_vinyl_water")
    assert bpy.ops.dimple.poke(**(PRESS | {"location": (0.0, 0.0, 1.0), "direction": (0.0, 0.0, -1.0)})) == {"FINISHED"}
    assert frames[0].session.model.pressure.fill == "liquid"
    assert frames[0].frame.volume == pytest.approx(frames[0].frame.rest_volume, rel=0.005)
    assert frames[0].frame.depths[0] > 0.005


@pytest.mark.parametrize(
    ("name", "where"),
    [("cone", {"location": (0.3, -0.4, 0.0)}), ("cone", {"location": (0.5, 0.0, 0.0), "direction": (-1.0, 0.0, -0.5)}),
     ("cylinder", {"location": (1.0, 0.0, 0.2), "direction": (-1.0, 0.0, 0.0)})],
)  # fmt: skip
def test_the_flank_of_a_round_primitive_answers_the_law(
    bpy: ModuleType, bare: Callable[[str], Any], frames: list[Any], name: str, where: dict[str, Any]
) -> None:
    """Its facets are strips."""
    bare(name)
    assert bpy.ops.dimple.poke(**(PRESS | where)) == {"FINISHED"}
    frame = frames[0].frame
    force = float(np.linalg.norm(frame.finger_forces, axis=1).max())
    assert force == pytest.approx(law_of(frames[0]), rel=NEAR)


def test_a_torus_whose_edges_are_as_long_as_the_fingertip_is_subdivided(
    bpy: ModuleType, bare: Callable[[str], Any], frames: list[Any]
) -> None:
    """Its own 576 vertices answered 1.4 times the law, by chance of where they lie."""
    bare("torus")
    where = {"location": (1.0, 0.17, 0.25), "direction": (0.0, 0.0, -1.0)}
    assert bpy.ops.dimple.poke(**(PRESS | where)) == {"FINISHED"}
    frame = frames[0].frame
    assert len(frames[0].session.model.mesh.rest_positions) > 1000
    force = float(np.linalg.norm(frame.finger_forces, axis=1).max())
    assert force == pytest.approx(law_of(frames[0]), rel=NEAR)


def test_the_artist_hears_at_what_size_and_with_how_many_vertices_it_is_pressed(
    bpy: ModuleType, bare: Callable[[str], Any], capfd: pytest.CaptureFixture[str]
) -> None:
    bare("cube")
    bpy.ops.dimple.poke(depth_mm=2.0, press_s=0.02, hold_s=0.0, release_s=0.0)
    said = capfd.readouterr().out
    assert "2 m across as modelled" in said and "it is pressed with 6,146 vertices" in said and "Warning" not in said


def test_a_size_or_a_mesh_that_was_chosen_is_kept(bpy: ModuleType, bare: Callable[[str], Any]) -> None:
    from bl_ext.user_default.dimple.operators import bridge

    obj = bare("cube")
    obj.dimple.size_mode, obj.dimple.simulated = "REAL", "MESH"
    link, model = bridge.read_body(bpy.context, obj)
    assert model.mesh.size == pytest.approx(2.0) and link.cuts == 0 and len(model.mass) == 8
    bpy.ops.dimple.poke(depth_mm=2.0, press_s=0.02, hold_s=0.0, release_s=0.0)
    assert obj.dimple.size_mode == "REAL"


def test_flat_text_becomes_a_body_in_one_click_and_an_undo_takes_it_back(
    bpy: ModuleType, empty_file: ModuleType
) -> None:
    bpy.ops.object.text_add()
    bpy.ops.ed.undo_push(message="Text")
    with pytest.raises(RuntimeError, match="Make Soft converts it"):
        bpy.ops.dimple.poke(depth_mm=1.0)
    assert bpy.ops.dimple.make_soft() == {"FINISHED"}
    obj = bpy.context.object
    assert obj.type == "MESH" and obj.dimensions.z == pytest.approx(0.3, rel=1e-3) and obj.dimple.enabled
    bpy.ops.ed.undo_push(message="Make Soft")
    bpy.ops.ed.undo()
    assert bpy.data.objects["Text"].type == "FONT" and bpy.data.objects["Text"].data.extrude == 0
