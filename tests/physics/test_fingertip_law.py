"""The force on a fingertip is the measured law at its depth, whatever simulates the body: the sentences that follow."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pytest

from core.base import TICK, Floats
from core.body.model import build_model
from core.material import Material
from core.mesh.ray import ray_hit
from core.mesh.surface import Mesh, base_vertices
from core.native.motion import Touch
from core.native.scene import Collider
from core.reduction.proxy import build_proxy
from core.session import Finger, Session
from core.world import World
from studies.law.press_and_drag import (
    FAR,
    PACE,
    Place,
    Surface,
    closest,
    drag,
    drag_figures,
    normal_force,
    over_surface,
    places,
    put,
)
from studies.meshes.simple import icosphere, sized
from studies.paper_objects import PRESETS
from studies.scenes import cube
from tests.bodies import block

SIZE, TIP, G = 0.165, 0.010, 9.81
VINYL, WATER = PRESETS[1].material, PRESETS[2].material
UP, ASIDE = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
CLEAR = 5e-4  # [m] a fingertip farther from the skin than a twentieth of its radius does not touch it


def ball(subdivisions: int = 4) -> Mesh:
    return sized(*icosphere(subdivisions), SIZE)


def eared() -> Mesh:
    """Return a ball with two ears, each 12 mm thick and 35 mm long."""
    points, faces = icosphere(4)
    for side in (-1, 1):
        along = np.array([side * 0.6, 0.0, 0.8])
        off = points - (points @ along)[:, None] * along
        thin, wide = off[:, 1], off @ np.cross(along, ASIDE)
        near = np.exp(-((thin / 0.11) ** 2) - (wide / 0.3) ** 4) * (points @ along > 0)
        points = points * (1 + 0.42 * near)[:, None]
    return sized(points, faces, SIZE)


def standing(mesh: Mesh, material: Material = VINYL, **options: object) -> Session:
    """Return a session of a body on its base."""
    return Session(build_model(mesh, [material], pinned=base_vertices(mesh)), **options)  # type: ignore[arg-type]


def place_on(mesh: Mesh, outward: Floats, beside: Sequence[float] = (0.0, 0.0, 0.0)) -> Place:
    """Return where a ray from outside towards a point beside the middle meets a mesh."""
    start, way = tuple((outward + beside).tolist()), tuple((-outward).tolist())
    hit = ray_hit(start, way, mesh.rest_positions, mesh.triangles)  # type: ignore[arg-type]
    assert hit
    return Place(np.array(hit[1]), np.array(hit[2]), mesh.size)


def pressed(
    session: Session, place: Place, depth: float, *, tip: float = TIP, frame: float = 1 / 60, seconds: float = 0.5
) -> Touch:
    """Press a body within half of some seconds and rest for the other half."""
    for share in np.linspace(0.0, 2.0, round(seconds / frame) + 1).clip(0, 1):
        touch = put(session, place.at + (tip - share * depth) * place.outward, tip, frame)
    return touch


def gap(session: Session, centre: Floats) -> float:
    """Return how far the fingertip's surface is from the skin as it is drawn [m]."""
    found = closest(session.skin()[session.model.mesh.triangles], centre)
    return float(np.linalg.norm(found - centre, axis=1).min()) - TIP


@pytest.mark.parametrize(("backend", "rounding"), [("native", 1e-3), ("native64", 1e-9)])
def test_a_free_body_gains_exactly_what_the_fingertip_loses(backend: str, rounding: float) -> None:
    mesh = ball(2)
    session = Session(build_model(mesh, [VINYL]), backend=backend)
    start, given = np.array([0.01, 0.02, mesh.rest_positions[:, 2].max() + TIP]), np.zeros(3)
    for time in np.arange(1, 51) * 2 * TICK:  # down and to one side, so that friction pushes too
        given -= put(session, start + time * np.array([0.1, -0.05, -0.2]), TIP, 2 * TICK).impulse
    gained = (session.body.model.mass * session.body.velocities()).sum(axis=1)
    assert np.linalg.norm(given) > 0.01 and abs(given[0]) > 1e-3
    np.testing.assert_allclose(gained, given, atol=rounding * float(np.linalg.norm(given)))


