"""What moves in place of a mesh: by itself where that runs live, kept with the object, compared and chosen by hand."""

import json
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest


@pytest.fixture
def fine(ball: Callable[..., Any]) -> Any:
    """A ball of 10,242 vertices and radius 1 that stands for one of 165 mm: too heavy to run live."""
    obj = ball("Fine", 6)
    obj.dimple.tolerance_mm, obj.dimple.tolerance_percent = 2.0, 20.0  # a small stand-in is a quick test
    return obj


@pytest.fixture
def heavy(monkeypatch: pytest.MonkeyPatch, bpy: ModuleType) -> None:
    """However fast this computer is, nothing above 2000 vertices runs live on it; nothing is measured."""
    from bl_ext.user_default.dimple.core.reduction import planner

    monkeypatch.setattr(planner, "pace", lambda model: len(model.mass) / 2000)
    monkeypatch.setattr(planner, "ALLOWANCE", 0.0)
    monkeypatch.setitem(planner.plan.__kwdefaults__, "allowance", 0.0)


def start(bpy: ModuleType, obj: Any) -> Any:
    from bl_ext.user_default.dimple.operators import sessions

    return sessions.start(obj, bpy.context)


def stop() -> None:
    from bl_ext.user_default.dimple.operators import sessions

    sessions.stop_all()


def test_a_mesh_that_runs_live_moves_itself_and_says_so(bpy: ModuleType, ball: Any, heavy: None) -> None:
    obj = ball()
    body, said = start(bpy, obj)
    assert body.session.proxy is None
    assert [": The edges of the mesh are 48 mm long, the fingertip 20 mm wide" in each for each in said] == [True]
    assert "42 vertices" in obj.dimple.plan_reason and obj.dimple.plan_vertices == 0
    stop()


def test_a_heavy_mesh_gets_a_stand_in_with_a_reason_and_keeps_it(bpy: ModuleType, fine: Any, heavy: None) -> None:
    body, said = start(bpy, fine)
    assert body.session.proxy is not None and body.session.model is not body.session.proxy.model
    assert "stand-in of" in said[0] and "stand-in of" in fine.dimple.plan_reason
    assert len(body.session.positions()) == len(body.link.rest)
    seeds = body.session.proxy.seeds
    stop()
    again, said = start(bpy, fine)
    assert np.array_equal(again.session.proxy.seeds, seeds) and said == []
    stop()
    fine.dimple.tolerance_percent = 50.0
    looser, said = start(bpy, fine)
    assert len(looser.session.proxy.seeds) < len(seeds) and "stand-in of" in said[0]
    stop()


def test_by_hand_the_mesh_itself_or_a_stand_in_of_a_size_moves(bpy: ModuleType, fine: Any, heavy: None) -> None:
    from bl_ext.user_default.dimple.core.base import DimpleError

    fine.dimple.moves = "MESH"
    assert start(bpy, fine)[0].session.proxy is None
    assert "As chosen" in fine.dimple.plan_reason
    stop()
    fine.dimple.moves, fine.dimple.stand_in_vertices = "STAND_IN", 400
    assert len(start(bpy, fine)[0].session.proxy.seeds) == 400
    stop()
    fine.dimple.stand_in_vertices = 8000
    with pytest.raises(DimpleError, match="Automatic"):
        start(bpy, fine)


