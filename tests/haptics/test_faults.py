"""The table of faults, row by row, on the device's side and on a clock that is handed in."""

from __future__ import annotations

import math

import pytest

from core.device import wire
from core.errors import DimpleError
from studies.bench.command import measured
from studies.bench.faults import FAULTS, FOREVER, InjectedFault, parse_fault
from studies.bench.faulty_emulator import FaultyEmulator
from studies.bench.numbers import load_emulated
from tests.haptics.bit_errors import lost_share
from tests.haptics.host import Table
from tests.haptics.test_firmware import BRAKE_NOISE, CONVERTERS, sizes, up


def taken(table: Table) -> wire.Command:
    """Return the Command that acts on the device."""
    command = table.device.firmware._command
    assert command is not None
    return command


def lost(table: Table) -> tuple[int, int]:
    """Return how many Commands the device missed, and how many it took."""
    watch = table.device.firmware.link
    assert watch is not None
    return watch.lost, watch.taken


@pytest.mark.parametrize("rate", [1e-4, 1e-3])
def test_flipped_bits_never_make_a_torque_or_a_place(rate: float) -> None:
    """3 s of both ways: all that acts was sent, all that arrives was sent too; losses are those of the bits hit."""
    table = Table(up(3.0), f"flip={rate}@0.1").run(0.1)
    while table.now < 3.0:
        table.run(0.01)
        command = taken(table)
        assert command == table.host.sent[command.seq]
    missed, took = lost(table)
    expected = -math.expm1(8 * wire.size(wire.Command) * math.log1p(-rate))
    sigma = math.sqrt(expected * (1 - expected) / (missed + took))
    assert missed / (missed + took) == pytest.approx(expected, rel=0.10, abs=3 * sigma)
    watch = table.device.firmware.link
    assert watch is not None and len(table.host.states) < watch.ticks
    arrived = len(table.host.states) / watch.ticks
    assert 1 - arrived == pytest.approx(lost_share(rate), rel=0.10, abs=3 * sigma)
    assert max(sizes(table)) <= 3.0 + BRAKE_NOISE


def test_more_than_30_percent_lost_disarm() -> None:
    """2e-3 of the bits: 40 % of the Commands. At 1e-3, 23 %, the force goes on."""
    table = Table(up(3.0), "flip-in=2e-3@0.7").run(2.5)
    assert [fault.code for fault in table.host.faults][:1] == [wire.FAULT_LINK]
    assert table.modes().index(wire.FAULT) <= 2001  # within the second that shows it
    assert wire.FAULT not in Table(up(3.0), "flip-in=1e-3@0.7").run(2.5).modes()


@pytest.mark.parametrize("name", ["garbage", "truncate"])
def test_after_garbage_the_next_zero_is_a_new_beginning(name: str) -> None:
    """Each spoils the frame it meets, and at most the next."""
    table = Table(up(3.0), f"{name}=0.05@0.1").run(3.0)
    missed, took = lost(table)
    assert table.device.decoder.refused > 50
    assert 0 < missed <= 2 * 1.3 * 0.05 * (missed + took)  # 1.3: three sigma of 145 hits
    assert table.device.mode == wire.ARMED and taken(table) == table.host.sent[taken(table).seq]


def test_at_a_wrong_baud_rate_nothing_answers_and_no_torque_acts() -> None:
    table = Table(up(3.0), "wrong-baud")
    for _ in range(10):
        table._to_device += table.host.hello()
        table.run(0.1)
    assert table.host.info is None and table.host.states == []
    assert {max(sizes(table, i)) for i in range(3)} == {0.0}


def test_a_duplicate_is_dropped_and_counted() -> None:
    table = Table(up(3.0), "duplicate-in=1@0.7").run(1.7)
    watch = table.device.firmware.link
    assert watch is not None and watch.stale == pytest.approx(1000, abs=5)
    assert (watch.lost, table.device.mode) == (0, wire.ARMED)
    assert sizes(table)[-1] == pytest.approx(3.0, abs=0.1)


def test_a_reordered_command_is_dropped_and_counted_and_the_newest_acts() -> None:
    table = Table(up(3.0), "reorder-in=0.2@0.7").run(0.7)
    watch, newest = table.device.firmware.link, 0
    while table.now < 2.0:
        table.run(0.002)
        assert not wire.seq_newer(newest, taken(table).seq)  # never back
        newest = taken(table).seq
    assert watch is not None and 100 < watch.stale == pytest.approx(watch.lost, abs=2)
    assert table.device.mode == wire.ARMED


def test_of_a_stale_queue_only_what_answers_a_young_state_acts() -> None:
    """Everything from the host waits 60 ms, then comes as fast as the line goes.

    A Command takes 0.347 ms of it and a new one comes each millisecond: the queue is 60 / (1 - 0.347) = 92 long, and
    the last 5 / (1 - 0.347) = 8 answer States no older than 5 ticks.
    """
    table = Table(up(3.0), "stale-in@0.8+0.06").run(0.8)
    watch = table.device.firmware.link
    assert watch is not None
    before = watch.stale
    table.run(0.2)
    assert watch.stale - before == pytest.approx(92 - 8, abs=3)
    assert table.device.mode == wire.ARMED
    force = sizes(table)
    assert min(force[830:858]) <= BRAKE_NOISE * 3  # meanwhile the watchdog had braked
    assert force[-1] == pytest.approx(3.0, abs=0.1)


