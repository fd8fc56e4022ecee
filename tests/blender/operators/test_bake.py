"""A bake plays what was simulated, the same at every frame rate, and can be taken off again."""

import csv
import shutil
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.blender.operators.test_starting import counted
from tests.point_cache import cache_of, read_point_cache

Add = Callable[..., Any]
Bits = Callable[[Any], bytes]
Shown = Callable[[Any], np.ndarray]


def table(obj: Any, scene: Any) -> list[dict[str, float]]:
    (path,) = Path(scene.dimple.cache_dir).glob(f"*{obj.name}*.csv")
    with path.open(newline="") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def cached(scene: Any, obj: Any) -> tuple[float, np.ndarray]:
    """Return the first frame of the only cache, and the coordinates (frames, n, 3) of a body that has no modifiers."""
    (path,) = Path(scene.dimple.cache_dir).glob("*.pc2")
    start, _, offsets = read_point_cache(path)
    rest = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", rest)
    return start, rest.reshape(-1, 3) + offsets


def test_the_modifier_plays_what_was_recorded_and_unbake_takes_it_off(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any], shown: Shown, coordinates: Bits
) -> None:
    obj = pressed()
    obj.location, obj.rotation_euler, obj.scale = (1, 2, 3), (0.1, 0.2, 0.3), (2, 2, 1.5)
    tip = scene.dimple.finger_1
    tip.parent = obj
    later = obj.modifiers.new("Later", "WEIGHTED_NORMAL")
    before = coordinates(obj)
    scene.frame_set(3)
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=19) == {"FINISHED"}
    assert scene.frame_current == 3
    assert coordinates(obj) == before
    assert [modifier.name for modifier in obj.modifiers] == [later.name, "Dimple"]
    start, positions = cached(scene, obj)
    assert start == 1 and positions.shape == (19, len(obj.data.vertices), 3)
    for frame in range(1, 20):
        scene.frame_set(frame)
        assert np.abs(shown(obj) - positions[frame - 1]).max() < 1e-5
    assert positions[0].tobytes() == before
    assert np.abs(positions[8] - positions[0]).max() > 0.1
    bpy.ops.dimple.unbake()
    assert [modifier.name for modifier in obj.modifiers] == [later.name] and shown(obj).tobytes() == before


def test_a_bake_without_frames_takes_those_of_the_scene(
    bpy: ModuleType, scene: Any, pressed: Callable[..., Any]
) -> None:
    obj = pressed()
    scene.frame_start, scene.frame_end = 3, 6
    bpy.ops.dimple.bake()
    start, positions = cached(scene, obj)
    assert (start, len(positions)) == (3, 4)


def test_a_second_bake_takes_the_place_of_the_first(bpy: ModuleType, scene: Any, pressed: Callable[..., Any]) -> None:
    obj = pressed()
    bpy.ops.dimple.bake(frame_start=1, frame_end=6)
    _, first = cached(scene, obj)
    bpy.ops.dimple.bake(frame_start=1, frame_end=6)
    assert np.array_equal(cached(scene, obj)[1], first), "the same press gives the same bits"
    assert len(obj.modifiers) == 1
    files = sorted(path.name for path in Path(scene.dimple.cache_dir).iterdir())
    assert files == ["untitled_Ball_bake_001.csv", "untitled_Ball_bake_001.pc2"], "though the file has no name"


