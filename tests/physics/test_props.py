"""A prop falls on a soft body, sinks in until the body carries its weight, and rests there."""

from dataclasses import replace

import numpy as np
import pytest

from core.base import DimpleError, Floats, Ints
from core.body import rigid
from core.body.model import Model, build_model
from core.material import Indenter
from core.mesh.surface import base_vertices
from core.native.scene import Collider
from core.session import Session
from core.world import World
from core.world.props import shrunk, touching_gap
from studies.contact.meeting import met
from studies.paper_objects import PRESETS
from studies.reference import rigid as turning
from studies.reference.energy import stored
from studies.scenes import cube
from tests.bodies import block

G, SIDE = 9.81, 0.165
DISC, THICK = 0.04, 0.02  # [m] radius and height of a flat weight
ABOVE = 0.002  # [m] where it falls from


def disc() -> tuple[Floats, Ints]:
    import trimesh

    made = trimesh.creation.cylinder(radius=DISC, height=THICK, sections=24)
    return np.array(made.vertices) + [0, 0, SIDE / 2 + THICK / 2 + ABOVE], np.array(made.faces)


def vinyl(cells: int = 12, **changes: float) -> Model:
    mesh = cube(cells, SIDE)
    material = replace(PRESETS[1].material, damping_ratio=0.5, **changes)  # type: ignore[arg-type]
    return build_model(mesh, [material], pinned=base_vertices(mesh))


def falling(session: Session, start: Floats, faces: Ints, mass: float, ground: float | None = None) -> World:
    return World([session], [Collider(np.ascontiguousarray(start.T), faces)], masses=[mass], ground=ground)


def led(model: Model, depth: float) -> float:
    """Return the force [N] with which a body answers the disc that is led to a depth [m]."""
    (start, faces), session = disc(), Session(model)
    collider, _ = shrunk(Collider(np.ascontiguousarray(start.T), faces), touching_gap(session))
    world, start = World([session], [collider]), collider.positions.T.copy()
    for share in np.linspace(0, 1, 21)[1:]:
        world.set_colliders([start - [0, 0, share * (ABOVE + depth)]])
        world.step(0.03)
    world.set_colliders([None])
    world.step(0.6)
    session.wake()
    return float(met(world, 0.1).forces[1, 2])


@pytest.mark.parametrize(
    "mass", [pytest.param(0.5, marks=pytest.mark.slow), 1.0, pytest.param(2.0, marks=pytest.mark.slow)]
)
def test_it_rests_at_the_depth_at_which_the_body_answers_its_weight(mass: float) -> None:
    model, (start, faces) = vinyl(), disc()
    session = Session(model)
    world = falling(session, start, faces, mass)
    world.step(2.0)
    session.wake()  # a sleeping body exerts no force
    carried = [met(world, 0.002).forces[1, 2] for _ in range(100)]
    assert np.mean(carried) == pytest.approx(mass * G, rel=0.01), "the body carries its weight"
    depth = SIDE / 2 - float(world.props[0].state.centre[2] - THICK / 2)
    assert led(model, depth) == pytest.approx(mass * G, rel=0.05), "as much as if it were held there"
    rest, down = model.mesh.rest_positions, model.mesh.rest_positions[:, 2] - session.body.positions()[2]
    under = down[(rest[:, 2] > 0.49 * SIDE) & (np.hypot(rest[:, 0], rest[:, 1]) < DISC)]
    assert np.median(under) == pytest.approx(depth, abs=5e-4) and under.min() > depth - 1e-4, "it stands on the skin"
    assert np.linalg.norm(world.props[0].state.velocity) < 0.01