def test_answers_older_than_5_ticks_are_no_answers() -> None:
    """A host that is 8 ms late all the time: no force, then the watchdog."""
    table = Table(up(3.0), "slow-host=0.008@0.7").run(1.0)
    assert table.device.mode == wire.FAULT
    assert [fault.code for fault in table.host.faults][:1] == [wire.FAULT_WATCHDOG]
    late = Table(up(3.0), "slow-host=0.002@0.7").run(1.0)
    assert late.device.mode == wire.ARMED and sizes(late)[-1] == pytest.approx(3.0, abs=0.1)
    watch = late.device.firmware.link
    assert watch is not None and watch.rtts[-1] == pytest.approx(2e-3 + 738e-6, abs=3e-4)
    assert watch.answered - watch.in_time > 250  # counted as late


def test_states_after_the_host_has_hung_up_are_not_late_answers() -> None:
    table = Table(up(3.0)).run(0.8)
    before = measured(table.device)
    table.host.answers = False
    table.run(0.05)
    after = measured(table.device)
    assert after["ticks"] == pytest.approx(float(before["ticks"]) + 50, abs=2)
    assert after["late_share"] == pytest.approx(float(before["late_share"]), abs=0.005)


def test_an_unplugged_device_sends_nothing_more() -> None:
    table = Table(up(3.0), "unplug@0.7").run(1.0)
    n = len(table.host.states)
    assert table.device.unplugged and n == pytest.approx(698, abs=3)
    assert len(table.run(0.1).host.states) == n


def test_a_signal_amid_a_tick_still_ends_the_device() -> None:
    """The handler sets `unplugged` between any two steps of the interpreter: here while a fault is asked its time."""

    class Signal(InjectedFault):
        def acts(self, now: float) -> bool:
            device.unplugged = True
            return False

    device = FaultyEmulator(load_emulated(), faults=[Signal("unplug", 1.0)])
    device.step(0.0, b"")
    assert device.unplugged


def test_a_device_that_stalls_lets_go() -> None:
    """Its amplifiers want a pulse each tick. 30 ms later it goes on; after 200 ms the watchdog has latched."""
    table = Table(up(3.0), "stall@0.7+0.03").run(1.0)
    assert max(sizes(table)[700:730]) == 0.0 and table.device.mode == wire.ARMED
    table = Table(up(3.0), "stall@0.7+0.2").run(1.0)
    assert max(sizes(table)[700:900]) == 0.0 and table.device.mode == wire.FAULT


@pytest.mark.parametrize(("name", "found"), [("adc-range", 0), ("adc-jump", 0), ("adc-frozen", 50)])
@pytest.mark.parametrize("finger", [0, 2])
def test_a_sensor_that_lies_masks_its_finger_at_once_and_disarms_after_5_ticks(
    name: str, found: int, finger: int
) -> None:
    """found: ticks until it can be known; a reading without noise is known as frozen after 50."""
    table = Table(up(3.0), f"{name}={finger}@0.8").run(1.2)
    assert table.host.faults[0][1:3] == (wire.FAULT_SENSOR, finger)
    force, at = sizes(table, finger), 800 + found
    assert force[at - 2] == pytest.approx(3.0, abs=0.1)
    assert max(force[at + 1 :]) == 0.0  # within the tick
    assert table.modes().index(wire.FAULT) == pytest.approx(at + 4, abs=1)
    masked = [state.status >> 4 for state in table.host.states if state.status >> 4]
    assert set(masked) == {1 << finger}
    others = sizes(table, 1)
    assert others[at + 2] == pytest.approx(3.0, abs=0.1) and max(others[at + 30 :]) < 1.0  # then the brake


def test_a_short_disturbance_of_a_sensor_masks_and_passes() -> None:
    table = Table(up(3.0), "adc-range=1@0.8+0.003").run(1.0)
    assert table.device.mode == wire.ARMED and max(sizes(table, 1)[801:803]) == 0.0
    assert sizes(table, 1)[-1] == pytest.approx(3.0, abs=0.1)


def test_a_device_with_a_broken_sensor_is_not_armed() -> None:
    table = Table(up(3.0), "adc-range=1").run(0.8)
    assert {fault.code for fault in table.host.faults} == {wire.FAULT_SENSOR, wire.FAULT_ARM_REFUSED}
    assert wire.RAMP not in table.modes()


def test_words_of_full_scale_are_limited_like_any_others() -> None:
    """The largest words of the wire: 10 N, 1 N a millisecond later than the millisecond before."""
    table = Table().armed()
    at = len(table.trace)
    table.host.words = (32767, -32768, 32767) * 3  # type: ignore[assignment]
    table.run(0.05)
    force = sizes(table)[at:]
    assert max(force) <= 10.0 + CONVERTERS
    assert max(b - a for a, b in zip(force, force[1:], strict=False)) <= 1.0 + CONVERTERS


def test_faults_are_parsed_as_documented() -> None:
    assert parse_fault("flip=1e-3") == InjectedFault("flip", 1e-3)
    assert parse_fault("flip-in") == InjectedFault("flip", FAULTS["flip"][0], way="in")
    assert parse_fault("adc-range=2@0.5+0.25") == InjectedFault("adc-range", 2.0, 0.5, 0.75)
    assert parse_fault("slow-host=0.01@1") == InjectedFault("delay", 0.01, 1.0, FOREVER, "in")
    assert all(parse_fault(name).name == name for name in FAULTS)
    for text in ("flup", "flip=x", "flip@x", "flip@-1", "flip=-1", "flip@1+0", "flip=nan", "unplug-in", ""):
        with pytest.raises(DimpleError, match="fault"):
            parse_fault(text)


def test_a_reader_that_begins_in_the_middle_gets_all_but_the_first() -> None:
    """The emulator's line cuts frames wherever time does."""
    table = Table(arms=False).run(0.1)
    assert table.host.decoder.refused == 0 and len(table.host.states) == pytest.approx(100, abs=3)
