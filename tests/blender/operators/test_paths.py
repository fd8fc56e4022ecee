"""Where keyframes lead the fingertips is known, so a proxy may be fine there and coarse elsewhere."""

import csv
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.point_cache import read_point_cache

RADIUS, LAST = 10.0, 10  # [mm], frames


@pytest.fixture
def keyed(bpy: ModuleType, scene: Any, ball: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> Any:
    """A ball of 10,242 vertices, 165 mm wide, whose flank a fingertip presses; what is above 1,200 is not live.

    It stands for a finer one: no proxy may have more than 4,000 vertices, where 8,000 are the most.
    """
    from bl_ext.user_default.dimple.core.reduction import decision, processor_time, proxy

    for module in (decision, proxy):
        monkeypatch.setattr(module, "LARGEST", 4000)
    monkeypatch.setattr(processor_time, "cost_of", lambda model: len(model.mass) / 2000)
    obj = ball("Fine", 6)
    obj.dimple.tolerance_percent, scene.dimple.finger_radius_mm = 12.0, RADIUS
    tip = bpy.data.objects.new("Tip", None)
    scene.collection.objects.link(tip)
    scene.dimple.finger_1 = tip
    for frame, way in ((1, 1 + RADIUS / 82.5), (6, 1 + RADIUS / 82.5 - 5 / 82.5)):
        tip.location = way * np.array([0.6, 0.48, 0.64])
        tip.keyframe_insert("location", frame=frame)
    return obj


def bake(bpy: ModuleType, obj: Any) -> tuple[float, bytes]:
    """Return the force on the last frame [N] and the bytes of the cache."""
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=LAST) == {"FINISHED"}
    path = Path(obj.modifiers["Dimple"].filepath)
    with path.with_suffix(".csv").open(newline="") as file:
        *_, last = csv.DictReader(file)
    data = path.read_bytes()
    bpy.ops.dimple.unbake()
    return max(float(value) for name, value in last.items() if name.startswith("force")), data


def test_a_bake_is_fine_where_keyframes_lead_the_fingertip_and_has_the_force_of_the_full_mesh(
    bpy: ModuleType, keyed: Any
) -> None:
    from bl_ext.user_default.dimple.operators import planning

    force, data = bake(bpy, keyed)
    assert keyed.dimple.plan_graded and keyed.dimple.plan_vertices < 600
    assert keyed.dimple.plan_reason.endswith("It is fine where it will be pressed.")
    assert "runs live, within" in keyed.dimple.plan_reason
    assert bake(bpy, keyed) == (force, data), "the same bits again"
    planning._choices.clear()
    planning._moving.clear()
    assert bake(bpy, keyed) == (force, data), "made again as it is kept with the object, too"
    keyed.dimple.plan_key = ""
    assert bake(bpy, keyed) == (force, data), "planned again, too"
    keyed.dimple.simulated = "MESH"
    full, _ = bake(bpy, keyed)
    assert full > 0.5 and force == pytest.approx(full, rel=0.12)


def test_play_along_the_timeline_shows_the_bake_and_a_poke_is_planned_for_any_place(
    bpy: ModuleType, scene: Any, keyed: Any, simulated: Callable[[Any], np.ndarray]
) -> None:
    from bl_ext.user_default.dimple.operators import sessions

    scene.frame_set(1)
    bpy.ops.dimple.play(frames=LAST - 1)
    shown, graded = simulated(keyed), sessions.get(keyed).session.proxy
    assert graded.pressed and len(graded.seeds) < 600
    bpy.ops.dimple.poke(depth_mm=1.0, press_s=0.01, hold_s=0.0, release_s=0.0)
    assert not keyed.dimple.plan_graded and keyed.dimple.plan_vertices > 2000
    bpy.ops.dimple.bake(frame_start=1, frame_end=LAST)
    baked = read_point_cache(keyed.modifiers["Dimple"].filepath)[2][-1]
    assert np.abs(baked - read_point_cache(keyed.modifiers["Dimple"].filepath)[2][0]).max() > 0.02
    assert np.array_equal(np.asarray(shown, "<f4"), baked)


