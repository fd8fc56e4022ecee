"""A fingertip meets a body in C as in the reference: force, depth, slope and direction, wherever it goes."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from core.base import Floats
from core.body.model import Model, build_model
from core.material import FINGERTIP
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.native.motion import FingertipMotion, Motion, Touch
from core.other_tip import factors
from studies.motions import straight
from studies.reference import create
from studies.scenes import cube
from tests.bodies import ball
from tests.parity.cases import CASES, SIZE, SOFT, TICK

RADIUS, SPEED = 0.01, 0.6  # [m], [m/s]
SOLID = replace(SOFT, fill="solid", indenter=FINGERTIP)


def sphere(**options: object) -> Model:
    points, faces = ball(2)
    mesh = mesh_from_triangles(points * SIZE / 2, faces)
    held = {} if options.pop("free", False) else {"pinned": base_vertices(mesh)}
    return build_model(mesh, [options.pop("material", SOFT)], **held, **options)  # type: ignore[arg-type]


def groove() -> Model:
    """Return a sheet that is bent upwards on both sides of y = 0, held at its rim."""
    i, j = np.meshgrid(np.arange(9), np.arange(9), indexing="ij")
    points = np.stack([0.01 * (i - 4), 0.01 * (j - 4), 0.008 * abs(j - 4)], axis=2).reshape(-1, 3)
    a = (9 * i + j)[:-1, :-1].ravel()
    faces = np.concatenate([np.stack([a, a + 9, a + 10], 1), np.stack([a, a + 10, a + 1], 1)])
    mesh = mesh_from_triangles(points, faces)
    rim = (abs(mesh.rest_positions[:, :2]) > 0.039).any(axis=1)
    return build_model(mesh, [replace(SOFT, fill="none")], pinned=rim)


def block() -> Model:
    mesh = cube(4, 0.1)
    return build_model(mesh, [SOFT], pinned=base_vertices(mesh))


def layer() -> Model:
    """Return a solid of 30 mm, so thin that what is below counts."""
    mesh = cube(4, 0.1)
    mesh = mesh_from_triangles(mesh.rest_positions * (1, 1, 0.3), mesh.triangles)
    return build_model(mesh, [SOLID], pinned=base_vertices(mesh))


def maps() -> dict[str, Floats]:
    rng = np.random.default_rng(4)
    return {name: rng.uniform(0.2, 0.8, 162) for name in ("softness", "knee")}


Way = list[tuple[float, float, float]]


@dataclass(frozen=True, kw_only=True)
class Press:
    """A model, the ways of fingertips through points [mm], and what else is said of these.

    lift: the second is taken away half way.
    """

    model: Callable[[], Model]
    ways: list[Way]
    radius: float = RADIUS
    force: float = 0.0
    lift: bool = False


TOP = 80.0  # [mm] of the sphere; and of the cube: 50
PRESSES = {
    "straight in": Press(model=sphere, ways=[[(2, 1, TOP + 10.5), (2, 1, TOP - 5)]]),
    "dragged": Press(model=sphere, ways=[[(-30, 1, TOP + 10.5), (-20, 1, TOP), (25, 8, TOP - 2)]]),
    "over an edge": Press(model=block, ways=[[(20, 3, 60.5), (22, 3, 54), (62, 7, 53), (61, 7, 20)]]),
    "round a corner": Press(model=block, ways=[[(40, 38, 60.5), (42, 40, 53), (58, 44, 48), (40, 61, 40)]]),
    "from behind a sheet": Press(model=groove, ways=[[(-3, 1, -10.5), (-2, 0.5, -6), (20, -0.5, -4)]]),
    "from inside, put outside": Press(model=sphere, ways=[[(3, 2, TOP - 9), (4, 3, TOP), (9, 3, TOP)]]),
    "in a groove": Press(model=groove, ways=[[(-3, 1, 13.5), (-2, 0.5, 8), (20, -0.5, 8), (22, 12, 16)]]),
    "on a free body": Press(
        model=lambda: sphere(free=True), ways=[[(2, 1, TOP + 10.5), (1, 0, TOP - 9), (9, 5, TOP - 20)]]
    ),
    "another tip on a layer": Press(model=layer, ways=[[(2, 1, 20.5), (4, 2, 14), (30, 9, 13)]], radius=0.005),
    "another tip on a bed": Press(model=sphere, ways=[[(2, 1, TOP + 15.5), (4, 2, TOP + 8)]], radius=0.015),
    "on painted maps": Press(
        model=lambda: sphere(**maps()), ways=[[(-9, 1, TOP + 10.5), (-2, 1, TOP + 2), (25, 8, TOP)]]
    ),
    "by a force": Press(model=sphere, ways=[[(2, 1, TOP + 10.2), (2, 1, TOP + 10), (2, 16, TOP + 10)]], force=3.0),
    "by a force, dragged": Press(model=sphere, ways=[[(2, 1, TOP + 10.2), (12, 1, TOP + 9)]], force=3.0),
    "beside another": Press(
        model=sphere, ways=[[(8, 0, TOP + 12), (9, 0, TOP - 4), (4, 1, TOP)], [(-8, 0, TOP + 10.2), (-8, 0, TOP - 3)]],
        lift=True,
    ),
    "two lift a free body": Press(
        model=lambda: sphere(free=True, gravity=(0, 0, -9.81)),
        ways=[[(sign * (TOP + 10.5), 1, 2), (sign * (TOP + 6), 1, 2), (sign * (TOP + 6), 1, 9)] for sign in (1, -1)],
    ),
}  # fmt: skip


def places(way: Way) -> Floats:
    """Return where a fingertip is after each tick (ticks + 1, 3) [m], at SPEED."""
    points = 1e-3 * np.array(way, np.float64)
    spent = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]) / SPEED
    at = np.arange(int(spent[-1] / TICK) + 1) * TICK
    return np.stack([np.interp(at, spent, column) for column in points.T], axis=1)


@cache
def pressed(name: str, backend: str) -> list[tuple[Touch, ...]]:
    """Return the touches of a press after each tick."""
    press = PRESSES[name]
    model = press.model()
    body, found = create(model, backend=backend), []
    ways = [places(way) for way in press.ways]
    other = factors(model.materials, press.radius, model.mesh.size)
    for t in range(max(map(len, ways)) - 1):
        tips = []
        for k, way in enumerate(ways):
            start, end = (tuple(way[min(at, len(way) - 1)].tolist()) for at in (t, t + 1))
            tip = FingertipMotion(start, end, end, press.radius, t == 0, press.force, factors=other)
            tips.append(tip if not (press.lift and k == 1 and t > 0.6 * len(ways[0])) else None)
        frame = body.step(Motion(1, model.substeps(TICK), TICK, tuple(tips)))
        assert frame.finite
        found.append(tuple(touch for touch in frame.touches if touch))
    return found


@pytest.mark.parametrize("name", PRESSES)
@pytest.mark.parametrize(("backend", "tolerance"), [("native64", 1e-7), ("native", 5e-3)])
def test_a_press_is_the_same_in_c_as_in_the_reference(name: str, backend: str, tolerance: float) -> None:
    radius = PRESSES[name].radius
    expected, found = pressed(name, "numpy"), pressed(name, backend)
    most = max(float(np.linalg.norm(touch.force)) for tick in expected for touch in tick)
    assert most > 0.3, "it presses"
    for t, (ours, theirs) in enumerate(zip(expected, found, strict=True)):
        for one, other in zip(ours, theirs, strict=True):
            said = f"in tick {t}"
            np.testing.assert_allclose(other.force, one.force, atol=tolerance * most, err_msg=said)
            np.testing.assert_allclose(other.outward, one.outward, atol=tolerance, err_msg=said)
            assert other.depth == pytest.approx(one.depth, abs=tolerance * radius), said
            assert other.slope == pytest.approx(one.slope, rel=tolerance, abs=1e-6), said
            assert other.law == pytest.approx(one.law, rel=tolerance), said
            assert other.friction == one.friction


@pytest.mark.parametrize("seed", range(2))
def test_a_fingertip_that_wanders_about_a_body_has_the_depth_numpy_finds(seed: int) -> None:
    """In and out, round corners and past the middle: it is followed alike."""
    rng = np.random.default_rng(seed)
    points, faces = CASES["crumpled"].shape()
    mesh = mesh_from_triangles(points * SIZE / np.ptp(points, axis=0).max(), faces)
    model = build_model(mesh, [SOFT], pinned=base_vertices(mesh))
    bodies = [create(model, backend=backend) for backend in ("numpy", "native64")]
    here, met = np.array([0.0, 0.0, 0.8 * SIZE]), 0
    for step in range(60):
        there = rng.normal(0, 0.35 * SIZE, 3)
        tip = FingertipMotion(tuple(here), tuple(there), tuple(there), 0.1 * SIZE, step % 20 == 0)
        expected, found = (body.step(Motion(0, 1, TICK, (tip._replace(start=tuple(there)),))) for body in bodies)
        one, other = expected.touches[0], found.touches[0]
        assert one and other
        assert other.depth == pytest.approx(one.depth, abs=1e-9)
        np.testing.assert_allclose(other.outward, one.outward, atol=1e-9)
        assert other.force == pytest.approx(one.force, rel=1e-6, abs=1e-9)
        here, met = there, met + (one.depth > 0)
    assert met > 10


def test_a_sheet_is_pressed_from_behind_as_from_the_front_and_a_body_from_outside_alone() -> None:
    """Also where the body has a hole: what is far behind it is not inside it, and what is inside comes from outside."""
    bodies = [create(groove()), create(sphere())]
    for body, (x, y, z) in ((bodies[0], (0.0, 0.0, -0.05)), (bodies[1], (0.01, 0.0, 0.1))):
        tip = FingertipMotion((x, y, z), (x, y, z), (x, y, z), RADIUS, True)
        touch = body.step(Motion(0, 1, TICK, (tip,))).touches[0]
        assert touch and touch.centre == (x, y, z) and touch.force == (0.0, 0.0, 0.0)
    within = (0.01, 0.0, 0.06)
    points, faces = ball(2)
    open_below = faces[points[faces].mean(axis=1)[:, 2] > -0.8]
    holed = create(build_model(mesh_from_triangles(points * SIZE / 2, open_below), [SOFT]))
    for body in (bodies[1], holed):
        touch = body.step(Motion(0, 1, TICK, (FingertipMotion(within, within, within, RADIUS, True),))).touches[0]
        assert touch and np.linalg.norm(touch.centre) > 0.99 * (SIZE / 2 + RADIUS) - 2e-3


@pytest.mark.parametrize("backend", ["native64", "numpy"])
def test_a_body_that_flies_and_spins_gains_the_momentum_and_the_moment_that_the_fingertip_loses(backend: str) -> None:
    model = sphere(free=True, material=replace(SOFT, friction=0.0))
    body, mass, rest = create(model, backend=backend), model.matching.mass, model.matching.rest
    velocities = np.array([[0.5], [0.0], [0.0]]) + np.cross([[0.0], [1.0], [0.0]], rest, axis=0)
    body.set_state(rest, velocities)
    substeps, given, turned = model.substeps(TICK), np.zeros(3), np.zeros(3)
    step, top = TICK / substeps, SIZE / 2 + RADIUS
    for k in range(20 * substeps):
        start, end = ((0.02 + 0.5 * t, 0.01, top - 0.2 * t) for t in (k * step, (k + 1) * step))
        touch = body.step(Motion(1, 1, step, (FingertipMotion(start, end, end, RADIUS, k == 0),))).touches[0]
        assert touch
        given -= touch.impulse
        turned -= np.cross(start, touch.impulse)  # through its centre, but for what a foot may be aside
    gained = (body.velocities() - velocities) @ mass
    spun = np.cross(body.positions(), body.velocities(), axis=0) @ mass - np.cross(rest, velocities, axis=0) @ mass
    assert np.linalg.norm(given) > 1e-4
    np.testing.assert_allclose(gained, given, atol=1e-10 * np.linalg.norm(given))
    np.testing.assert_allclose(spun, turned, atol=1e-3 * RADIUS * np.linalg.norm(given))


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_no_number_that_is_none_comes_into_a_force(backend: str) -> None:
    """Where the law falls with the depth it has no slope, and what is beyond all measure is no force."""
    model = sphere(free=True)
    falling, beyond = (np.linspace(first, 0, 33)[None] for first in (1.0, 1e308))
    for table in (falling, beyond):
        body = create(model, backend=backend)
        start, end = ((0.0, 0.0, SIZE / 2 + RADIUS - down) for down in (-1e-4, 8e-3))
        tip = straight(start, end, ticks=10, radius=RADIUS, fresh=True)
        frame = body.step(Motion(10, model.substeps(TICK), TICK, (tip._replace(factors=(table, 4e-3)),)))
        for touch in frame.touches:
            assert touch and np.isfinite([*touch.force, *touch.impulse, touch.slope]).all() and touch.slope >= 0
