"""The sensory comparison in Blender, felt with an emulated device: blind, refused where it cannot be felt, resumed."""

import csv
import json
import re
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from tests.blender.operators.device_rig import connect, softened, wait
from tests.haptics.machine import NEEDS_PTY

STANDARD, SOFTER = {"object": "S"}, {"object": "A", "level": 0.5}
PLAN: dict[str, Any] = {
    "consent": "Agree?", "instruction": "Press.", "question": "Which was stiffer?", "answers": ["First", "Second"],
    "exposure_s": 0.3, "trial_s": 10, "press_n": 2.5, "objects": {"A": "Soft", "S": "Soft"}, "made": {"kind": "pair"},
    "participants": {
        "P01": [{"show": [STANDARD, SOFTER]}, {"show": [{"real": "A"}, STANDARD], "rest_s": 0.2}],
        "P02": [{"show": [STANDARD, SOFTER]}],
    },
}  # fmt: skip
UNSEEN = {"plan_key", "plan_vertices", "plan_reason"}  # how a body is simulated: drawn in a panel that is hidden
NO_NUMBERS = {"DIMPLE_PT_experiment", "DIMPLE_PT_material_presets", "DIMPLE_PT_still_warning"}

pytestmark = NEEDS_PTY


@pytest.fixture
def plan(bpy: ModuleType, cube: Any, tmp_path: Path) -> Path:
    softened(bpy, cube)
    cube.dimple.enabled = True
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(PLAN))
    return path


def change(plan: Path, **entries: Any) -> Path:
    plan.write_text(json.dumps({**PLAN, **entries}))
    return plan


def experiment() -> Any:
    from bl_ext.user_default.dimple.operators.experiment import blind_trial

    return blind_trial.experiments[0]


def present(bpy: ModuleType) -> None:
    """Present the next interval, until it was felt for long enough."""
    from bl_ext.user_default.dimple.operators.press import haptic_fingertips, sessions

    at = experiment().due
    assert bpy.ops.dimple.continue_experiment() == {"FINISHED"}
    haptic_fingertips.read()
    assert experiment().due == at, "what was felt before counts for nothing"
    felt = bool(sessions.sessions)
    wait(lambda _: experiment().due > at, bpy if felt else None, arms=felt)


class Layout:
    """A layout that keeps all texts and properties that are drawn in it."""

    def __init__(self) -> None:
        self.said: list[str] = []

    def __getattr__(self, name: str) -> Callable[..., Any]:
        def draw(*given: Any, **named: Any) -> Any:
            self.said.extend(str(each) for each in [*given, *named.values()] if isinstance(each, str))
            return SimpleNamespace() if name == "operator" else self

        return draw

    def __setattr__(self, name: str, value: Any) -> None:
        if name == "said":
            object.__setattr__(self, name, value)


def on_screen(bpy: ModuleType) -> list[str]:
    """Return all that the panels of Dimple draw, what they may show, and every name and setting in the file."""
    context = SimpleNamespace(
        region=SimpleNamespace(width=400), preferences=SimpleNamespace(system=SimpleNamespace(ui_scale=1.0)),
        scene=bpy.context.scene, object=bpy.context.object, material=bpy.context.object.active_material, area=None,
        window_manager=bpy.context.window_manager,
    )  # fmt: skip
    found = []
    for name in sorted(name for name in dir(bpy.types) if name.startswith("DIMPLE_PT_")):
        if name not in NO_NUMBERS and getattr(bpy.types, name).poll(context):
            found.append(name)
    layout = Layout()
    bpy.types.DIMPLE_PT_experiment.draw(SimpleNamespace(layout=layout), context)
    found += layout.said
    for data in (bpy.data.objects, bpy.data.materials, bpy.data.meshes, bpy.data.scenes, bpy.data.texts):
        for each in data:
            settings = getattr(each, "dimple", None)
            names = [key for key in settings.bl_rna.properties.keys() if key not in UNSEEN] if settings else []
            values = [(key, getattr(settings, key)) for key in names]
            found += [each.name, *(f"{key} {getattr(value, 'name', value)}" for key, value in values)]
    return [re.sub(" at 0x.*|<Vector.*", "", each) for each in found]