@pytest.mark.parametrize("friction", [0.0, 0.5, 2.0])
@pytest.mark.parametrize("body", ["ball", "cube", "eared"])
def test_a_closed_cycle_of_pressing_and_sliding_gives_back_no_more_than_it_took(body: str, friction: float) -> None:
    """From rest on, a body can never have given more than it has taken."""
    mesh = {"ball": lambda: ball(3), "cube": lambda: cube(4, SIZE), "eared": eared}[body]()
    session, rng = standing(mesh, replace(VINYL, friction=friction)), np.random.default_rng(2)
    top = place_on(mesh, UP, (0.05, 0.01, 0.0)).at + TIP * UP
    clear = top + (mesh.rest_positions[:, 2].max() + 2 * TIP - top[2]) * UP
    for _ in range(2):
        inside = [top + rng.uniform([-0.02, -0.02, -0.018], [0.04, 0.02, -0.002]) for _ in range(3)]
        corners = [clear, *inside, inside[0], clear]
        session.reset()
        taken, speed = [0.0], rng.uniform(0.03, 0.3)
        for centre in _path(corners, speed * 4 * TICK):
            put(session, centre, TIP, 4 * TICK)
            taken.append(session.frame.work)
        assert max(taken) > 1e-3
        assert min(taken) > -1e-3 * max(taken)


def _path(corners: Sequence[Floats], step: float) -> Iterator[Floats]:
    for a, b in itertools.pairwise(corners):
        yield from np.linspace(a, b, max(2, round(float(np.linalg.norm(b - a)) / step) + 1))


@pytest.mark.parametrize("tip", [0.005, TIP, 0.02])
def test_a_fingertip_that_just_touches_has_neither_depth_nor_force(tip: float) -> None:
    session = standing(ball(3))
    for place in places(session.model, tip, 20, np.random.default_rng(0)):
        session.reset()
        touch = put(session, place.at + tip * place.outward, tip, 1 / 60)
        assert abs(touch.depth) < 1e-6 and np.linalg.norm(touch.force) < 1e-3


DEPTHS = (0.3 * VINYL.x0, 1.4 * VINYL.x0)


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("cells", [1, 4, 16])
def test_the_force_does_not_depend_on_the_mesh_of_a_cube(cells: int, depth: float) -> None:
    mesh = cube(cells, SIZE)
    touch = pressed(standing(mesh), place_on(mesh, UP, (0.021, 0.013, 0.0)), depth)
    assert normal_force(touch) == pytest.approx(VINYL.law(depth), rel=0.01)


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("subdivisions", [2, 3, 4])
def test_the_force_does_not_depend_on_the_mesh_of_a_ball(subdivisions: int, depth: float) -> None:
    mesh, outward = ball(subdivisions), np.array([0.36, 0.48, 0.8])
    touch = pressed(standing(mesh), place_on(mesh, outward), depth)
    assert normal_force(touch) == pytest.approx(VINYL.law(depth), rel=0.03)


@pytest.mark.parametrize("depth", DEPTHS)
def test_the_force_does_not_depend_on_a_proxy(depth: float) -> None:
    mesh, outward = ball(), np.array([0.36, 0.48, 0.8])
    model = build_model(mesh, [VINYL], pinned=base_vertices(mesh))
    forces = [
        normal_force(pressed(Session(model, proxy=proxy), place_on(mesh, outward), depth))
        for proxy in (None, build_proxy(model, 500))
    ]
    assert forces[1] == pytest.approx(forces[0], rel=0.01)


@pytest.mark.parametrize("depth", DEPTHS)
def test_the_force_depends_on_no_step_no_friction_and_no_frame_rate(depth: float) -> None:
    mesh = ball(3)
    place = place_on(mesh, np.array([0.36, 0.48, 0.8]))
    wanted = normal_force(pressed(standing(mesh), place, depth))
    finer = standing(mesh)
    finer.substeps *= 3
    others = {
        "three times the steps": pressed(finer, place, depth),
        "half a tick": pressed(standing(mesh, tick=TICK / 2), place, depth),
        "no friction": pressed(standing(mesh, replace(VINYL, friction=0.0)), place, depth),
        "three times the friction": pressed(standing(mesh, replace(VINYL, friction=1.5)), place, depth),
        "24 frames a second": pressed(standing(mesh), place, depth, frame=1 / 24),
        "120 frames a second": pressed(standing(mesh), place, depth, frame=1 / 120),
    }
    assert {name: normal_force(each) for name, each in others.items()} == pytest.approx(
        dict.fromkeys(others, wanted), rel=0.005
    )


