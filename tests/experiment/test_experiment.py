"""The sensory comparison without Blender: plans, which intervals count, and files that lose nothing."""

import csv
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from core.base import DimpleError
from core.experiment.log import COLUMNS, Log, parsed
from core.experiment.plan_file import Plan, read_plan
from core.experiment.run import Experiment, Interval
from studies.experiment.counterbalanced_plans import KINDS, LEVELS, PAPER, make
from studies.experiment.people import written
from studies.paper_objects import PRESETS
from tools.environment import ROOT

MATERIALS = {"A": PRESETS[1].material, "S": PRESETS[1].material}


def planned(folder: Path, kind: str, **more: Any) -> Plan:
    path = folder / f"{kind}.json"
    path.write_text(written(make(kind, **more)))
    return read_plan(path)


@pytest.fixture
def pairs(tmp_path: Path) -> Plan:
    return planned(tmp_path, "pairs", participants=2)


def feel(experiment: Experiment, *seconds: float) -> None:
    for each in seconds:
        experiment.begin()
        experiment.intervals[-1].seconds = each


def answer(experiment: Experiment, count: int) -> None:
    for _ in range(count):
        feel(experiment, 10.0, 10.0)
        experiment.answer(1)


def begun(path: Path, plan: Plan, code: str = "P01") -> Experiment:
    experiment = Experiment(plan, code, path, MATERIALS, {})
    experiment.agree()
    return experiment


# plans


@pytest.mark.parametrize("kind", KINDS)
def test_the_sample_of_each_kind_is_what_the_command_writes(kind: str) -> None:
    sample = ROOT / "blend_samples" / f"experiment_{kind}.json"
    assert sample.read_text() == written(make(kind)) and len(read_plan(sample).participants) == 8


def test_real_objects_follow_a_latin_square_and_neither_comes_first_more_often(tmp_path: Path) -> None:
    plan = planned(tmp_path, "rating", participants=6)
    orders = set()
    for trials in plan.participants.values():
        main = [trial for trial in trials if trial.part == "main"]
        orders.add(tuple(dict.fromkeys(next(each.real for each in trial.show if each.real) for trial in main)))
        firsts = Counter(
            (trial.show[1].real or trial.show[0].real, trial.show[0].object or trial.show[1].object,
             trial.show[0].level * trial.show[1].level, bool(trial.show[0].real)) for trial in main
        )  # fmt: skip
        assert all(firsts[*key, True] == firsts[*key, False] for *key, _ in firsts if key[0] == key[1])
    assert len(orders) == 6 and {order[0] for order in orders} == {"A", "B", "C"}


def test_every_level_comes_as_often_first_as_second(pairs: Plan) -> None:
    for trials in pairs.participants.values():
        firsts = Counter(
            (trial.show[0].level if first else trial.show[1].level, first)
            for trial in trials if trial.part == "main" for first in [trial.show[0].object == "A"]
        )  # fmt: skip
        assert set(firsts.values()) == {10} and {level for level, _ in firsts} == {*LEVELS}
    assert pairs.participants["P01"] != pairs.participants["P02"]


@pytest.mark.parametrize(
    ("entry", "value"),
    [("answers", ["Only"]), ("answers", [1, 2]), ("exposure_s", float("nan")), ("exposure_s", "2"), ("colour", 1),
     ("objects", {"S": 5}), ("participants", []), ("participants", {"P 1": []}), ("consent", None),
     ("participants", {"P1": [{"show": []}]}), ("participants", {"P1": [{"show": [{"object": "Z"}]}]}),
     ("participants", {"P1": [{"show": [{"object": "A", "real": "A"}]}]}),
     ("tracks", {"above": 1})],
)  # fmt: skip
def test_an_entry_that_cannot_be_is_refused_by_its_name(tmp_path: Path, entry: str, value: Any) -> None:
    path = tmp_path / "plan.json"
    path.write_text(json.dumps({**make("pairs", participants=1), entry: value}))
    with pytest.raises(DimpleError, match=f"wrong or missing entry: {entry}"):
        read_plan(path)


# what counts as felt


def touched(force: float, count: int = 100, begin: float = 0.0) -> list[tuple[float, ...]]:
    return [(begin + 0.001 * i, *(0.0,) * 5, force, *(0.0,) * 12) for i in range(count)]


