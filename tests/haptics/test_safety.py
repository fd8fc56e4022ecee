"""What stands between a computed force and a hand."""

import itertools
import math

import pytest

from core.device.force_guard import Arming, Guard, Switch
from core.device.passivity import Passivity
from core.vectors import ZERO, length

LIMITS = 10.0, 4.0  # [N] peak, continuous
MS = 1e-3


def run(switch: Switch, start: int, ticks: int, wanted: float = 0.0, held: bool = True, on: bool = True) -> list[float]:
    return [switch.gain(wanted, (start + i) * MS, held=held, device_on=on) for i in range(ticks)]


def test_nothing_acts_before_it_is_armed() -> None:
    assert set(run(Switch(), 0, 1000)) == {0.0}


def test_arming_waits_until_there_is_no_force_for_50_ms_and_then_ramps_for_half_a_second() -> None:
    switch = Switch()
    switch.arm()
    assert set(run(switch, 0, 300, wanted=0.25)) == {0.0}
    gains = run(switch, 300, 700)
    assert set(gains[:50]) == {0.0}
    assert gains[50 + 250] == pytest.approx(0.5, abs=0.01)
    assert gains[50 + 505] == 1.0
    assert gains == sorted(gains)


def test_a_force_that_comes_back_while_waiting_starts_the_wait_again() -> None:
    switch = Switch()
    switch.arm()
    run(switch, 0, 40)
    run(switch, 40, 1, wanted=1.0)
    assert set(run(switch, 41, 50)) == {0.0} and switch.arming is Arming.WAITING


def test_a_device_that_does_not_arm_is_given_up() -> None:
    switch = Switch()
    switch.arm()
    assert set(run(switch, 0, 2000, on=False)) == {0.0}
    assert switch.arming is Arming.OFF and "did not arm" in switch.reason


def test_releasing_the_dead_man_switch_takes_the_force_away_and_gripping_it_begins_anew() -> None:
    switch = Switch()
    switch.arm()
    run(switch, 0, 700)
    assert run(switch, 700, 1, held=False) == [0.0]
    gains = run(switch, 701, 700)
    assert set(gains[:50]) == {0.0} and 0 < gains[100] < 0.2 and gains[-1] == 1.0


def test_after_a_disarm_only_a_new_request_arms() -> None:
    switch = Switch()
    switch.arm()
    run(switch, 0, 700)
    switch.disarm("why")
    assert set(run(switch, 700, 700)) == {0.0} and switch.reason == "why"
    switch.arm()
    assert run(switch, 1400, 700)[-1] == 1.0


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_no_number_no_force(bad: float) -> None:
    guard = Guard(*LIMITS)
    guard.output((0.0, 0.0, 2.0), 1.0, 0.01)
    assert guard.output((0.0, bad, 0.0), 1.0, MS) == ZERO


@pytest.mark.parametrize("wanted", [12.0, 1e3, 1e9])
def test_no_force_passes_the_peak_and_none_rises_faster_than_a_newton_a_millisecond(wanted: float) -> None:
    guard = Guard(*LIMITS)
    pushes = [length(guard.output((wanted, 0.0, 0.0), 1.0, MS)) for _ in range(50)]
    assert pushes[:10] == pytest.approx([i + 1.0 for i in range(10)])
    assert max(pushes) <= 10.0 and guard.full


def test_no_device_may_say_that_it_is_allowed_more_than_the_ceiling() -> None:
    guard = Guard(100.0, 100.0)
    for _ in range(200):
        guard.output((0.0, 99.0, 0.0), 1.0, MS)
    assert length(guard.sent) == pytest.approx(20.0)


def test_the_root_mean_square_over_10_s_stays_at_the_continuous_force() -> None:
    guard, square, seconds = Guard(*LIMITS), 0.0, 60
    for i in range(seconds * 1000):
        guard.move((0.0, 0.0, 0.0), i * MS)
        force = length(guard.output((0.0, 0.0, 9.0), 1.0, MS))
        square += (force**2 - square) * MS / 10.0
        assert square <= 4.0**2 * 1.001
    assert length(guard.sent) == pytest.approx(4.0)


