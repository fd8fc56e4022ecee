"""The full mesh or a proxy is simulated: planned, kept with the object, compared, and chosen by hand."""

import json
from collections.abc import Callable
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest


@pytest.fixture
def fine(ball: Callable[..., Any]) -> Any:
    """A ball of 10,242 vertices and radius 1 with a physical size of 165 mm: too heavy to run live."""
    obj = ball("Fine", 6)
    obj.dimple.tolerance_mm, obj.dimple.tolerance_percent = 2.0, 20.0  # a small proxy is a quick test
    return obj


@pytest.fixture
def heavy(monkeypatch: pytest.MonkeyPatch, bpy: ModuleType) -> None:
    """Nothing above 2000 vertices runs live."""
    from bl_ext.user_default.dimple.core.reduction import processor_time

    monkeypatch.setattr(processor_time, "cost_of", lambda model: len(model.mass) / 2000)


def start(bpy: ModuleType, obj: Any) -> Any:
    from bl_ext.user_default.dimple.operators import sessions

    return sessions.start(obj, bpy.context)


def stop() -> None:
    from bl_ext.user_default.dimple.operators import sessions

    sessions.stop_all()


def test_a_mesh_that_runs_live_is_simulated_in_full_with_a_reason(bpy: ModuleType, ball: Any, heavy: None) -> None:
    obj = ball()
    body, said = start(bpy, obj)
    assert body.session.proxy is None
    assert [": The edges of the mesh are 48 mm long, the fingertip 20 mm wide" in each for each in said] == [True]
    assert "42 vertices" in obj.dimple.plan_reason and obj.dimple.plan_vertices == 0
    stop()


def test_a_heavy_mesh_gets_a_proxy_with_a_reason_and_keeps_it(bpy: ModuleType, fine: Any, heavy: None) -> None:
    body, said = start(bpy, fine)
    assert body.session.proxy is not None and body.session.model is not body.session.proxy.model
    assert "proxy of" in said[0] and "proxy of" in fine.dimple.plan_reason
    assert len(body.session.positions()) == len(body.link.rest)
    seeds = body.session.proxy.seeds
    stop()
    again, said = start(bpy, fine)
    assert np.array_equal(again.session.proxy.seeds, seeds) and said == []
    stop()
    fine.dimple.tolerance_percent = 50.0
    looser, said = start(bpy, fine)
    assert len(looser.session.proxy.seeds) < len(seeds) and "proxy of" in said[0]
    stop()


def test_the_full_mesh_or_a_proxy_of_a_size_can_be_chosen_by_hand(bpy: ModuleType, fine: Any, heavy: None) -> None:
    from bl_ext.user_default.dimple.core.base import DimpleError

    fine.dimple.simulated = "MESH"
    assert start(bpy, fine)[0].session.proxy is None
    assert "As chosen" in fine.dimple.plan_reason
    stop()
    fine.dimple.simulated, fine.dimple.proxy_vertices = "PROXY", 400
    assert len(start(bpy, fine)[0].session.proxy.seeds) == 400
    stop()
    fine.dimple.proxy_vertices = 8000
    with pytest.raises(DimpleError, match="Automatic"):
        start(bpy, fine)