def test_only_the_time_counts_in_which_this_stimulus_is_felt() -> None:
    interval = Interval(needed=500.0, least_n=0.2, most_n=4.0)
    interval.feel(touched(0.0), 600.0)
    assert interval.seconds == 0, "nothing is touched"
    interval.feel(touched(1.0, begin=0.1), 600.0)
    assert interval.seconds == pytest.approx(0.1)
    interval.feel(touched(1.0, 10, begin=0.2), 400.0)
    assert interval.seconds == 0, "the device renders it softer than it is"
    interval.feel(touched(1.0, begin=0.21), 600.0)
    interval.feel(touched(5.0, 1, begin=0.31), 600.0)
    assert interval.seconds == 0, "it was pressed harder than it can be rendered"
    interval.feel(touched(1.0, 2, begin=9.0), 600.0)
    assert interval.seconds < 0.01, "a gap in the samples is not felt"
    assert len(interval.samples) == 313


def test_an_answer_needs_all_its_stimuli_and_an_interrupted_one_is_counted(pairs: Plan, tmp_path: Path) -> None:
    experiment = begun(tmp_path / "a.csv", pairs)
    for seconds in ([], [10.0], [0.1], [1.9]):
        feel(experiment, *seconds)
        with pytest.raises(DimpleError, match="at least 2 s"):
            experiment.answer(1)
    feel(experiment, 2.0)
    with pytest.raises(DimpleError, match="no answer 3"):
        experiment.answer(3)
    experiment.answer(2)
    assert [experiment.log.rows[-1][name] for name in ("answer", "first_times", "second_times")] == ["2", "1", "3"]


# files of record


