"""The serial line, on pseudo-terminals: opened by one, never waiting, lost in one way."""

import os
import pty
import re
import select
import tty
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from core.device.serial_line import LineLost, SerialLine, open_line, ports
from core.errors import DimpleError


@pytest.fixture
def ends() -> Iterator[tuple[int, str]]:
    """Return a device's end of a line, and the name of the other."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    name = os.ttyname(slave)
    os.close(slave)
    yield master, name
    try:
        os.close(master)
    except OSError:
        pass  # unplugged by the test


@pytest.fixture
def link(ends: tuple[int, str]) -> Iterator[SerialLine]:
    made = open_line(ends[1], 921600)
    yield made
    made.close()


def test_bytes_go_both_ways_unaltered(ends: tuple[int, str], link: SerialLine) -> None:
    """All 256 of them: no line discipline in between."""
    everything = bytes(range(256))
    assert link.read() == b""
    assert link.write(everything)
    assert os.read(ends[0], 1000) == everything
    os.write(ends[0], everything)
    assert link.wait(1.0)
    assert link.read() == everything
    assert not link.wait(0.0)


def test_a_second_opener_is_refused_with_the_reason(ends: tuple[int, str], link: SerialLine) -> None:
    with pytest.raises(DimpleError, match=f"{re.escape(ends[1])} is in use by another program"):
        open_line(ends[1], 921600)
    assert link.write(b"still here")
    link.close()
    open_line(ends[1], 921600).close()


@pytest.mark.parametrize("read", [True, False], ids=["by reading", "by writing"])
def test_an_unplugged_port_is_lost_within_a_tenth_of_a_second(
    ends: tuple[int, str], link: SerialLine, read: bool
) -> None:
    os.close(ends[0])
    with pytest.raises(LineLost, match="lost .* arm again"):
        for _ in range(10):  # looks, not seconds: a busy machine's own gaps do not count
            if read:
                link.wait(0.01)
                link.read()
            else:
                link.write(b"x")
    with pytest.raises(LineLost):
        link.read()
    link.close()


def test_a_closed_port_is_lost_too(link: SerialLine) -> None:
    """Closed under its reader: pyserial raises TypeError there."""
    link.close()
    for act in (link.read, lambda: link.write(b"x"), lambda: link.wait(0.01)):
        with pytest.raises(LineLost):
            act()
    link.close()


def test_a_line_that_is_never_read_takes_no_time_and_reports_it(ends: tuple[int, str], link: SerialLine) -> None:
    """pyserial alone would spin for ever here."""
    assert not all(link.write(b"\x55" * 32) for _ in range(20_000))
    assert not link.write(b"more")
    while select.select([ends[0]], [], [], 0.1)[0]:
        os.read(ends[0], 65536)
    assert link.write(b"again")


def test_reading_and_writing_ask_the_terminal_nothing(
    ends: tuple[int, str], link: SerialLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A question waits for the system's worker that brings the bytes (arrivals): 1 to 4 ms between State and answer."""
    os.write(ends[0], b"state")
    assert link.wait(1.0)
    monkeypatch.setattr(select, "select", lambda *_: pytest.fail("asked"))
    assert link.read() == b"state" and link.write(b"answer")


def test_what_is_no_port_is_named(tmp_path: Path) -> None:
    with pytest.raises(DimpleError, match="no port /dev/ttyNothing0"):
        open_line("/dev/ttyNothing0", 921600)
    (tmp_path / "file").touch()
    with pytest.raises(DimpleError, match="not a serial port"):
        open_line(str(tmp_path / "file"), 921600)


def test_the_list_of_ports_is_paths_and_descriptions_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    from serial.tools import list_ports

    found = [SimpleNamespace(device=f"/dev/ttyUSB{i}", description=f"Adapter {i}") for i in (1, 0)]
    monkeypatch.setattr(list_ports, "comports", lambda: found)
    assert ports() == [("/dev/ttyUSB0", "Adapter 0"), ("/dev/ttyUSB1", "Adapter 1")]
