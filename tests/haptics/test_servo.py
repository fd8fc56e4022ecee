"""The servo on an injected clock: what it answers, and what must end all force."""

import math
from dataclasses import replace

import pytest

from core.device import wire
from core.device.force_guard import Guard
from core.device.notes import FAULTS
from core.device.rendered_surface import Law
from core.device.servo_finger import ServoFinger
from core.device.spec import Spec
from core.vectors import ZERO
from tests.haptics.bench_device import SESSION, TICK, BenchDevice, disarmed, note, wall


def test_a_press_meets_the_wall_once_it_is_armed() -> None:
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


def test_nothing_acts_before_arming() -> None:
    device = BenchDevice(at=[(0.0, 0.0, -0.01)] * 3)
    device.set_surfaces(*[wall(device.now)] * 3)
    device.tick(1000)
    assert device.strongest == 0.0
    assert not any(f.flags & wire.ENABLE for f in device.heard if isinstance(f, wire.Command))


def test_arming_in_the_middle_of_an_object_waits() -> None:
    device = BenchDevice(at=[(0.0, 0.0, -0.01)] * 3)
    device.set_surfaces(*[wall(device.now)] * 3)
    device.armed()
    assert device.strongest == 0.0 and device.servo.report().arming.name == "WAITING"


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


@pytest.mark.parametrize(
    "bad", [{"place": (math.nan, 0, 0)}, {"law": Law(math.inf, 1.0, 1.0, 1.0)}, {"place": (0, 0, -math.inf)}]
)
def test_a_surface_that_is_not_numbers_is_never_rendered_and_disarms(bad: dict[str, object]) -> None:
    device = BenchDevice().pressing()
    device.fresh = False
    device.set_surfaces(replace(wall(device.now), **bad))
    device.tick()
    assert disarmed(device) and "not numbers" in note(device)


@pytest.mark.parametrize("huge", [{"place": (0, 0, 1.6)}, {"law": Law(1e6, 1e6, 1.0, 1.0), "place": (0, 0, 9.0)}])
def test_a_huge_force_is_never_on_the_wire(huge: dict[str, object]) -> None:
    device = BenchDevice().pressing()
    before = device.strongest
    for _ in range(20):
        device.set_surfaces(replace(wall(device.now), **huge))
        device.fresh = False
        device.tick()
        assert device.strongest <= before + 1.05  # 1 N a millisecond, and a step of the DAC
        before = device.strongest
        assert before <= device.spec.peak_force * 1.01
    assert before > 0.9 * device.spec.peak_force, "it is limited, not dropped"


@pytest.mark.parametrize("looks", [0, 1, 5])
def test_a_change_is_spread_over_a_frame_however_often_the_key_is_renewed(looks: int) -> None:
    """1.5 N more, 16 ms after the contact before: 0.1 N a millisecond, and twice that for the converters' steps."""
    device = BenchDevice(looks=looks).pressing()
    before = device.strongest
    device.tick(-device.seq % 16)
    device.set_surfaces(wall(device.now, force=1.5))
    pushes = [before]
    for _ in range(40):
        device.tick()
        pushes.append(device.strongest)
    assert pushes[-1] == pytest.approx(before + 1.5, abs=0.05)
    assert max(b - a for a, b in zip(pushes, pushes[1:], strict=False)) < 0.2


def test_a_fingertip_that_runs_away_disarms() -> None:
    device = BenchDevice().pressing()
    for _ in range(60):
        x, y, z = device.at[0]
        device.at[0] = (x, y, z + 2e-3)
        device.tick()
    assert disarmed(device) and "1.5 m/s" in note(device)


@pytest.mark.parametrize("word", [0x7FFF, -0x7FFF, -0x8000])
def test_a_fingertip_at_the_end_of_the_range_is_not_trusted(word: int) -> None:
    """It may be farther away, so nobody knows how deep it is; one step before, it is known."""
    finger = ServoFinger(guard=Guard(10.0, 4.0))
    for at, bad in ((round(0x7FFE * math.copysign(1, word)), 0), (word, 1)):
        finger.sense((0, 0, at), False, TICK, 0.0, ZERO, 1.0)
        assert finger.known and finger.bad == bad


def test_a_place_that_jumps_masks_its_finger_at_once_and_disarms_after_5_of_them() -> None:
    device = BenchDevice().pressing()
    x, *rest = device.state_words(0)
    device.words = (x + 5000, *rest, *device.state_words(1), *device.state_words(2))
    device.tick()
    assert device.strongest == 0.0 and device.servo.report().tips[0].masked
    device.tick(5)
    assert disarmed(device) and "sensor" in note(device)


