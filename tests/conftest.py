"""What every test may ask for. Blender's own fixtures are in tests/blender/conftest.py."""

import sys
from pathlib import Path

import pytest

from tools import extension

BLENDER_TESTS = Path(__file__).parent / "blender"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if len({BLENDER_TESTS in item.path.parents for item in items}) == 2:
        raise pytest.UsageError(
            "core and the installed extension are the same modules under two names and never mix in one "
            "process: run `python3 dev.py test`, or tests/blender by itself"
        )


@pytest.fixture(scope="session")
def extension_zip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the zip that Blender installs."""
    return extension.build_zip(sys.executable, tmp_path_factory.mktemp("zip"))
