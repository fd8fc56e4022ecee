"""The servo on an injected clock: what it answers, and what must end all force."""

import math
from dataclasses import replace

import pytest

from core.devices import wire
from core.devices.letters import Link
from core.devices.servo import Servo
from core.devices.spec import info, load_spec
from tests.devices.bench_device import SESSION, BenchDevice, disarmed, wall


def message(device: BenchDevice) -> str:
    return device.servo.report().message


def test_a_press_feels_the_wall_once_it_is_armed() -> None:
    """600 N/m, 5 mm: 3 N, within a converter's step (0.25 mm) of the way."""
    device = BenchDevice().pressing()
    assert device.forces[0] == pytest.approx((0, 0, 3.0), abs=600 * 0.25e-3)
    assert device.forces[1] == device.forces[2] == (0, 0, 0)


def test_before_the_first_state_no_fingertip_is_anywhere() -> None:
    """A session that put them at the origin would press there."""
    device = BenchDevice()
    assert all(tip.masked for tip in device.servo.report().tips)
    device.tick()
    assert not any(tip.masked for tip in device.servo.report().tips)


def test_every_state_is_answered_with_its_own_number() -> None:
    device = BenchDevice()
    device.tick(100)
    echoes = [frame.echo for frame in device.heard if isinstance(frame, wire.Command)]
    assert echoes == list(range(1, 101))


def test_nothing_acts_before_arming() -> None:
    device = BenchDevice(at=[(0.0, 0.0, -0.01)] * 3)
    device.feel(*[wall(device.now)] * 3)
    device.tick(1000)
    assert device.strongest == 0.0
    assert not any(f.flags & wire.ENABLE for f in device.heard if isinstance(f, wire.Command))


def test_arming_in_the_middle_of_an_object_waits() -> None:
    device = BenchDevice(at=[(0.0, 0.0, -0.01)] * 3)
    device.feel(*[wall(device.now)] * 3)
    device.armed()
    assert device.strongest == 0.0 and device.servo.report().arming.name == "WAITING"


def test_only_the_newest_of_several_states_acts() -> None:
    device = BenchDevice().pressing()
    states = []
    for depth in (0.004, 0.003, 0.006):
        device.at[0] = (0.0, 0.0, -depth)
        device.now += 1e-3
        states.append(device.state())
    device.heard.clear()
    device.say(b"".join(map(wire.encode, states)))
    assert [frame.echo for frame in device.heard if isinstance(frame, wire.Command)] == [states[-1].seq]


def test_duplicated_reordered_and_stale_states_are_dropped_and_counted() -> None:
    device = BenchDevice()
    device.tick(10)
    old = device.state()
    device.tick(10)
    device.heard.clear()
    for state in (old, old):
        device.say(wire.encode(state))
    assert device.heard == [] and device.servo.report().stale == 2


def test_a_state_of_another_session_is_nobodys() -> None:
    device = BenchDevice()
    device.tick(10)
    device.heard.clear()
    device.say(wire.encode(device.state()._replace(session=SESSION + 1)))
    assert device.heard == []


def test_missing_states_are_counted() -> None:
    device = BenchDevice()
    device.tick(10)
    device.seq += 5
    device.tick(10)
    assert device.servo.report().lost == 5


def test_without_a_state_the_force_is_gone_after_5_ms_and_the_device_lost_after_100_ms() -> None:
    device = BenchDevice().pressing()
    assert device.strongest > 1
    device.pause(0.004)
    assert device.strongest > 1
    device.pause(0.003)
    assert device.strongest == 0.0 and device.servo.link is Link.READY
    device.pause(0.1)
    assert device.servo.link is Link.LOST and disarmed(device) and "lost" in message(device)


def test_a_lost_device_that_comes_back_needs_a_new_arm() -> None:
    device = BenchDevice().pressing()
    device.pause(0.5)
    device.say(wire.encode(info(device.spec, 5, SESSION)))
    device.mode = wire.IDLE
    device.at[0] = (0.0, 0.0, 0.01)
    device.tick(1000)
    assert device.servo.link is Link.READY and disarmed(device)
    assert device.armed().servo.report().arming.name == "ON"


def test_a_frozen_simulation_fades_out_between_100_and_200_ms() -> None:
    device = BenchDevice().pressing()
    device.fresh = False
    device.tick(80)
    whole = device.strongest
    assert whole == pytest.approx(3.0, abs=0.15)
    device.tick(70)
    assert 0.2 * whole < device.strongest < 0.9 * whole
    device.tick(60)
    assert device.strongest == 0.0 and device.servo.report().arming.name == "ON"


@pytest.mark.parametrize("bad", [{"force": (math.nan, 0, 0)}, {"k_n": math.inf}, {"at": (0, 0, -math.inf)}])
def test_contacts_that_are_not_numbers_are_never_felt_and_three_in_a_row_disarm(bad: dict[str, object]) -> None:
    device = BenchDevice().pressing()
    device.fresh = False
    for i in range(3):
        assert device.servo.report().arming.name == "ON"
        device.feel(replace(wall(device.now), **bad))
        device.tick(5)
        words = [frame.torque for frame in device.heard if isinstance(frame, wire.Command)]
        assert max(map(abs, words[-1])) <= max(map(abs, words[-6])), i
    assert disarmed(device) and "not numbers" in message(device)


