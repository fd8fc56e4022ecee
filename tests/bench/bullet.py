"""Press a body with Bullet's soft body (panda3d), beside which Dimple is measured. Takes arrays; knows no Dimple."""

from __future__ import annotations

import time
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from panda3d.bullet import BulletRigidBodyNode, BulletSoftBodyNode, BulletSphereShape, BulletWorld
from panda3d.core import LPoint3, NodePath, PTA_int, PTA_LVecBase3

Floats = npt.NDArray[np.float64]

# Bullet samples the sphere on a fixed grid of a quarter unit: in metres a fingertip of 20 mm sinks in by half
UNITS = 100.0  # a metre
MARGIN = 5e-4  # [m] between surfaces that touch; the sphere is as much smaller, so that they meet at its radius

# What differs from Bullet's defaults, which are one iteration over the links, no bending links, no drag.
VOLUME = 5e7  # [Pa/m3] of volume lost; the explicit step of 1 ms takes 1e8 and blows up at 1e9
LINKS = 0.5  # share of a link's stretch undone in an iteration: the skins stretch as much as Dimple's
POSE = 0.005  # share of the way to the shape at rest in a step: without it the cube is a bag that stays crumpled
DAMPING = 0.005  # share of the velocity lost in a step
FRICTION = 0.5  # Coulomb coefficient, as Dimple's
HARDNESS = 1.0  # share of a penetration undone in a step; Bullet's 0.1 for a kinematic sphere lets it sink in


@dataclass(frozen=True, slots=True)
class Press:
    """What a press cost and where the vertices were.

    cost: processor time [s] of the solver and of moving the fingertip.
    positions: (k, n, 3) [m] after the ticks asked for.
    """

    cost: float
    positions: Floats


def press(
    positions: Floats,
    triangles: npt.NDArray[np.integer],
    pinned: npt.NDArray[np.bool_],
    mass: float,
    centres: Floats,
    radius: float,
    *,
    tick: float = 1e-3,
    seen: Collection[int] = (),
    iterations: int = 1,
) -> Press:
    """Move a spherical fingertip and step the body once a tick.

    Args:
        positions: (n, 3) of a closed surface at rest [m].
        triangles: (t, 3) vertices, outward.
        pinned: (n,) which vertices do not move.
        mass: of the body [kg].
        centres: (ticks + 1, 3) of the fingertip [m], the first before the first tick.
        radius: of the fingertip [m].
        tick: [s].
        seen: after which ticks, counted from 1, to read the positions.
        iterations: of the position solver over the links and contacts.
    """
    world = BulletWorld()
    world.set_gravity((0, 0, 0))
    body = soft_body(world, positions, triangles, pinned, mass, iterations)
    world.attach(body)
    sphere = BulletRigidBodyNode("fingertip")
    sphere.add_shape(BulletSphereShape((radius - MARGIN) * UNITS))
    sphere.set_kinematic(True)
    fingertip = NodePath(sphere)
    start, *path = (LPoint3(*centre) for centre in (np.asarray(centres) * UNITS).tolist())
    fingertip.set_pos(start)
    world.attach(sphere)

    cost, found = 0.0, []
    for i, centre in enumerate(path, 1):
        started = time.process_time()
        fingertip.set_pos(centre)
        world.do_physics(tick, 1, tick)
        cost += time.process_time() - started
        if i in seen:
            found.append(vertices(body))
    return Press(cost, np.array(found).reshape(-1, *np.shape(positions)))


def soft_body(
    world: BulletWorld,
    positions: Floats,
    triangles: npt.NDArray[np.integer],
    pinned: npt.NDArray[np.bool_],
    mass: float,
    iterations: int,
) -> BulletSoftBodyNode:
    points, corners = PTA_LVecBase3(), PTA_int()
    for point in (np.asarray(positions) * UNITS).tolist():
        points.push_back(LPoint3(*point))
    for corner in np.ravel(triangles).tolist():
        corners.push_back(corner)
    body = BulletSoftBodyNode.make_tri_mesh(world.get_world_info(), points, corners, False)
    body.get_material(0).set_linear_stiffness(LINKS)
    body.get_shape(0).set_margin(MARGIN * UNITS)
    settings = body.get_cfg()
    settings.set_positions_solver_iterations(iterations)
    settings.set_volume_conservation_coefficient(VOLUME / UNITS**4)  # force an area and volume
    settings.set_pose_matching_coefficient(POSE)
    settings.set_damping_coefficient(DAMPING)
    settings.set_dynamic_friction_coefficient(FRICTION)
    settings.set_kinetic_contacts_hardness(HARDNESS)
    body.set_total_mass(mass, False)
    for vertex in np.flatnonzero(pinned).tolist():
        body.set_mass(vertex, 0)
    body.set_pose(True, True)  # volume, shape
    return body


def vertices(body: BulletSoftBodyNode) -> Floats:
    """Return the positions (n, 3) [m] of a body."""
    return np.array([tuple(body.get_node(i).get_pos()) for i in range(body.get_num_nodes())]) / UNITS
