"""The emulator as a real process behind a real port: a short soak, and everything that dies.

Times here are those of a busy machine: bounds are wide, the figures are printed, the logic is tested elsewhere.
"""

from __future__ import annotations

import contextlib
import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from core.device import wire
from core.device.serial_line import LineLost, SerialLine, open_line
from core.errors import DimpleError
from tests.haptics.host import SPEC, Host, Presser
from tests.haptics.machine import NEEDS_PTY, unable
from tools.environment import ROOT

pytestmark = NEEDS_PTY
LIMIT = 20.0  # [s] no test takes longer
Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def port(tmp_path: Path) -> Path:
    return tmp_path / "haptic"


@pytest.fixture
def start(port: Path) -> Iterator[Start]:
    """Return what starts an emulator; at the end none is left."""
    started: list[subprocess.Popen[str]] = []

    def begin(*words: str | Path) -> subprocess.Popen[str]:
        (rest := port.with_name("rest.json")).write_text(json.dumps({"tips": [[[0.0, 0.0, 0.0, 0.0]]] * 3}))
        where = ["--pty", port, "--hand", rest, "--seconds", str(6 * LIMIT)]
        command = [sys.executable, "-m", "studies", "emulator", *where, *words]
        process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        started.append(process)
        assert process.stdout is not None and "emulated" in process.stdout.readline()
        return process

    yield begin
    for process in started:
        if process.poll() is None:
            process.kill()
        process.communicate()


def drive(link: SerialLine, host: Host, seconds: float = LIMIT, *, until: int | None = None, states: int = 1) -> None:
    """Run a host for a while, or until the device reports a mode and some STATEs have come."""
    begin = asked = time.monotonic()
    link.write(host.hello())
    while time.monotonic() - begin < seconds and (
        len(host.states) < states or (until is not None and host.states[-1].status & wire.MODE != until)
    ):
        if not host.states and time.monotonic() - asked > 0.2:
            asked = time.monotonic()
            link.write(host.hello())
        if link.wait(0.01):
            answer = host.step(time.monotonic() - begin, link.read())
            if answer:
                link.write(answer)


def arm(link: SerialLine, host: Host) -> None:
    """Let a host arm the device; a machine that loses more than one STATE of a hundred cannot run the test."""
    drive(link, host, 0.7 * LIMIT, until=wire.ARMED)
    if host.states[-1].status & wire.MODE != wire.ARMED:
        ticks = (host.states[-1].t_us - host.states[0].t_us) * 1e-6 / SPEC.tick
        assert len(host.states) < 0.99 * ticks, host.states[-1]
        unable(f"this machine cannot run a loop of 1 kHz: {len(host.states)} of {ticks:.0f} positions came")


def is_lost_within_100_ms(link: SerialLine) -> bool:
    """Tell whether ten looks of 10 ms see that a line is lost; looks, for a busy machine's own gaps do not count."""
    with contextlib.suppress(LineLost):
        for _ in range(10):
            link.wait(0.01)
            link.read()
            link.write(b"\0")
        return False
    return True


def end(process: subprocess.Popen[str]) -> None:
    process.terminate()
    process.communicate(timeout=LIMIT)
    assert process.returncode == 0


def test_soak(start: Start, port: Path, tmp_path: Path) -> None:
    """Some 3 s through the real driver: armed, pushing, no wrong frame, the port gone at the end."""
    process = start("--json", tmp_path / "device.json", "--trace", tmp_path / "trace.csv")
    link, host = open_line(str(port), SPEC.baud), Presser(2.0)
    arm(link, host)
    session = host.states[-1].session
    begin = time.monotonic()
    while time.monotonic() - begin < 2.0:
        if link.wait(0.01):
            link.write(host.step(time.monotonic() - begin, link.read()))
    end(process)
    link.close()
    record = json.loads((tmp_path / "device.json").read_text())
    print(record)
    assert len(host.states) > 500 and record["answered"] > 200  # 3000 on a quiet machine
    assert host.decoder.refused <= 2 * record["overflows"] and record["bad"] == 0
    assert all(a.t_us < b.t_us for a, b in zip(host.states, host.states[1:], strict=False))
    assert {state.session for state in host.states} == {session}
    assert wire.ARMED in {state.status & wire.MODE for state in host.states}
    rows = list(csv.DictReader((tmp_path / "trace.csv").open()))
    assert max(float(row["fz1_n"]) for row in rows) == pytest.approx(2.0, abs=0.3)
    assert not port.is_symlink()


def test_a_second_host_is_refused(start: Start, port: Path) -> None:
    start()
    link, host = open_line(str(port), SPEC.baud), Host(arms=False)
    with pytest.raises(DimpleError, match="in use by another program"):
        open_line(str(port), SPEC.baud)
    drive(link, host, states=50)  # the first goes on
    assert len(host.states) >= 50
    link.close()


