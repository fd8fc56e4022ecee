"""Questions are no dead ends: each answer that is offered leads to a reading, or on to another question."""

import re
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from core.base import DimpleError
from core.calibration.calibrate import calibrate
from core.calibration.question import Answers, Candidate, Question, Undecided

KINDS = {field.name: {"int | None": int, "float | None": float}.get(str(field.type), str) for field in fields(Answers)}
SWAP = str.maketrans(".,", ",.")

# what is asked first: header, row (number from 1, depth [mm], force [N])
ASKED = {
    "which columns, then units": ("", lambda i, d, f: f"{d:.5f},{f:.5f}"),
    "which of three columns": ("", lambda i, d, f: f"{i / 10},{d:.5f},{f:.5f}"),
    "a table of R, whose header is shorter": ("Depth (mm),Force (N)", lambda i, d, f: f"{i},{d:.5f},{f:.5f}"),
    "which of two depths": ("Crosshead (mm),Extensometer (mm),Load (N)", lambda i, d, f: f"{1.4 * d:.5f},{d:.5f},{f}"),
    "which of two forces": ("Depth (mm),Force (N),Ch3 (N)", lambda i, d, f: f"{d:.5f},{f / 100:.5f},{f:.5f}"),
    "no depth": ("Compression (%),Load (N)", lambda i, d, f: f"{d / 1.65:.5f},{f:.5f}"),
    "no force": ("Displacement (mm),Stress (MPa)", lambda i, d, f: f"{d:.5f},{f / 1e3:.7f}"),
    "units": ("Depth,Force", lambda i, d, f: f"{d:.5f},{f:.5f}"),
    "unit of the force": ("Depth (mm),Force", lambda i, d, f: f"{d:.5f},{f:.5f}"),
    "a time that is no clock": ("Time (s),Depth (mm),Force (N)", lambda i, d, f: f"{f:.5f},{i / 10},{d:.5f}"),
    "decimal": ("Weg (um);Kraft (mN)", lambda i, d, f: f"{1e3 * d:,.0f};{1e3 * f:,.0f}".translate(SWAP)),
}
# answers that the data, rather than another answer, speak against
NO_PRESS = "reverses|never increases|a fit needs at least"


def answered(path: Path, answers: Answers, given: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], str]]:
    """Give every answer to the first of the open questions, and so on; yield the answers given and the error or ""."""
    try:
        calibrate(path, answers)
        yield given, ""
    except Undecided as undecided:
        question = undecided.questions[0]
        assert getattr(answers, question.name) is None, f"{given}: {question.name} is asked again"
        for candidate in _offered(question, given):
            value = KINDS[question.name](candidate.value)
            yield from answered(path, replace(answers, **{question.name: value}), (*given, f"{question.name} {value}"))
    except DimpleError as error:
        yield given, str(error)


def _offered(question: Question, given: tuple[str, ...]) -> tuple[Candidate, ...]:
    """Return the answers; of units, which differ by a factor only, one where something else was asked before."""
    return question.candidates[: 1 if given and "unit" in question.name else None]


def check(path: Path) -> None:
    became = dict(answered(path, Answers()))
    assert () not in became, "something is asked"
    assert "" in became.values()
    assert not {given: error for given, error in became.items() if error and not re.search(NO_PRESS, error)}


@pytest.mark.parametrize("name", ASKED)
def test_every_answer_about_the_columns_leads_on(name, curve, write):
    header, line = ASKED[name]
    rows = (line(i, d, f) for i, (d, f) in enumerate(zip(curve.depth, curve.force, strict=True), 1))
    check(write("\n".join(filter(None, [header, *rows])) + "\n"))


def table(depth, force, head="Depth (mm),Force (N)") -> str:
    return f"{head}\n" + "".join(f"{d:.5f},{f:.5f}\n" for d, f in zip(depth, force, strict=True))


def two_presses(curve) -> str:
    there_and_back = [*curve.depth, *curve.depth[::-1]], [*curve.force, *curve.force[::-1]]
    return table(there_and_back[0] * 2, [*there_and_back[1], *(0.4 * np.array(there_and_back[1]))])


def both_ways(curve) -> str:
    depth = curve.depth - 5
    return table(depth, np.where(depth < 0, -60 * (np.abs(depth + 2) < 1), curve.force))


PRESSES: dict[str, Callable] = {
    "cycle": two_presses,
    "table": lambda curve: table(curve.depth, curve.force) + table(curve.depth, curve.force / 2, "Weg (mm),Kraft (N)"),
    "press": both_ways,
    "contact_mm": lambda curve: table(curve.depth[60:] - curve.depth[60], curve.force[60:]),
}


@pytest.mark.parametrize("name", PRESSES)
def test_every_answer_about_the_press_leads_on(name, curve, write):
    path = write(PRESSES[name](curve))
    with pytest.raises(Undecided) as asked:
        calibrate(path)
    assert [question.name for question in asked.value.questions] == [name.split(",")[0]]
    check(path)


def test_a_column_that_is_said_to_be_the_depth_is_not_taken_for_the_force(curve, write):
    path = write(table(curve.force, curve.depth))  # exchanged
    fit = calibrate(path, Answers(depth_column="2", depth_unit="mm", force_unit="N")).fit
    assert (fit.K1.value, fit.x0.value) == pytest.approx((610, 0.0163), rel=0.05)
