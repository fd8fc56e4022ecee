"""What keeps the hand safe on the device's side, whatever the host does. All on a clock that is handed in."""

from __future__ import annotations

import math
import random

import pytest

from core.device import wire
from core.vectors import ZERO
from studies.bench.hand import EmulatedHand
from studies.bench.round_trips import RoundTrips, percentiles
from tests.haptics.host import HELD, SPEC, Host, Table
from tests.haptics.test_motors import hottest, rise

# [N] what the converters add to a force: half a step of the motors' (0.02 N) and of the sensors' at 10 N (0.03 N)
CONVERTERS = 0.05
# [N] the brake's noise at rest: 5 N s/m times the converter's 0.09 mm over the 5 ms of the speed's filter, three sigma
BRAKE_NOISE = 0.3


def up(newtons: float, start: float = 0.1) -> object:
    """Return a host's force: straight up, from a time on."""
    return lambda finger, time: (0.0, 0.0, newtons if time >= start else 0.0)


def sizes(table: Table, finger: int = 0) -> list[float]:
    return [math.hypot(*force) for force in table.forces(finger)]


def test_no_force_acts_before_arm() -> None:
    """Every motor word at full scale, ENABLE and DEADMAN held, for a second: nothing."""
    table = Table(arms=False)
    table.host.words = (32767,) * 9
    table.run(1.0)
    assert len(table.host.states) > 990
    assert {max(sizes(table, i)) for i in range(3)} == {0.0}


def test_arming_waits_for_50_ms_without_force_then_ramps_for_half_a_second() -> None:
    table = Table(up(3.0)).armed()
    modes = table.modes()
    arming, ramp, armed = (modes.index(mode) for mode in (wire.ARMING, wire.RAMP, wire.ARMED))
    assert 50 <= ramp - arming <= 53 and armed - ramp == 500
    force = sizes(table)
    assert max(force[:ramp]) == 0.0
    for i in range(ramp, armed):  # never more than the ramp lets through, but for the damping of the hand's own motion
        assert force[i] <= 3.0 * (i - ramp) / 500 + BRAKE_NOISE
    assert force[armed + 1] == pytest.approx(3.0, abs=0.1)


def test_a_host_that_pushes_is_not_armed() -> None:
    """0.21 N asked of one finger: refused after a second, with a FAULT."""
    table = Table(lambda finger, time: (0.21 if finger == 2 else 0.0, 0.0, 0.0)).run(1.2)
    assert table.device.mode == wire.IDLE
    assert [fault.code for fault in table.host.faults] == [wire.FAULT_ARM_REFUSED]
    assert max(sizes(table, 2)) == 0.0
    assert Table(lambda finger, time: (0.19, 0.0, 0.0)).run(0.2).device.mode == wire.RAMP


def test_a_host_that_falls_silent_is_not_armed() -> None:
    table = Table().run(0.02)
    table.host.answers = False
    table.run(0.2)
    assert wire.RAMP not in table.modes()


def test_lost_commands_hold_5_ms_fall_to_zero_by_25_ms_brake_and_latch_after_100_ms() -> None:
    """The host stalls, or is killed, during a press of 3 N."""
    table = Table(up(3.0)).armed()
    table.host.answers = False
    last = len(table.trace)
    table.run(0.3)
    force = sizes(table)[last:]
    assert min(force[:5]) == pytest.approx(3.0, abs=CONVERTERS)
    for ms in range(6, 25):  # linear; the last Command came within the tick before
        assert force[ms] == pytest.approx(3.0 * (25 - ms) / 20, abs=0.2)
    for ms in range(25, 300):  # from now on only a brake: against the motion, never along it
        (x0, y0, z0), (x1, y1, z1) = table.trace[last + ms - 1][2:5], table.trace[last + ms][2:5]
        fx, fy, fz = table.forces()[last + ms]
        power = (fx * (x1 - x0) + fy * (y1 - y0) + fz * (z1 - z0)) / SPEC.tick
        assert power <= 1e-3  # [W] of the noise
    assert max(force[200:]) < BRAKE_NOISE
    modes = table.modes()[last:]
    assert modes.index(wire.FAULT) == pytest.approx(100, abs=1)
    assert {state.status & wire.MODE for state in table.host.states[-250:-205]} == {wire.BRAKE}
    table.run(0.02)
    assert [fault.code for fault in table.host.faults] == [wire.FAULT_WATCHDOG] * 3  # at once, then each 100 ms


