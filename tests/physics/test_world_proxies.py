"""Bodies that a proxy moves meet others: proxies pass through nothing, the mesh shown by no more than is said."""

import re

import numpy as np
import pytest

from core.body.model import Model, build_model
from core.material import Material
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.props import PropWorld
from core.reduction.planner import Plan, plan_proxy
from core.reduction.protrusion import in_contact
from core.session import Session
from core.world import Collider, World, drop_proxies
from tests.bodies import ball, block, sheet

GEL = Material(K1=200, K2=900, x0=0.010, k=300, density=1000, damping_ratio=0.4, fill="liquid")
RADIUS, DEPTH = 0.08, 0.012


def soft_ball(points: np.ndarray, faces: np.ndarray) -> Model:
    mesh = mesh_from_triangles(points, faces)
    return build_model(mesh, [GEL], pinned=base_vertices(mesh))


def moved_by(vertices: int, model: Model) -> Plan:
    return in_contact(model.mesh, plan_proxy(model, vertices, radius=0.01))


def overlap_with_a_plate(model: Model, chosen: Plan) -> float:
    """Press a plate onto a body; return the farthest that the mesh shown passes through it [m], negative before."""
    body, (points, faces), most = Session(model, proxy=chosen.proxy), sheet(2, 0.3), -np.inf
    start = points + (0, 0, model.mesh.rest_positions[:, 2].max() + 0.002)
    world = World([body], [Collider(start.T.copy(), faces)])
    for frame in range(1, 16):
        world.set_colliders([start - (0, 0, (DEPTH + 0.002) * min(frame / 10, 1))])
        world.step(1 / 60)
        world.check()
        most = max(most, float(body.positions()[:, 2].max() - world.collider(0)[0, 2]))
    assert world.meeting.touching
    return most


def test_a_smooth_mesh_that_a_proxy_moves_stays_clear_of_what_presses_it() -> None:
    model = soft_ball(*ball(4, RADIUS))
    chosen = moved_by(600, model)
    assert chosen.reason.endswith("the mesh shown stays clear.")
    assert -0.002 < overlap_with_a_plate(model, chosen) < 0


def test_a_rough_mesh_that_a_proxy_moves_overlaps_a_plate_by_no_more_than_its_plan_says() -> None:
    points, faces = ball(4, RADIUS)
    rough = np.random.default_rng(3).normal(scale=0.012, size=len(points)).clip(-0.03, 0.03)
    model = soft_ball(points * (1 + rough)[:, None], faces)
    chosen = moved_by(600, model)
    said = re.search(r"the mesh shown may overlap by up to (.+) mm", chosen.reason)
    assert said and 1e-4 < overlap_with_a_plate(model, chosen) < float(said[1]) / 1e3


def dented() -> tuple[np.ndarray, np.ndarray]:
    """Return a ball with a dent in its top that the faces of a coarse proxy bridge."""
    points, faces = ball(5, RADIUS)
    away = np.hypot(points[:, 0], points[:, 1])
    dent = 0.012 * np.exp(-((away / 0.012) ** 2)) * (points[:, 2] > 0)
    return points * (1 - dent / RADIUS)[:, None], faces


@pytest.mark.parametrize(("lift", "is_full"), [(0.0005, True), (0.02, False)], ids=["in the dent", "above it"])
def test_what_only_a_proxy_intersects_at_the_start_is_met_by_the_full_mesh(lift: float, is_full: bool) -> None:
    points, faces = dented()
    body = Session(model := soft_ball(points, faces), proxy=moved_by(150, model).proxy)
    patch = faces[(np.hypot(*points.T[:2]) < 0.02)[faces].all(axis=1) & (points[faces][:, :, 2] > 0).all(axis=1)]
    collider = Collider((points + (0, 0, lift)).T.copy(), patch)
    notes = drop_proxies([body], [collider], [False], ["Ball", "Plug"])
    assert (body.proxy is None) == is_full == ('"Plug"' in notes[0])
    world = World([body], [collider])
    world.step(0.01)
    world.check()


def test_a_weight_sinks_as_deep_into_a_body_that_a_proxy_moves_as_into_its_mesh() -> None:
    model = soft_ball(*ball(4, RADIUS))
    corners, faces = block((0.06, 0.06, 0.03), (0, 0, RADIUS + 0.016))
    depths = []
    for proxy in (None, moved_by(1000, model).proxy):
        weight = Collider(np.array(corners).T.copy(), np.array(faces))
        world = PropWorld([Session(model, proxy=proxy)], [weight], masses=[0.5])
        world.step(1.0)
        depths.append(-float(world.pose(0)[2, 3]))
    assert depths[1] == pytest.approx(depths[0], rel=0.04)
