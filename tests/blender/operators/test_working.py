"""What takes a while shows how far it is, can be cancelled, and leaves nothing half done."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

Bits = Callable[[Any], bytes]


@pytest.fixture(autouse=True)
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
    from bl_ext.user_default.dimple.operators.press import progress

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
    run.operator.then = "play"
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
