"""Copy Report puts what a bug report should say into the clipboard, and the log keeps the last error."""

from types import ModuleType
from typing import Any

import pytest


def test_a_report_has_versions_plan_messages_and_the_last_traceback(
    bpy: ModuleType, cube: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from types import SimpleNamespace

    from bl_ext.user_default.dimple.core.message import read
    from bl_ext.user_default.dimple.operators import bug_report
    from bl_ext.user_default.dimple.operators.press import live_step

    bpy.ops.dimple.poke(depth_mm=5.0)
    monkeypatch.setattr(live_step, "advance", lambda *_, **__: 1 / 0)
    with pytest.raises(RuntimeError, match="division by zero"):
        bpy.ops.dimple.poke(depth_mm=5.0)
    manager = SimpleNamespace(clipboard="")  # without a window there is none
    said: list[str] = []
    operator = SimpleNamespace(report=lambda _kind, sentence: said.append(sentence))
    bug_report.DIMPLE_OT_copy_report.run(operator, SimpleNamespace(window_manager=manager, scene=bpy.context.scene))
    lines = manager.clipboard.splitlines()
    assert bpy.app.version_string in lines[0] and lines[1].startswith("Core: ABI ")
    assert f"Cube: {read(cube.dimple.plan_reason)}" in lines
    assert any("Pressed 5.0 mm deep" in line for line in lines)
    assert any("ZeroDivisionError" in line for line in lines) and any("Traceback" in line for line in lines)
    assert said == ["The report is on the clipboard"]
