"""The sensory comparison in Blender: blind trials from a file, answers kept, stopped and gone on with."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

TASKS = [
    {"kind": "rating", "condition": "seen", "object": "object_2_vinyl_air", "repeats": 1},
    {"kind": "comparison", "condition": "seen", "object": "Own", "levels": [0.5, 2.0], "repeats": 1},
]


@pytest.fixture
def plan(bpy: ModuleType, add: Callable[..., Any], tmp_path: Path) -> Path:
    body = add()
    own = bpy.data.materials.new("Own")
    body.data.materials.append(own)
    own.dimple.K1 = 0.4
    path = tmp_path / "plan.json"
    path.write_text(json.dumps({"name": "soft", "seed": 1, "tasks": TASKS}))
    return path


def rows(plan: Path) -> list[dict[str, str]]:
    with plan.with_name("plan_7_answers.csv").open() as file:
        return list(csv.DictReader(file))


def test_an_experiment_is_shown_answered_stopped_and_gone_on_with(bpy: ModuleType, plan: Path) -> None:
    from bl_ext.user_default.dimple.operators.experiment import blind_trial

    ops, body = bpy.ops.dimple, bpy.context.object
    assert ops.open_experiment(filepath=str(plan), participant="7") == {"FINISHED"}
    assert not ops.show_trial.poll(), "not before the consent"
    assert ops.agree_experiment() == {"FINISHED"} and not ops.answer_trial.poll()
    for number in range(1, 4):
        trial = blind_trial.trial()
        assert trial.number == number
        for interval in range(1, len(trial.shown) + 1):
            assert ops.show_trial(interval=interval) == {"FINISHED"}
            law = 0.61 if trial.task.kind == "rating" else 0.4 * trial.shown[interval - 1]
            assert body.active_material.dimple.K1 == pytest.approx(law, rel=1e-5)
            assert trial.task.object not in body.active_material.name
        assert ops.answer_trial(choice=2) == {"FINISHED"}
        if number == 2:
            assert ops.stop_experiment() == {"FINISHED"}
            assert body.active_material.name == "Own" and body.active_material.dimple.K1 == pytest.approx(0.4)
            assert ops.open_experiment(filepath=str(plan), participant="7") == {"FINISHED"}
            ops.agree_experiment()
    assert blind_trial.trial() is None and not ops.show_trial.poll()
    answers = rows(plan)
    assert [row["trial"] for row in answers] == ["1", "2", "3"] and {row["condition"] for row in answers} == {"seen"}
    assert all(float(row["force_max_n"]) > 1 and float(row["depth_max_mm"]) > 0.1 for row in answers)
    assert len(plan.with_name("plan_7_answers_touch.csv").read_text().splitlines()) > 60
    ops.stop_experiment()


def test_a_softer_body_is_seen_to_sink_in_deeper_and_no_material_is_left(bpy: ModuleType, plan: Path) -> None:
    from bl_ext.user_default.dimple.operators.experiment import blind_trial

    bpy.ops.dimple.open_experiment(filepath=str(plan), participant="7")
    bpy.ops.dimple.agree_experiment()
    depths = {}
    while trial := blind_trial.trial():
        for interval, level in enumerate(trial.shown, start=1):
            blind_trial.get().samples.clear()
            bpy.ops.dimple.show_trial(interval=interval)
            depths[trial.task.kind, level] = max(depth for _, depth, _ in blind_trial.get().samples)
        bpy.ops.dimple.answer_trial(choice=1)
    assert depths["comparison", 0.5] > 1.3 * depths["comparison", 1.0] > 1.6 * depths["comparison", 2.0]
    bpy.ops.dimple.stop_experiment()
    assert [material.name for material in bpy.data.materials] == ["Own"]


@pytest.mark.parametrize(
    "text", ["{", "[]", '{"tasks": [{"kind": "taste"}]}', '{"tasks": [{"kind": "rating", "object": "No"}]}']
)
def test_a_file_that_is_no_experiment_is_refused_in_words(bpy: ModuleType, plan: Path, text: str) -> None:
    plan.write_text(text)
    with pytest.raises(RuntimeError, match="experiment|Task 1|preset"):
        bpy.ops.dimple.open_experiment(filepath=str(plan))


def test_a_participant_sees_no_number_and_no_chart(
    bpy: ModuleType, plan: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Force against depth is drawn over what plays, and would tell which is the stiffer."""
    from bl_ext.user_default.dimple.addon import overlay
    from bl_ext.user_default.dimple.operators.experiment import blind_trial

    ops, looked = bpy.ops.dimple, []
    monkeypatch.setattr(overlay, "shown_bodies", lambda context: looked.append(context) or [])
    monkeypatch.setattr(overlay.force_chart, "calibrated_curves", lambda _: None)
    assert ops.open_experiment(filepath=str(plan), participant="8") == {"FINISHED"}
    overlay.draw_numbers()
    assert looked and bpy.types.DIMPLE_PT_readout.poll(bpy.context), "the experimenter may look"
    looked.clear()
    assert ops.agree_experiment() == {"FINISHED"} and blind_trial.is_blind()
    overlay.draw_numbers()
    assert not looked and not bpy.types.DIMPLE_PT_readout.poll(bpy.context)
    assert ops.stop_experiment() == {"FINISHED"}
    overlay.draw_numbers()
    assert looked and bpy.types.DIMPLE_PT_readout.poll(bpy.context)
