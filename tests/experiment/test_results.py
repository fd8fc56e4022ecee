"""Results of the sensory comparison: each participant is fitted or refused, the group is a group of people."""

import random
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest

from core.base import DimpleError
from core.experiment.plan_file import read_plan
from studies.experiment.counterbalanced_plans import LEVELS, make
from studies.experiment.people import MANNERS, person, take_part, written
from studies.experiment.results import QUARTER, Pairs, Ratings, fit, group, read, summary

GUESSED = [10, 9, 11, 10, 8, 12, 10]


def taken_part(folder: Path, kind: str, manners: tuple[str, ...]) -> tuple[list[Pairs], list[Ratings]]:
    path = folder / "plan.json"
    path.write_text(written(make(kind, participants=len(manners))))
    plan, files = read_plan(path), []
    for code, manner in zip(plan.participants, manners, strict=True):
        files.append(folder / f"{code}.csv")
        take_part(plan, code, files[-1], person(manner, random.Random(code)).answer)
    pairs, ratings, notes = read(files)
    assert notes == []
    return pairs, ratings


def test_the_fit_finds_the_function_that_made_exact_answers() -> None:
    x, n = np.linspace(0.5, 1.5, 11), 1000
    stiffer = [round(n * NormalDist().cdf((level - 1.05) * QUARTER / 0.12)) for level in x]
    found = fit(x.tolist(), stiffer, [n] * len(x))
    assert (found["pse"], found["jnd"]) == pytest.approx((1.05, 0.12), rel=0.01)
    assert found["pse_95"][0] < 1.05 < found["pse_95"][1] and found["jnd_95"][0] < 0.12 < found["jnd_95"][1]
    assert found["deviance"] < 3


@pytest.mark.parametrize(
    ("stiffer", "why"),
    [([15] * 7, "do not rise"), (GUESSED, "do not rise"), ([20, 19, 15, 10, 6, 2, 0], "fall with"),
     ([0] * 7, "do not rise"), ([0, 0, 0, 0, 1, 2, 5], "do not reach")],
)  # fmt: skip
def test_answers_without_a_point_of_equality_are_refused(stiffer: list[int], why: str) -> None:
    assert why in fit(LEVELS, stiffer, [20] * 7)["refused"]
    assert "fewer than 20" in fit(LEVELS[:2], [3, 9], [9, 9])["refused"]


def test_each_manner_of_answering_pairs_is_fitted_or_refused(tmp_path: Path) -> None:
    pairs, _ = taken_part(tmp_path, "pairs", ("good", "swapped", "guessing", "one button"))
    assert [bool(each.refused) for each in pairs] == [False, True, True, True]
    true = person("good", random.Random("P01"))
    assert pairs[0].pse_95[0] < true.pse < pairs[0].pse_95[1] and pairs[0].jnd_95[0] < true.jnd < pairs[0].jnd_95[1]
    assert pairs[0].catch == (5, 5) and pairs[3].first[0] == 1.0
    assert "1 of 4 people fitted" in summary(pairs, [])[0]


def test_ratings_are_counted_for_twins_and_foils_apart(tmp_path: Path) -> None:
    _, ratings = taken_part(tmp_path, "rating", MANNERS)
    said = dict(zip(MANNERS, ratings, strict=True))
    assert said["good"].told > 0.6 and not said["good"].refused
    assert all("catch trials" in said[manner].refused for manner in ("swapped", "guessing"))
    assert "all answers are alike" in said["one button"].refused
    assert all(len(answers) == 4 for key, answers in said["good"].answers.items() if key[0] == key[1] and key[2] == 1)


def test_a_group_is_of_people_and_not_of_answers() -> None:
    mean, low, high = group([0.9, 1.0, 1.1, 1.2])
    assert mean == pytest.approx(1.05) and high - low > 0.35


def test_what_is_not_a_file_of_answers_is_refused_and_stays(tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    path.write_text('{"a": 1}')
    for wrong in (path, tmp_path / "none.csv"):
        with pytest.raises(DimpleError):
            read([wrong])
    assert path.read_text() == '{"a": 1}' and list(tmp_path.iterdir()) == [path]


def test_nobody_counts_twice_and_what_is_missing_is_said(tmp_path: Path) -> None:
    taken_part(tmp_path, "rating", ("good",))
    path = tmp_path / "P01.csv"
    with pytest.raises(DimpleError, match="P01 are given twice"):
        read([path, path])
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:4] + lines[5:] + lines[-1:]))
    notes: list[Any] = read([path])[2]
    assert "answered twice" in notes[0] and "trials [3] are missing" in notes[1]
