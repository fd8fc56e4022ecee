"""A proxy that is fine where it will be pressed takes seconds to make: progress is shown meanwhile, and Esc heard."""

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.blender.operators.test_paths import bake, keyed

__all__ = ["keyed"]

LONGEST_S = 20.0  # before a proxy is made all the same: who waits for it so long has not gone on beside it


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> Iterator[SimpleNamespace]:
    """What says that a graded proxy is begun, and lets it be made: until then it takes for ever."""
    from bl_ext.user_default.dimple.operators import planning

    found = SimpleNamespace(begun=threading.Event(), go_on=threading.Event())
    build = planning.build_proxy

    def waiting(model: Any, vertices: int, pressed: Any = None, *others: Any) -> Any:
        if pressed:
            found.begun.set()
            assert found.go_on.wait(LONGEST_S), "nobody went on meanwhile"
        return build(model, vertices, pressed, *others)

    planning._choices.clear()  # of another test
    planning._moving.clear()
    monkeypatch.setattr(planning, "build_proxy", waiting)
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
    assert state == {"FINISHED"} and keyed.dimple.plan_graded
    beside = Path(keyed.modifiers["Dimple"].filepath).read_bytes()
    bpy.ops.dimple.unbake()
    assert bake(bpy, keyed)[1] == beside, "the same bits as at once"


def test_an_export_goes_on_while_its_proxy_is_made_and_once_stopped_leaves_nothing(
    bpy: ModuleType, scene: Any, keyed: Any, slow: Any, tmp_path: Path
) -> None:
    from bl_ext.user_default.dimple.operators import exporting

    plan = exporting.ExportPlan(objects=[keyed], formats=["PC2"], folder=tmp_path / "out", first=1, last=4)
    plan.folder.mkdir()
    steps = exporting.export(bpy.context, plan, [], [])
    while not slow.begun.is_set():
        assert 0 <= next(steps) < 1
    assert 0 < next(steps) < 0.05
    steps.close()
    assert not any(plan.folder.iterdir())


def test_play_wound_back_plans_between_events_while_the_timeline_waits_and_esc_ends_it(
    bpy: ModuleType, scene: Any, keyed: Any, hand: Any, slow: Any, sessions: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators import timeline

    monkeypatch.setattr(timeline, "is_playing", lambda _context: True)
    slow.go_on.set()
    scene.frame_set(1)
    play = hand("play")

    def wind_back(way: tuple[float, ...]) -> None:
        slow.begun.clear()
        scene.dimple.finger_1.location = np.array(way)
        scene.dimple.finger_1.keyframe_insert("location", frame=10)
        for frame in (2, 1):
            scene.frame_set(frame)
            play.ticks(1)
        for _ in range(200):  # waits of up to 0.1 s
            if slow.begun.is_set():
                return
            play.ticks(1)
        raise AssertionError("it is not planned anew")

    play.invoke()
    slow.go_on.clear()
    wind_back((0.68, 0.4, 0.6))
    session, time = sessions.get(keyed).session, sessions.get(keyed).frame.time
    assert "Getting ready 60%" in play.context.said and time > 0
    assert play.send("TIMER0", "NOTHING") == play.send("G") == {"RUNNING_MODAL"}, "the timeline waits, and all else"
    slow.go_on.set()
    while play.send("G") == {"RUNNING_MODAL"}:
        play.ticks(1)
    assert sessions.get(keyed).session is session and sessions.get(keyed).frame.time == 0, "wound back"
    assert min(session.proxy.pressed.places)[0] > 0
    slow.go_on.clear()
    wind_back((-0.6, 0.48, 0.64))
    assert play.send("ESC") == {"CANCELLED"} and not sessions.sessions and not keyed.modifiers
    assert scene.frame_current == 1
