"""What rolls and turns: a solid by the inertia of its volume, any other body by that of its skin."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.base import Floats
from core.body.model import build_model
from core.body.rigid import RigidShape, rigid_shape
from core.body.shape_matching import fit_pose
from core.material import Material
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from core.world import Collider, World
from studies.contact.meeting import met
from studies.reference.constants import ROLL_ARM
from studies.scenes import cube
from tests.bodies import Shape, ball, block, sheet

FIRM = Material(K1=2000, K2=4000, x0=0.02, k=2000, spread=0.02, mass=0.15)
SLOPE, G = 0.18, 9.81
LONG = (0.5, 1.0, 1.5)


def body_of(shape: Shape, fill: str, *, gravity: float = 0.0, friction: float = 0.6) -> Session:
    material = replace(FIRM, fill=fill, friction=friction)
    return Session(build_model(mesh_from_triangles(*shape), [material], gravity=(0, 0, gravity)))


@pytest.mark.parametrize(("fill", "inertia"), [("solid", 2 / 5), ("air", 2 / 3), ("liquid", 2 / 3)])
def test_a_ball_rolls_down_a_slope_as_a_solid_or_as_a_shell(fill: str, inertia: float) -> None:
    turn, (points, faces), (flat, squares) = Rotation.from_euler("y", SLOPE), ball(4, 0.04), sheet(2, 4.0)
    body = body_of((turn.apply(points + (0, 0, 0.042)), faces), fill, gravity=-G)
    world, way = World([body], [Collider(turn.apply(flat).T.copy(), squares, 0.6)]), []
    for _ in range(24):
        world.step(0.025)
        way.append(float(turn.inv().apply(body.body.positions().T)[:, 0].mean()))
    found = 2 * np.polyfit(0.025 * np.arange(6, 24), way[6:], 2)[0]
    resisted = 2 * ROLL_ARM * np.cos(SLOPE)  # the arm in radii
    assert found == pytest.approx(G * (np.sin(SLOPE) - resisted) / (1 + inertia), rel=0.05)


def box() -> Shape:
    mesh = cube(8, 0.1)
    return mesh.rest_positions * LONG, mesh.triangles


def ellipsoid() -> Shape:
    points, faces = ball(3, 0.05)
    return points * LONG, faces


def turned_as(shape: RigidShape, body: Session, world: World, seconds: float = 0.02) -> Floats:
    """Return the angular momentum (3,) about the origin with which a solid of this shape goes as the body does."""
    rest, mass, poses = body.model.matching.rest, body.model.matching.mass, []
    for _ in range(2):
        poses.append(fit_pose(rest, body.body.positions(), mass))
        world.step(seconds)
    (before, _), (after, _) = poses
    spin = Rotation.from_matrix(after @ before.T).as_rotvec() / seconds
    turn = Rotation.from_rotvec(seconds / 2 * spin).as_matrix() @ before
    x, v = body.body.positions() @ mass / mass.sum(), body.body.velocities() @ mass
    momentum: Floats = turn @ shape.inertia @ turn.T @ spin + np.cross(x, v)
    return momentum


@pytest.mark.parametrize("side", [0, 1, 2])
@pytest.mark.parametrize(("shape", "arm", "speed"), [(box, 0.8, 0.3), (ellipsoid, 0.6, 0.5)])
def test_two_posts_that_push_a_solid_turn_it_with_the_inertia_of_its_volume(
    shape: Callable[[], Shape], arm: float, speed: float, side: int
) -> None:
    points, faces = shape()
    points, ways, moment = np.roll(points, side, axis=1), [*speed * np.array([5, 10, 15]), -50, -100], np.zeros(3)
    half = np.abs(points).max(axis=0)
    posts = [block((0.02, 0.4, 0.02), (up * arm * half[0], 0.0, -up * (half[2] + 0.012))) for up in (1, -1)]
    body = body_of((points, faces), "solid", friction=0.0)
    world = World([body], [Collider(x.T.copy(), corners, 0.0) for x, corners in posts])
    for way in ways:
        world.set_colliders([x + (0, 0, up * 1e-3 * way) for (x, _), up in zip(posts, (1, -1), strict=True)])
        moment += 0.005 * met(world, 0.005).moments[0]
    world.step(0.03)
    found = turned_as(rigid_shape(points, faces, FIRM.mass or 0), body, world)
    assert np.linalg.norm(moment) > 1e-5
    assert np.abs(found - moment).max() < 0.1 * np.linalg.norm(moment)


def test_a_solid_that_tumbles_keeps_its_angular_momentum() -> None:
    points, faces = box()
    body, spin = body_of((points, faces), "solid"), np.array([6.0, 2.0, 4.0])
    body.body.set_state(points.T, np.cross(spin, points).T)
    shape, world, found = rigid_shape(points, faces, FIRM.mass or 0), World([body], []), []
    for _ in range(5):
        found.append(turned_as(shape, body, world, 0.005))
        world.step(0.4)
    assert np.ptp(found, axis=0).max() < 1e-3 * np.linalg.norm(found[0])
    assert Rotation.from_matrix(fit_pose(points.T, body.body.positions(), np.ones(len(points)))[0]).magnitude() > 0.5
