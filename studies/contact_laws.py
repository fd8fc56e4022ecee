"""The laws of contact, as figures: rest, friction, bounce and the third law."""

from __future__ import annotations

import numpy as np

from core.base import Bools, Floats, Ints
from core.body.model import build_model
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from core.world import Collider, World

from .contact_scenes import SOFT, grid, icosphere, moved

RADIUS, SETTLED, WATCHED = 0.04, 5, 10  # [m], [s], [s]
SLOPES = (0.3, 0.6)  # [rad] the friction angle is 0.38
SQUARES = (2, 80, 160)  # along the metre of a slope: those of the sheet on it are 80 to the metre
RATES = (24, 60, 120)


def measure_laws() -> dict[str, float]:
    """Return what rest, friction, bounce and the third law come to.

    Returns:
        the drift of a ball at rest on another in ten seconds [mm]; the error of the acceleration on slopes, as a share
        of friction's most; by how much a dropped ball differs between frame rates at its highest, in speed and where it
        ends [mm], [mm/s]; the momentum that two bodies that collide gain, as a share of what they exchange.
    """
    friction = max(_slide(slope, squares) for slope in SLOPES for squares in SQUARES)
    return {"drift_mm": _drift(), "friction_error": friction, **_bounces(), "third_law": _collide()}


def _session(
    points: Floats, faces: Ints, *, pinned: Bools | None = None, gravity: float = -9.81, backend: str = "native"
) -> Session:
    model = build_model(mesh_from_triangles(points, faces), [SOFT], pinned=pinned, gravity=(0, 0, gravity))
    return Session(model, backend=backend)


def _velocity(body: Session) -> Floats:
    """Return the velocity of the centre of mass (3,) [m/s]."""
    mean: Floats = body.body.velocities() @ body.model.mass / body.model.mass.sum()
    return mean


def _drift() -> float:
    rng = np.random.default_rng(0)
    low, faces = moved(icosphere(3, RADIUS), rng)
    low -= low.mean(axis=0)
    high = moved(icosphere(3, RADIUS), rng)[0]
    high += (0, 0, low[:, 2].max() + 1e-3 - high[:, 2].min()) - high.mean(axis=0) * (1, 1, 0)
    body = _session(high, faces)
    world = World([_session(low, faces, pinned=low[:, 2] < -0.5 * RADIUS), body])
    world.step(SETTLED)
    before, most = body.body.positions(), 0.0
    for _ in range(WATCHED):
        world.step(1.0)
        most = max(most, float(np.abs(body.body.positions() - before).max()))
    return 1e3 * most


def _slide(slope: float, along: int) -> float:
    """Return the error of the acceleration of a sheet down a slope [rad] of squares, as a share of friction's most."""
    turn = np.array([[np.cos(slope), 0, np.sin(slope)], [0, 1, 0], [-np.sin(slope), 0, np.cos(slope)]])
    points, faces = grid(8, 8, 0.1, 0.1)
    body = _session((points + (0, 0, 1.3e-3)) @ turn.T, faces)
    flat, squares = grid(along, along, 1.0, 1.0)
    world = World([body], [Collider((flat @ turn.T).T.copy(), squares, SOFT.friction)])
    speeds = []
    for _ in range(2):
        world.step(0.2)
        speeds.append(float(_velocity(body) @ turn[:, 0]))
    most = 9.81 * SOFT.friction * np.cos(slope)
    return abs((speeds[1] - speeds[0]) / 0.2 - max(9.81 * np.sin(slope) - most, 0.0)) / most


def _bounces() -> dict[str, float]:
    """Drop a ball by 40 mm at several frame rates, and compare how fast it comes off and where it comes to rest."""
    points, faces = moved(icosphere(2, RADIUS), np.random.default_rng(0), (0, 0, 2 * RADIUS))
    flat, squares = grid(2, 2, 1.0, 1.0)
    speeds, ends = [], []
    for rate in RATES:
        body, fastest = _session(points, faces), 0.0
        world = World([body], [Collider(flat.T.copy(), squares, SOFT.friction)])
        for frame in range(4 * rate):
            world.step(1 / rate)
            if frame % (rate // 12) == rate // 12 - 1:
                fastest = max(fastest, float(_velocity(body)[2]))
        speeds.append(fastest)
        ends.append(body.body.positions())
    return {
        "bounce_mm_s": 1e3 * speeds[0], "bounce_differs_mm_s": 1e3 * float(np.ptp(speeds)),
        "rest_differs_mm": 1e3 * max(float(np.abs(end - ends[0]).max()) for end in ends),
    }  # fmt: skip


def _collide() -> float:
    rng, bodies = np.random.default_rng(0), []
    for height, speed in ((2 * RADIUS, 0.0), (4.3 * RADIUS, -1.0)):
        body = _session(*moved(icosphere(2, RADIUS), rng, (0, 0, height)), gravity=0.0, backend="native64")
        x = body.body.positions()
        body.body.set_state(x, np.full_like(x, [[0.0], [0.1], [speed]] if speed else 0.0))
        bodies.append(body)
    world, before = World(bodies), [body.body.velocities() @ body.model.mass for body in bodies]
    world.step(0.1)
    gained = [body.body.velocities() @ body.model.mass - was for body, was in zip(bodies, before, strict=True)]
    return float(np.abs(sum(gained)).max() / np.abs(gained[0]).max())