def test_play_wound_back_is_fine_where_the_keyframes_lead_now(
    bpy: ModuleType, scene: Any, keyed: Any, hand: Any, monkeypatch: pytest.MonkeyPatch, sessions: Any
) -> None:
    from bl_ext.user_default.dimple.operators import timeline

    monkeypatch.setattr(timeline, "is_playing", lambda _context: True)
    scene.frame_set(1)
    play, pressed = hand("play"), []
    play.invoke()
    for way in ((0.6, 0.48, 0.64), (-0.6, 0.48, 0.64)):
        scene.dimple.finger_1.location = np.array(way)
        scene.dimple.finger_1.keyframe_insert("location", frame=10)
        for frame in (2, 1):
            scene.frame_set(frame)
            play.ticks(1)
            while play.operator._again:  # planned in parts, as long as this computer takes
                play.ticks(1)
        pressed.append(np.array(sessions.get(keyed).session.proxy.pressed.places))
    assert pressed[0][:, 0].min() > 0 > pressed[1][:, 0].min()
    play.send("ESC")


def test_paths_that_change_are_planned_again_and_unknown_ones_are_not_planned_for(
    bpy: ModuleType, scene: Any, keyed: Any
) -> None:
    from bl_ext.user_default.dimple.operators import bridge, paths

    link, model = bridge.read_body(bpy.context, keyed)

    def places() -> Any:
        return paths.pressed_along(scene, keyed, model, link)

    tip, before = scene.dimple.finger_1, places()
    at = np.array(before.places) / link.scale
    assert np.abs(at @ [0.6, 0.48, 0.64] - 1).max() < 0.05, "near where it presses"
    tip.location = (0.0, 0.0, 1.05)
    tip.keyframe_insert("location", frame=20)
    assert set(before.places) < set(places().places)
    holder = bpy.data.objects.new("Holder", None)
    tip.parent = holder
    assert places().places, "a parent that stands"
    holder.keyframe_insert("location", frame=1)
    assert places() is None, "a parent that goes"
    tip.parent = None
    tip.constraints.new("COPY_LOCATION")
    assert places() is None
    tip.constraints.clear()
    assert places() is not None
    keyed.keyframe_insert("location", frame=1)
    assert places() is None, "the body goes"
    keyed.animation_data_clear()
    tip.animation_data_clear()
    assert places() is None, "a hand moves it"


def test_a_bake_is_fine_where_keyframes_lead_a_collider_and_even_where_what_falls_may_meet_it(
    bpy: ModuleType, scene: Any, keyed: Any, add: Callable[..., Any]
) -> None:
    from bl_ext.user_default.dimple.operators import bridge, paths

    scene.dimple.finger_1 = None
    other = add(name="Other")
    other.scale, other.dimple.collider = (0.1, 0.1, 0.1), True
    for frame, height in ((1, 1.15), (6, 1.05)):
        other.location = (0, 0, height)
        other.keyframe_insert("location", frame=frame)
    link, model = bridge.read_body(bpy.context, keyed)

    def places() -> Any:
        bpy.context.view_layer.update()
        return paths.pressed_along(scene, keyed, model, link)

    assert np.array(places().places)[:, 2].min() > 0.5 * link.scale, "near its top"
    other.select_set(False)
    keyed.select_set(True)
    bpy.context.view_layer.objects.active = keyed
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=LAST) == {"FINISHED"}
    said = " It is fine where it will be pressed. In contact there "
    assert keyed.dimple.plan_graded and said in keyed.dimple.plan_reason
    other.dimple.is_prop = True
    assert places() is None, "it falls"
    other.dimple.is_prop = False
    other.keyframe_insert("rotation_euler", frame=1)
    assert places() is None, "it turns"
    other.animation_data_clear()
    other.modifiers.new("Wave", "WAVE")
    assert places() is None, "it is deformed"
    other.modifiers.clear()
    assert places() is not None, "it stands"
    scene.dimple.finger_1 = bpy.data.objects.new("Hand", None)
    assert places() is None, "a hand moves the fingertip"


