"""The dead-man key on an injected clock: held for a short while at a time, and whatever ends that ends the force."""

import math
import time
from dataclasses import replace

import pytest

from core.device.device import Device
from core.device.limits import LEASE
from core.device.mailbox import TO_SERVO, Mailbox
from core.device.orders import Order, unpack_order
from tests.haptics.bench_device import TICK, BenchDevice, wall

RENEW = 0.05  # [s] between two looks of Blender at the key
STALL = 0.2  # [s] of Blender's main thread, once a second


def arming(device: BenchDevice) -> str:
    return device.servo.report().arming.name


def lift(device: BenchDevice, seconds: float = 0.7) -> None:
    """Take the first fingertip out of the wall, no faster than a hand, and wait."""
    begin = device.at[0][2]
    for i in range(100):
        device.at[0] = (0.0, 0.0, begin + i / 100 * (0.01 - begin))
        device.tick()
    device.tick(round(seconds / TICK))


def post(device: BenchDevice, *, renew: bool) -> None:
    """Let Blender post a contact of now, and look at the key."""
    device.set_surfaces(wall(device.now))
    if renew:
        device.hold()


def test_it_is_a_key_or_the_button_of_the_device() -> None:
    device = BenchDevice(buttons=1, held=False).pressing()
    assert device.strongest > 1
    device.buttons = 0
    device.tick()
    assert device.strongest == 0.0
    device.held = True
    lift(device)
    assert arming(device) == "ON"


@pytest.mark.parametrize("frames", [True, False], ids=["frames go on", "Blender stands still"])
def test_a_key_that_is_not_renewed_counts_as_released(frames: bool) -> None:
    """Within the lease, though the simulation goes on and its contacts are as fresh as ever."""
    device = BenchDevice().pressing()
    device.hold()
    device.fresh, begun = False, device.now
    while device.now < begun + LEASE - 2 * TICK:
        if frames:
            post(device, renew=False)
        device.tick()
    assert (device.strongest > 1) == frames  # contacts of a standstill fade by 0.2 s
    device.tick(3)
    assert device.strongest == 0.0 and arming(device) == "WAITING"


def test_a_lapsed_key_held_again_under_a_pressed_finger_gives_no_force_until_it_lets_go() -> None:
    device = BenchDevice().pressing()
    device.held = False
    device.tick(round(2 * LEASE / TICK))
    device.held = True
    device.tick(1000)
    assert device.strongest == 0.0 and arming(device) == "WAITING"
    lift(device)
    assert arming(device) == "ON"


def test_a_stall_of_200_ms_each_second_lets_the_key_not_go() -> None:
    """The wall fades meanwhile, and is back without a new ramp; each stall begins when the next look is due."""
    device = BenchDevice().pressing()
    device.fresh, looked, stalls = False, -math.inf, 0
    begun = device.now
    for i in range(4000):
        in_second = i % 1000 * TICK
        if in_second >= STALL or i < 1000:
            if device.now - looked >= RENEW:
                looked = device.now
                post(device, renew=True)
            elif i % 16 == 0:
                post(device, renew=False)
        elif in_second == 0:
            stalls, looked = stalls + 1, device.now - RENEW
            device.servo.order = replace(device.servo.order, held_until=looked + LEASE)
        device.tick()
        assert arming(device) == "ON", device.now - begun
    assert stalls == 3 and device.strongest > 1


@pytest.mark.parametrize("button", [0, 1], ids=["the key", "the button of the device"])
def test_after_a_pause_a_finger_that_sank_in_has_no_force_until_it_lets_go(button: int) -> None:
    """Blender renews the key, or stands still while the button is held; the wall fades, and must not come back."""
    device = BenchDevice(buttons=button, held=not button).pressing(0.001)
    device.fresh = False
    for i in range(1000):
        if i % 50 == 0 and not button:
            device.hold()
        device.at[0] = (0.0, 0.0, -0.001 - i * 1e-5)
        device.tick()
    assert device.strongest == 0.0 and arming(device) == "WAITING"
    device.fresh = True
    for _ in range(1000):
        device.tick()
        assert device.strongest == 0.0 and arming(device) == "WAITING"
    lift(device)
    assert arming(device) == "ON"


def test_arming_over_a_simulation_that_stands_still_waits_for_it_and_then_for_the_quiet() -> None:
    """The finger is 10 mm deep: contacts that have faded are no quiet, and those that come at last are none either."""
    device = BenchDevice(at=[(0.0, 0.0, -0.01)] * 3, fresh=False)
    device.set_surfaces(*[wall(device.now)] * 3)
    device.tick(150)
    device.arm()
    for fresh in (False, True):
        device.fresh = fresh
        for _ in range(3000):
            device.hold()
            device.tick()
            assert device.strongest == 0.0 and arming(device) == "WAITING"


def test_a_simulation_of_4_frames_a_second_arms_where_there_is_no_force_and_nowhere_else() -> None:
    """Its contacts fade before the next one comes; what is left of them then is no quiet."""
    for at, ends in ((0.01, "ON"), (-0.01, "WAITING")):
        device = BenchDevice(at=[(0.0, 0.0, at)] * 3, fresh=False)
        device.arm()
        for i in range(3000):
            if i % 250 == 0:
                device.set_surfaces(*[wall(device.now)] * 3)
            device.hold()
            device.tick()
            assert device.strongest == 0.0
        assert arming(device) == ends


@pytest.mark.parametrize("stamp", [math.nan, math.inf, -math.inf, 1e9, 0.0])
def test_a_contact_of_no_time_of_this_clock_lets_the_key_go(stamp: float) -> None:
    device = BenchDevice().pressing()
    device.fresh = False
    device.set_surfaces(replace(wall(device.now), stamp=stamp))
    device.tick()
    assert device.strongest == 0.0 and arming(device) == ("WAITING" if math.isfinite(stamp) else "OFF")


@pytest.mark.parametrize("until", [math.nan, math.inf, -math.inf, 1e9, 0.0, -1.0])
def test_a_time_that_is_none_of_this_clock_holds_nothing(until: float) -> None:
    assert not Order(held_until=until).is_held(100.0)
    assert Order(held_until=100.0 + LEASE).is_held(100.0) and not Order(held_until=100.0).is_held(100.0)


def test_no_order_holds_the_key_for_longer_than_it_was_set() -> None:
    """Frames are written at their own rate; they renew the lease, but only until the time that was given."""
    device, box = Device("nowhere"), Mailbox()
    device._box = box

    def held_for() -> float:
        order = unpack_order(box.read(TO_SERVO)[1] or b"")
        return order.held_until - time.perf_counter()

    device.arm()
    device.write([wall()])
    assert held_for() < 0.0, "it is not held before it is set"
    device.hold(time.perf_counter() + 0.1)
    device.write([wall()])
    device.renew()
    device.arm()
    assert held_for() <= 0.1
    device.hold(time.perf_counter() + 3600.0)
    assert held_for() <= LEASE
    device.hold(0.0)
    device.write([wall()])
    assert held_for() < 0.0
    device.close()
