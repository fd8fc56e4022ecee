"""A proxy of a fine mesh takes a while to make: progress is shown meanwhile, and Esc heard."""

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
    from bl_ext.user_default.dimple.core.messages import read

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