def test_a_press_is_the_same_at_every_frame_rate(bpy: ModuleType, scene: Any, pressed: Callable[..., Any]) -> None:
    dents, forces = {}, {}
    for fps in (24, 30, 60, 120):
        obj = pressed(fps)
        bpy.ops.dimple.bake(frame_start=1, frame_end=1 + fps // 2)
        positions = cached(scene, obj)[1]
        # every sixth of a second is a whole frame at each of these rates
        dents[fps] = positions[[fps // 6, fps // 3, fps // 2]]
        forces[fps] = table(obj, scene)[fps // 3]["force_1_n"]
        shutil.rmtree(scene.dimple.cache_dir)
        bpy.data.objects.remove(obj)
        bpy.data.objects.remove(scene.dimple.finger_1)
    for fps in (30, 60, 120):
        assert np.abs(dents[fps] - dents[24]).max() / 2 * 165 < 0.05  # [mm] on a dent of 20 mm
        assert forces[fps] == pytest.approx(forces[24], rel=1e-3)


@pytest.mark.parametrize("fps", [24, 120])
def test_a_free_body_falls_by_physics_not_by_frames(
    bpy: ModuleType, scene: Any, add: Add, coordinates: Bits, fps: int, shown: Any
) -> None:
    obj = add()
    obj.dimple.pinned, obj.dimple.size_mode = False, "REAL"
    scene.dimple.use_gravity, scene.render.fps = True, fps
    bpy.ops.dimple.bake(frame_start=1, frame_end=1 + fps)
    _, positions = cached(scene, obj)
    fallen = positions[-1, :, 2].mean() - positions[0, :, 2].mean()
    assert fallen == pytest.approx(-9.81 / 2, rel=2e-3)
    before = coordinates(obj)
    bpy.ops.dimple.unbake()
    bpy.ops.dimple.play(seconds=1.0)
    live = shown(obj)[:, 2].mean()
    assert live == pytest.approx(-9.81 / 2, rel=2e-3)
    bpy.ops.dimple.reset()
    assert coordinates(obj) == before


def test_an_animated_body_carries_its_pins(bpy: ModuleType, scene: Any, ball: Add, shown: Shown) -> None:
    obj = ball()
    obj.active_material = bpy.data.materials.new("Soft")  # so that it still lags where a frame ends
    soft = obj.active_material.dimple
    soft.K1, soft.K2, soft.damping_ratio = 0.05, 0.5, 1.0
    for frame, x in ((1, 0.0), (13, 2.0)):
        obj.location.x = x
        obj.keyframe_insert("location", index=0, frame=frame)
    bpy.ops.dimple.bake(frame_start=1, frame_end=25)
    lowest = min(obj.data.vertices, key=lambda vertex: vertex.co.z)
    lags = []
    for frame in range(1, 26):
        scene.frame_set(frame)
        seen = shown(obj)
        assert seen[lowest.index] == pytest.approx(tuple(lowest.co), abs=1e-5)
        lags.append(float(seen.mean(axis=0)[0]))
    from bl_ext.user_default.dimple import Body

    model = Body.from_object(obj).session.model
    # acceleration 4 m/s^2 over stiffness per mass, as a share of the radius that stands for 82.5 mm
    most = 4 / (model.matching.k1.sum() / model.mass.sum()) / 0.0825
    assert most / 8 < max(map(abs, lags)) < most, "what is soft gives way by what its inertia asks for, and no more"
    assert abs(lags[-1]) < 1e-5, "and comes to rest where it is carried"


def test_that_nothing_moved_a_body_is_said_and_only_then(
    bpy: ModuleType, scene: Any, ball: Add, capfd: pytest.CaptureFixture[str]
) -> None:
    ball().dimple.pinned = False
    scene.dimple.use_ground = False
    for falls in (False, True):
        scene.dimple.use_gravity = falls
        assert bpy.ops.dimple.bake(frame_start=1, frame_end=3) == {"FINISHED"}
        assert ("Nothing moves the bodies" in capfd.readouterr().out) != falls


def test_frames_in_the_wrong_order_are_said(bpy: ModuleType, scene: Any, pressed: Callable[..., Any]) -> None:
    pressed()
    with pytest.raises(RuntimeError, match="must come after"):
        bpy.ops.dimple.bake(frame_start=5, frame_end=5)


@pytest.mark.parametrize("simulated", ["MESH", pytest.param("PROXY", marks=pytest.mark.once)])
def test_a_bake_with_keyframed_constants_answers_at_once_as_one_that_has_them_all_the_time(
    bpy: ModuleType, scene: Any, ball: Add, simulated: str
) -> None:
    def baked(*keys: tuple[int, float]) -> list[dict[str, float]]:
        for frame, constants.K1 in keys:
            if len(keys) > 1:
                constants.keyframe_insert("K1", frame=frame)
        bpy.ops.dimple.bake(frame_start=1, frame_end=40)
        constants.id_data.animation_data_clear()
        return table(obj, scene)

    obj = ball(subdivisions=4)
    obj.active_material = bpy.data.materials.new("Keyed")
    constants = obj.active_material.dimple
    constants.damping_ratio, obj.dimple.simulated, obj.dimple.proxy_vertices = 1.0, simulated, 300
    bpy.ops.dimple.add_fingertip()
    tip = scene.dimple.finger_1
    for frame, height in ((1, tip.location.z), (8, tip.location.z - 10 / 165 * 2)):
        tip.location.z = height
        tip.keyframe_insert("location", index=2, frame=frame)
    soft, hard = baked((1, 0.6)), baked((1, 3.0))
    keyed = baked((1, 0.6), (20, 0.6), (21, 3.0))
    assert keyed[18]["force_1_n"] == pytest.approx(soft[18]["force_1_n"], rel=1e-3)
    for frame in (20, 21, -1):  # the rows of frames 21, 22 and 40
        assert keyed[frame]["force_1_n"] == pytest.approx(hard[frame]["force_1_n"], rel=1e-3)
    assert hard[-1]["force_1_n"] == pytest.approx(5 * soft[-1]["force_1_n"], rel=1e-3)


@pytest.mark.parametrize("simulated", ["MESH", "PROXY"])
def test_a_keyframed_pressure_swells_a_body_in_a_bake(bpy: ModuleType, scene: Any, ball: Add, simulated: str) -> None:
    obj = ball(subdivisions=4)
    obj.active_material = bpy.data.materials.new("Keyed")
    settings = obj.active_material.dimple
    settings.damping_ratio, obj.dimple.simulated, obj.dimple.proxy_vertices = 1.0, simulated, 300
    for frame, value in ((1, 0.0), (10, 0.0), (11, 20.0), (30, 20.0), (31, 0.0)):
        settings.pressure_kpa = value
        settings.keyframe_insert("pressure_kpa", frame=frame)
    bpy.ops.dimple.bake(frame_start=1, frame_end=50)
    volume = [row["volume_m3"] / row["rest_volume_m3"] for row in table(obj, scene)]
    assert volume[8] == pytest.approx(1, abs=1e-3) and volume[49] == pytest.approx(1, abs=2e-3)
    assert 1.05 < volume[29] < (1 + 20e3 / 101325) ** (1 / 1.4), "no farther than without a skin"
    _, positions = cached(scene, obj)
    wide = np.ptp(positions[:, :, 0], axis=1)
    assert wide[29] / wide[8] > 1.01 and wide[49] == pytest.approx(wide[8], rel=2e-3), "and so it is seen"


def test_keyframed_pins_let_a_body_go(bpy: ModuleType, scene: Any, ball: Add) -> None:
    obj = ball()
    scene.dimple.use_gravity = True
    for frame, pinned in ((1, True), (10, False)):
        obj.dimple.pinned = pinned
        obj.dimple.keyframe_insert("pinned", frame=frame)
    bpy.ops.dimple.bake(frame_start=1, frame_end=20)
    _, positions = cached(scene, obj)
    heights = positions.mean(axis=1)[:, 2]
    assert abs(heights[8] - heights[0]) < 0.05, "it hangs from its base"
    fallen, seconds = (heights[9] - heights[19]) * 0.165 / 2, 10 / scene.render.fps
    assert fallen == pytest.approx(9.81 / 2 * seconds**2, rel=0.15), "and falls"


def test_a_keyframe_that_cannot_be_simulated_stops_the_bake_in_words(bpy: ModuleType, scene: Any, ball: Add) -> None:
    obj = ball()
    obj.active_material = bpy.data.materials.new("Keyed")
    for frame, value in ((1, 0.6), (5, 0.0)):
        obj.active_material.dimple.K1 = value
        obj.active_material.dimple.keyframe_insert("K1", frame=frame)
    with pytest.raises(RuntimeError, match="K1 must be greater than 0"):
        bpy.ops.dimple.bake(frame_start=1, frame_end=8)
    assert not obj.modifiers


def test_a_frame_in_which_a_body_rests_is_that_before_it(
    bpy: ModuleType, scene: Any, ball: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.bridge import object_link

    obj, calls = ball(), Counter[str]()
    counted(monkeypatch, calls, object_link, "offsets_of")
    bpy.ops.dimple.bake(frame_start=1, frame_end=80)
    assert calls.total() < 20, "it falls asleep within 20 frames"
    lines = Path(cache_of(obj).filepath).with_suffix(".csv").read_text().splitlines()
    resting = {line.split(",", 2)[2].rsplit(",", 1)[0] for line in lines[40:]}
    assert len(lines) == 81 and len(resting) == 1, "but for frame, time and steps"
