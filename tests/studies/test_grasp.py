"""`grasp`: three fingertips of an emulated device lift the cube of nylon and put it down."""

import json
from pathlib import Path

import numpy as np
import pytest

from studies.__main__ import main
from studies.device import grasp
from studies.device.grasp import DOWN, LIFT, LOWER, RAISE, RAISED, Moment


@pytest.fixture(scope="module")
def moments() -> list[Moment]:
    return list(grasp.run(grasp.grasp()))


def during(moments: list[Moment], begin: float, end: float) -> list[Moment]:
    return [moment for moment in moments if begin <= moment.time < end]


def test_the_cube_is_lifted_and_not_dropped(moments: list[Moment]) -> None:
    """The hand goes up 60 mm; it yields to the weight, and the fingertips slip a little: two thirds at least."""
    heights = [moment.height for moment in during(moments, RAISED + 0.1, LOWER)]
    assert max(heights) > LIFT * 2 / 3
    assert min(heights) > LIFT / 2


def test_the_cube_is_put_down_again_whole_and_let_go(moments: list[Moment]) -> None:
    last = moments[-1]
    assert last.height == pytest.approx(0.0, abs=0.001)
    assert last.size == pytest.approx(grasp.PRESET.size, rel=0.05)
    assert not any(last.forces[i][c] for i in range(3) for c in range(3))


def test_the_device_renders_the_squeeze_and_the_weight(moments: list[Moment]) -> None:
    held = during(moments, RAISED + 0.1, LOWER)
    thumb, index, middle = np.mean([moment.forces for moment in held], axis=0)
    assert thumb[0] < -1 and index[0] > 1 and middle[0] > 1  # pushed apart
    # the body bears on the fingertips with its whole weight, and so does the device: its forces are the model's. The
    # cube still swings a little
    weight = 9.81 * grasp.PRESET.material.mass
    assert np.sum([moment.borne for moment in held], axis=1)[:, 2].mean() == pytest.approx(-weight, rel=0.1)
    assert thumb[2] + index[2] + middle[2] == pytest.approx(-weight, rel=0.1)
    assert max(np.linalg.norm(force) for moment in moments for force in moment.forces) < 10.0


def test_the_device_stays_armed_and_loses_nothing(moments: list[Moment]) -> None:
    report = moments[-1].report
    assert (report.arming.name, report.lost, report.wrong, report.stale) == ("ON", 0, 0, 0)


SLOW = pytest.mark.slow


@pytest.mark.parametrize("cells", [6, *(pytest.param(cells, marks=SLOW) for cells in (12, 24, 40))])
def test_finer_cubes_are_lifted_too(cells: int) -> None:
    """218 to 9,602 vertices: the grip does not depend on how many share it, and no fingertip ever lets go."""
    held = [m for m in grasp.run(grasp.grasp(cells), seconds=DOWN) if m.time >= RAISE]
    assert min(m.height for m in during(held, RAISED + 0.1, LOWER)) > LIFT * 2 / 3
    assert min(abs(force[0]) for m in held for force in m.forces) > 0.5


def test_without_friction_it_is_not_lifted() -> None:
    """What comes up then is the skin in the fingertips' dents: less than half of what friction lifts."""
    moments = list(grasp.run(grasp.grasp(friction=0.0), seconds=LOWER))
    assert max(moment.height for moment in during(moments, RAISED, LOWER)) < LIFT / 3
    assert max(moment.forces[1][0] for moment in moments) > 1  # pressed as hard, all the same


def test_the_command_tells_how_high_the_cube_was(
    moments: list[Moment], capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "grasp.json"
    monkeypatch.setattr(grasp, "run", lambda _session: moments)
    assert main(["grasp", "--json", str(out)]) == 0
    output = capsys.readouterr().out
    assert "lifted" in output and "weighs 0.98 N" in output
    assert max(row["height_m"] for row in json.loads(out.read_text())) > LIFT * 2 / 3
    assert main(["grasp", "--json", str(tmp_path)]) == 2
