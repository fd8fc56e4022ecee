"""What a device renders of a touch: the measured law and friction, as a local contact."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.haptics.contact_model import Contact, force_at
from core.haptics.contact_rendering import SIDEWAYS, Law, Workspace, contact_of, fingers, rendered, wall_slope
from core.haptics.servo_messages import ServoReport, TipState
from core.material import FINGERTIP, PRESETS, law_force, law_slope
from core.native.motion import Touch
from core.session import Finger
from core.vectors import Vector

CAP = 1e4  # [N/m] of a device that renders all
RADIUS = 0.01
MATERIAL = PRESETS[1].material  # vinyl and air: K1 = 610 N/m
VINYL: Law = (MATERIAL.K1, MATERIAL.K2, MATERIAL.x0, MATERIAL.power)
SOLID_MATERIAL = replace(MATERIAL, K1=600.0, K2=1350.0, x0=0.006, fill="solid", indenter=FINGERTIP)
SOLID: Law = (600.0, 1350.0, 0.006, SOLID_MATERIAL.power)
TURN = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))  # a quarter round z
UP = (0.0, 0.0, 1.0)


def touch(depth: float, x: float = 0.0, *, grip: float = 0.0, law: Law = VINYL) -> Touch:
    """Return the touch of a fingertip that is pressed down at a place along x, with a force sideways [N]."""
    force = grip, 0.0, law_force(depth, *law)
    return Touch((0.0, 0.0, 0.0), (x, 0.0, -depth), depth, UP, force, 0.0, 0.5, law, 0)


def contact(touch: Touch, place: Workspace | None = None, cap: float = CAP) -> Contact:
    found = contact_of(touch, place or Workspace(), cap, 7.0)
    assert found
    return found


@pytest.mark.parametrize("depth", [0.001, 0.005, 0.012, 0.020])
@pytest.mark.parametrize("law", [VINYL, SOLID], ids=["straight", "bent"])
def test_what_a_device_can_render_is_the_force_of_the_touch(depth: float, law: Law) -> None:
    pressed = touch(depth, 0.1, grip=0.3, law=law)
    found = contact(pressed)
    assert found.force == pytest.approx(pressed.force)
    assert (found.at, found.normal, found.gap) == (pressed.centre, UP, 0.0)
    assert (found.friction, found.stamp) == (0.5, 7.0)
    assert found.k_n == max(law_slope(depth, *law), law[0])
    assert found.k_t == pytest.approx(SIDEWAYS * law_force(depth, *law) / depth)


def test_the_slope_of_a_law_is_its_derivative() -> None:
    for law in (VINYL, SOLID):
        for depth in (0.002, 0.005, 0.008, 0.020):
            rise = law_force(depth + 1e-7, *law) - law_force(depth - 1e-7, *law)
            assert law_slope(depth, *law) == pytest.approx(rise / 2e-7, rel=1e-4)


def test_what_the_device_cannot_render_is_rendered_as_steep_as_it_can() -> None:
    found = contact(touch(0.020), cap=640.0)
    assert found.k_n == 640.0
    assert found.force[2] == pytest.approx(610 * 0.0163 + 640 * (0.020 - 0.0163))
    assert rendered(VINYL, 640.0) == (610.0, 640.0, *VINYL[2:])


def test_of_a_solid_the_rendered_law_is_softer_everywhere_and_no_steeper_than_the_cap() -> None:
    """With other slopes it would begin with another power, and harder."""
    depths = np.linspace(0, 4 * SOLID[2], 400)
    for cap in (1300.0, 800.0, 300.0):
        softer = rendered(SOLID, cap)
        forces, law = (np.array([law_force(depth, *each) for depth in depths]) for each in (softer, SOLID))
        assert (forces <= law + 1e-12).all() and softer[3] == SOLID[3]
        assert np.diff(forces).max() <= cap * depths[1] * (1 + 1e-9)
    assert rendered(SOLID, CAP) == SOLID


@pytest.mark.parametrize("cap", [CAP, 800.0])
def test_a_wall_of_a_solid_gives_no_more_than_it_took(cap: float) -> None:
    """Whatever the frames: with the slope at its begin, which is none, it would give a fifth of a mJ each time."""
    frame, law = 1 / 60, rendered(SOLID, cap)
    for middle, way, rate in ((0.004, 0.0015, 3), (0.005, 0.0008, 5), (0.003, 0.003, 2), (0.007, 0.002, 3.3)):
        t = np.linspace(0, 20 / rate, 60_001)  # twenty times
        x, seen = (middle + way * np.sin(2 * np.pi * rate * at) for at in (t, frame * np.floor(t / frame)))
        pushes, slopes = np.array([(law_force(depth, *law), wall_slope(law, depth)) for depth in seen]).T
        forces = np.maximum(pushes + slopes * (x - seen), 0)
        assert -float(((forces[1:] + forces[:-1]) / 2) @ np.diff(x)) / 20 < 1e-5, "[J]"


def test_two_frames_of_one_press_tell_the_same_curve() -> None:
    """So a new contact changes nothing while the knee is not passed: the simulation's rate does not matter."""
    before, after = contact(touch(0.004)), contact(touch(0.009))
    assert force_at(before, after.at, CAP)[2] == pytest.approx(after.force[2])