@pytest.mark.parametrize("mass", [0.5, pytest.param(1.0, marks=pytest.mark.slow), 2.0])
def test_a_flat_weight_rests_as_deep_as_the_law_says_that_was_measured_with_a_punch_like_it(mass: float) -> None:
    """Filled with nothing: a fill adds its pressure, which the closed form leaves out; with air it is a fifth less."""
    mesh, tip = cube(24, SIDE), Indenter(shape="punch", radius=DISC)
    material = replace(PRESETS[1].material, indenter=tip, fill="none")
    session = Session(build_model(mesh, [material], pinned=base_vertices(mesh)))
    world = falling(session, *disc(), mass)
    world.step(4.0)
    depth = SIDE / 2 - float(world.props[0].state.centre[2] - THICK / 2)
    ways = np.linspace(0, 2 * material.x0, 10_000)
    wanted = float(np.interp(mass * G, [material.law(way) for way in ways], ways))
    print(f"{mass} kg: {1e3 * depth:.2f} mm for {1e3 * wanted:.2f} mm by the law, {depth / wanted - 1:+.1%}")
    assert depth == pytest.approx(wanted, rel=0.05)
    assert np.linalg.norm(world.props[0].state.velocity) < 0.01


@pytest.mark.parametrize("size", [(0.1, 0.06, 0.02), (0.1, 0.1, 0.1)])
def test_what_touches_of_a_prop_lies_inside_it_by_a_gap(size: tuple[float, float, float]) -> None:
    points, faces = block(size, (0.0, 0.0, 0.0))
    for turned in (faces, faces[:, ::-1]):
        (inner, by), wanted = shrunk(Collider(np.ascontiguousarray(points.T), turned), 0.002), np.array(size) - 0.004
        np.testing.assert_allclose(np.ptp(inner.positions, axis=1), wanted, atol=1e-9)
        assert by == 0.002
    sheet = Collider(np.ascontiguousarray(points.T), faces[:-1])
    assert shrunk(sheet, 0.002) == (sheet, 0.0), "what is open has no inside"
    thin = Collider(np.ascontiguousarray((points * [1, 1, 0.01]).T), faces)
    assert np.ptp(shrunk(thin, 0.002)[0].positions[2]) > 0.4 * 0.01 * size[2], "and what is thin keeps a thickness"


def test_what_falls_free_falls_as_newton_says_and_keeps_its_spin() -> None:
    points, faces = block((0.1, 0.06, 0.02), (0.0, 0.0, 0.0))
    shape = rigid.rigid_shape(points + [0.5, 0, 0], faces, 2.0)
    np.testing.assert_allclose(shape.centre, [0.5, 0, 0], atol=1e-9)
    wanted = 2.0 / 12 * np.array([0.06**2 + 0.02**2, 0.1**2 + 0.02**2, 0.1**2 + 0.06**2])
    np.testing.assert_allclose(np.diag(shape.inertia), wanted, rtol=1e-2)
    world = falling(Session(vinyl(2)), points + [0.5, 0, 0], faces, 2.0)
    state = world.props[0].state
    state.momentum = momentum = shape.inertia @ [2.0, 9.0, 1.0]
    before = turning.energy(shape, state, np.zeros(3))
    world.step(1.0)
    assert state.centre[2] == pytest.approx(-G / 2, rel=2e-3)
    np.testing.assert_array_equal(state.momentum, momentum)
    state.velocity[:] = 0
    assert turning.energy(shape, state, np.zeros(3)) == pytest.approx(before, rel=0.02)
    gaps = np.linalg.norm(rigid.positions(shape, state)[:, None] - rigid.positions(shape, state), axis=2)
    np.testing.assert_allclose(gaps, np.linalg.norm(points[:, None] - points, axis=2), atol=1e-12)


def test_energy_does_not_grow() -> None:
    model, (start, faces) = vinyl(), disc()
    session, gravity = Session(model, backend="native64"), np.array([0.0, 0.0, -G])
    world = falling(session, start, faces, 1.0)
    begun, left = turning.energy(world.props[0].falling.shape, world.props[0].state, gravity), [0.0]
    for _ in range(250):
        world.step(0.001)
        moving = turning.energy(world.props[0].falling.shape, world.props[0].state, gravity)
        left.append(held_by(session, model) + moving - begun)
    lowest = np.minimum.accumulate(left)
    assert lowest[-1] < -0.008, "it has sunk in"
    # a tick's speed is half a tick ahead of its place
    assert (left - lowest).max() < G * np.sqrt(2 * G * ABOVE) * 0.001, "nothing comes back"