def test_a_press_and_a_bake_move_the_same_stand_in_and_give_the_mesh_back(
    bpy: ModuleType, fine: Any, heavy: None, coordinates: Callable, shown: Callable, tmp_path: Any
) -> None:
    scene = bpy.context.scene
    before = coordinates(fine)
    scene.dimple.cache_dir, scene.dimple.finger_radius_mm = str(tmp_path), 20.0
    tip = bpy.data.objects.new("Tip", None)
    scene.collection.objects.link(tip)
    scene.dimple.finger_1 = tip
    reach = 1 + 20 / 82.5
    for frame, height in ((1, reach), (5, reach - 0.1)):
        tip.location.z = height
        tip.keyframe_insert("location", frame=frame)
    bpy.ops.dimple.bake(frame_start=1, frame_end=5)
    planned = fine.dimple.plan_vertices
    assert 0 < planned < 5000
    scene.frame_set(5)
    dented, rest = shown(fine), np.frombuffer(before, np.float32).reshape(-1, 3)
    assert dented[:, 2].max() < 0.97 and np.isfinite(dented).all()
    lowest = rest[:, 2].argmin()
    assert np.array_equal(dented[lowest], rest[lowest]), "what is held stays"
    bpy.ops.dimple.unbake()
    assert coordinates(fine) == before
    assert start(bpy, fine)[0].session.proxy is not None and fine.dimple.plan_vertices == planned
    stop()
    assert coordinates(fine) == before


def test_a_comparison_charts_this_very_object_and_any_variant_can_be_taken(
    bpy: ModuleType, ball: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators import compare

    monkeypatch.setattr(compare, "SIZES", 3)
    obj = ball("Ball", 4)
    bpy.context.scene.dimple.finger_radius_mm = 20.0
    assert bpy.ops.dimple.compare_methods(presses=1) == {"FINISHED"}
    kept = json.loads(obj.dimple.comparison)
    found = kept["variants"]
    assert [each["asked"] for each in found] == [0, 100, 179, 321]
    assert found[0]["error"] == 0 and all(0 < each["error"] < 10 for each in found[1:])
    assert bpy.ops.dimple.apply_method(vertices=179) == {"FINISHED"}
    assert (obj.dimple.moves, obj.dimple.stand_in_vertices) == ("STAND_IN", 179)
    assert len(start(bpy, obj)[0].session.proxy.seeds) == 179
    stop()
    bpy.ops.dimple.apply_method(vertices=0)
    assert obj.dimple.moves == "MESH"
    assert kept["holds_for"] == compare.holds_for(bpy.context.scene, obj), "how it moves is what is compared"
    bpy.context.scene.dimple.finger_radius_mm = 10.0
    assert kept["holds_for"] != compare.holds_for(bpy.context.scene, obj)


def test_escape_stops_a_comparison_and_nothing_has_changed(
    bpy: ModuleType, fine: Any, hand: Callable, coordinates: Callable
) -> None:
    before = coordinates(fine)
    compare = hand("compare_methods")
    compare.operator.presses = 1
    assert compare.invoke() == {"RUNNING_MODAL"}
    compare.ticks(3)
    assert "Comparing" in compare.context.said and "s left" in compare.context.said
    assert compare.send("ESC") == {"CANCELLED"}
    assert fine.dimple.comparison == "" and coordinates(fine) == before
    assert not bpy.context.window_manager.dimple.show_comparison


def test_paper_laws_are_not_compared_and_the_reason_is_told(bpy: ModuleType, ball: Any) -> None:
    ball().dimple.law_set = "PAPER"
    with pytest.raises(RuntimeError, match="paper's equations"):
        bpy.ops.dimple.compare_methods()


def test_the_budget_is_shared_by_the_bodies_of_a_scene_and_a_new_one_plans_again(
    bpy: ModuleType, fine: Any, heavy: None, ball: Any
) -> None:
    from bl_ext.user_default.dimple.operators import planning

    scene = bpy.context.scene
    assert planning.budget_of(scene, fine) == pytest.approx(0.6)
    start(bpy, fine)
    stop()
    first = fine.dimple.plan_key
    ball().dimple.enabled = True
    assert planning.budget_of(scene, fine) == pytest.approx(0.3)
    start(bpy, fine)
    stop()
    assert fine.dimple.plan_key != first
    scene.dimple.frame_budget_percent = 90.0
    assert planning.budget_of(scene, fine) == pytest.approx(0.45)
