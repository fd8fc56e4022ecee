"""While a body is live Blender's autosave waits, so a recovery copy is written in its stead, at rest."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from tests.blender.operators.test_sessions import is_clean

Bits = Callable[[Any], bytes]


@pytest.fixture
def copy(bpy: ModuleType) -> Iterator[Path]:
    """Where Blender would write its autosave; nothing is there before and after."""
    from bl_ext.user_default.dimple.operators.press import modal_runs

    modal_runs.recovery_path().unlink(missing_ok=True)
    yield modal_runs.recovery_path()
    modal_runs.recovery_path().unlink(missing_ok=True)


def minutes_later(run: Any, minutes: float) -> None:
    run.operator._run.saved_at = time.monotonic() - 60 * minutes


@pytest.mark.parametrize("name", ["poke", "play"])
def test_a_recovery_copy_is_written_at_the_interval_of_the_preferences_and_is_at_rest(
    bpy: ModuleType, hand: Any, ball: Any, coordinates: Bits, rest: bytes, copy: Path, name: str, shown: Any
) -> None:
    obj = ball()
    bpy.context.scene.dimple.use_gravity = True
    run, settings = hand(name), bpy.context.preferences.filepaths
    run.invoke()
    run.ticks(5)
    minutes_later(run, settings.auto_save_time - 0.5)
    run.ticks(1)
    assert not copy.exists()
    minutes_later(run, settings.auto_save_time)
    run.ticks(1)
    first = copy.stat().st_mtime_ns
    assert shown(obj).tobytes() != rest and bpy.data.filepath == "", "the session goes on, and the file is another"
    run.ticks(3)
    assert copy.stat().st_mtime_ns == first
    assert [path.name for path in copy.parent.glob(f"*{copy.stem}*")] == [copy.name], "nothing else is left"
    assert run.send("ESC") == {"CANCELLED"}
    bpy.ops.wm.open_mainfile(filepath=str(copy))
    assert is_clean(bpy.data.objects["Ball"]) and coordinates(bpy.data.objects["Ball"]) == rest


def test_no_copy_is_written_where_autosave_is_switched_off(bpy: ModuleType, hand: Any, ball: Any, copy: Path) -> None:
    ball()
    run, settings = hand("play"), bpy.context.preferences.filepaths
    run.invoke()
    settings.use_auto_save_temporary_files = False
    try:
        minutes_later(run, 1000)
        run.ticks(2)
    finally:
        settings.use_auto_save_temporary_files = True
    assert not copy.exists()
    run.send("ESC")


def test_a_copy_that_cannot_be_written_is_said_and_the_session_goes_on(
    bpy: ModuleType, hand: Any, ball: Any, monkeypatch: Any, tmp_path: Path
) -> None:
    from bl_ext.user_default.dimple.operators.press import modal_runs, sessions

    ball()
    run = hand("play")
    run.invoke()
    monkeypatch.setattr(modal_runs, "recovery_path", lambda: tmp_path / "nowhere" / "autosave.blend")
    minutes_later(run, 1000)
    assert run.ticks(1) == {"PASS_THROUGH"}
    assert any(text.startswith("The recovery copy could not be written") for _, text in run.reports)
    assert sessions.sessions
    run.send("ESC")
