"""The servo's end of the line on an injected clock: what it answers, and what it makes of lost and wrong bytes."""

import random

import pytest

from core.device import wire
from core.device.orders import LinkState
from core.device.servo import Servo
from core.device.spec import Spec
from studies.bench.numbers import info
from tests.haptics.bench_device import SESSION, BenchDevice, disarmed, note


def test_every_state_is_answered_with_its_own_number() -> None:
    device = BenchDevice()
    device.tick(100)
    echoes = [frame.echo for frame in device.heard if isinstance(frame, wire.Command)]
    assert echoes == list(range(1, 101))


def test_only_the_newest_of_several_states_acts() -> None:
    device = BenchDevice().pressing()
    states = []
    for depth in (0.004, 0.003, 0.006):
        device.at[0] = (0.0, 0.0, -depth)
        device.now += 1e-3
        states.append(device.state())
    device.heard.clear()
    device.exchange(b"".join(map(wire.encode, states)))
    assert [frame.echo for frame in device.heard if isinstance(frame, wire.Command)] == [states[-1].seq]


def test_duplicated_reordered_and_stale_states_are_dropped_and_counted() -> None:
    device = BenchDevice()
    device.tick(10)
    old = device.state()
    device.tick(10)
    device.heard.clear()
    for state in (old, old):
        device.exchange(wire.encode(state))
    assert device.heard == [] and device.servo.report().stale == 2


def test_a_state_of_another_session_is_dropped() -> None:
    device = BenchDevice()
    device.tick(10)
    device.heard.clear()
    device.exchange(wire.encode(device.state()._replace(session=SESSION + 1)))
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
    assert device.strongest == 0.0 and device.servo.link is LinkState.READY
    device.pause(0.1)
    assert device.servo.link is LinkState.LOST and disarmed(device) and "lost" in note(device)


def test_a_lost_device_that_comes_back_needs_a_new_arm() -> None:
    device = BenchDevice().pressing()
    device.pause(0.5)
    device.exchange(wire.encode(info(device.spec, 5, SESSION)))
    device.mode = wire.IDLE
    device.at[0] = (0.0, 0.0, 0.01)
    device.tick(1000)
    assert device.servo.link is LinkState.READY and disarmed(device)
    assert device.armed().servo.report().arming.name == "ON"


def test_the_last_words_are_no_force_and_disarm() -> None:
    device = BenchDevice().pressing()
    frames = wire.Decoder().feed(device.servo.close())
    assert [type(frame) for frame in frames] == [wire.Command, wire.Disarm]
    assert frames[0].force == wire.NO_FORCE


def test_a_loss_of_more_than_5_percent_warns_and_of_more_than_30_disarms() -> None:
    device = BenchDevice().armed()
    for i in range(1000):
        device.seq += i % 10 == 0
        device.tick()
    assert "lost" in note(device) and device.servo.report().arming.name == "ON"
    for _ in range(1000):
        device.seq += 1
        device.tick()
    assert disarmed(device) and "frames" in note(device)


def test_a_silent_line_is_refused_within_a_second_and_no_force_was_ever_sent() -> None:
    servo, out = Servo(), b""
    for i in range(1100):
        out += servo.step(50 + i * 1e-3, bytes([i % 251] * 7))  # a wrong baud rate is noise
    assert servo.link is LinkState.REFUSED and "baud" in servo.report().note
    assert {type(frame) for frame in wire.Decoder().feed(out)} == {wire.Hello}


def test_another_protocol_is_refused_naming_both() -> None:
    servo = Servo(nonce=5)
    servo.step(0.0, b"")
    assert servo.step(0.01, wire.encode(info(Spec(), 5, SESSION, (3, 4)))) == b""
    assert servo.link is LinkState.REFUSED
    assert "3.4" in servo.report().note and "2.0" in servo.report().note


def test_an_answer_to_another_hello_is_not_taken() -> None:
    servo = Servo(nonce=5)
    servo.step(0.0, b"")
    servo.step(0.01, wire.encode(info(Spec(), 6, SESSION)))
    assert servo.link is LinkState.OPENING


def test_garbage_never_raises_and_never_moves_a_motor() -> None:
    """Neither before arming nor between the STATEs of a press, where the force stays what it is."""
    dice = random.Random(1)
    device = BenchDevice()
    for _ in range(2000):
        device.now += 1e-3
        device.exchange(dice.randbytes(dice.randrange(80)))
    assert device.strongest == 0.0
    device = BenchDevice().pressing()
    force = device.strongest
    for _ in range(1000):
        device.exchange(dice.randbytes(dice.randrange(80)) + b"\0")
        device.tick()
        assert device.strongest == pytest.approx(force, abs=0.01)
    assert device.servo.report().wrong > 900


def test_after_a_gap_of_5_s_there_is_no_force_and_a_new_arm_is_needed() -> None:
    """The host was suspended, the device went on; and the device stood still, the host went on."""
    for here, there in ((5.0, 5.0), (5.0, 0.0), (0.0, 5.0)):
        device = BenchDevice().pressing()
        device.now += here
        late = device.state()
        device.exchange(wire.encode(late._replace(t_us=late.t_us + round(1e6 * (there - here)) & 0xFFFFFFFF)))
        assert disarmed(device), (here, there)
        assert "stood still" in note(device)
        device.tick(200)
        assert disarmed(device)


@pytest.mark.parametrize("shift", [-1_000_000, -1, 0])
def test_a_device_whose_clock_does_not_go_on_is_disarmed(shift: int) -> None:
    """With no time between two STATEs force could not fall, nor a fingertip run away."""
    device = BenchDevice().pressing()
    last = device.servo._state
    assert last
    device.now += 1e-3
    device.exchange(wire.encode(device.state()._replace(t_us=last.t_us + shift & 0xFFFFFFFF)))
    assert disarmed(device) and "clock" in note(device)


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
        device.exchange(data)
        device.now -= shift
        assert device.strongest <= before + 1.05
        assert device.strongest <= 3.3  # the wall's 3 N
    assert disarmed(device) or jump < 10.0
    assert device.strongest > 2.5 or abs(jump) > 0.002, "a jump of two ticks is no reason to let go"


def test_a_device_that_answers_but_streams_nothing_is_refused() -> None:
    device = BenchDevice()
    device.pause(0.9)
    assert device.servo.link is LinkState.READY
    device.pause(0.2)
    assert device.servo.link is LinkState.REFUSED and "streams no positions" in note(device)
    assert device.strongest == 0.0


def test_megabytes_of_noise_without_an_end_are_forgotten_and_what_follows_is_heard() -> None:
    device = BenchDevice()
    for _ in range(20):
        device.exchange(b"\x55" * 100_000)
    assert len(device.servo._decoder._rest) < 64
    device.exchange(b"\0")
    device.heard.clear()
    device.tick()
    assert [type(frame) for frame in device.heard] == [wire.Command]