def test_a_latched_fault_needs_a_clear_and_a_new_arm() -> None:
    table = Table(up(3.0)).armed()
    table.host.answers = False
    table.run(0.15)
    table.host.answers = True
    table.run(0.3)
    assert table.device.mode == wire.FAULT  # the host is back: still no force
    table.send(wire.Arm(table.session)).run(0.1)
    assert table.device.mode == wire.FAULT and table.host.faults[-1].code in (
        wire.FAULT_ARM_REFUSED,
        wire.FAULT_WATCHDOG,
    )
    table.host.flags |= wire.CLEAR
    table.run(0.05)
    assert table.device.mode == wire.FAULT  # a CLEAR with force in it is none
    table.host.force, table.host.flags = lambda finger, time: ZERO, HELD
    table.run(0.05)
    assert table.device.mode == wire.FAULT  # nor is no force without it
    table.host.flags |= wire.CLEAR
    table.run(0.05)
    assert table.device.mode == wire.IDLE
    table.send(wire.Arm(table.session)).run(0.6)
    assert table.device.mode == wire.ARMED


def test_commands_that_come_back_in_time_go_on() -> None:
    """60 ms are braked, not latched; the force comes back no faster than 1 N a millisecond."""
    table = Table(up(3.0)).armed()
    table.host.answers = False
    table.run(0.06)
    table.host.answers = True
    back = len(table.trace)
    table.run(0.05)
    assert table.device.mode == wire.ARMED
    force = sizes(table)[back:]
    assert force[-1] == pytest.approx(3.0, abs=CONVERTERS)
    assert max(b - a for a, b in zip(force, force[1:], strict=False)) <= 1.0 + CONVERTERS


def test_a_command_holds_no_longer_than_its_time_to_live() -> None:
    motions = []
    for ttl in (5, 1):
        table = Table(up(3.0)).armed()
        answer = table.host.answer
        table.host.answer = lambda state, now, answer=answer, ttl=ttl: shorter(answer(state, now), ttl)  # type: ignore
        table.run(0.01)
        table.host.answers = False
        last = len(table.trace)
        motions.append(sizes(table.run(0.03))[last:])
    assert motions[0][4] == pytest.approx(3.0, abs=CONVERTERS)
    assert motions[1][4] == pytest.approx(3.0 * 21 / 24, abs=0.2)


def shorter(code: bytes, ttl: int) -> bytes:
    (command,) = wire.Decoder().feed(code)
    return wire.encode(command._replace(ttl_ms=ttl))  # type: ignore[union-attr]


def test_the_dead_man_switch_ends_force_at_once_and_the_ramp_begins_anew() -> None:
    for held in (wire.ENABLE, wire.DEADMAN, 0):
        table = Table(up(3.0)).armed()
        table.host.flags = held
        at = len(table.trace)
        table.run(0.1)
        assert max(sizes(table)[at + 2 :]) == 0.0
        table.host.flags = HELD
        at = len(table.trace)
        table.run(0.25)
        assert table.device.mode == wire.RAMP
        assert max(sizes(table)[at:]) <= 1.5 + BRAKE_NOISE
        table.run(0.3)
        assert table.device.mode == wire.ARMED


def test_disarm_ends_force_at_once() -> None:
    table = Table(up(3.0)).armed()
    table.send(wire.Disarm(table.session, wire.FAULT_HOST))
    at = len(table.trace)
    table.run(0.3)
    assert max(sizes(table)[at + 2 :]) == 0.0 and table.device.mode == wire.IDLE


@pytest.mark.parametrize("seconds", [3, pytest.param(12, marks=pytest.mark.slow)])
def test_no_command_whatever_exceeds_peak_slew_or_heat(seconds: int) -> None:
    """Random words of full scale: 10 N, 1 N/ms and, in the long run, 4 N over any 10 s are never exceeded."""
    dice = random.Random(3)
    table = Table(hand=EmulatedHand(stiffness=3000.0, damping=40.0)).armed()
    since = len(table.trace)
    for _ in range(5 * seconds):
        table.host.words = tuple(dice.choice((-32768, 32767, dice.randint(-9000, 9000))) for _ in range(9))  # type: ignore
        table.run(0.2)
    assert table.device.mode == wire.ARMED
    for finger in range(3):
        forces = table.forces(finger)[since:]
        assert max(math.hypot(*force) for force in forces) <= SPEC.peak_force + CONVERTERS
        assert max(map(rise, forces, forces[1:])) <= 1.0 + 2 * CONVERTERS
        assert hottest(forces, 10.0) <= SPEC.continuous_force + CONVERTERS
        assert max(math.hypot(*force) for force in forces) > 9.0  # it did push
    assert any(state.status & wire.LIMITED for state in table.host.states)