@pytest.mark.parametrize("huge", [{"force": (0, 0, 999.0)}, {"k_n": 1e6, "force": (0, 0, 900.0)}])
def test_a_huge_contact_is_never_on_the_wire(huge: dict[str, object]) -> None:
    device = BenchDevice().pressing()
    before = device.strongest
    for _ in range(20):
        device.feel(replace(wall(device.now), **huge))
        device.fresh = False
        device.tick()
        assert device.strongest <= before + 1.05  # 1 N a millisecond, and a step of the DAC
        before = device.strongest
        assert before <= device.spec.peak_force * 1.01


def test_a_fingertip_that_runs_away_disarms() -> None:
    device = BenchDevice().pressing()
    for _ in range(60):
        x, y, z = device.at[0]
        device.at[0] = (x, y, z + 2e-3)
        device.tick()
    assert disarmed(device) and "1.5 m/s" in message(device)


@pytest.mark.parametrize("words", [(0, 0, 0), (0xFFF0, 32768, 32768), (65535, 65535, 65535)])
def test_a_sensor_at_its_rail_masks_its_finger_at_once_and_disarms_after_5_readings(words: tuple[int, ...]) -> None:
    device = BenchDevice().pressing()
    device.adc = (*words, *device.state_words(1), *device.state_words(2))
    device.tick()
    assert device.strongest == 0.0 and device.servo.report().tips[0].masked
    device.tick(5)
    assert disarmed(device) and "sensor" in message(device)


def test_a_sensor_that_jumps_masks_its_finger_and_disarms() -> None:
    device = BenchDevice().pressing()
    q0, *rest = device.state_words(0)
    device.adc = (q0 + 0x1000, *rest, *device.state_words(1), *device.state_words(2))
    device.tick()
    assert device.strongest == 0.0
    device.tick(5)
    assert disarmed(device) and "sensor" in message(device)


@pytest.mark.parametrize("hz", [250, 1000, 2000])
def test_a_turn_faster_than_any_hand_is_a_jump_at_every_rate(hz: int) -> None:
    """20 rad/s, 6 m/s at the tip: one a little slower is believed, one a little faster is not, and neither is a gap."""
    for missed, speed, believed in ((0, 19.0, True), (0, 22.0, False), (3, 19.0, True), (3, 22.0, False)):
        device = BenchDevice(spec=replace(load_spec(), tick_hz=hz))
        device.tick(2)
        q0, *rest = device.state_words(0)
        step = round(speed * (1 + missed) / hz / device.spec.adc_span * 65536)
        device.adc = (q0 + step, *rest, *device.state_words(1), *device.state_words(2))
        device.seq += missed
        device.tick()
        assert device.servo.report().tips[0].masked != believed


def test_a_finger_that_the_device_masks_feels_nothing() -> None:
    device = BenchDevice().pressing()
    device.masked = wire.MASKED << 0
    device.tick()
    assert device.strongest == 0.0


@pytest.mark.parametrize("code", [wire.FAULT_WATCHDOG, wire.FAULT_SENSOR, wire.FAULT_SPEED])
def test_a_fault_of_the_device_disarms_and_says_which(code: int) -> None:
    device = BenchDevice().pressing()
    device.mode = wire.FAULT
    device.say(wire.encode(wire.Fault(SESSION, code, 0, device.seq)))
    device.tick(100)
    assert disarmed(device) and message(device)
    device.at[0] = (0.0, 0.0, 0.01)
    device.tick(100)
    device.armed()  # which clears the fault
    assert device.servo.report().arming.name == "ON"


def test_a_request_to_disarm_takes_the_force_away_at_once() -> None:
    device = BenchDevice().pressing()
    device.servo.order = replace(device.servo.order, disarm=1)
    device.tick()
    assert disarmed(device)
    assert any(isinstance(frame, wire.Disarm) for frame in device.heard)


def test_the_last_words_are_no_force_and_disarm() -> None:
    device = BenchDevice().pressing()
    frames = wire.Decoder().feed(device.servo.close())
    assert [type(frame) for frame in frames] == [wire.Command, wire.Disarm]
    assert frames[0].torque == wire.NO_TORQUE


def test_a_loss_of_more_than_5_percent_warns_and_of_more_than_30_disarms() -> None:
    device = BenchDevice().armed()
    for i in range(1000):
        device.seq += i % 10 == 0
        device.tick()
    assert "lost" in message(device) and device.servo.report().arming.name == "ON"
    for _ in range(1000):
        device.seq += 1
        device.tick()
    assert disarmed(device) and "frames" in message(device)


