"""The sensory comparison without Blender: order, staircase, answers that survive, and what they come to."""

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest

from core.base import DimpleError
from core.experiment.log import Log, read_rows
from core.experiment.plan import make_plan, order, read_plan
from core.experiment.run import Experiment
from core.experiment.staircase import next_level
from studies.experiment import PLAN, RATING, by_psignifit, observe, touched
from studies.experiment_results import Comparison, compared, rated, sentences
from studies.psychometric import QUARTER, fit, shares

SMALL = {
    "name": "small", "seed": 3,
    "tasks": [
        {"kind": "rating", "object": "Object 2", "repeats": 2},
        {"kind": "comparison", "object": "Object 2", "levels": [0.8, 1.2], "repeats": 10},
        {"kind": "comparison", "object": "Object 2", "condition": "seen", "levels": [0.8, 1.2], "repeats": 10},
    ],
}  # fmt: skip


def test_the_order_is_that_of_the_seed_and_the_participant_and_every_level_comes_as_often() -> None:
    plan = make_plan(PLAN)
    first, again, other = order(plan, "1"), order(plan, "1"), order(plan, "2")
    assert first == again and first != other
    levels = [slot.level for slot in first if not slot.task.staircase]
    assert {levels.count(level) for level in set(levels)} == {24} and len(first) == 400
    firsts = [slot.test_first for slot in first if not slot.task.staircase]
    assert sum(firsts) == len(firsts) / 2
    assert not {slot.label for slot in first} & {"Object 2", "Object 3"}


def test_a_csv_says_the_same_as_a_json(tmp_path: Path) -> None:
    (tmp_path / "plan.csv").write_text(
        "kind,condition,object,repeats,levels,steps\nrating,felt,Object 2,2,,no | a bit | yes\n"
        "comparison,seen,Object 2,10,0.8 1.2,\n"
    )
    file = {"tasks": [
        {"kind": "rating", "object": "Object 2", "repeats": 2, "steps": ["no", "a bit", "yes"]},
        {"kind": "comparison", "condition": "seen", "object": "Object 2", "repeats": 10, "levels": [0.8, 1.2]},
    ]}  # fmt: skip
    (tmp_path / "plan.json").write_text(json.dumps(file))
    assert read_plan(tmp_path / "plan.csv").tasks == read_plan(tmp_path / "plan.json").tasks


@pytest.mark.parametrize(
    "task",
    [{}, {"kind": "rating"}, {"repeats": 0.5}, {"x": 1}, {"levels": [1.0]}, {"levels": ["nan", 1]},
     {"levels": [-1, 1]}, {"condition": "smelt"}],
)  # fmt: skip
def test_a_task_that_cannot_be_is_refused_with_its_number(task: dict[str, object]) -> None:
    usual = {"kind": "comparison", "object": "A"} if task and "kind" not in task else {}
    with pytest.raises(DimpleError, match="Task 1"):
        make_plan({"name": "bad", "tasks": [{**usual, **task}]})


def test_a_staircase_goes_round_the_point_of_equality() -> None:
    dice, answers = np.random.default_rng(1), []
    for _ in range(200):
        level = next_level(1.5, 0.1, answers)
        answers.append((level, bool(dice.random() < shares(np.array(level), 1.1, 0.12, 0.0))))
    late = [level for level, _ in answers[60:]]
    assert np.mean(late) == pytest.approx(1.1, abs=0.06) and np.std(late) > 0.05


def test_felt_and_seen_are_never_pooled(tmp_path: Path) -> None:
    experiment = Experiment(make_plan(SMALL), "1", Log(tmp_path / "a.csv", sync=False))
    while trial := experiment.next():
        stiffer = trial.level > 1
        experiment.answer(2 if trial.task.kind == "rating" else 1 if stiffer == trial.test_first else 2)
    rows = experiment.log.rows
    assert [each.counts for each in rated(rows)] == [(0, 2, 0, 0)]
    found = compared(rows)
    assert [(each.condition, each.stiffer, each.trials) for each in found] == [
        ("felt", (0, 10), (10, 10)), ("seen", (0, 10), (10, 10)),
    ]  # fmt: skip
    assert len(sentences(rows)) == 3


