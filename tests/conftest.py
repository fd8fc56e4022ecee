"""What every test may ask for. Blender's own fixtures are in tests/blender/conftest.py."""

import os
import sys
from collections.abc import Generator
from pathlib import Path

import pytest

from tools import extension

# numpy's threads wait for each other at every small product: on a busy machine that costs several times the work
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when numpy is imported, so before any test module
BLENDER_TESTS = Path(__file__).parent / "blender"
HAPTIC_TESTS = Path(__file__).parent / "haptics"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if len({BLENDER_TESTS in item.path.parents for item in items}) == 2:
        raise pytest.UsageError(
            "core and the installed extension are the same modules under two names and never mix in one "
            "process: run `python3 dev.py test`, or tests/blender by itself"
        )


def keeps_hands_safe(item: pytest.Item) -> bool:
    return HAPTIC_TESTS in item.path.parents or "safety" in item.nodeid


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Let no test that keeps a hand safe be skipped where the environment sets CI: there it fails."""
    report = yield
    if os.environ.get("CI") and report.skipped and not hasattr(report, "wasxfail") and keeps_hands_safe(item):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        report.outcome, report.longrepr = "failed", f"{item.nodeid} keeps a hand safe, and in CI it must run: {reason}"
    return report


@pytest.fixture(scope="session")
def extension_zip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the zip that Blender installs."""
    return extension.build_zip(sys.executable, tmp_path_factory.mktemp("zip"))
