"""What takes a while shows how far it is, hears Esc meanwhile, and leaves nothing half done."""

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.point_cache import cache_of

LAST = 10  # frames
LONGEST_S = 20.0  # before a proxy is made all the same: who waits for it so long has not gone on beside it
Bits = Callable[[Any], bytes]


@pytest.fixture
def body(ball: Callable[..., Any]) -> Any:
    """The ball that is there."""
    return ball()


def test_a_bake_shows_progress_and_can_be_cancelled(
    bpy: ModuleType,
    hand: Any,
    body: Any,
    rest: bytes,
    coordinates: Bits,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from bl_ext.user_default.dimple.operators.animate import bake_to_files
    from bl_ext.user_default.dimple.operators.press import progress

    assert bake_to_files.SLICE_S > 0, "a body is read at its own pace, whichever test imports this first"
    monkeypatch.setattr(progress, "SLICE_S", 0.0)
    bpy.context.scene.dimple.cache_dir = str(tmp_path)
    run = hand("bake")
    run.operator.frame_end, run.given = 9, {"frame_start", "frame_end"}
    assert run.invoke() == {"RUNNING_MODAL"}
    while "left" not in run.context.said:
        assert run.ticks(1) == {"RUNNING_MODAL"} and "%" in run.context.said
    assert run.send("G") == {"RUNNING_MODAL"}
    (folder,) = tmp_path.iterdir()
    assert {path.suffix for path in folder.iterdir()} >= {".pc2", ".csv"}, "in a folder of their own so far"
    assert run.send("ESC") == {"CANCELLED"}
    assert not list(tmp_path.iterdir()) and not body.modifiers and coordinates(body) == rest
    run = hand("bake")
    run.operator.frame_end, run.given = 9, {"frame_start", "frame_end"}
    run.invoke()
    assert run.ticks(50) == {"FINISHED"}
    assert len(list(tmp_path.iterdir())) == 2 and body.modifiers
    assert [level for level, _ in run.reports][-2:] == ["WARNING"] * 2, "what is said last is what is seen"


def test_a_bake_that_fails_on_its_way_leaves_nothing(
    bpy: ModuleType, hand: Any, body: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.press import progress

    monkeypatch.setattr(progress, "SLICE_S", 0.0)
    bpy.context.scene.dimple.cache_dir = str(tmp_path)
    run = hand("bake")
    run.invoke()
    while "left" not in run.context.said:
        run.ticks(1)
    body.scale.x = 0
    assert run.ticks(2) == {"CANCELLED"}
    assert any("scale of 0" in text for _, text in run.reports)
    assert not list(tmp_path.iterdir()) and not body.modifiers


def test_a_large_mesh_gets_ready_between_events_with_progress_and_esc_leaves_nothing(
    bpy: ModuleType, hand: Any, ball: Callable[..., Any], coordinates: Bits, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.press import modal_runs, progress, sessions

    monkeypatch.setattr(progress, "SLICE_S", 0.01)  # many slices, however fast this computer is
    large = ball("Large", subdivisions=7)
    assert len(large.data.vertices) > progress.LARGE
    before = coordinates(large)
    run = hand("start")
    run.operator.then = "dimple.play"
    assert progress.takes_long(run.context)
    for ticks in (1, 3):
        assert run.invoke() == {"RUNNING_MODAL"}
        assert run.ticks(ticks) == {"RUNNING_MODAL"} and "Getting ready" in run.context.said
        assert run.send("G") == {"RUNNING_MODAL"}, "nothing changes the scene meanwhile"
        assert run.send("ESC") == {"CANCELLED"}
        assert not sessions.sessions and not modal_runs.runs and not large.modifiers and coordinates(large) == before
    run.operator._finished = lambda context: {"FINISHED"}
    run.invoke()
    slices = 0
    while run.ticks(1) == {"RUNNING_MODAL"}:
        slices += 1
    assert sessions.get(large) and slices > 5
    assert not progress.takes_long(run.context), "what runs already is ready"
    sessions.stop_all()


@pytest.fixture
def keyed(bpy: ModuleType, scene: Any, ball: Callable[..., Any]) -> Any:
    """A ball of 10,242 vertices, 165 mm wide, that a proxy moves; keyframes lead a fingertip into its flank."""
    obj, radius = ball("Fine", 6), 10 / 82.5
    obj.dimple.simulated, obj.dimple.proxy_vertices, scene.dimple.finger_radius_mm = "PROXY", 1000, 10.0
    tip = bpy.data.objects.new("Tip", None)
    scene.collection.objects.link(tip)
    scene.dimple.finger_1 = tip
    for frame, way in ((1, 1 + radius), (6, 1 + radius - 5 / 82.5)):
        tip.location = way * np.array([0.6, 0.48, 0.64])
        tip.keyframe_insert("location", frame=frame)
    return obj


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> Iterator[SimpleNamespace]:
    """What says that a proxy is begun, and lets it be made: until then it takes for ever."""
    from bl_ext.user_default.dimple.core.reduction import proxy

    found = SimpleNamespace(begun=threading.Event(), go_on=threading.Event())
    build = proxy.build_proxy

    def waiting(*given: Any) -> Any:
        found.begun.set()
        assert found.go_on.wait(LONGEST_S), "nobody went on meanwhile"
        return build(*given)

    proxy._made.clear()  # of another test
    monkeypatch.setattr(proxy, "build_proxy", waiting)
    yield found
    found.go_on.set()


def test_a_bake_makes_its_proxy_between_events_with_progress_and_esc_leaves_nothing(
    bpy: ModuleType, scene: Any, keyed: Any, hand: Any, slow: Any, coordinates: Callable[[Any], bytes]
) -> None:
    before = coordinates(keyed)
    scene.frame_set(3)
    run = hand("bake")
    run.operator.frame_end, run.given = 10, {"frame_start", "frame_end"}
    assert run.invoke() == {"RUNNING_MODAL"}
    while not slow.begun.is_set():
        assert run.ticks(1) == {"RUNNING_MODAL"}
    assert run.ticks(1) == {"RUNNING_MODAL"} and run.context.said == "Baking 3% | Esc: cancel"
    assert run.send("G") == {"RUNNING_MODAL"}, "nothing changes the scene meanwhile"
    assert run.send("ESC") == {"CANCELLED"}
    assert scene.frame_current == 3 and not keyed.modifiers and coordinates(keyed) == before
    assert not any(Path(scene.dimple.cache_dir).glob("*"))
    slow.go_on.set()
    run.invoke()
    while (state := run.ticks(1)) == {"RUNNING_MODAL"}:
        assert "%" in run.context.said
    from bl_ext.user_default.dimple.core.message import read

    assert state == {"FINISHED"} and "A proxy of 1,000 vertices" in read(keyed.dimple.plan_reason)
    path = Path(cache_of(keyed).filepath)
    beside = path.read_bytes()
    bpy.ops.dimple.unbake()
    assert bpy.ops.dimple.bake(frame_start=1, frame_end=LAST) == {"FINISHED"}
    assert path.read_bytes() == beside, "the same bits as at once"


def test_an_export_goes_on_while_its_proxy_is_made_and_once_stopped_leaves_nothing(
    bpy: ModuleType, scene: Any, keyed: Any, slow: Any, tmp_path: Path
) -> None:
    from bl_ext.user_default.dimple.operators.export import export_plan

    plan = export_plan.ExportPlan(objects=[keyed], formats=["PC2"], folder=tmp_path / "out", first=1, last=4)
    plan.folder.mkdir()
    steps = export_plan.export(bpy.context, plan, [], [])
    while not slow.begun.is_set():
        assert 0 <= next(steps) < 1
    assert 0 < next(steps) < 0.05
    steps.close()
    assert not any(plan.folder.iterdir())