def test_a_trial_is_felt_answered_and_resumed_and_each_row_says_what_was_presented(
    bpy: ModuleType, plan: Path, port: Any
) -> None:
    from bl_ext.user_default.dimple.operators.press import sessions

    ops, body = bpy.ops.dimple, bpy.context.object
    connect(bpy, port.path)
    bpy.context.scene.dimple.device_origin = (0.0, 0.0, 1.0 + 0.010 * 2 / 0.165)
    assert ops.open_experiment(filepath=str(plan), participant="P01") == {"FINISHED"}
    with pytest.raises(RuntimeError, match="no answer"):
        ops.answer_trial(choice=1)
    assert ops.continue_experiment() == {"FINISHED"}, "the consent"
    with pytest.raises(RuntimeError, match="for long enough"):
        ops.answer_trial(choice=1)
    stiffness = []
    for _ in range(2):
        present(bpy)
        stiffness.append(sessions.get(body).session.model.materials[0].K1)
        assert body.active_material.dimple.K1 == pytest.approx(0.2), "the object's own material stays as it is"
    assert stiffness == pytest.approx([200, 100], rel=1e-4)
    assert not ops.continue_experiment.poll(), "both were presented"
    assert ops.answer_trial(choice=1) == {"FINISHED"} and not sessions.sessions
    assert ops.stop_experiment() == {"FINISHED"}
    assert ops.open_experiment(filepath=str(plan), participant="P01") == {"FINISHED"}
    ops.continue_experiment()
    with pytest.raises(RuntimeError, match="Rest a little longer"):
        ops.continue_experiment()
    wait(lambda _: not experiment().rests)
    present(bpy)
    assert not sessions.sessions, "nothing virtual is there while the real object is touched"
    present(bpy)
    ops.answer_trial(choice=2)
    assert experiment().trial is None
    ops.stop_experiment()
    with plan.with_name("plan_P01.csv").open() as file:
        rows = list(csv.DictReader(file))
    shown = [[row[name] for name in ("event", "trial", "first", "first_level", "second", "second_level", "answer_text")]
             for row in rows]  # fmt: skip
    assert shown == [
        ["consent", *[""] * 6], ["answer", "1", "S", "1", "A", "0.5", "First"], ["consent", *[""] * 6],
        ["answer", "2", "A", "real", "S", "1", "Second"],
    ]  # fmt: skip
    stated = json.loads(rows[0]["details"])
    assert stated["constants"]["A"]["K1"] == pytest.approx(200, rel=1e-4) and stated["cap_n_m"] > 0
    with (plan.parent / rows[1]["trace"]).open() as file:
        trace = list(csv.DictReader(file))
    for interval in ("1", "2"):
        samples = [row for row in trace if row["interval"] == interval]
        times = [float(row["time_s"]) for row in samples]
        assert times == sorted(times) and len(samples) > 300, "at the rate of the servo"
        assert max(abs(float(row["tip2_fz_n"])) for row in samples) > 0.1


def test_nothing_in_the_window_says_which_stiffness_is_felt(bpy: ModuleType, plan: Path, port: Any) -> None:
    ops = bpy.ops.dimple
    connect(bpy, port.path)
    change(plan, participants={"P01": [{"show": [STANDARD, SOFTER]}], "P02": [{"show": [SOFTER, STANDARD]}]})
    seen = []
    for participant in ("P01", "P02"):
        ops.open_experiment(filepath=str(plan), participant=participant)
        ops.continue_experiment()
        here = [on_screen(bpy)]
        for _ in range(2):
            ops.continue_experiment()
            bpy.ops.ed.undo_push(message="Before")
            bpy.ops.ed.undo_push(message="After")
            here.append(on_screen(bpy))
            bpy.ops.ed.undo()
            here.append(on_screen(bpy))
            experiment().intervals[-1].seconds = 1.0  # as if it had been felt for long enough
        seen.append(here)
        ops.stop_experiment()
    different = [pair for here in zip(*seen, strict=True) for pair in zip(*here, strict=True) if pair[0] != pair[1]]
    assert not different, "the two participants feel them in the opposite order"
    assert not [name for name in seen[0][1] if name.startswith("DIMPLE_PT_")], "every other panel is hidden"
    assert not {"S", "A", "0.5", "Soft"} & {*seen[0][1]} - {material.name for material in bpy.data.materials}
    assert "DIMPLE_PT_readout" in on_screen(bpy), "the experimenter may look afterwards"