@pytest.mark.parametrize("cut", [1, 7, 30])
def test_a_row_that_a_kill_left_unfinished_is_asked_again(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "a.csv"
    experiment = Experiment(make_plan(SMALL), "1", Log(path))
    for _ in range(5):
        experiment.answer(1, samples=[(0.0, 0.001, 1.0)])
    os.truncate(path, path.stat().st_size - cut)
    again = Experiment(make_plan(SMALL), "1", Log(path))
    trial = again.next()
    assert trial and trial.number == 5
    again.answer(1, samples=[(0.0, 0.001, 1.0)])
    assert [row.trial for row in Log(path).rows] == [1, 2, 3, 4, 5]
    assert [row.trial for row in read_rows(path)] == [1, 2, 3, 4, 5] and touched(path, again.log.rows) == 5


def test_the_answers_of_another_participant_or_plan_are_not_mixed_in(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    Experiment(make_plan(SMALL), "1", Log(path)).answer(1)
    with pytest.raises(DimpleError, match="another"):
        Experiment(make_plan(SMALL), "2", Log(path))
    with pytest.raises(DimpleError, match="another"):
        Experiment(make_plan(RATING), "1", Log(path))
    (tmp_path / "b.csv").write_text("what,ever\n1,2\n")
    with pytest.raises(DimpleError, match="not a file of answers"):
        Log(tmp_path / "b.csv")


def test_the_fit_finds_the_function_that_made_exact_answers() -> None:
    x, n = np.linspace(0.5, 1.5, 11), np.full(11, 10_000)
    found = fit(x, np.round(n * shares(x, 1.05, 0.12 / QUARTER, 0.01)), n)
    assert (found.pse, found.jnd) == pytest.approx((1.05, 0.12), rel=0.01)
    assert found.pse_95[0] < 1.05 < found.pse_95[1] and found.jnd_95[0] < 0.12 < found.jnd_95[1]
    assert found.lapse == pytest.approx(0.01, abs=0.005) and found.deviance < 1


def test_answers_that_leave_an_end_open_say_so() -> None:
    found = fit([0.9, 1.1], [4, 9], [10, 10])
    assert found.pse_95[0] == -math.inf or found.pse_95[0] < 0.8
    with pytest.raises(DimpleError, match="alike"):
        fit([0.9, 1.1], [20, 20], [20, 20])
    with pytest.raises(DimpleError, match="20 answers"):
        fit([0.9, 1.1], [1, 2], [3, 3])


def test_psignifit_fits_the_same_function() -> None:
    levels, stiffer, trials = (0.6, 0.8, 1.0, 1.2, 1.4), (2, 6, 11, 18, 23), (24,) * 5
    found = fit(levels, stiffer, trials)
    each = Comparison("", "", "", levels, stiffer, trials, found)
    judged = by_psignifit(each)
    assert (found.pse, found.jnd) == pytest.approx((judged["pse"], judged["jnd"]), rel=0.003)


def test_an_observer_interrupted_anywhere_answers_as_one_that_was_not(tmp_path: Path) -> None:
    plan = make_plan(SMALL)
    observe(plan, tmp_path / "whole.csv", 1)
    whole = Log(tmp_path / "whole.csv").rows
    data = (tmp_path / "whole.csv").read_bytes()
    for cut in np.random.default_rng(2).integers(200, len(data), 5):
        (tmp_path / "cut.csv").write_bytes(data[:cut])
        (tmp_path / "cut_touch.csv").write_bytes((tmp_path / "whole_touch.csv").read_bytes())
        observe(plan, tmp_path / "cut.csv", 1)
        rows = Log(tmp_path / "cut.csv").rows
        assert [(r.trial, r.level, r.response) for r in rows] == [(r.trial, r.level, r.response) for r in whole]


@pytest.mark.parametrize("stiffer", [[15] * 7, [20, 19, 15, 10, 6, 2, 0], [10, 9, 11, 10, 8, 12, 10]])
def test_answers_that_do_not_rise_with_the_stiffness_are_refused(stiffer: list[int]) -> None:
    with pytest.raises(DimpleError, match="do not rise"):
        fit([0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3], stiffer, [20] * 7)


def test_a_point_of_equality_beyond_the_levels_is_refused() -> None:
    with pytest.raises(DimpleError, match="do not reach"):
        fit([0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3], [0, 0, 0, 0, 1, 2, 5], [20] * 7)


def test_every_participant_has_a_fit_of_their_own_and_no_answer_counts_twice(tmp_path: Path) -> None:
    rows = []
    for who in ("1", "2"):
        experiment = Experiment(make_plan(SMALL), who, Log(tmp_path / f"{who}.csv", sync=False))
        while experiment.next():
            experiment.answer(1)
        rows += experiment.log.rows
    assert [(each.participant, each.condition) for each in compared(rows)] == [
        ("1", "felt"), ("2", "felt"), ("1", "seen"), ("2", "seen"),
    ]  # fmt: skip
    assert [(each.people, sum(each.counts)) for each in rated(rows)] == [(2, 4)]
    with pytest.raises(DimpleError, match="twice"):
        sentences([*rows, rows[0]])


@pytest.mark.parametrize("text", ["", '{"name": "a plan"}', "what,ever\n1,2", "trial,plan\r1,2"])
def test_a_file_that_is_read_stays_as_it_is(tmp_path: Path, text: str) -> None:
    path = tmp_path / "plan.json"
    path.write_bytes(text.encode())
    with pytest.raises(DimpleError, match="not a file of answers"):
        read_rows(path)
    assert path.read_bytes() == text.encode() and list(tmp_path.iterdir()) == [path]
    if text:
        with pytest.raises(DimpleError, match="not a file of answers"):
            Log(path)
        assert path.read_bytes() == text.encode()


def test_a_file_of_answers_only_grows(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    Experiment(make_plan(SMALL), "1", Log(path)).answer(1)
    path.write_bytes(path.read_bytes() + b'2,"half')
    before = path.read_bytes()
    Experiment(make_plan(SMALL), "1", Log(path)).answer(1)
    assert path.read_bytes().startswith(before) and [row.trial for row in read_rows(path)] == [1, 2]
