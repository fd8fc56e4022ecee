"""What tests/conftest.py promises about tests that are skipped."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tools.environment import ROOT

SKIPS = """
import pytest
def test_in_the_body(): pytest.skip("the machine is busy")
@pytest.mark.skipif(True, reason="the port is not here")
def test_by_a_mark(): pass
@pytest.mark.xfail
def test_expected_to_fail(): assert False
"""


def run(path: Path, ci: str) -> subprocess.CompletedProcess[str]:
    path.write_text(SKIPS)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "tests.conftest", "-c", ROOT / "pyproject.toml"]
    quiet = ["-o", f"cache_dir={path.parent / 'cache'}", "--rootdir", path.parent, path]
    return subprocess.run([*command, *quiet], cwd=ROOT, env={**os.environ, "CI": ci}, capture_output=True, text=True)


@pytest.mark.parametrize(("name", "ci", "end"), [
    ("test_safety.py", "true", "1 failed, 1 xfailed, 1 error"), ("test_safety.py", "", "2 skipped, 1 xfailed"),
    ("test_colours.py", "true", "2 skipped, 1 xfailed"),
])  # fmt: skip
def test_a_safety_test_is_never_skipped_in_ci_and_the_reason_is_shown(
    tmp_path: Path, name: str, ci: str, end: str
) -> None:
    done = run(tmp_path / name, ci)
    assert done.stdout.splitlines()[-1].startswith(end), done.stdout + done.stderr
    assert done.returncode == end.startswith("1 failed")
    assert "the machine is busy" in done.stdout and "the port is not here" in done.stdout