def test_a_press_and_a_bake_simulate_the_same_proxy_and_restore_the_mesh(
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
    assert np.array_equal(dented[lowest], rest[lowest]), "pinned vertices stay"
    bpy.ops.dimple.unbake()
    assert coordinates(fine) == before
    assert start(bpy, fine)[0].session.proxy is not None and fine.dimple.plan_vertices == planned
    stop()
    assert coordinates(fine) == before


def test_a_comparison_charts_this_very_object_and_any_variant_can_be_taken(
    bpy: ModuleType, ball: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators import compare_proxies

    monkeypatch.setattr(compare_proxies, "SIZES", 3)
    obj = ball("Ball", 4)
    bpy.context.scene.dimple.finger_radius_mm = 20.0
    assert bpy.ops.dimple.compare_proxies(presses=1) == {"FINISHED"}
    kept = json.loads(obj.dimple.comparison)
    found = kept["variants"]
    assert [each["asked"] for each in found] == [0, 100, 179, 321]
    assert found[0]["error"] == 0 and all(0.01 < each["error"] < 10 for each in found[1:])
    assert found[3]["error"] < found[1]["error"], "more vertices, smaller error"
    assert bpy.ops.dimple.apply_proxy(vertices=179) == {"FINISHED"}
    assert (obj.dimple.simulated, obj.dimple.proxy_vertices) == ("PROXY", 179)
    assert len(start(bpy, obj)[0].session.proxy.seeds) == 179
    stop()
    bpy.ops.dimple.apply_proxy(vertices=0)
    assert obj.dimple.simulated == "MESH"
    assert kept["depends_on"] == compare_proxies.depends_on(bpy.context.scene, obj), (
        "not on the choice between its variants"
    )
    bpy.context.scene.dimple.finger_radius_mm = 10.0
    assert kept["depends_on"] != compare_proxies.depends_on(bpy.context.scene, obj)


def test_escape_stops_a_comparison_and_nothing_has_changed(
    bpy: ModuleType, fine: Any, hand: Callable, coordinates: Callable
) -> None:
    before = coordinates(fine)
    compare = hand("compare_proxies")
    compare.operator.presses = 1
    assert compare.invoke() == {"RUNNING_MODAL"}
    compare.ticks(3)
    assert "Comparing" in compare.context.said and "s left" in compare.context.said
    assert compare.send("ESC") == {"CANCELLED"}
    assert fine.dimple.comparison == "" and coordinates(fine) == before
    assert not bpy.context.window_manager.dimple.show_comparison


def test_paper_laws_are_not_compared_and_the_message_says_why(bpy: ModuleType, ball: Any) -> None:
    ball().dimple.law_set = "PAPER"
    with pytest.raises(RuntimeError, match="paper's equations"):
        bpy.ops.dimple.compare_proxies()


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


def test_bodies_that_are_alike_are_planned_once(
    bpy: ModuleType, heavy: None, ball: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators import planning

    planned, decide = [], planning.decide

    def counted(*args: Any, **named: Any) -> Any:
        planned.append(args)
        return decide(*args, **named)

    monkeypatch.setattr(planning, "decide", counted)
    alike = [ball(f"Ball {i}", 5) for i in range(6)]
    for obj in alike:
        obj.dimple.enabled, obj.dimple.tolerance_mm, obj.dimple.tolerance_percent = True, 2.0, 20.0
    start(bpy, alike[0])
    for_one = len(planned)
    for obj in alike[1:]:
        start(bpy, obj)
    stop()
    assert len(planned) == for_one == 1
    assert {obj.dimple.plan_key for obj in alike} == {alike[0].dimple.plan_key}


def test_another_plan_with_as_many_vertices_makes_no_other_proxy(
    bpy: ModuleType, fine: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A proxy of a million vertices takes seconds to make, and only the mesh, a number and where it is stiffer decide
    where its vertices are.
    """
    from bl_ext.user_default.dimple.core.reduction import processor_time
    from bl_ext.user_default.dimple.operators import planning

    monkeypatch.setattr(processor_time, "cost_of", lambda model: len(model.mass) / 10_000)
    fine.dimple.tolerance_percent = 19.0  # planned for by no other test
    first = start(bpy, fine)[0].session.proxy
    key = fine.dimple.plan_key
    monkeypatch.setattr(planning, "build_proxy", lambda *args: 1 / 0)
    stop()
    bpy.context.scene.dimple.frame_budget_percent = 80.0
    body, said = start(bpy, fine)
    assert fine.dimple.plan_key != key and "proxy of" in said[0]
    assert body.session.proxy.seeds is first.seeds
    stop()
    model, vertices = body.session.model, fine.dimple.plan_vertices
    assert planning._proxy(first, model, vertices) is first
    k1 = np.where(model.matching.rest[0] > 0, 1.0, 4.0) * model.matching.k1
    with pytest.raises(ZeroDivisionError):  # it would be made anew
        planning._proxy(first, replace(model, matching=replace(model.matching, k1=k1)), vertices)


def test_whatever_shape_matching_pulls_with_is_part_of_what_was_planned(bpy: ModuleType, ball: Any) -> None:
    from bl_ext.user_default.dimple.operators import bridge, planning

    obj = ball()
    obj.data.materials.append(bpy.data.materials.new("New"))
    settings = obj.active_material.dimple

    def key(constant: str, factor: float) -> str:
        setattr(settings, constant, factor * getattr(settings, constant))
        _, model = bridge.read_body(bpy.context, obj)
        return planning.key(bpy.context.scene, obj, model)

    keys = {key(*each) for each in (("K1", 1.0), ("K1", 2.0), ("K2", 2.0), ("x0", 2.0), ("spread_mm", 2.0))}
    assert len(keys) == 5