def test_a_second_fingertip_in_the_dent_of_the_first_feels_nothing_before_it_meets_the_skin() -> None:
    mesh, wide, deep = ball(), 0.020, 0.018
    session, top = standing(mesh), place_on(mesh, UP)
    pressed(session, top, deep, tip=wide)
    x, y, z = (top.at + (wide - deep) * UP).tolist()
    first, place = Finger((x, y, z), wide), place_on(mesh, UP, (0.031, 0.0, 0.0))
    ways, found = np.arange(-0.002, 0.014, 2.5e-4), []
    for way in ways.tolist():
        a, b, c = centre = place.at + (TIP - way) * place.outward
        session.set_fingers([first, Finger((a, b, c), TIP)])
        touch = session.step(1 / 60).touches[1]
        assert touch
        found.append((gap(session, centre), float(np.linalg.norm(touch.force)), normal_force(touch)))
    _felt_where_it_is_seen(ways, found)


def test_a_side_that_bulges_under_a_plate_is_felt_where_it_is_seen() -> None:
    import trimesh

    mesh = ball(3)
    session, place, thick = standing(mesh, WATER), place_on(mesh, ASIDE), 0.01
    points, faces = trimesh.remesh.subdivide_to_size(*block((0.2, 0.2, thick), (0.0, 0.0, 0.0)), max_edge=0.03)
    start = points + UP * (mesh.rest_positions[:, 2].max() + thick / 2 + 0.002)
    world = World([session], [Collider(np.ascontiguousarray(start.T), faces)])
    for share in np.linspace(0.0, 1.0, 22):
        world.set_colliders([start - share * 0.042 * UP])
        world.step(0.02)
    ways, found = np.arange(-0.009, 0.004, 2.5e-4), []
    for way in ways.tolist():
        a, b, c = centre = place.at + (TIP - way) * place.outward
        session.set_fingers([Finger((a, b, c), TIP)])
        world.step(1 / 60)
        touch = session.frame.touches[0]
        assert touch
        found.append((gap(session, centre), float(np.linalg.norm(touch.force)), normal_force(touch)))
    _felt_where_it_is_seen(ways, found, WATER)


def _felt_where_it_is_seen(ways: Floats, found: list[tuple[float, float, float]], material: Material = VINYL) -> None:
    """Judge a fingertip that goes some ways into the surface at rest, by gap, force and normal force on each."""
    gaps, forces, normal = np.array(found).T
    met = float(ways[gaps < CLEAR][0])
    assert abs(met) > 0.001, "the skin is elsewhere than at rest"
    assert forces[gaps > CLEAR].max() == 0, "and before it is met there is no force"
    inside = ways - met
    felt = np.interp(0.004, inside, normal)
    assert felt == pytest.approx(material.law(0.004), rel=0.15), "from there on it is the law's"


def test_a_slope_that_changes_under_a_resting_fingertip_acts_in_the_next_frame() -> None:
    mesh, depth = ball(3), 0.5 * VINYL.x0
    session = standing(mesh)
    pressed(session, place_on(mesh, UP), depth)
    for factor in (3.0, 0.4):
        softer = replace(VINYL, K1=factor * VINYL.K1)
        session.change(build_model(mesh, [softer], pinned=base_vertices(mesh)))
        touch = session.step(1 / 60).touches[0]
        assert touch
        assert normal_force(touch) == pytest.approx(softer.law(depth), rel=0.02)


