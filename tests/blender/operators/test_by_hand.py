"""A kitchen scale: a table that is typed or pasted becomes a material."""

from collections.abc import Callable
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests.blender.operators.test_calibrate import record_of

GRAM = 9.80665e-3  # [N]


def fill(table: Any, rows: list[tuple[float, float]]) -> None:
    for i, (depth, grams) in enumerate(rows):
        table.hand_depths[i], table.hand_grams[i] = depth, grams


def test_a_typed_table_becomes_a_soft_mesh(bpy: ModuleType, add: Callable[..., Any]) -> None:
    body = add()
    table = bpy.context.scene.dimple
    fill(table, [(0, 0), (1, 52), (2, 98), (3, 155), (4, 203), (5, 249)])  # 50 g for each millimetre
    bpy.ops.dimple.calibrate_by_hand(tip="SPHERE", tip_radius_mm=12)
    result = record_of(table)
    assert result["model"] == "one", "six rows on a line show no knee"
    low, high = result["K1_interval"]
    assert low < 50 * GRAM < high and high - low < 0.1 * 50 * GRAM
    assert bpy.ops.dimple.apply_calibration() == {"FINISHED"}
    settings = body.active_material.dimple
    assert body.dimple.enabled and (settings.tip, settings.tip_radius_mm) == ("SPHERE", 12)
    assert settings.K1 == pytest.approx(50 * GRAM, rel=0.03)


def test_turns_of_a_screw_and_a_scale_that_was_not_set_to_zero(bpy: ModuleType, empty_file: ModuleType) -> None:
    table = bpy.context.scene.dimple
    table.hand_step_mm = 0.8  # M5
    fill(table, [(turns, 300 + 40 * turns + (160 * (turns - 4) if turns > 4 else 0)) for turns in range(10)])
    bpy.ops.dimple.calibrate_by_hand()
    result = record_of(table)
    assert result["model"] == "two" and result["tare"] == pytest.approx(300 * GRAM)
    assert result["K1"] == pytest.approx(40 * GRAM / 0.8, rel=0.01)
    assert result["K2"] == pytest.approx(200 * GRAM / 0.8, rel=0.01)
    assert result["x0"] == pytest.approx(4 * 0.8, rel=0.01)


def test_too_few_rows_say_so(bpy: ModuleType, empty_file: ModuleType) -> None:
    fill(bpy.context.scene.dimple, [(0, 0), (1, 50), (2, 100)])
    with pytest.raises(RuntimeError, match="a fit needs at least"):
        bpy.ops.dimple.calibrate_by_hand()


@pytest.mark.parametrize(
    "text", ["Depth\tGrams\n0\t0\n1\t50\n2,5\t130\n", "0;0\n1;50\n2,5;130\n", "0 0\n1 50\n2.5 130"]
)
def test_rows_are_pasted_as_a_sheet_or_a_note_has_them(bpy: ModuleType, empty_file: ModuleType, text: str) -> None:
    from bl_ext.user_default.dimple.operators.calibrate.by_hand import DIMPLE_OT_paste_table

    table = bpy.context.scene.dimple
    context = SimpleNamespace(scene=bpy.context.scene, window_manager=SimpleNamespace(clipboard=text))
    DIMPLE_OT_paste_table.run(SimpleNamespace(), context)
    assert [*table.hand_depths[:5]] == [0, 1, 2.5, 3.5, 4.5] and [*table.hand_grams[:4]] == [0, 50, 130, 0]
