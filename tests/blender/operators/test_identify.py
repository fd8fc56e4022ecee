"""A virtual press that answers as was measured: identified for a material, cancelled, remembered."""

import json
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest


@pytest.fixture
def no_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make every new identification fail."""
    from bl_ext.user_default.dimple.core.calibration import identify

    monkeypatch.setattr(identify, "identification", None)


def identified(settings: Any) -> dict:
    return json.loads(settings.identification) if settings.identification else {}


def test_the_identified_body_answers_the_measured_curve_and_sessions_use_its_constants(
    bpy: ModuleType, vinyl: Any, cube: Any, forgetful: Path
) -> None:
    vinyl.tip, vinyl.tip_radius_mm = "POINT", 2.0  # which answers with a knee as sharp as the measured one
    assert bpy.ops.dimple.identify() == {"FINISHED"}
    record = identified(vinyl)
    assert 0 < record["rms"] < 0.03 and 0 < record["force_off"] < 0.1 and 0 < record["volume_change"] < 0.005
    assert record["deepest"] == pytest.approx(1.5 * 16.3, rel=1e-3)
    assert record["object"] == "Cube" and record["size"] == pytest.approx(165)
    assert record["fingerprint"]["vertices"] == 98
    assert record["fingerprint"]["area"] == pytest.approx(6 * 0.165**2)
    assert record["fingerprint"]["volume"] == pytest.approx(0.165**3)
    assert any("k is taken at" in note for note in record["notes"]), "a sentence explains the scale on k"
    from bl_ext.user_default.dimple.operators import bridge

    _, model = bridge.read_body(bpy.context, cube)
    constants = model.materials[0].constants
    assert constants.kappa1 == pytest.approx(vinyl.kappa1 * 1e6, rel=1e-6)
    assert constants.d0 == pytest.approx(vinyl.d0 / 1e3, rel=1e-6)
    assert constants.membrane_scale == pytest.approx(vinyl.membrane_scale, rel=1e-6)
    assert constants.tension == record["tension"] > 0
    assert [list(piece) for piece in constants.pieces] == record["pieces"] and record["pieces"]
    assert vinyl.to_params()["constants"] == constants


def test_a_fingertip_is_met_and_its_largest_error_is_kept(bpy: ModuleType, vinyl: Any, forgetful: Path) -> None:
    assert (vinyl.tip, vinyl.tip_radius_mm) == ("SPHERE", 10)
    assert bpy.ops.dimple.identify() == {"FINISHED"}
    record = identified(vinyl)
    assert 0 < record["rms"] < 0.02 and 0 < record["volume_change"] < 0.005
    off = [abs(force / law(vinyl, depth) - 1) for depth, force in record["points"]]
    assert record["force_off"] == pytest.approx(max(off), rel=1e-3)


def law(settings: Any, depth: float) -> float:
    """Return the measured force [N] at a depth [mm]."""
    return settings.K1 * min(depth, settings.x0) + settings.K2 * max(depth - settings.x0, 0)


def test_what_was_identified_once_is_remembered(
    bpy: ModuleType, vinyl: Any, forgetful: Path, request: pytest.FixtureRequest
) -> None:
    bpy.ops.dimple.identify(depth_mm=8)
    first = vinyl.kappa1
    assert len(list(forgetful.glob("*.json"))) == 1
    vinyl.kappa1, vinyl.identification = 0.0, ""
    request.getfixturevalue("no_work")
    bpy.ops.dimple.identify(depth_mm=8)
    assert vinyl.kappa1 == first and identified(vinyl)


def test_where_nothing_can_be_remembered_the_result_is_kept_all_the_same(
    bpy: ModuleType, vinyl: Any, hand: Any, forgetful: Path
) -> None:
    forgetful.rmdir()
    forgetful.write_text("a file where the folder should be")
    try:
        run = hand("identify")
        run.operator.depth_mm = 8.0
        assert run.operator.execute(bpy.context) == {"FINISHED"}
    finally:
        forgetful.unlink()
        forgetful.mkdir()
    assert vinyl.kappa1 > 0 and identified(vinyl)["rms"] < 0.03
    assert any(level == "WARNING" and "not be stored" in text for level, text in run.reports)


def test_escape_leaves_the_material_as_it_was(bpy: ModuleType, vinyl: Any, hand: Any, forgetful: Path) -> None:
    from bl_ext.user_default.dimple.operators import working

    slice_s, working.SLICE_S = working.SLICE_S, 0.0
    before = {name: getattr(vinyl, name) for name in ("K1", "kappa1", "identification", "provenance")}
    try:
        run = hand("identify")
        assert run.invoke() == {"RUNNING_MODAL"}
        run.ticks(4)
        assert "Identifying" in run.context.said and "s left" in run.context.said
        for verb in ("play", "poke", "bake", "identify", "measure"):
            assert not getattr(bpy.ops.dimple, verb).poll(), verb
        assert run.send("Z", ctrl=True) == {"RUNNING_MODAL"}, "no undo meanwhile"
        assert run.send("ESC") == {"CANCELLED"}
    finally:
        working.SLICE_S = slice_s
    assert ("INFO", "The identification was stopped; the material is as it was") in run.reports
    assert {name: getattr(vinyl, name) for name in before} == before
    assert not list(forgetful.glob("*")) and bpy.ops.dimple.identify.poll()


def test_loading_a_file_ends_the_identification(bpy: ModuleType, vinyl: Any, hand: Any, forgetful: Path) -> None:
    run = hand("identify")
    run.invoke()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert run.ticks(1) == {"CANCELLED"} and not list(forgetful.glob("*"))


def test_a_body_that_cannot_answer_as_was_measured_keeps_its_estimate(
    bpy: ModuleType, vinyl: Any, forgetful: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from dataclasses import replace

    from bl_ext.user_default.dimple.core.calibration import identify

    real = identify.identification

    def hopeless(*given: Any) -> Iterator[Any]:
        found = yield from real(*given)
        return replace(found, simulated=1.5 * found.wanted, notes=(*found.notes, "It is off the most at 3 mm."))

    monkeypatch.setattr(identify, "identification", hopeless)
    with pytest.raises(RuntimeError, match="off the most at 3 mm. Nothing was written"):
        bpy.ops.dimple.identify(depth_mm=8)
    assert vinyl.kappa1 == 0 and vinyl.identification == ""


def test_between_blenders_events_it_comes_to_the_same_end(
    bpy: ModuleType, vinyl: Any, hand: Any, forgetful: Path
) -> None:
    run = hand("identify")
    run.operator.depth_mm = 8.0
    run.invoke()
    assert run.ticks(2000) == {"FINISHED"}
    live = [getattr(vinyl, name) for name in ("kappa1", "kappa2", "d0", "membrane_scale")]
    for path in forgetful.glob("*"):
        path.unlink()
    bpy.ops.dimple.identify(depth_mm=8)
    assert [getattr(vinyl, name) for name in ("kappa1", "kappa2", "d0", "membrane_scale")] == live


def test_one_undo_takes_the_model_constants_back(bpy: ModuleType, vinyl: Any, forgetful: Path) -> None:
    bpy.ops.ed.undo_push(message="Preset")
    bpy.ops.dimple.identify(depth_mm=8)
    bpy.ops.ed.undo_push(message="Identify")
    bpy.ops.ed.undo()
    settings = bpy.data.objects["Cube"].active_material.dimple
    assert settings.kappa1 == 0 and settings.identification == ""
    bpy.ops.ed.redo()
    assert bpy.data.objects["Cube"].active_material.dimple.kappa1 > 0


def test_the_3d_cursor_says_where_the_tip_goes_in(bpy: ModuleType, vinyl: Any, cube: Any) -> None:
    from bl_ext.user_default.dimple.operators import indentation

    bpy.context.scene.cursor.location = (2.0, 0.5, 0.5)
    bench = indentation.set_up(bpy.context, cube, "CURSOR", 0.0)
    assert bench.site.point == pytest.approx([0.0825, 0.04125, 0.04125])
    assert bench.site.inward == pytest.approx([-1, 0, 0], abs=1e-6)
    top = indentation.set_up(bpy.context, cube, "TOP", 5.0)
    assert top.site.point == pytest.approx([0, 0, 0.0825], abs=0.02) and top.deepest == 0.005


def test_a_fingertip_is_set_down_on_the_middle_of_a_flat_top(bpy: ModuleType, cube: Any) -> None:
    bpy.ops.dimple.add_fingertip()
    assert tuple(bpy.context.scene.dimple.finger_1.location)[:2] == pytest.approx((0, 0), abs=1e-6)


def test_a_baked_press_is_no_part_of_the_shape_that_is_pressed(bpy: ModuleType, vinyl: Any, cube: Any) -> None:
    from bl_ext.user_default.dimple.operators import indentation

    rest = indentation.set_up(bpy.context, cube, "TOP", 8.0).mesh.rest_positions
    bpy.ops.dimple.add_fingertip()
    tip = bpy.context.scene.dimple.finger_1
    for frame, height in ((1, 1.2), (6, 0.9)):
        tip.location.z = height
        tip.keyframe_insert("location", index=2, frame=frame)
    bpy.ops.dimple.bake(target="SHAPE_KEYS", frame_start=1, frame_end=6)
    bpy.context.scene.frame_set(6)
    assert cube.data.shape_keys.key_blocks[-1].value == 1
    assert np.array_equal(indentation.set_up(bpy.context, cube, "TOP", 8.0).mesh.rest_positions, rest)


def test_what_cannot_be_pressed_says_why(bpy: ModuleType, vinyl: Any, cube: Any) -> None:
    vinyl.k = 0
    with pytest.raises(RuntimeError, match="k must be greater than 0"):
        bpy.ops.dimple.identify()
    vinyl.k = 9.2
    cube.data.clear_geometry()
    cube.data.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    with pytest.raises(RuntimeError, match="pinned.* 3D Cursor"):
        bpy.ops.dimple.identify()
    cube.active_material = None
    assert not bpy.ops.dimple.identify.poll() and not bpy.ops.dimple.measure.poll()