@pytest.mark.parametrize("force", [1.0, 5.0, 20.0])
@pytest.mark.parametrize("material", [VINYL, WATER], ids=["air", "water"])
@pytest.mark.parametrize("body", ["ball", "cube"])
def test_pressed_by_a_force_the_depth_is_that_of_the_law(body: str, material: Material, force: float) -> None:
    mesh = ball(3) if body == "ball" else cube(1, SIZE)
    session, place = standing(mesh, material), place_on(mesh, UP, (0.011, 0.007, 0.0))
    x, y, z = (place.at + TIP * place.outward).tolist()
    a, b, c = (-place.outward).tolist()
    session.set_fingers([Finger((x, y, z), TIP, force, (a, b, c))])
    frame = session.step(1.5)
    ways = np.linspace(0, 2 * material.x0, 10_000)
    wanted = float(np.interp(force, [material.law(way) for way in ways], ways))
    assert frame.depths[0] == pytest.approx(wanted, rel=0.01)
    touch = frame.touches[0]
    assert touch and normal_force(touch) == pytest.approx(force, rel=0.01)


def lifted(friction: float) -> tuple[float, float]:
    """Squeeze a free cube between a thumb and two fingertips, lift it by 40 mm and hold it.

    Returns:
        Its height at the end [m], and the sum of the law's forces that squeezed it [N].
    """
    edge, deep = PRESETS[0].size, 0.010
    material = replace(PRESETS[0].material, friction=friction)
    session = Session(build_model(cube(6, edge), [material], gravity=(0, 0, -G), ground=-edge / 2))
    sides, squeezed, frames = [(-1.0, 0.0), (1.0, -0.2 * edge), (1.0, 0.2 * edge)], 0.0, np.arange(1, 102) / 60
    in_by, up_by = np.interp(frames, (0, 0.3), (-0.002, deep)), np.interp(frames, (0.5, 1.2), (0, 0.040))
    for squeeze, height in zip(in_by.tolist(), up_by.tolist(), strict=True):
        session.set_fingers([Finger((side * (edge / 2 + TIP - squeeze), y, height), TIP) for side, y in sides])
        depths = session.step(1 / 60).depths
        if height == 0:
            squeezed = sum(material.law(depth) for depth in depths)
    return float(session.positions()[:, 2].mean()), squeezed


def test_three_fingertips_lift_a_cube_and_hold_it_as_long_as_friction_carries_it() -> None:
    height, squeezed = lifted(0.5)
    limit = G * (PRESETS[0].material.mass or 0.0) / squeezed  # the friction that just carries its weight
    assert height > 0.035 and 0.02 < limit < 0.2
    assert lifted(1.4 * limit)[0] > 0.030
    assert lifted(0.7 * limit)[0] < 0.010, "it is dropped"


@pytest.mark.parametrize("body", ["cube", "eared"])
@pytest.mark.parametrize("manner", ["over the surface", "straight"])
def test_over_an_edge_and_round_an_ear_the_force_does_not_jump(body: str, manner: str) -> None:
    """Dragged at 100 mm/s it changes by no more than a tenth from tick to tick, and is the law's all along.

    In the crease below the ear, narrower than the fingertip, one tick in twenty may: it meets wall after wall.
    """
    mesh = cube(4, SIZE) if body == "cube" else eared()
    session, surface = standing(mesh), Surface(mesh)
    beside = {"cube": (0.07, 0.02, 0.0), "eared": (0.02, 0.0, 0.0)}[body]
    for turn in (0.2, 2.0, 4.0):
        place, way = place_on(mesh, UP, beside), np.array([np.cos(turn), np.sin(turn), 0.0])
        way -= (way @ place.outward) * place.outward
        path = over_surface(surface, place, TIP, way / np.linalg.norm(way))
        if manner == "straight":
            path = path[0] + np.arange(0, FAR, PACE)[:, None] * way
        over, sideways, jumps = drag_figures(drag(session, place, TIP, path, 0.1), VINYL)
        print(f"{body}, {manner}, {turn:g}: {over.min():.3f} to {over.max():.3f} of the law, "
              f"{sideways.max(initial=0):.3f} of the limit sideways, jump {jumps.max():.3f}")
        assert np.quantile(jumps, 1.0 if body == "cube" else 0.95) < 0.1
        np.testing.assert_allclose(over, 1.0, atol=0.02)
        assert sideways.max() < 1.02