def test_a_file_states_all_that_was_presented_and_refuses_another(pairs: Plan, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    answer(experiment := begun(path, pairs), 3)
    experiment.log.file.close()
    stated = json.loads(parsed(path, path.read_bytes())[0]["details"])
    assert stated["constants"]["A"]["K1"] == 610 and stated["plan"]["made"]["seed"] == 1
    changed = {**MATERIALS, "A": PRESETS[0].material}
    for code, materials in (("P02", MATERIALS), ("P01", changed)):
        with pytest.raises(DimpleError, match="another participant, or to another plan"):
            Experiment(pairs, code, path, materials, {})
    assert [trial.number for trial in begun(path, pairs).left()][:2] == [4, 5]


@pytest.mark.parametrize("cut", [1, 2, 7, 30])
def test_a_row_that_was_cut_is_asked_again_and_the_file_only_grows(pairs: Plan, tmp_path: Path, cut: int) -> None:
    path = tmp_path / "a.csv"
    experiment = begun(path, pairs)
    answer(experiment, 5)
    experiment.log.file.close()
    os.truncate(path, path.stat().st_size - cut)
    before = path.read_bytes()
    answer(again := begun(path, pairs), 2)
    rows = [row["trial"] for row in again.log.rows if row["event"] == "answer"]
    assert path.read_bytes().startswith(before) and rows == [str(i) for i in range(1, 7 if cut > 1 else 8)]


@pytest.mark.parametrize(
    "save",
    [lambda data: b"\xef\xbb\xbf" + data.replace(b"\n", b"\r\n"), lambda data: data.replace(b"\n", b"\r"),
     lambda data: respelled(data, ";"), lambda data: respelled(data, "\t"), lambda data: data.rstrip(b"\n")],
)  # fmt: skip
def test_what_a_spreadsheet_saved_is_read_and_gone_on_with(pairs: Plan, tmp_path: Path, save: Any) -> None:
    path = tmp_path / "a.csv"
    answer(experiment := begun(path, pairs), 3)
    experiment.log.file.close()
    path.write_bytes(save(path.read_bytes()))
    answer(again := begun(path, pairs), 2)
    again.log.file.close()
    rows = parsed(path, path.read_bytes())
    assert [row["trial"] for row in rows] == ["", "1", "2", "3", "", "4", "5"]
    assert json.loads(rows[0]["details"]) == json.loads(rows[4]["details"])


def respelled(data: bytes, mark: str) -> bytes:
    rows = csv.reader(data.decode().splitlines())
    out = [mark.join(f'"{cell.replace(chr(34), 2 * chr(34))}"' for cell in row) for row in rows]
    return ("\r\n".join(out) + "\r\n").encode()


def test_a_file_that_another_program_replaces_loses_nothing(pairs: Plan, tmp_path: Path) -> None:
    path, saved = tmp_path / "a.csv", tmp_path / "saved.csv"
    experiment = begun(path, pairs)
    answer(experiment, 2)
    saved.write_bytes(path.read_bytes())
    answer(experiment, 2)
    saved.replace(path)  # as spreadsheets save: what was answered meanwhile is not in it
    with pytest.raises(DimpleError, match="Another program has changed"):
        answer(experiment, 1)
    (copy,) = tmp_path.glob("a_kept_*.csv")
    assert [row["trial"] for row in parsed(copy, copy.read_bytes())] == ["", "1", "2", "3", "4", "5"]
    assert len(parsed(path, path.read_bytes())) == 3


def test_two_windows_do_not_share_a_file(pairs: Plan, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    experiment = begun(path, pairs)
    words = "import sys; from pathlib import Path; from core.experiment.log import Log; Log(Path(sys.argv[1]))"
    other = subprocess.run([sys.executable, "-c", words, path], cwd=ROOT, capture_output=True, text=True, check=False)
    assert "is already open" in other.stderr and other.returncode
    answer(experiment, 1)
    experiment.log.file.close()
    assert subprocess.run([sys.executable, "-c", words, path], cwd=ROOT, check=False).returncode == 0


@pytest.mark.parametrize("text", ['{"name": "a plan"}', "what,ever\n1,2", "trial,plan\r1,2", "event,time\n"])
def test_another_file_stays_as_it_is(tmp_path: Path, text: str) -> None:
    path = tmp_path / "plan.json"
    path.write_bytes(text.encode())
    with pytest.raises(DimpleError, match="not an answer file"):
        Log(path)
    assert path.read_bytes() == text.encode() and list(tmp_path.iterdir()) == [path]


def test_a_row_that_was_edited_to_nonsense_is_said(pairs: Plan, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    answer(experiment := begun(path, pairs), 3)
    experiment.log.file.close()
    text = path.read_text().replace(f",{experiment._key},2,", f",{experiment._key},second,")
    path.write_text(text)
    with pytest.raises(DimpleError, match="not an answer file"):
        begun(path, pairs)
    assert path.read_text() == text


def test_a_disk_that_is_full_is_said_and_the_answer_is_asked_again(pairs: Plan, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    answer(experiment := begun(path, pairs), 2)

    class Full:
        """A file on a disk that has room for ten more bytes."""

        def __init__(self, file: Any) -> None:
            self.file, self.fileno = file, file.fileno

        def write(self, data: bytes) -> int:
            return self.file.write(data[:10])

    experiment.log.file, real = Full(experiment.log.file), experiment.log.file
    with pytest.raises(DimpleError, match="No space left"):
        answer(experiment, 1)
    experiment.log.file = real
    experiment.answer(2)
    answer(experiment, 1)
    assert [row["trial"] for row in parsed(path, path.read_bytes())] == ["", "1", "2", "3", "4"]


def test_a_header_that_a_full_disk_cut_is_completed(pairs: Plan, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(",".join(COLUMNS).encode()[:20])
    answer(begun(path, pairs), 1)
    assert len(parsed(path, path.read_bytes())) == 2


@pytest.mark.skipif(os.name == "nt", reason="kill -9")
def test_of_ten_kills_no_answer_is_lost_and_none_is_there_twice(pairs: Plan, tmp_path: Path) -> None:
    path, dice, seen = tmp_path / "a.csv", random.Random(1), 0
    words = (
        "import sys; from pathlib import Path; from core.experiment.plan_file import read_plan\n"
        "from studies.experiment.people import take_part\n"
        "take_part(read_plan(Path(sys.argv[1])), 'P01', Path(sys.argv[2]), lambda *_: 1, pause_s=0.002)"
    )
    for _ in range(10):
        process = subprocess.Popen([sys.executable, "-c", words, tmp_path / "pairs.json", path], cwd=ROOT)
        wanted = seen + dice.randint(2, 8)
        while process.poll() is None and (not path.exists() or path.read_bytes().count(b"\nanswer") < wanted):
            time.sleep(0.001)
        process.send_signal(signal.SIGKILL)
        process.wait()
        rows = [row["trial"] for row in parsed(path, path.read_bytes()) if row["event"] == "answer"]
        assert rows == [str(i) for i in range(1, len(rows) + 1)] and len(rows) >= seen
        seen = len(rows)
    traces = {row["trace"] for row in parsed(path, path.read_bytes()) if row["trace"]}
    assert seen >= 20 and len(traces) == seen and all((tmp_path / trace).exists() for trace in traces)


def test_the_paper_s_objects_can_be_told_apart_by_no_more_than_five_percent_below_their_knees() -> None:
    """So a plan needs a foil that is softer: another twin alone would be rated as alike."""
    stiffness = [each.material.K1 for each in PRESETS if each.name in PAPER]
    assert max(stiffness) / min(stiffness) < 1.06
