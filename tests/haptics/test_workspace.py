"""From a session to a device: the surface under a fingertip, and where its own place is."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.body.model import build_model
from core.device.orders import ServoReport, TipState
from core.device.rendered_surface import Contact, Surface, is_sane
from core.device.workspace import Workspace, fingers, surface_of, surfaces_of
from core.material import law_force
from core.mesh.surface import base_vertices
from core.native.motion import Touch
from core.session import Finger, Session
from core.vectors import Vector
from studies.paper_objects import PRESETS
from studies.scenes import cube

CAP = 1e5  # [N/m] of a device that renders all
RADIUS = 0.01
MATERIAL = PRESETS[1].material  # vinyl and air: K1 = 610 N/m
VINYL = (MATERIAL.K1, MATERIAL.K2, MATERIAL.x0, MATERIAL.power)
TURN = ((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))  # a quarter round z
UP = (0.0, 0.0, 1.0)
TOP = PRESETS[1].size / 2


def touch(depth: float, x: float = 0.0, *, grip: float = 0.0) -> Touch:
    """Return the touch of a fingertip that is pressed down at a place along x, with a force sideways [N]."""
    force = grip, 0.0, law_force(depth, *VINYL)
    return Touch((0.0, 0.0, 0.0), (x, 0.0, -depth), depth, UP, force, 0.0, 0.5, VINYL, 0)


def surface(touch: Touch, place: Workspace | None = None) -> Surface:
    found = surface_of(touch, place or Workspace(), 7.0)
    assert found
    return found


def felt(touch: Touch, place: Workspace | None = None) -> Vector:
    """Return the force [N] on the device's fingertip where the touch was."""
    place, made = place or Workspace(), Contact()
    x = place.to_device(touch.centre)
    made.take(surface(touch, place), x, 7.0, CAP)
    return made.force(x, 7.1)


@pytest.mark.parametrize("depth", [0.001, 0.005, 0.012, 0.020])
def test_what_a_device_renders_is_the_force_of_the_touch(depth: float) -> None:
    pressed = touch(depth, 0.1, grip=0.3)
    assert felt(pressed) == pytest.approx(pressed.force)
    assert surface(pressed).depth(pressed.centre) == pytest.approx(depth)


def test_clear_of_the_body_the_gap_is_known() -> None:
    clear = surface(touch(-0.003))
    assert clear.depth((0.0, 0.0, 0.003)) == pytest.approx(-0.003) and clear.anchor is None


def test_a_larger_workspace_renders_the_same_stiffness() -> None:
    place = Workspace(origin=(0.1, 0.2, 0.3), scale=2.5, turn=TURN)
    assert felt(touch(0.010), place)[2] == pytest.approx(MATERIAL.K1 * 0.010 / 2.5)
    assert felt(touch(0.020), place)[2] == pytest.approx(law_force(0.020, *VINYL) / 2.5)
    assert place.to_session(surface(touch(0.010), place).place) == pytest.approx((0, 0, 0), abs=1e-12)


def test_a_turned_workspace_turns_the_force() -> None:
    assert felt(touch(0.010, grip=-1.0), Workspace(turn=TURN)) == pytest.approx((0.0, 1.0, MATERIAL.K1 * 0.010))
    aside = surface(touch(0.010)._replace(outward=(1.0, 0.0, 0.0)), Workspace(turn=TURN))
    assert aside.normal == pytest.approx((0.0, -1.0, 0.0))


def test_a_place_goes_to_the_session_and_back() -> None:
    place, at = Workspace(origin=(0.1, 0.2, 0.3), scale=2.5, turn=TURN), (0.01, -0.02, 0.03)
    there = np.array(place.origin) + 2.5 * np.array(TURN) @ np.array(at)
    assert place.to_session(at) == pytest.approx(tuple(there))
    assert place.to_device(place.to_session(at)) == pytest.approx(at)


def test_no_touch_no_surface() -> None:
    for missed in (None, touch(0.0)._replace(triangle=-1)):
        assert surface_of(missed, Workspace(), 0.0) is None