def test_no_number_and_no_chart_is_drawn_over_a_blind_trial(
    bpy: ModuleType, plan: Path, port: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Force against depth is drawn over what plays, and would tell which is the stiffer."""
    from bl_ext.user_default.dimple.addon import overlay

    ops, looked = bpy.ops.dimple, []
    monkeypatch.setattr(overlay, "shown_bodies", lambda context: looked.append(context) or [])
    monkeypatch.setattr(overlay.force_chart, "calibrated_curves", lambda _: None)
    connect(bpy, port.path)
    ops.open_experiment(filepath=str(plan), participant="P02")
    overlay.draw_numbers()
    assert looked, "the experimenter may look"
    looked.clear()
    ops.continue_experiment()
    overlay.draw_numbers()
    assert not looked
    ops.stop_experiment()
    overlay.draw_numbers()
    assert looked


def test_what_the_device_cannot_render_is_refused_before_it_begins(bpy: ModuleType, plan: Path, port: Any) -> None:
    ops = bpy.ops.dimple
    with pytest.raises(RuntimeError, match="No haptic device is ready"):
        ops.open_experiment(filepath=str(plan), participant="P01")
    connect(bpy, port.path)
    for stiff in ({"level": 20.0}, {"level": 0.1}):  # too stiff at once; or beyond its knee, which is reached early
        show = [STANDARD, {"object": "A", **stiff}]
        change(plan, participants={"P01": [{"show": show}]})
        with pytest.raises(RuntimeError, match=r"renders up to .* Object A at the level"):
            ops.open_experiment(filepath=str(plan), participant="P01")
    assert [path.name for path in plan.parent.glob("*.csv")] == []


def test_a_plan_that_cannot_be_is_refused_with_the_entry_and_the_code_is_asked_for(
    bpy: ModuleType, plan: Path, port: Any
) -> None:
    connect(bpy, port.path)
    for code in ("", "1", "P03"):
        with pytest.raises(RuntimeError, match="one of P01, P02"):
            bpy.ops.dimple.open_experiment(filepath=str(plan), participant=code)
    for entries, why in (
        ({"objects": {"A": "Nothing", "S": "Soft"}}, "no material or preset"), ({"answers": ["Only"]}, "answers"),
        ({"colour": 1}, "colour"), ({"participants": {"P01": [{"show": [{"object": "Z"}]}]}}, "P01, 1, object"),
    ):  # fmt: skip
        with pytest.raises(RuntimeError, match=why):
            bpy.ops.dimple.open_experiment(filepath=str(change(plan, **entries)), participant="P01")


def test_a_device_that_is_lost_ends_no_experiment_and_gives_no_answer(bpy: ModuleType, plan: Path, port: Any) -> None:
    ops = bpy.ops.dimple
    connect(bpy, port.path)
    ops.open_experiment(filepath=str(plan), participant="P02")
    ops.continue_experiment()
    ops.connect_device()  # lets go of it
    with pytest.raises(RuntimeError, match="No haptic device is ready"):
        ops.continue_experiment()
    with pytest.raises(RuntimeError, match="for long enough"):
        ops.answer_trial(choice=1)
    connect(bpy, port.path)
    assert ops.continue_experiment() == {"FINISHED"}, "connected again, it goes on"
    ops.stop_experiment()
