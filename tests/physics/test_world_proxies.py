"""Bodies that a proxy moves meet others: proxies pass through nothing, the mesh shown by little."""

import numpy as np
import pytest

from core.body.model import Model, build_model
from core.constants import OFFSET
from core.material import Material
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.reduction.proxy import Proxy, build_proxy
from core.session import Session
from core.world import Collider, World, drop_proxies
from studies.contact.meeting import meeting_of
from tests.bodies import ball, block, sheet

GEL = Material(K1=200, K2=900, x0=0.010, k=300, density=1000, damping_ratio=0.4, fill="liquid")
RADIUS, DEPTH = 0.08, 0.012


def soft_ball(points: np.ndarray, faces: np.ndarray) -> Model:
    mesh = mesh_from_triangles(points, faces)
    return build_model(mesh, [GEL], pinned=base_vertices(mesh))


def pressed_by_a_plate(model: Model, proxy: Proxy | None) -> tuple[float, float, float]:
    """Press a plate onto a body.

    Returns:
        how far the mesh shown passes through it at most, and at the end [m], negative before it, and the force [N].
    """
    body, (points, faces), overlaps = Session(model, proxy=proxy), sheet(2, 0.3), []
    start = points + (0, 0, model.mesh.rest_positions[:, 2].max() + 0.002)
    world = World([body], [Collider(start.T.copy(), faces)])
    for frame in range(1, 16):
        world.set_colliders([start - (0, 0, (DEPTH + 0.002) * min(frame / 10, 1))])
        world.step(1 / 60)
        world.check()
        overlaps.append(float(body.positions()[:, 2].max() - world.collider(0)[0, 2]))
    assert meeting_of(world).touching
    return max(overlaps), overlaps[-1], -float(meeting_of(world).forces[0, 2])


def test_a_smooth_mesh_meets_a_plate_where_and_as_hard_as_it_does_without_the_proxy_that_moves_it() -> None:
    model = soft_ball(*ball(5, RADIUS))
    _, whole, force = pressed_by_a_plate(model, None)
    most, end, by_proxy = pressed_by_a_plate(model, build_proxy(model, 1000))
    touches = 2 * OFFSET * model.mesh.rest_lengths.mean()
    assert most < 0 and whole < 0, "it stays clear"
    assert end > -1.6 * touches  # the edges of its proxy are three times longer
    assert by_proxy == pytest.approx(force, rel=0.12)


def test_a_smooth_mesh_that_a_proxy_moves_overlaps_the_edges_of_a_weight_by_a_tenth_of_its_edges() -> None:
    model = soft_ball(*ball(5, RADIUS))
    corners, faces = block((0.06, 0.06, 0.03), (0, 0, RADIUS + 0.016))
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    body = Session(model, proxy=(proxy := build_proxy(model, 1000)))
    world, most = World([body], [Collider(np.array(corners).T.copy(), np.array(faces))], masses=[0.5]), -np.inf
    for _ in range(30):
        world.step(1 / 60)
        pose = world.props[0].pose()
        seen = (body.positions().astype(np.float64) - pose[:3, 3]) @ pose[:3, :3]
        most = max(most, float(np.minimum(seen - low, high - seen).min(axis=1).max()))
    assert -0.01 * proxy.spacing < most < 0.1 * proxy.spacing


def test_a_rough_mesh_that_a_proxy_moves_overlaps_a_plate_by_less_than_it_is_rough() -> None:
    points, faces = ball(4, RADIUS)
    rough = np.random.default_rng(3).normal(scale=0.012, size=len(points)).clip(-0.03, 0.03)
    model = soft_ball(points * (1 + rough)[:, None], faces)
    assert 1e-4 < pressed_by_a_plate(model, build_proxy(model, 600))[0] < 0.03 * RADIUS


def dented() -> tuple[np.ndarray, np.ndarray]:
    """Return a ball with a dent in its top that the faces of a coarse proxy bridge."""
    points, faces = ball(5, RADIUS)
    away = np.hypot(points[:, 0], points[:, 1])
    dent = 0.012 * np.exp(-((away / 0.012) ** 2)) * (points[:, 2] > 0)
    return points * (1 - dent / RADIUS)[:, None], faces


@pytest.mark.parametrize(("lift", "is_full"), [(0.0005, True), (0.02, False)], ids=["in the dent", "above it"])
def test_what_only_a_proxy_intersects_at_the_start_is_met_by_the_full_mesh(lift: float, is_full: bool) -> None:
    points, faces = dented()
    body = Session(model := soft_ball(points, faces), proxy=build_proxy(model, 150))
    patch = faces[(np.hypot(*points.T[:2]) < 0.02)[faces].all(axis=1) & (points[faces][:, :, 2] > 0).all(axis=1)]
    collider = Collider((points + (0, 0, lift)).T.copy(), patch)
    notes = drop_proxies([body], [collider], ["Ball", "Plug"])
    assert (body.proxy is None) == is_full == ('"Plug"' in notes[0])
    world = World([body], [collider])
    world.step(0.01)
    world.check()


def test_a_weight_sinks_as_deep_into_a_body_that_a_proxy_moves_as_into_its_mesh() -> None:
    model = soft_ball(*ball(4, RADIUS))
    corners, faces = block((0.06, 0.06, 0.03), (0, 0, RADIUS + 0.016))
    depths = []
    for proxy in (None, build_proxy(model, 1000)):
        weight = Collider(np.array(corners).T.copy(), np.array(faces))
        world = World([Session(model, proxy=proxy)], [weight], masses=[0.5])
        world.step(1.0)
        depths.append(-float(world.props[0].pose()[2, 3]))
    assert depths[1] == pytest.approx(depths[0], rel=0.04)
