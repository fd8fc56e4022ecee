"""Bodies that move together behave as at rest: contact counts displacements relative to each other."""

import numpy as np
import pytest

from core.body.model import build_model
from core.material import Material
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from core.world import Collider, World
from studies.contact.meeting import met
from tests.bodies import ball, block, sheet

SOFT = Material(K1=600, K2=4000, x0=0.02, k=400, spread=0.02, mass=0.15, friction=0.4)


def free_ball(height: float, velocity: tuple[float, float, float], gravity: float = -9.81) -> Session:
    points, faces = ball(2, 0.04)
    model = build_model(mesh_from_triangles(points + (0, 0, height), faces), [SOFT], gravity=(0, 0, gravity))
    made = Session(model)
    made.body.set_state(made.body.positions(), np.tile(np.array(velocity)[:, None], len(points)))
    return made


def rolled(along: float) -> tuple[np.ndarray, int]:
    """Return where a ball on a tray that moves at a speed [m/s] ends, seen from it, and how often it is stopped."""
    body, (points, faces) = free_ball(0.043, (0.3, along, 0.0)), sheet(4, 2.0)
    world, held, tick = World([body], [Collider(points.T.copy(), faces, 0.4)]), 0, body.clock.tick
    for k in range(400):
        world.set_colliders([points + (0, along * tick * (k + 1), 0)])
        held += met(world, tick).truncated
    return body.body.positions().mean(axis=1) - (0, along * tick * 400, 0), held


@pytest.mark.parametrize("along", [1.0, 3.0])
def test_a_ball_on_a_moving_tray_rolls_as_on_one_at_rest(along: float) -> None:
    (still, _), (moving, held) = rolled(0.0), rolled(along)
    assert held == 0
    assert np.abs(moving - still).max() < 1e-3


def test_a_ball_that_flies_close_to_a_plate_is_not_slowed() -> None:
    points, faces = sheet(2, 6.0)
    body = free_ball(0.0415, (5.0, 0.0, 0.0), gravity=0.0)
    world = World([body], [Collider(points.T.copy(), faces, 0.4)])
    assert sum(met(world, 1e-3).truncated for _ in range(60)) == 0
    assert body.body.velocities()[0].mean() == pytest.approx(5.0, abs=1e-3)


def test_a_moving_collider_does_not_let_go_of_a_free_body_that_has_travelled() -> None:
    """Its skin is pulled from where it rests on the body now, not from where the body started."""
    points, faces = sheet(4, 2.0)
    body = free_ball(0.043, (0.0, 0.4, 0.0))
    world, tick = World([body], [Collider(points.T.copy(), faces, 0.4)]), body.clock.tick
    for k in range(600):
        if k % 50 == 0:
            body.body.set_constants(body.body.model)  # as a keyframed material does
        world.set_colliders([points + (0, 0.4 * tick * (k + 1), 0)])
        world.step(tick)
        assert not any(part.torn.any() for part in world.parts)
    assert body.body.positions()[1].mean() > 0.2


def test_a_prop_that_is_put_elsewhere_beside_a_body_is_met_there() -> None:
    points, faces = ball(3, 0.04)
    pinned = points[:, 2] < -0.03
    fixed = Session(build_model(mesh_from_triangles(points, faces), [SOFT], pinned=pinned, gravity=(0, 0, 0)))
    start, corners = block((0.02, 0.02, 0.02), (0.051, 0.0, 0.0))
    world = World([fixed], [Collider(start.T.copy(), corners)], masses=[0.2], gravity=(0, 0, 0))
    for k in range(1500):
        fixed.set_pins(points + (0, 0, 2e-4 * np.sin(0.01 * k)))
        if k == 1400:
            fixed.body.set_constants(fixed.body.model)  # a query finds the boxes of a prop that sleeps
        world.step(1e-3)
    prop = world.props[0].state
    prop.centre, prop.velocity, prop.momentum = np.array([-0.0508, 0.0, 0.0]), np.array([6.0, 0.0, 0.0]), np.zeros(3)
    for _ in range(60):
        world.step(1e-3)
        world.check()