def test_a_muted_curve_does_not_lead_the_fingertip(bpy: ModuleType, scene: Any, keyed: Any) -> None:
    from bl_ext.user_default.dimple.operators import bridge, paths, shape_keys

    link, model = bridge.read_body(bpy.context, keyed)
    tip = scene.dimple.finger_1
    (curves,) = (bag.fcurves for bag in shape_keys.curve_bags(tip))
    before = paths.pressed_along(scene, keyed, model, link)
    curves[2].mute = True
    tip.location.z = -0.64 * (1 + RADIUS / 82.5)
    pressed = paths.pressed_along(scene, keyed, model, link)
    heights = [np.array(found.places)[:, 2] for found in (before, pressed)]
    assert heights[0].min() > 0 > heights[1].max(), "it stays at the height that it has"
    scene.frame_set(6)
    assert tip.location.z < 0, "as in Blender"
    for curve in curves:
        curve.mute = True
    assert paths.pressed_along(scene, keyed, model, link) is None, "a hand moves it"


def test_what_a_bone_carries_is_not_planned_for_however_far_up(bpy: ModuleType, scene: Any, keyed: Any) -> None:
    """A bone may be led by its own constraints, of which its armature has none."""
    from bl_ext.user_default.dimple.operators import bridge, paths

    link, model = bridge.read_body(bpy.context, keyed)
    tip, rig = scene.dimple.finger_1, bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones.new("Bone").tail = (0.0, 0.0, 1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    holder = bpy.data.objects.new("Holder", None)
    scene.collection.objects.link(holder)
    holder.parent = rig
    for led in (tip, keyed):
        led.parent = holder
        assert paths.pressed_along(scene, keyed, model, link) is not None, "an armature that stands"
        holder.parent_type, holder.parent_bone = "BONE", "Bone"
        assert paths.pressed_along(scene, keyed, model, link) is None
        led.parent, holder.parent_type = None, "OBJECT"


def test_a_play_by_keyframes_and_a_poke_each_keep_what_is_dear_to_find_of_their_proxy(
    bpy: ModuleType, scene: Any, keyed: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.core.reduction import cell_record, proxy
    from bl_ext.user_default.dimple.operators import planning, sessions

    searched, spread = [], proxy.spread_seeds
    monkeypatch.setattr(cell_record, "SMALLEST", 100)
    monkeypatch.setattr(proxy, "spread_seeds", lambda *given: searched.append(given[3]) or spread(*given))
    scene.frame_set(1)

    def in_turn() -> list[int]:
        """Play and poke as if nothing had run before; return how many vertices each moved."""
        moved = []
        for run in (
            lambda: bpy.ops.dimple.play(frames=1),
            lambda: bpy.ops.dimple.poke(depth_mm=1.0, press_s=0.01, hold_s=0.0, release_s=0.0),
        ):
            planning._choices.clear()
            planning._moving.clear()
            run()
            moved.append(keyed.dimple.plan_vertices)
            sessions.stop_all()
        return moved

    moved = in_turn()
    assert len(searched) >= 2 and moved[0] < 600 < 2000 < moved[1]
    searched.clear()
    assert in_turn() == moved and searched == []


def test_a_body_that_runs_gets_ready_for_its_paths_between_events_and_esc_leaves_it_as_it_was(
    bpy: ModuleType, scene: Any, keyed: Any, hand: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators import sessions, start, working

    monkeypatch.setattr(start, "LARGE", len(keyed.data.vertices) - 1)
    monkeypatch.setattr(working, "SLICE_S", 0.001)
    scene.frame_set(1)
    body = sessions.start(keyed, bpy.context)[0]
    even, run = body.session.proxy, hand("start")
    run.operator.then = "play"
    run.operator._finished = lambda context: {"FINISHED"}
    assert start.takes_long(run.context, along=True) and not start.takes_long(run.context)
    assert run.invoke() == {"RUNNING_MODAL"}
    assert run.ticks(1) == {"RUNNING_MODAL"} and run.send("ESC") == {"CANCELLED"}
    assert body.session.proxy is even and body.pressed is None and sessions.get(keyed) is body
    run.invoke()
    while run.ticks(1) == {"RUNNING_MODAL"}:
        pass
    assert body.session.proxy.pressed and len(body.session.proxy.seeds) < 600
    assert not start.takes_long(run.context, along=True) and start.takes_long(run.context), "a poke goes anywhere"
    sessions.stop_all()


@pytest.fixture
def slow(scene: Any, keyed: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The same ball, pressed at 2.5 mm/s; in full it would run at a quarter of real time."""
    from bl_ext.user_default.dimple.core.reduction import processor_time
    from bl_ext.user_default.dimple.operators import shape_keys

    monkeypatch.setattr(processor_time, "cost_of", lambda model: len(model.mass) / 4000)
    (curves,) = (bag.fcurves for bag in shape_keys.curve_bags(scene.dimple.finger_1))
    for point in (curve.keyframe_points[1] for curve in curves):
        point.co.x = 49
    for point in (each for curve in curves for each in curve.keyframe_points):
        point.interpolation = "LINEAR"
    return keyed


def test_a_slow_press_bakes_the_full_mesh_in_fewer_steps_as_it_plays_and_with_its_force(
    bpy: ModuleType, scene: Any, slow: Any, simulated: Callable[[Any], np.ndarray]
) -> None:
    scene.frame_set(1)
    bpy.ops.dimple.play(frames=LAST - 1)
    shown = simulated(slow)
    force, data = bake(bpy, slow)
    assert slow.dimple.plan_faster > 3 and slow.dimple.plan_vertices == 0
    assert slow.dimple.plan_reason.startswith("The presses are slow, so the full mesh runs live with 1/")
    bpy.ops.dimple.bake(frame_start=1, frame_end=LAST)
    assert np.array_equal(np.asarray(shown, "<f4"), read_point_cache(slow.modifiers["Dimple"].filepath)[2][-1])
    bpy.ops.dimple.unbake()
    slow.dimple.plan_key = ""
    assert bake(bpy, slow) == (force, data), "planned again, the same bits again"
    slow.dimple.simulated = "MESH"
    full, _ = bake(bpy, slow)
    assert slow.dimple.plan_faster == 1, "as chosen: in all its steps"
    assert full > 0.05 and force == pytest.approx(full, rel=0.05)


def test_what_is_not_a_slow_press_alone_takes_all_its_steps(bpy: ModuleType, scene: Any, slow: Any) -> None:
    from bl_ext.user_default.dimple.operators import sessions

    def faster() -> int:
        bpy.ops.dimple.play(frames=1)
        found = sessions.get(slow).session.clock.faster
        bpy.ops.dimple.reset()
        assert found in (1, slow.dimple.plan_faster)
        return found

    material = bpy.data.materials.new("Skin")
    slow.data.materials.append(material)
    assert faster() > 3
    slow.dimple.collider = True
    assert faster() == 1, "others may meet it"
    slow.dimple.collider = False
    assert faster() > 3
    material.dimple.keyframe_insert("K1", frame=1)
    assert faster() == 1, "its constants change"
    material.animation_data_clear()
    assert faster() > 3
    bpy.ops.dimple.poke(depth_mm=1.0, press_s=0.01, hold_s=0.0, release_s=0.0)
    assert slow.dimple.plan_faster == 1, "a hand may press fast"
    assert faster() > 3
    scene.dimple.finger_1.location *= 0.98
    scene.dimple.finger_1.keyframe_insert("location", frame=50)
    assert faster() == 1, "it jumps"
