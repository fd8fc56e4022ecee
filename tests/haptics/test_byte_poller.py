"""What waits for bytes: pipes and terminals alike."""

import os
import pty
import tty

import pytest

from core.device.serial_line import EDGE_TRIGGERED, Poller


@pytest.mark.parametrize("edges", [EDGE_TRIGGERED, False], ids=["epoll", "select"])
def test_each_end_is_named_when_something_came_there(edges: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """On Linux, and where the system has no epoll."""
    monkeypatch.setattr("core.device.serial_line.EDGE_TRIGGERED", edges)
    (here, there), (here2, there2) = os.pipe(), os.pipe()
    arrivals = Poller(here, here2)
    assert arrivals.wait(0.0) == []
    os.write(there, b"a")
    assert arrivals.wait(1.0) == [here] and os.read(here, 10) == b"a"
    os.write(there, b"a")
    os.close(there2)
    assert sorted(arrivals.wait(1.0)) == sorted((here, here2)) and os.read(here2, 10) == b""
    for end in (here, there, here2):
        os.close(end)


@pytest.mark.skipif(not EDGE_TRIGGERED, reason="only Linux has a worker that one would wait for")
def test_a_terminal_is_reported_once_for_all_that_came() -> None:
    """Left unread it is not named again, which asking would do; the next bytes are."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    arrivals = Poller(slave)
    os.write(master, b"a")
    assert arrivals.wait(1.0) == [slave] and arrivals.wait(0.01) == []
    os.write(master, b"b")
    assert arrivals.wait(1.0) == [slave] and os.read(slave, 10) == b"ab"
    os.close(master)
    assert arrivals.wait(1.0) == [slave]  # it is gone
    os.close(slave)