def test_nobody_on_the_line_is_said_within_a_second_and_no_torque_was_ever_sent() -> None:
    servo, out = Servo(load_spec()), b""
    for i in range(1100):
        out += servo.step(50 + i * 1e-3, bytes([i % 251] * 7))  # a wrong baud rate is noise
    assert servo.link is Link.REFUSED and "baud" in servo.report().message
    assert {type(frame) for frame in wire.Decoder().feed(out)} == {wire.Hello}


def test_another_protocol_is_refused_naming_both() -> None:
    servo = Servo(load_spec(), nonce=5)
    servo.step(0.0, b"")
    assert servo.step(0.01, wire.encode(info(load_spec(), 5, SESSION, (2, 3)))) == b""
    assert servo.link is Link.REFUSED
    assert "2.3" in servo.report().message and "1.0" in servo.report().message


def test_an_answer_to_somebody_elses_hello_is_not_ours() -> None:
    servo = Servo(load_spec(), nonce=5)
    servo.step(0.0, b"")
    servo.step(0.01, wire.encode(info(load_spec(), 6, SESSION)))
    assert servo.link is Link.OPENING


def delayed(device: BenchDevice, p99_us: int) -> float:
    """Let the device measure a delay; return the largest stiffness from then on [N/m]."""
    device.say(wire.encode(wire.Report(SESSION, 0, 1000, 1000, 0, 900, p99_us, 5000, 738, 0, 0, 0)))
    device.tick(16)
    return device.servo.report().cap


def test_the_cap_follows_the_measured_delay_in_whole_ticks() -> None:
    device = BenchDevice()
    device.feel(wall(device.now))
    for p99_us, ticks in ((900, 1), (1500, 2), (2001, 3)):
        assert delayed(device, p99_us) == pytest.approx(0.8 * 2.0 / (0.5e-3 + ticks * 1e-3))


def test_the_cap_never_rises_under_a_pressed_finger() -> None:
    device = BenchDevice().pressing()
    low = delayed(device, 3500)
    assert low < 640 and delayed(device, 900) == low
    for i in range(100):
        device.at[0] = (0.0, 0.0, -0.005 + i * 1e-4)
        device.tick()
    assert delayed(device, 900) > 1000


def test_garbage_never_raises_and_never_moves_a_motor() -> None:
    import random

    dice = random.Random(1)
    device = BenchDevice()
    for _ in range(2000):
        device.now += 1e-3
        device.say(dice.randbytes(dice.randrange(80)))
    assert device.strongest == 0.0


def test_after_a_gap_of_5_s_there_is_no_force_and_a_new_arm_is_needed() -> None:
    """The host was suspended, the device went on; and the device stood still, the host went on."""
    for here, there in ((5.0, 5.0), (5.0, 0.0), (0.0, 5.0)):
        device = BenchDevice().pressing()
        device.now += here
        late = device.state()
        device.say(wire.encode(late._replace(t_us=late.t_us + round(1e6 * (there - here)) & 0xFFFFFFFF)))
        assert disarmed(device), (here, there)
        assert "stood still" in message(device)
        device.tick(200)
        assert disarmed(device)


@pytest.mark.parametrize("shift", [-1_000_000, -1, 0])
def test_a_device_whose_clock_does_not_go_on_is_disarmed(shift: int) -> None:
    """With no time between two STATEs force could not fall, nor a fingertip run away."""
    device = BenchDevice().pressing()
    last = device.servo._state
    assert last
    device.now += 1e-3
    device.say(wire.encode(device.state()._replace(t_us=last.t_us + shift & 0xFFFFFFFF)))
    assert disarmed(device) and "clock" in message(device)


@pytest.mark.parametrize("jump", [-10.0, -0.05, -0.002, 0.002, 0.05, 10.0])
@pytest.mark.parametrize("back", [True, False], ids=["and back", "for good"])
def test_a_host_clock_that_jumps_never_breaks_a_limit(jump: float, back: bool) -> None:
    """The device's own clock goes on."""
    device, shift = BenchDevice().pressing(), 0.0
    for i in range(100):
        before = device.strongest
        device.now += 1e-3
        data = wire.encode(device.state())
        shift = jump if i == 10 or (i > 10 and not back) else 0.0
        device.now += shift
        device.say(data)
        device.now -= shift
        assert device.strongest <= before + 1.05
        assert device.strongest <= 3.3  # the wall's 3 N
    assert disarmed(device) or jump < 10.0


def test_a_device_that_answers_but_streams_nothing_is_refused() -> None:
    device = BenchDevice()
    device.pause(0.9)
    assert device.servo.link is Link.READY
    device.pause(0.2)
    assert device.servo.link is Link.REFUSED and "streams no positions" in message(device)
    assert device.strongest == 0.0


def test_megabytes_of_noise_without_an_end_are_forgotten_and_what_follows_is_heard() -> None:
    device = BenchDevice()
    for _ in range(20):
        device.say(b"\x55" * 100_000)
    assert len(device.servo._decoder._rest) < 64
    device.say(b"\0")
    device.heard.clear()
    device.tick()
    assert [type(frame) for frame in device.heard] == [wire.Command]