@pytest.mark.parametrize("how", ["unplugged", "killed"])
def test_a_device_that_goes_away_is_lost_within_100_ms(start: Start, port: Path, how: str) -> None:
    process = start(*(["--fault", "unplug@1"] if how == "unplugged" else []))
    link, host = open_line(str(port), SPEC.baud), Host(arms=False)
    if how == "killed":
        drive(link, host, states=50)
        process.send_signal(signal.SIGKILL)
    else:
        with pytest.raises(LineLost):
            drive(link, host, states=100_000)
    process.wait(timeout=LIMIT)
    assert is_lost_within_100_ms(link)
    link.close()
    assert port.is_symlink() == (how == "killed")
    assert len(host.states) >= 50
    start()  # and the same path serves again
    drive(link := open_line(str(port), SPEC.baud), host := Host(arms=False), states=50)
    assert len(host.states) >= 50
    link.close()


HOST = """
import sys, time
sys.path.insert(0, {root!r})
from core.device.serial_line import open_line
from core.device import wire
from tests.haptics.host import SPEC, Presser
from tests.haptics.machine import UNABLE
from tests.haptics.test_pseudo_terminal import arm
link, host = open_line({port!r}, SPEC.baud), Presser(3.0)
try:
    arm(link, host)
except UNABLE as busy:
    print(busy, flush=True)
print(host.mode, flush=True)
begin = time.monotonic()
while time.monotonic() - begin < 20.0:
    if link.wait(0.01):
        link.write(host.step(time.monotonic() - begin, link.read()))
"""


def test_a_killed_host_leaves_no_force_no_arm_and_no_stuck_port(start: Start, port: Path, tmp_path: Path) -> None:
    """SIGKILL during a press of 3 N."""
    device = start("--trace", tmp_path / "trace.csv", "--json", tmp_path / "device.json")
    host = subprocess.Popen(
        [sys.executable, "-c", HOST.format(root=str(ROOT), port=str(port))], stdout=subprocess.PIPE, cwd=ROOT
    )
    try:
        assert host.stdout is not None
        line = host.stdout.readline()
        if line.startswith(b"this machine"):
            unable(line.decode().strip())
        assert line == b"%d\n" % wire.ARMED
        time.sleep(0.2)
    finally:
        host.send_signal(signal.SIGKILL)
        host.communicate(timeout=LIMIT)
    time.sleep(1.0)
    link, again = open_line(str(port), SPEC.baud), Host(arms=False, nonce=2)
    drive(link, again, states=50)
    assert {state.status & wire.MODE for state in again.states} == {wire.FAULT}  # until it is cleared
    link.close()
    end(device)
    assert json.loads((tmp_path / "device.json").read_text())["fault"] == wire.FAULT_WATCHDOG
    rows = list(csv.DictReader((tmp_path / "trace.csv").open()))
    modes = [int(float(row["mode"])) for row in rows]
    latched = max(i for i, mode in enumerate(modes) if mode == wire.FAULT and modes[i - 1] != wire.FAULT)
    up_force = [float(row["fz1_n"]) for row in rows]
    assert max(up_force[:latched]) == pytest.approx(3.0, abs=0.3)
    # latched 100 ms after the last Command: zero 75 ms before that, and only the brake since: it pushes nothing up
    # where the hand's spring pulls the tip down, but for the noise of its speed
    assert max(abs(float(row["fx1_n"])) for row in rows[latched - 73 :]) < 0.3
    assert max(abs(force) for force in up_force[latched + 100 :]) < 0.3


def test_sigint_ends_it_cleanly_and_a_taken_path_is_refused(start: Start, port: Path, tmp_path: Path) -> None:
    process = start("--json", tmp_path / "device.json")
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=LIMIT)
    assert process.returncode == 0 and not port.is_symlink()
    assert json.loads((tmp_path / "device.json").read_text())["mode"] == "idle"
    port.touch()
    words = [sys.executable, "-m", "studies", "emulator", "--pty", port]
    refused = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=LIMIT)
    assert refused.returncode == 2 and "exists already" in refused.stderr
    assert os.path.getsize(port) == 0


def test_an_emulator_never_takes_the_path_of_one_that_lives_and_always_of_one_that_was_killed(
    start: Start, port: Path
) -> None:
    """Not even when a terminal window was opened meanwhile, which gets the number of the dead one."""
    first = start()
    words = [sys.executable, "-m", "studies", "emulator", "--pty", port]
    refused = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=LIMIT)
    assert refused.returncode == 2 and "another emulator" in refused.stderr
    drive(link := open_line(str(port), SPEC.baud), host := Host(arms=False))
    assert host.states
    link.close()
    first.kill()
    first.wait()
    assert port.is_symlink()
    ends = [os.openpty() for _ in range(3)]
    with pytest.raises(DimpleError, match="no port"):
        open_line(str(port), SPEC.baud)
    start()
    drive(link := open_line(str(port), SPEC.baud), host := Host(arms=False, nonce=2))
    assert host.states
    link.close()
    for end_of in ends:
        for descriptor in end_of:
            os.close(descriptor)