def held_by(session: Session, model: Model) -> float:
    """Return the energy of a body's motion and shape [J]."""
    x, v, pose = session.body.positions(), session.body.velocities(), (np.eye(3), np.zeros(3))
    moving = 0.5 * float((model.mass * (v * v).sum(axis=0)).sum())
    return moving + stored(model, x, pose)


def test_a_ball_that_lands_beside_the_middle_of_a_ball_rolls_off_it() -> None:
    import trimesh

    from studies.scenes import ball

    mesh = ball(2, 0.08)
    session = Session(build_model(mesh, [replace(PRESETS[1].material, spread=0.02)], pinned=base_vertices(mesh)))
    small = trimesh.creation.icosphere(2, 0.02)
    world = falling(session, np.array(small.vertices) + [0.05, 0, 0.095], np.array(small.faces), 0.1)
    world.step(0.5)
    assert world.props[0].state.centre[0] > 0.1 and world.props[0].state.centre[2] < 0.02
    assert turning.spin(world.props[0].falling.shape, world.props[0].state)[1] > 1.0, "it turns as it rolls"


def test_a_prop_without_mass_or_faces_is_refused() -> None:
    start, faces = disc()
    for mass in (0.0, float("inf"), float("nan")):
        with pytest.raises(DimpleError, match="greater than 0 kg"):
            rigid.rigid_shape(start, faces, mass)
    with pytest.raises(DimpleError, match="no faces"):
        rigid.rigid_shape(np.zeros((3, 3)), np.array([[0, 1, 2]]), 1.0)


def test_a_sheet_is_a_shell_whose_centre_is_its_own() -> None:
    points = np.array([[0.0, 0, 0], [0.2, 0, 0], [0.2, 0.1, 0], [0, 0.1, 0]])
    shape = rigid.rigid_shape(points, np.array([[0, 1, 2], [0, 2, 3]]), 3.0)
    np.testing.assert_allclose(shape.centre, [0.1, 0.05, 0])
    assert shape.inertia[2, 2] == pytest.approx(3.0 / 12 * (0.2**2 + 0.1**2), rel=1e-2)


@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_what_falls_beside_the_body_comes_to_rest_on_the_ground(tilt: float) -> None:
    """A block of 60 x 40 x 20 mm, flat and on an edge; it settles on a face, and its energy never grows."""
    turned, faces = block((0.06, 0.04, 0.02), (0.3, 0.0, 0.0), (0.0, tilt, 0.1))
    world = falling(Session(vinyl(4)), turned, faces, 0.2, -SIDE / 2)
    energies = []
    for _ in range(20):
        world.step(0.05)
        energies.append(turning.energy(world.props[0].falling.shape, world.props[0].state, np.array([0.0, 0.0, -G])))
    heights = (world.props[0].pose()[:3, :3] @ turned.T).T[:, 2] + world.props[0].pose()[2, 3] + SIDE / 2
    assert np.sort(heights)[:4] == pytest.approx(0.0, abs=2e-5) and heights.min() > -1e-9, "four corners are on it"
    assert np.linalg.norm(world.props[0].state.velocity) < 1e-3
    assert np.diff(energies).max() < 0.005 * 0.2 * G * SIDE / 2, "of what it falls"


def test_on_the_ground_it_slides_until_friction_has_taken_its_speed() -> None:
    """v^2 / 2 mu g."""
    speed = 1.0
    world = falling(Session(vinyl(4)), *block((0.06, 0.06, 0.01), (0.3, 0.0, -SIDE / 2 + 0.005)), 0.2, -SIDE / 2)
    world.props[0].state.velocity = np.array([speed, 0.0, 0.0])
    begun = world.props[0].state.centre[0]
    world.step(0.6)
    assert world.props[0].state.centre[0] - begun == pytest.approx(speed**2 / (2 * 0.5 * G), rel=0.02)
    assert np.linalg.norm(world.props[0].state.velocity) < 1e-6