@pytest.mark.parametrize("cap", [CAP, 300.0])
def test_two_frames_of_a_fingertip_that_sticks_tell_the_same_line(cap: float) -> None:
    """A spring of two thirds of the law's slope, softer by as much as the device renders the law softer."""
    k = SIDEWAYS * MATERIAL.K1
    before, after = (contact(touch(0.010, x, grip=-k * x), cap=cap) for x in (0.002, 0.004))
    assert force_at(before, after.at, cap) == pytest.approx(after.force)
    assert after.force[0] == pytest.approx(-SIDEWAYS * min(MATERIAL.K1, cap) * 0.004)


@pytest.mark.parametrize("cap", [CAP, 300.0])
def test_a_fingertip_that_slips_is_held_by_the_friction_of_what_is_rendered(cap: float) -> None:
    found = contact(touch(0.010, grip=-0.5 * law_force(0.010, *VINYL)), cap=cap)
    assert found.force[0] == pytest.approx(-0.5 * found.force[2])
    farther = force_at(found, (0.005, 0.0, found.at[2]), cap)
    assert farther[0] == pytest.approx(found.force[0]), "no more than that"


def test_clear_of_the_body_the_gap_is_known() -> None:
    found = contact(touch(-0.003))
    assert found.gap == pytest.approx(0.003) and found.force == (0.0, 0.0, 0.0) and found.k_t == 0.0
    assert force_at(found, (0.0, 0.0, -0.002), CAP)[2] == pytest.approx(MATERIAL.K1 * 0.002)


def test_a_larger_workspace_renders_the_same_stiffness() -> None:
    place, pressed = Workspace(origin=(0.1, 0.2, 0.3), scale=2.5, turn=TURN), touch(0.010)
    found = contact(pressed, place)
    assert found.k_n == MATERIAL.K1
    assert found.force[2] == pytest.approx(MATERIAL.K1 * 0.010 / 2.5)
    assert place.to_session(found.at) == pytest.approx(pressed.centre, abs=1e-12)
    assert contact(touch(-0.010), place).gap == pytest.approx(0.010 / 2.5)


def test_a_turned_workspace_turns_the_force() -> None:
    turned = contact(touch(0.010, grip=-1.0), Workspace(turn=TURN))
    assert turned.force == pytest.approx((0.0, 1.0, MATERIAL.K1 * 0.010))
    aside = contact(touch(0.010)._replace(outward=(1.0, 0.0, 0.0)), Workspace(turn=TURN))
    assert aside.normal == pytest.approx((0.0, -1.0, 0.0))


def test_a_place_goes_to_the_session_and_back() -> None:
    place, at = Workspace(origin=(0.1, 0.2, 0.3), scale=2.5, turn=TURN), (0.01, -0.02, 0.03)
    there = np.array(place.origin) + 2.5 * np.array(TURN) @ np.array(at)
    assert place.to_session(at) == pytest.approx(tuple(there))
    assert place.to_device(place.to_session(at)) == pytest.approx(at)


def test_no_touch_no_contact() -> None:
    for missed in (None, touch(0.0)._replace(triangle=-1)):
        assert contact_of(missed, Workspace(), CAP, 0.0) is None


@pytest.mark.parametrize("force", [(0.0, 0.0, 0.0), (1.0, 0.0, -1.0)])
def test_a_touch_without_a_push_has_no_grip(force: Vector) -> None:
    """Whatever a frame says: the force along the normal is the law's, and all numbers are finite."""
    found = contact(touch(0.005)._replace(force=force))
    assert found.force == (0.0, 0.0, pytest.approx(MATERIAL.K1 * 0.005)) and all(map(math.isfinite, found.force))


def test_a_fingertip_that_is_not_trusted_is_none() -> None:
    report = ServoReport(tips=(TipState(position=(0.0, 0.0, 0.01)), TipState(masked=True)))
    place = Workspace(origin=(0.0, 0.0, 1.0))
    assert fingers(report, place, RADIUS) == [Finger((0.0, 0.0, 1.01), RADIUS), None]
