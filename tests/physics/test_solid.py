"""A solid: its skin gives way under a fingertip, shows on it, and comes back; beside it nothing changes."""

from dataclasses import replace

import numpy as np
import pytest

from core.base import Floats
from core.body.model import Model, build_model
from core.material import DEFAULT_MATERIAL, Material
from core.mesh.surface import base_vertices
from core.reduction.proxy import build_proxy
from core.session import Finger, Session
from studies.meshes.simple import icosphere, sized
from studies.scenes import cube

BACKENDS = ["native64", "native"]
RADIUS, TIP, DEPTH = 0.08, 0.010, 0.012  # [m]
SOLID = replace(DEFAULT_MATERIAL, K2=2.1 * DEFAULT_MATERIAL.K1, x0=0.006, fill="solid", density=1000, damping_ratio=1.0)


def ball(material: Material, subdivisions: int = 3) -> Model:
    mesh = sized(*icosphere(subdivisions), 2 * RADIUS)
    return build_model(mesh, [material], pinned=base_vertices(mesh))


def pressed(session: Session, depth: float = DEPTH, radius: float = TIP) -> tuple[Finger, float]:
    """Press from above, wait, and return the fingertip and its force [N]."""
    above = Finger((0.0, 0.0, RADIUS + radius), radius)
    tip = above._replace(position=(0.0, 0.0, RADIUS + radius - depth))
    session.set_fingers([above])
    session.set_fingers([tip])
    session.step(0.2)
    session.step(0.3)
    return tip, float(session.step(0.02).finger_forces[0][2])


def inside(points: Floats, tip: Finger) -> float:
    """Return how deep [m] the deepest point (n, 3) lies in a fingertip."""
    return tip.radius - float(np.linalg.norm(points - np.array(tip.position), axis=1).min())


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_skin_gives_way_and_shows_on_the_fingertip(backend: str) -> None:
    session = Session(ball(SOLID, 4), backend=backend)
    tip, _ = pressed(session)
    body, shown = session.body.positions().T, session.positions().astype(float)
    assert 0.1 * TIP < inside(body, tip) < 0.5 * TIP
    assert abs(inside(shown, tip)) < 1e-6
    moved = np.linalg.norm(shown - body, axis=1) > 1e-7
    assert np.array_equal(moved, np.linalg.norm(body - np.array(tip.position), axis=1) < TIP - 1e-7)


def test_no_other_fill_has_a_skin_that_gives_way() -> None:
    for fill in ("air", "liquid", "none"):
        assert not ball(replace(SOLID, fill=fill)).compliance.any()


@pytest.mark.parametrize("radius", [0.003, 0.01, 0.02])
def test_no_fingertip_passes_it_however_deep(radius: float) -> None:
    session = Session(ball(SOLID, 4))
    forces = []
    for depth in np.linspace(0.5 * radius, min(10 * radius, 0.05), 5):
        tip, force = pressed(session, depth, radius)
        forces.append(force)
        assert inside(session.body.positions().T, tip) < 0.55 * radius
    assert np.all(np.diff(forces) > 0)


def test_after_a_change_of_the_fill_it_is_as_if_it_had_always_been_so() -> None:
    """Without friction, which remembers the way."""
    solid = replace(SOLID, friction=0.0)
    before = ball(replace(solid, fill="liquid"), 4)
    after = build_model(before.mesh, [solid], pinned=base_vertices(before.mesh))
    for first, then in ((before, after), (after, before)):
        session, fresh = Session(first), Session(then)
        pressed(session), pressed(fresh)
        session.change(then)
        session.step(1.0)
        assert np.abs(session.positions() - fresh.positions()).max() < 0.01 * DEPTH


def test_the_force_does_not_depend_on_the_step() -> None:
    coarse, fine = Session(ball(SOLID)), Session(ball(SOLID))
    fine.substeps *= 10
    assert pressed(coarse)[1] == pytest.approx(pressed(fine)[1], rel=0.01)


def test_a_force_presses_it_as_deep_as_that_depth_answers() -> None:
    session = Session(ball(SOLID))
    _, force = pressed(session)
    session.reset()
    session.set_fingers([Finger((0.0, 0.0, RADIUS + TIP), TIP, force=force)])
    session.step(1.0)
    session.step(1.0)
    placed = session.placed[0]
    assert placed and RADIUS + TIP - placed.position[2] == pytest.approx(DEPTH, rel=0.02)


def test_a_proxy_gives_way_as_the_full_mesh_does() -> None:
    full = ball(SOLID, 5)
    proxy = build_proxy(full, 2562)
    assert (1 / proxy.model.compliance).sum() == pytest.approx((1 / full.compliance).sum(), rel=0.01)
    session = Session(full, proxy=proxy)
    tip, force = pressed(session)
    assert force == pytest.approx(pressed(Session(full))[1], rel=0.1)
    assert inside(session.positions().astype(float), tip) < 1e-6


def test_beside_a_hard_material_only_the_solid_gives_way() -> None:
    mesh = ball(SOLID).mesh
    half = replace(mesh, triangle_material=(mesh.rest_positions[mesh.triangles, 0].mean(axis=1) > 0).astype(int))
    compliance = build_model(half, [SOLID, replace(SOLID, fill="liquid")], pinned=base_vertices(mesh)).compliance
    x = mesh.rest_positions[:, 0]
    assert (compliance[x < -0.01] > 0).all() and not compliance[x > 0.01].any()


def test_friction_drags_a_solid_no_more_than_what_is_hard() -> None:
    """A shallow dent dragged along a flat face: sideways the coefficient times the push."""
    mesh, friction = cube(30, 0.16), 0.3
    session = Session(build_model(mesh, [replace(SOLID, friction=friction)], pinned=base_vertices(mesh)))
    place = (-0.015, 0.002, 0.08 + TIP - 0.002)
    session.set_fingers([Finger((*place[:2], 0.08 + TIP), TIP)])
    session.set_fingers([Finger(place, TIP)])
    session.step(0.3)
    forces = []
    for step in range(36):
        session.set_fingers([Finger((place[0] + 0.03 * (step + 1) / 36, *place[1:]), TIP)])
        forces.append(session.step(1 / 60).finger_forces[0])
    side, _, up = np.mean(forces[24:], axis=0)
    assert -side / up == pytest.approx(friction, rel=0.1)