def test_a_tip_that_runs_away_is_braked_at_once_and_latched_after_5_ticks() -> None:
    """A hand that lets go of a push of 10 N: 0.12 kg reach 1.5 m/s in some 20 ms."""
    keys = ((0.0, 0.0, 0.0, -0.2), (1.0, 0.0, 0.0, -0.2))
    table = Table(up(10.0, 0.62), hand=EmulatedHand(tips=(keys,) * 3, stiffness=0.0, damping=0.0)).armed()
    table.run(0.2)
    assert [fault.code for fault in table.host.faults][:1] == [wire.FAULT_SPEED]
    heights = [row[4] for row in table.trace]
    speeds = [(b - a) / SPEC.tick for a, b in zip(heights, heights[1:], strict=False)]
    over = next(i for i, speed in enumerate(speeds) if speed > SPEC.tip_speed)
    # the speed is known 5 ms late, while 10 N still push: 0.4 m/s more, and 10 ms of slew
    assert max(speeds) < SPEC.tip_speed + 1.0
    latched = table.modes().index(wire.FAULT)
    assert latched - over <= 5 + 5 + 5
    assert sizes(table)[latched] <= 10.0 - 4.0  # the brake did not wait: 1 N a millisecond
    assert abs(speeds[-1]) < 0.1  # and it came to rest


def test_another_major_protocol_is_refused_and_both_versions_are_named() -> None:
    table = Table(up(3.0), "version=3").run(0.1)
    assert table.host.info is not None and (table.host.info.major, wire.PROTOCOL[0]) == (3, 2)
    assert table.host.states == [] and max(sizes(table)) == 0.0
    table.send(wire.Arm(0)).send(wire.Arm(1)).run(0.1)
    assert table.device.mode == wire.IDLE


def test_a_new_session_is_disarmed_and_the_old_one_is_not_heard() -> None:
    table = Table(up(3.0)).armed()
    old = table.session
    host, table.host = table.host, Host(up(3.0), arms=False, nonce=2)  # type: ignore[arg-type]
    table._to_device = table.host.hello()
    at = len(table.trace)
    table.run(0.1)
    assert table.device.mode == wire.IDLE and max(sizes(table)[at + 2 :]) == 0.0
    assert table.session != old
    for _ in range(20):  # what the old host still has in its queue
        newest = table.host.states[-1]
        table._to_device += host.answer(newest._replace(session=old), table.now)
        table.send(wire.Arm(old)).run(0.01)
    assert table.device.mode == wire.IDLE and max(sizes(table)[at + 2 :]) == 0.0


def test_the_same_host_again_needs_a_new_arm_too() -> None:
    """With the nonce it had before: reconnecting never keeps the force."""
    table = Table(up(3.0)).armed()
    old, table.host.arms = table.session, False
    table._to_device += table.host.hello()
    table.run(0.1)
    assert table.device.mode == wire.IDLE and table.session != old


def test_hello_asked_twice_is_one_session() -> None:
    """A host that asks again before the answer is there must not lose its session."""
    table = Table()
    table._to_device += table.host.hello()
    table.run(0.05)
    session = table.session
    table.run(0.2)
    assert len(table.host.states) > 200 and table.device.mode == wire.RAMP and table.session == session


def test_a_device_without_a_host_is_silent() -> None:
    """Before a HELLO, and a second after the last frame: no port fills with unread STATEs."""
    table = Table(arms=False)
    table._to_device = b""
    table.run(0.2)
    assert table.host.states == []
    table._to_device = table.host.hello()
    table.run(0.1)
    table.host.answers = False
    table.run(2.0)
    assert len(table.host.states) == pytest.approx(1100, abs=5)


def test_the_round_trip_is_measured_on_the_device_s_clock() -> None:
    """Wire time 738 us, and the host's 0.1 ms step: what the device measures is their sum."""
    link = Table().armed().device.firmware.link
    assert link is not None
    assert 738e-6 <= percentiles(link.rtts)[0] <= 938e-6
    assert link.in_time == link.answered >= link.ticks - 12 and (link.stale, link.lost) == (0, 0)


def test_a_state_that_was_passed_over_has_waited_for_the_answer_to_the_next() -> None:
    """The host was kept from running for 2.4 ms, then answered the newest of three: an old force acted."""
    watch = RoundTrips(SPEC, 1)
    seqs = [watch.send(1e-3 * i) for i in range(3)]
    assert watch.take(wire.Command(1, 1, seqs[-1], wire.NO_FORCE, 0, 5), 2.4e-3)
    assert list(watch.rtts) == pytest.approx([2.4e-3, 1.4e-3, 0.4e-3])
    assert (watch.answered, watch.in_time) == (1, 1)
    assert not watch.take(wire.Command(1, 1, seqs[0], wire.NO_FORCE, 0, 5), 2.5e-3) and len(watch.rtts) == 3