def test_a_force_that_yields_falls_at_once_and_rises_slowly_again() -> None:
    """A force that lags goes on pushing: 10 N that decrease by 1 N/ms give a hand of 0.5 m/s 25 mJ."""
    guard = Guard(*LIMITS)
    pushes = [guard.output((0.0, 0.0, wanted), 1.0, MS)[2] for wanted in (*(9.0,) * 20, 1.0, 9.0, -9.0)]
    assert pushes[19] == pytest.approx(9.0) and pushes[20:] == pytest.approx([1.0, 2.0, 1.0])


def test_a_zero_is_at_once() -> None:
    guard = Guard(*LIMITS)
    for _ in range(20):
        guard.output((0.0, 0.0, 8.0), 1.0, MS)
    assert guard.output((0.0, 0.0, 8.0), 0.0, MS) == ZERO


def test_the_ramp_damps() -> None:
    guard = Guard(*LIMITS)
    for i in range(100):
        guard.move((0.0, 0.0, i * 1e-3 * 0.2), i * MS)  # 0.2 m/s
    assert guard.output((0.0, 0.0, 0.0), 0.5, MS)[2] == pytest.approx(-0.5 * 3.0 * 0.2, rel=0.01)


def test_a_fingertip_faster_than_a_hand_runs_away() -> None:
    slow, fast = Guard(*LIMITS), Guard(*LIMITS)
    for i in range(100):
        slow.move((i * MS * 1.3, 0.0, 0.0), i * MS)
        fast.move((i * MS * 1.7, 0.0, 0.0), i * MS)
    assert fast.runs_away and not slow.runs_away


def press_and_leave(push: float, pull: float, *, control: bool) -> float:
    """Go 10 mm into a wall that pushes back with one stiffness on the way in and another, larger one on the way out.

    Returns:
        the energy [J] that the wall has taken less what it gave.
    """
    guard, taken, before = Guard(*LIMITS), 0.0, 0.0
    for i in range(401):
        x = 0.01 * min(i, 400 - i) / 200
        taken += guard.sent[0] * (before - x) * -1.0
        guard.move((-x, 0.0, 0.0), i * MS)
        if not control:
            guard.passivity.stored, guard.passivity.floor = 0.0, -math.inf
        guard.output(((push if i <= 200 else pull) * x, 0.0, 0.0), 1.0, MS)
        before = x
    return taken


def test_the_passivity_controller_takes_back_what_an_active_wall_gives() -> None:
    """A wall that pushes out harder than it was pushed in gives 0.5 (560 - 500) 0.01^2 = 3 mJ.

    What was taken is given back 3.3 mm before the end; from there the wall still pushes 0.9 N on average, of which the
    controller's 12 N s/m take 0.6 N at 0.05 m/s: at least half of the 3 mJ.
    """
    assert press_and_leave(500.0, 560.0, control=False) == pytest.approx(-0.003, rel=0.15)
    assert press_and_leave(500.0, 560.0, control=True) > -0.0015


def test_what_happens_in_a_long_step_is_counted_with_the_force_of_that_step() -> None:
    """Pressed with 4 N, a fingertip sinks 4 mm while the device lets go: the hand gives less than 16 mJ."""
    guard = Guard(*LIMITS)
    for i in range(20):
        guard.move((0.0, 0.0, 0.0), i * MS, (0.0, 0.0, 4.0))
    guard.move((0.0, 0.0, -0.004), 0.050, (0.0, 0.0, 4.0), left=0.0)
    assert guard.passivity.stored == pytest.approx(0.0, abs=1e-9)
    guard.move((0.0, 0.0, 0.0), 0.060, (0.0, 0.0, 4.0), left=0.0)
    assert guard.passivity.stored == pytest.approx(-0.016), "what it gets is counted whole"