@pytest.mark.parametrize("force", [(0.0, 0.0, 0.0), (1.0, 0.0, -1.0)])
def test_a_touch_without_a_push_has_no_grip(force: Vector) -> None:
    """Whatever a frame says: the force along the normal is the law's, and all numbers are finite."""
    found = felt(touch(0.005)._replace(force=force))
    assert found == (0.0, 0.0, pytest.approx(MATERIAL.K1 * 0.005)) and all(map(math.isfinite, found))


def test_where_painting_leaves_no_stiffness_there_is_no_force_with_any_tip() -> None:
    painted = touch(0.005)._replace(law=(0.0, 0.0, 0.01, 1.0), force=(0.0, 0.0, 0.0))
    for other in (None, (0.02, lambda depths: [0.0] * len(depths))):
        found, made = surface_of(painted, Workspace(), 7.0, other), Contact()
        assert found and is_sane(found)
        made.take(found, painted.centre, 7.0, CAP)
        assert made.force(painted.centre, 7.1) == (0.0, 0.0, 0.0)


def test_a_fingertip_that_is_not_trusted_is_none() -> None:
    report = ServoReport(tips=(TipState(position=(0.0, 0.0, 0.01)), TipState(masked=True)))
    place = Workspace(origin=(0.0, 0.0, 1.0))
    assert fingers(report, place, RADIUS) == [Finger((0.0, 0.0, 1.01), RADIUS), None]


def pressed_cube(radius: float, material_radius: float = RADIUS) -> Session:
    mesh = cube(8, PRESETS[1].size)
    material = replace(MATERIAL, indenter=replace(MATERIAL.indenter, radius=material_radius))
    return Session(build_model(mesh, [material], pinned=base_vertices(mesh)))


@pytest.mark.parametrize("radius", [RADIUS, 0.006, 0.018])
def test_the_servo_gives_the_force_that_presses_the_body_also_with_another_tip(radius: float) -> None:
    """A ramp of 100 mm/s: the servo goes on for 16 ms from what it was sent, Blender's own step is beside it."""
    session, made = pressed_cube(radius), Contact()
    for tick in range(300):
        x = (0.01, 0.005, TOP + radius + 0.005 - 1e-4 * tick)
        session.set_fingers([Finger(x, radius)])
        frame = session.step(1e-3)
        if tick % 16 == 0:
            made.take(surfaces_of(session, frame.touches, Workspace(), tick * 1e-3)[0], x, tick * 1e-3, CAP)
        if tick > 48:
            force = made.force(x, tick * 1e-3)[2]
            assert force == pytest.approx(frame.finger_forces[0][2], rel=3e-3, abs=3e-3), tick


@pytest.mark.parametrize(("way", "hz"), [(0.001, 10), (0.010, 1)], ids=["sticks", "slips"])
def test_a_fingertip_dragged_over_a_body_meets_the_friction_that_drags_the_body(way: float, hz: float) -> None:
    """Back and forth, 6 mm deep; what the servo is sent is 5 ms old. It takes from the hand what the body's takes."""
    session, made, errors, taken, before = pressed_cube(RADIUS), Contact(), [], np.zeros(2), None
    for tick in range(1200):
        x = (way * math.sin(2e-3 * math.pi * hz * max(tick - 200, 0)), 0.0, TOP + RADIUS - min(1e-4 * tick, 0.006))
        session.set_fingers([Finger(x, RADIUS)])
        frame = session.step(1e-3)
        if tick % 16 == 0:
            sent = surfaces_of(session, frame.touches, Workspace(), tick * 1e-3)[0]
        elif tick % 16 == 5:
            made.take(sent, x, tick * 1e-3, CAP)
        if tick > 200:
            forces = np.array([made.force(x, tick * 1e-3), frame.finger_forces[0]])
            errors.append(np.linalg.norm(forces[0] - forces[1]) / np.linalg.norm(forces[1]))
            taken -= forces @ (np.array(x) - before)
        before = np.array(x)
    assert np.mean(errors) < 0.01 and max(errors) < 0.1
    assert taken[0] == pytest.approx(taken[1], rel=0.05) and taken[0] > 0
