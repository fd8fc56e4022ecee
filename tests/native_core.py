"""What a test does where there is no native core: tests/blender may not import the one under core/."""

import os
from typing import NoReturn

import pytest

from tools import native


def missing(reason: str) -> NoReturn:
    """Skip a test; in CI, where there is a compiler, the core must be there."""
    if os.environ.get("CI") == "true" and (native.ZIG / "ziglang").exists():
        pytest.fail(f"{reason}, though its compiler is in {native.ZIG.name}")
    pytest.skip(reason)
