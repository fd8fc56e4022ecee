"""The native core under test: the one `python3 dev.py native` compiled, or the file DIMPLE_LIBRARY names."""

import os
from pathlib import Path

import pytest

from core import native


@pytest.fixture(scope="session", autouse=True)
def _library() -> None:
    named = os.environ.get("DIMPLE_LIBRARY")
    if named:
        native._loaded.append(native.load(Path(named)))
