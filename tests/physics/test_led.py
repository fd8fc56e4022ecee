"""A collider follows its keyframes and the skin gives way, whatever its tessellation and speed."""

import numpy as np
import pytest
import trimesh

from core.base import Floats, Ints
from core.body.model import build_model
from core.errors import DimpleError
from core.material import Material
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from core.world import Collider, World
from studies.contact.meeting import met
from studies.reference.facets import nearest_on_triangles
from studies.scenes import cube
from tests.bodies import ball

MATERIAL = Material(K1=600, K2=4000, x0=0.02, k=400, spread=0.02, mass=0.15, friction=0.4)
SIDE, DEEP, ABOVE = 0.1, 0.03, 0.002  # [m] of the cube, how deep things are led into it, and from where


def star() -> trimesh.Trimesh:
    turn = np.arange(10) * np.pi / 5
    r = np.where(np.arange(10) % 2, 0.012, 0.03)
    rim = [np.c_[r * np.cos(turn), r * np.sin(turn), np.full(10, z)] for z in (0.0, 0.02)]
    faces = []
    for i in range(10):
        j = (i + 1) % 10
        faces += [[20, j, i], [21, 10 + i, 10 + j], [i, j, 10 + j], [i, 10 + j, 10 + i]]
    return trimesh.Trimesh(np.concatenate([*rim, [[0, 0, 0], [0, 0, 0.02]]]), faces)


def cone() -> trimesh.Trimesh:
    made = trimesh.creation.cone(0.01, 0.06, sections=12)
    made.vertices[:, 2] *= -1
    made.invert()
    return made


SHAPES = {
    "box": lambda: trimesh.creation.box((0.03, 0.03, 0.03)), "bar": lambda: trimesh.creation.box((0.03, 0.2, 0.03)),
    "plate": lambda: trimesh.creation.box((0.06, 0.06, 0.01)), "star": star, "cone": cone,
    "blade": lambda: trimesh.creation.box((0.004, 0.2, 0.04)),
}  # fmt: skip


def shape(name: str, cuts: int) -> tuple[Floats, Ints]:
    made = SHAPES[name]()
    for _ in range(cuts):
        made = made.subdivide()
    points = np.array(made.vertices)
    return points - [0, 0, points[:, 2].min()] + [7e-4, 1.3e-3, ABOVE], np.array(made.faces)


def soft_cube(cells: int = 12) -> Session:
    """Return a cube that is pinned below; its top is at a height of 0."""
    mesh = cube(cells, SIDE)
    points = mesh.rest_positions - [0, 0, SIDE / 2]
    low = points[:, 2] < -SIDE + 1e-6
    return Session(build_model(mesh_from_triangles(points, mesh.triangles), [MATERIAL], pinned=low))


def soft_ball(height: float) -> Session:
    """Return a ball of a height [m], a pillow where that is less than its width, pinned below; its top is at 0."""
    points, faces = ball(4, SIDE / 2)
    points = points * [1, 1, height / SIDE] - [0, 0, height / 2]
    return Session(build_model(mesh_from_triangles(points, faces), [MATERIAL], pinned=points[:, 2] < -0.9 * height))


TARGETS = {"cube": lambda: soft_cube(16), "ball": lambda: soft_ball(SIDE), "pillow": lambda: soft_ball(0.6 * SIDE)}


