"""Devices as Blender opens them: a refusal gives its reason, and nothing is left behind."""

import os
import subprocess
import sys
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest

from core.base import DimpleError
from core.device import device as devices
from core.device import process as processes
from core.device.device import Device
from core.device.mailbox import Mailbox
from core.device.orders import LinkState
from core.device.process import python
from studies.bench import logged_servo
from studies.bench import processes as bench_processes
from studies.bench.processes import EmulatedDevice
from tests.haptics.machine import NEEDS_PTY
from tests.haptics.pressing import drive, gone, ready

pytestmark = NEEDS_PTY


@pytest.mark.parametrize(
    ("device", "which"), [(Device("/dev/null"), 0), (EmulatedDevice(), 0), (EmulatedDevice(), 1)]
)
def test_a_device_that_cannot_be_opened_leaves_nothing_behind(
    device: Device, which: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first process that is started cannot be, or the second: out of memory, for example."""
    started, folders, boxes = [], [], []
    monkeypatch.setattr(devices, "Mailbox", lambda: boxes.append(Mailbox()) or boxes[-1])
    monkeypatch.setattr(devices.tempfile, "mkdtemp", lambda **how: folders.append(mkdtemp(**how)) or folders[-1])

    def fails(words: list[str], errors: Any, **how: Any) -> Any:
        if len(started) == which:
            raise OSError(12, "Cannot allocate memory")
        started.append(processes.start(words, errors, **how))
        return started[-1]

    monkeypatch.setattr(devices, "start", fails)
    monkeypatch.setattr(bench_processes, "start", fails)
    with pytest.raises(DimpleError, match="cannot be opened: .*Cannot allocate"):
        device.open()
    assert len(started) == which and all(gone(process.pid) for process in started)
    assert not any(map(os.path.exists, [*folders, *(box.path for box in boxes)]))


def test_a_port_that_is_none_is_reported() -> None:
    device = Device("/")
    device.open()
    report = drive(device, ready)
    assert report.link is LinkState.REFUSED and "/ is not" in report.note
    device.close()


def test_a_log_that_cannot_be_written_is_reported(tmp_path: Path) -> None:
    with pytest.raises(DimpleError, match="log .* cannot be written"):
        logged_servo.write_log(tmp_path, [(0.0,)])


def test_a_port_that_is_not_there_is_reported(tmp_path: Path) -> None:
    device = Device(str(tmp_path / "nothing"))
    device.open()
    report = drive(device, ready)
    assert report.link is LinkState.REFUSED and "nothing" in report.note
    device.close()


def test_a_port_is_no_option_whatever_its_name() -> None:
    device = Device("-h")
    device.open()
    report = drive(device, ready)
    assert report.link is LinkState.REFUSED and "no port -h" in report.note
    device.close()


def test_an_emulated_device_opens_moves_and_leaves_nothing_behind() -> None:
    device = EmulatedDevice()
    device.open()
    assert device.process and device.emulator
    pids = device.process.pid, device.emulator.pid
    drive(device, ready)
    folder = Path(device.port).parent
    device.close()
    device.close()
    assert all(map(gone, pids)) and not folder.exists()


def test_a_python_is_found_where_sys_executable_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """So it is in some builds of Blender; and where it is Blender itself."""
    for executable in (None, "/opt/blender/blender"):
        monkeypatch.setattr(sys, "executable", executable)
        output = subprocess.run([python(), "-c", "print(6 * 7)"], capture_output=True, check=True).stdout
        assert output.strip() == b"42"


def test_without_any_python_it_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", None)
    monkeypatch.setattr(sys, "prefix", "/nowhere")
    with pytest.raises(DimpleError, match="Python was not found"):
        python()