def test_a_force_that_gave_too_much_yields_until_nothing_was_touched_for_a_moment() -> None:
    """The device let go of a fingertip 5 mm deep: what a hand gave, 4 mJ, may push it out, and no more."""
    guard, given, ms = Guard(*LIMITS), 0.0, 0

    def go(x: float, push: float) -> float:
        nonlocal given, ms
        ms += 1
        given += guard.sent[0] * (guard.at[0] - x if guard.at else 0.0)
        guard.move((x, 0.0, 0.0), ms * MS)
        return guard.output((push, 0.0, 0.0), 1.0, MS)[0]

    for i in range(100):
        go(-5e-5 * i, 3.2e2 * 1e-3 * i / 20)
    guard.zero()
    guard.passivity.left = 0.0
    for _ in range(100):
        go(-0.015, 9.0)
    guard.passivity.left = 1.0
    for i in range(300):
        go(-0.015 + 5e-5 * i, 9.0)
    assert given > -1e-3 and guard.passivity.share < 0.1
    assert go(0.0, 9.0) < 1.0, "a touch that goes on stays soft"
    for _ in range(60):
        go(0.0, 0.0)
    for _ in range(10):
        go(0.0, 9.0)
    assert guard.sent[0] == pytest.approx(9.0)


def test_a_force_that_yields_comes_back_slowly_once_the_hand_presses_on() -> None:
    """A push of 3 N gives 1 mJ that nobody gave; pressed on against what is left of it, the hand pays it back."""
    guard, ms = Guard(*LIMITS), 0

    def go(x: float, push: float) -> float:
        nonlocal ms
        ms += 1
        guard.move((x, 0.0, 0.0), ms * MS, (push, 0.0, 0.0))
        return guard.output((3.0, 0.0, 0.0), 1.0, MS)[0]

    for i in range(11):
        go(1e-3 * i / 10, 1.0)
    yields = guard.passivity.share
    assert 0.05 < yields < 0.5
    for i in range(21):
        go(1e-3 - 1e-4 * i, 1.0)
    paid = guard.passivity.share
    assert yields <= paid < yields + 0.05, "not at once"
    for _ in range(600):
        go(-1e-3, 3.0)
    assert guard.passivity.share == 1.0 and guard.sent[0] == pytest.approx(3.0)


def test_the_passivity_controller_takes_back_what_a_sampled_wall_leaks() -> None:
    """Each tick holds the force of the one before: K T v x = 0.3 mJ for 600 N/m, 1 ms, 0.05 m/s, 10 mm."""
    assert press_and_leave(600.0, 600.0, control=False) == pytest.approx(-0.0003, rel=0.1)
    assert press_and_leave(600.0, 600.0, control=True) > -0.00003


@pytest.mark.parametrize("speed", [1e-150, 1e-160, 1e-161, 1e-162, 5e-324])
def test_a_fingertip_that_has_all_but_come_to_rest_keeps_its_force(speed: float) -> None:
    """Its filtered speed falls by a sixth each tick, until its square is no number above 0."""
    owing = Passivity(stored=-1e-4)
    assert owing.damp((0.0, 0.0, 1.0), (0.0, 0.0, speed), MS)[2] == pytest.approx(1.0)


def test_the_passivity_controller_leaves_a_passive_wall_alone() -> None:
    assert press_and_leave(700.0, 600.0, control=True) == press_and_leave(700.0, 600.0, control=False)


@pytest.mark.parametrize(("amplitude", "hertz"), [(1.1e-4, 250.0), (4e-3, 5.0)])
def test_what_a_wall_gives_is_seen_through_steps_of_a_fifth_of_a_millimetre(amplitude: float, hertz: float) -> None:
    """It is seen within 10 %, where it shakes a fingertip across one step, and where a hand shakes.

    A slow touch reads no different, so it is charged K q^2 = 0.04 mJ for each step q and back, which it does not get.
    """
    step, stiffness, at, given = 2e-4, 1000.0, 0.0081, 0.0
    seen, acts, answer = Passivity(), 0.0, 0.0  # each answer acts from the next tick on
    depths = [at + amplitude * math.sin(2 * math.pi * hertz * i * MS + 0.4) for i in range(2000)]
    for before, depth in itertools.pairwise(depths):
        was, reads = (step * round(x / step) for x in (before, depth))
        acts, answer = answer, stiffness * was
        given += acts * (before - depth)
        seen.observe((0.0, 0.0, acts), (0.0, 0.0, was - reads))
    assert given > 0.01 and seen.stored == pytest.approx(-given, rel=0.1)
