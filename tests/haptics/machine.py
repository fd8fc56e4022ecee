"""What a safety test needs of the computer that it runs on."""

import os
from typing import NoReturn

import pytest

IN_CI = bool(os.environ.get("CI"))
NEEDS_PTY = pytest.mark.skipif(
    not hasattr(os, "openpty") and not IN_CI, reason="the emulated device needs pseudo-terminals"
)

UNABLE = (pytest.skip.Exception, pytest.fail.Exception)


def unable(why: str) -> NoReturn:
    """Skip a test that this computer cannot run; in continuous integration fail: safety was not tested there."""
    if IN_CI:
        pytest.fail(f"{why}; in continuous integration this is a failure")
    pytest.skip(why)