@pytest.mark.parametrize("hz", [250, 1000, 2000])
def test_a_motion_faster_than_any_hand_is_a_jump_at_every_rate(hz: int) -> None:
    """6 m/s: one a little slower is trusted, one a little faster is not, and neither is a gap."""
    for missed, speed, trusted in ((0, 5.8, True), (0, 6.2, False), (3, 5.8, True), (3, 6.2, False)):
        device = BenchDevice(spec=Spec(tick_hz=hz))
        device.tick(2)
        x, *rest = device.state_words(0)
        step = round(speed * (1 + missed) / hz / wire.PLACE_STEP)
        device.words = (x + step, *rest, *device.state_words(1), *device.state_words(2))
        device.seq += missed
        device.tick()
        assert device.servo.report().tips[0].masked != trusted


def test_a_finger_that_the_device_masks_has_no_force() -> None:
    device = BenchDevice().pressing()
    device.masked = wire.MASKED << 0
    device.tick()
    assert device.strongest == 0.0


@pytest.mark.parametrize("code", [wire.FAULT_WATCHDOG, wire.FAULT_SENSOR, wire.FAULT_SPEED])
def test_a_fault_of_the_device_disarms_and_says_which(code: int) -> None:
    device = BenchDevice().pressing()
    device.mode = wire.FAULT
    device.exchange(wire.encode(wire.Fault(SESSION, code, 0, device.seq)))
    device.tick(100)
    assert disarmed(device) and note(device)
    device.at[0] = (0.0, 0.0, 0.01)
    device.tick(100)
    device.armed()  # which clears the fault
    assert device.servo.report().arming.name == "ON"


@pytest.mark.parametrize("code", [wire.FAULT_WATCHDOG, wire.FAULT_SENSOR, wire.FAULT_SPEED])
def test_a_fault_while_the_key_is_up_is_reported_and_needs_a_new_arm(code: int) -> None:
    device = BenchDevice().armed()
    device.held = False
    device.tick(50)
    assert device.servo.report().arming.name == "WAITING"
    device.mode = wire.FAULT
    device.tick(50)  # though its word of it was lost at first
    assert device.mode == wire.FAULT, "there is no request to clear it"
    device.exchange(wire.encode(wire.Fault(SESSION, code, 0, device.seq)))
    assert disarmed(device) and note(device) == FAULTS[code]
    device.held = True
    device.tick(1000)
    assert disarmed(device) and device.mode == wire.FAULT
    assert device.armed().servo.report().arming.name == "ON"


def test_a_fault_whose_word_never_comes_gives_no_force_either() -> None:
    device = BenchDevice().armed()
    device.held = False
    device.tick(50)
    device.mode, device.held, device.obedient = wire.FAULT, True, False
    device.tick(1500)
    assert disarmed(device) and device.mode == wire.FAULT


def test_a_late_refusal_of_a_short_tap_of_the_key_disarms_nothing() -> None:
    """The device gives up after 1 s; the key was let go meanwhile."""
    device = BenchDevice().armed()
    device.held = False
    device.tick(50)
    device.exchange(wire.encode(wire.Fault(SESSION, wire.FAULT_ARM_REFUSED, wire.EVERY_FINGER, device.seq)))
    device.held = True
    device.tick(1000)
    assert device.servo.report().arming.name == "ON"


def test_a_request_to_disarm_takes_the_force_away_at_once() -> None:
    device = BenchDevice().pressing()
    device.servo.order = replace(device.servo.order, disarm=1)
    device.tick()
    assert disarmed(device)
    assert any(isinstance(frame, wire.Disarm) for frame in device.heard)


def delayed(device: BenchDevice, *lags: int) -> float:
    """Let forces answer positions after some ticks, in turn; return the largest stiffness from then on [N/m]."""
    for i in range(1500):
        device.lag = lags[i % len(lags)]
        device.tick()
    return device.servo.report().cap


def test_the_cap_follows_the_measured_delay_without_a_step() -> None:
    """The mean counts; until it is measured, two ticks are assumed."""
    device = BenchDevice()
    device.set_surfaces(wall(device.now))
    device.tick(16)
    assert device.servo.report().cap == pytest.approx(0.8 * 2.0 / 2.5e-3, rel=0.05)
    for lags in ([1], [1] * 9 + [2], [1, 2], [3]):
        mean = sum(lags) / len(lags)
        assert delayed(device, *lags) == pytest.approx(0.8 * 2.0 / (0.5e-3 + mean * 1e-3), rel=1e-2)
        assert device.servo.report().delay == pytest.approx(mean * 1e-3, rel=1e-2)


def test_the_cap_never_rises_under_a_pressed_finger() -> None:
    device = BenchDevice().pressing()
    low = delayed(device, 3)
    assert low < 460 and delayed(device, 1) == low
    for i in range(100):
        device.at[0] = (0.0, 0.0, -0.005 + i * 1e-4)
        device.tick()
    assert delayed(device, 1) > 1000