def led(name: str, cuts: int, speed: float, target: str) -> tuple[float, float]:
    """Lead a shape into a body; return its force [N] and how far the skin is below it [m]."""
    session, (start, faces) = TARGETS[target](), shape(name, cuts)
    world = World([session], [Collider(start.T.copy(), faces)])
    ticks = round((DEEP + ABOVE) / speed / 1e-3)
    for tick in range(1, ticks + 1):
        end = start - [0, 0, (DEEP + ABOVE) * tick / ticks]
        world.set_colliders([end])
        world.step(1e-3)
        assert np.abs(world.collider(0) - end).max() < 1e-12 and not world.held
    for _ in range(20):
        world.step(1e-2)
    world.check()
    force = np.mean([met(world, 1e-3).forces[1, 2] for _ in range(20)])
    x, low = session.body.positions().T, np.array([7e-4, 1.3e-3, world.collider(0)[:, 2].min()])
    corners = x[session.body.model.mesh.triangles].transpose(2, 0, 1)
    near = np.einsum("ctk,tk->ct", corners, nearest_on_triangles(corners, low))
    return float(force), float(np.linalg.norm(near - low[:, None], axis=0).min())


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize(
    ("speed", "target"),
    [(0.1, "cube"), (1.0, "cube"), (1.0, "ball"), (1.0, "pillow"), pytest.param(0.01, "cube", marks=pytest.mark.slow)],
)
def test_a_led_shape_goes_where_it_is_led_with_the_skin_below_it_and_as_hard_however_it_is_cut(
    name: str, speed: float, target: str
) -> None:
    forces, gaps = zip(*(led(name, cuts, speed, target) for cuts in (0, 1)), strict=True)
    print(f"{name} {speed} m/s into a {target}: {forces} N, {gaps} m")
    assert max(gaps) < 1.6e-3  # the skin touches at 0.7 mm, and bridges what lies between its edges
    assert max(forces) < 1.1 * min(forces)


def test_a_led_shape_that_skin_cannot_get_away_from_is_held_back_and_that_is_said() -> None:
    session, (start, faces) = soft_cube(), shape("plate", 0)
    world = World([session], [Collider(start.T.copy(), faces)], itself=[True], names=["Cube", "Plate"])
    for tick in range(1, 121):
        world.set_colliders([start - [0, 0, tick * 1e-3]])
        world.step(1e-3)
        world.check()
    (held,) = world.held
    assert held.name == "Plate" and held.late > 0.01 and world.collider(0)[:, 2].min() > -SIDE
    assert held.said == session.held_note and "no room" in held.said


@pytest.mark.parametrize("speed", [1.0, 3.0, 6.0, 10.0, 20.0])
def test_a_ball_led_through_a_body_lets_go_of_it_and_it_comes_back_to_rest(speed: float) -> None:
    points, faces = ball(3, 0.0825)
    session = Session(build_model(mesh_from_triangles(points, faces), [MATERIAL], pinned=points[:, 2] < -0.06))
    tip, corners = ball(2, 0.02)
    start = tip + [-0.15, 0.0, 0.02]
    world, most, ticks = World([session], [Collider(start.T.copy(), corners)]), 0.0, round(1.2 / speed / 1e-3)
    torn = False
    for tick in range(1, ticks + 1):
        world.set_colliders([start + [1.2 * tick / ticks, 0, 0]])
        world.step(1e-3)
        torn = torn or any(held.torn for held in world.held)
        most = max(most, float(np.linalg.norm(session.body.positions().T - points, axis=1).max()))
    for _ in range(100):
        world.step(1e-2)
    print(f"{speed} m/s: skin at most {1e3 * most:.0f} mm from its place, let go: {torn}")
    assert most < 1.3 * 0.165
    assert np.linalg.norm(session.body.positions().T - points, axis=1).max() < 5e-3
    try:
        world.check()
    except DimpleError:
        pytest.fail("they meet again where they are apart")


@pytest.mark.parametrize("mass", [0.5, 2.0, 6.0])
def test_a_falling_box_rests_as_deep_whole_as_cut(mass: float) -> None:
    depths = []
    for cuts in (0, 1, 2):
        start, faces = shape("plate", cuts)
        world = World([soft_cube(16)], [Collider(np.ascontiguousarray(start.T), faces)], masses=[mass])
        world.step(3.0)
        depths.append(-float(world.props[0].state.centre[2]) + 0.005)
    print(f"{mass} kg: {depths} m")
    assert max(depths) < 1.05 * min(depths)
