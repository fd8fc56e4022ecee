"""The commands of dev.py: their help asks for no environment, and each study is where the list says."""

import subprocess
import sys
from pathlib import Path

import pytest

import dev
from studies.commands import COMMANDS
from tools.environment import ROOT, run


def bare(*words: str) -> subprocess.CompletedProcess[str]:
    """Run dev.py in a Python that finds no installed package."""
    return subprocess.run([sys.executable, "-S", "-s", "-E", ROOT / "dev.py", *words], capture_output=True, text=True)


@pytest.mark.parametrize(
    ("words", "listed"),
    [
        (("--help",), [action.__name__ for action in dev.COMMANDS]),
        (("core", "--help"), list(COMMANDS)),
        (("bench", "--help"), ["--quick", "--peers", "--scale"]),
        (("charts", "--help"), ["--out", "--quick", "--redraw"]),
        (("test", "--help"), ["--blender", "--slow"]),
    ],
)
def test_help_needs_no_installed_package(words: tuple[str, ...], listed: list[str]) -> None:
    answer = bare(*words)
    assert answer.returncode == 0 and answer.stderr == ""
    assert [name for name in listed if name not in answer.stdout] == []


@pytest.mark.parametrize("words", [("core",), ("core", "nonsense"), ("bench", "--nonsense"), ("charts", "--nonsense")])
def test_a_wrong_command_is_refused_before_anything_is_set_up(words: tuple[str, ...]) -> None:
    answer = bare(*words)
    assert answer.returncode == 2 and "error: " in answer.stderr


@pytest.mark.parametrize("name", COMMANDS)
def test_each_study_is_where_the_list_says(name: str) -> None:
    _, module, function = COMMANDS[name]
    path = ROOT.joinpath("studies", *module.split(".")[1:]).with_suffix(".py")
    assert f"\ndef {function}(" in path.read_text()


def test_a_command_runs_where_the_user_stands(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run([sys.executable, "-c", "import os; print(os.getcwd())"], folder=tmp_path) == 0
    assert capfd.readouterr().out.strip() == str(tmp_path)
