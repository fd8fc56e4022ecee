"""Bodies meet colliders, each other and themselves; nothing passes through anything, and what is put down stays."""

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import core.session.stepping
from core.base import DimpleError
from core.body.model import build_model
from core.constants import OFFSET
from core.material import Material
from core.mesh.surface import mesh_from_triangles
from core.native.motion import Frame
from core.session import Session
from core.world import Collider, World
from studies.contact.judge import trembling_of
from studies.contact.meeting import meeting_of, met
from studies.contact.scenes import SCENES
from studies.meshes.simple import icosphere
from studies.reference.proximity import find_pairs, join_surfaces
from studies.scenes import cube
from tests.bodies import ball, sheet

SOFT = Material(K1=600, K2=4000, x0=0.02, k=400, spread=0.02, mass=0.15, friction=0.4)
RADIUS = 0.04


def session(
    at: tuple[float, float, float], *, gravity: float = -9.81, level: int = 2, backend: str = "native",
    turn: tuple[float, float, float] = (0, 0, 0), held: bool = False,
) -> Session:  # fmt: skip
    """Return a ball, turned about its axes [rad], and held by its lowest quarter or free."""
    points, faces = ball(level, RADIUS)
    points = Rotation.from_euler("xyz", turn).apply(points)
    mesh, pinned = mesh_from_triangles(points + at, faces), points[:, 2] < -0.5 * RADIUS if held else None
    return Session(build_model(mesh, [SOFT], gravity=(0, 0, gravity), pinned=pinned), backend=backend)


def table(slope: float = 0.0, friction: float = 0.4) -> Collider:
    points, faces = sheet(2, 1.0)
    return Collider(Rotation.from_euler("y", slope).apply(points).T.copy(), faces, friction)


def test_a_fast_ball_meets_a_resting_table_alike_at_any_height() -> None:
    taken = []
    for height in (0.0, 1.0):
        body, top = session((0.0, 0.0, height + RADIUS + 0.002), gravity=0.0), table()
        positions = body.body.positions()
        body.body.set_state(positions, np.tile([[0.0], [0.0], [-8.0]], positions.shape[1]))
        world = World([body], [top._replace(positions=top.positions + [[0.0], [0.0], [height]])])
        taken.append(sum(met(world, 1e-3).taken for _ in range(20)))
    assert taken[1] == pytest.approx(taken[0], rel=0.1, abs=1e-3)


def momentum(body: Session) -> np.ndarray:
    return body.body.velocities() @ body.model.mass


@pytest.mark.parametrize(("at", "gravity"), [(-0.05, -9.81), (-0.15, 9.81)], ids=["in it", "below it"])
def test_an_open_bowl_stops_a_ball_from_within_and_from_without(at: float, gravity: float) -> None:
    points, faces = ball(3, 0.1)
    bowl = Collider(points.T.copy(), faces[points[faces].mean(axis=1)[:, 2] < 0.06], 0.4)
    body = session((0, 0, at), gravity=gravity)
    world = World([body], [bowl])
    before = body.body.positions()[2].mean()
    world.step(0.5)
    far = np.linalg.norm(body.body.positions(), axis=0)
    assert meeting_of(world).touching and abs(body.body.positions()[2].mean() - before) > 0.005
    assert far.max() < 0.1 if at > -0.1 else far.min() > 0.1 * np.cos(0.1)  # the bowl is of flat faces


def test_two_bodies_that_collide_keep_their_momentum() -> None:
    sessions = [
        session((0.003, 0, 0), gravity=0, backend="native64"),
        session((0, 0, 0.09), gravity=0, backend="native64"),
    ]
    sessions[1].body.set_state(sessions[1].body.positions(), np.full((3, 162), 0.0) + [[0.0], [0.1], [-1.0]])
    before = sum(momentum(each) for each in sessions)
    world, most = World(sessions), 0
    for _ in range(60):
        most = max(most, met(world, 1e-3).touching)
        assert meeting_of(world).taken == 0
    assert most > 5
    assert np.abs(sum(momentum(each) for each in sessions) - before).max() < 1e-13
    assert abs(momentum(sessions[0])[2]) > 0.05


def test_a_dropped_ball_comes_to_rest_on_a_table_whatever_the_frame_rate() -> None:
    ends = []
    for rate in (24, 60, 120):
        body = session((0.001, 0.002, 0.06))
        world = World([body], [table()])
        for _ in range(rate):
            world.step(1 / rate)
        ends.append(body.positions())
        assert 0 < ends[-1][:, 2].min() < 3e-3
    assert all(np.abs(a - b).max() < 1e-5 for a, b in pairwise(ends))


@pytest.mark.parametrize("speed", [0.5, 5.0])
def test_a_plate_that_would_press_a_body_to_nothing_waits_and_passes_neither_body_nor_table(speed: float) -> None:
    body = session((0.001, 0.002, RADIUS + 1e-3))
    start = sheet(2, 0.5)[0] + (0, 0, 2 * RADIUS + 2e-3)
    world, most = World([body], [table(), Collider(start.T.copy(), sheet(2, 0.5)[1])]), 0.0
    for tick in range(1, 201):
        world.set_colliders([None, start - (0, 0, min(speed * tick * 1e-3, 2 * RADIUS + 4e-3))])
        most = max(most, met(world, 1e-3).held_back)
        world.check()
    assert body.frame.finite and most > 0
    assert body.positions()[:, 2].min() > 0 and world.collider(1)[:, 2].min() > 0


def slide(slope: float, friction: float, edge: float, *, soft: bool = False, block: bool = False) -> float:
    """Return the acceleration [m/s2] of a sheet or a block, its edges 12.5 mm, down a flat surface of so long edges."""
    turn, cells = Rotation.from_euler("y", slope), max(round(0.4 / edge), 2)
    points, faces = (cube(8, 0.1).rest_positions, cube(8, 0.1).triangles) if block else sheet(8, 0.1)
    flat, squares = sheet(cells, cells * edge)
    points = Rotation.from_euler("z", 0.3).apply(points - (0, 0, points[:, 2].min()))
    gap = OFFSET * (0.0125 + (edge if soft else 0.0125)) * 1.14
    material = Material(K1=2000, K2=2000, x0=0.01, k=400, mass=0.1, friction=friction)
    body, *base = (
        Session(build_model(mesh_from_triangles(turn.apply(x), f), [material], pinned=pinned, gravity=(0, 0, -9.81)))
        for x, f, pinned in ((points + (0, 0, gap), faces, None), (flat, squares, np.ones(len(flat), bool)))[: 1 + soft]
    )
    collider = Collider(turn.apply(flat).T.copy(), squares, friction)
    world, speeds = World([body, *base], [] if soft else [collider]), []
    for _ in range(2):
        world.step(0.1)
        speeds.append(float(momentum(body) @ turn.apply((1, 0, 0))) / 0.1)
    return (speeds[1] - speeds[0]) / 0.1


@pytest.mark.parametrize("soft", [False, True])
@pytest.mark.parametrize("edge", [0.5, pytest.param(0.025, marks=pytest.mark.slow), 0.0125,
                                  pytest.param(0.00625, marks=pytest.mark.slow)])  # fmt: skip
def test_flat_on_flat_slides_as_coulomb_says_however_fine_they_are_and_without_friction_freely(
    edge: float, soft: bool
) -> None:
    for block in (False, True):
        for friction in (0.0, 0.4):
            most = 9.81 * np.cos(0.6)
            drag = (9.81 * np.sin(0.6) - slide(0.6, friction, edge, soft=soft, block=block)) / most
            assert abs(drag - friction) < 0.008, (block, friction)


@pytest.mark.parametrize("edge", [0.5, 0.0125])
def test_friction_holds_a_body_on_a_slope_up_to_its_cone_and_lets_it_slide_beyond(edge: float) -> None:
    assert abs(slide(np.arctan(0.98 * 0.4), 0.4, edge)) < 1e-3
    assert slide(np.arctan(1.02 * 0.4), 0.4, edge) > 0.03


def test_what_intersects_at_the_start_is_refused_with_its_names_and_its_place() -> None:
    with pytest.raises(DimpleError, match=r'"Ball" and "Table" intersect at \('):
        World([session((0, 0, 0.03))], [table()], names=["Ball", "Table"])


def test_a_body_that_is_far_from_everything_moves_as_if_alone() -> None:
    alone, met = session((0, 0, 1.0)), session((0, 0, 1.0))
    world = World([met], [table()])
    for _ in range(20):
        alone.step(1e-3)
        world.step(1e-3)
    assert np.array_equal(alone.body.positions(), met.body.positions())


def test_bodies_pressed_together_keep_the_distance_at_which_they_touch_and_are_still() -> None:
    sessions = []
    for side in (-1, 1):
        points, faces = ball(3, RADIUS)
        placed = points @ Rotation.from_euler("xyz", (0.3, 0.5 * side, 0.2)).as_matrix().T
        pinned = placed[:, 2] * side > 0.5 * RADIUS
        mesh = mesh_from_triangles(placed + (0, 0, side * (RADIUS + 5e-4)), faces)
        sessions.append(Session(build_model(mesh, [SOFT], pinned=pinned)))
    rests, world = [body.model.mesh.rest_positions for body in sessions], World(sessions)
    x = np.zeros((0, 3))
    for tick in range(300):
        for body, rest, side in zip(sessions, rests, (-1, 1), strict=True):
            body.set_pins(rest - (0, 0, side * min(tick / 150, 1.0) * 0.012))
        world.step(1e-3)
        if tick == 250:
            x = np.concatenate([body.positions() for body in sessions])
    surfaces = join_surfaces(rests, [body.model.mesh.triangles for body in sessions])
    before, x = x, np.concatenate([body.positions() for body in sessions]).astype(np.float64)
    touch = OFFSET * float(surfaces.edge.sum())
    pairs = find_pairs(surfaces, x, 0, 1, reach=2 * touch, closest=0.0)
    faces_of = pairs.ones == 1
    assert np.count_nonzero(pairs.gap[faces_of] < 1.1 * touch) > 50
    gaps = pairs.gap[faces_of] / touch  # of 3,910 pairs in 14 such presses, 2 are nearer than 0.9, the nearest 0.87
    assert np.percentile(gaps, 1) > 0.9 and gaps.min() > 0.8
    assert np.abs(x - before).max() < 5e-5
    assert meeting_of(world).truncated == 0 and meeting_of(world).queries == 0


class Slow(World):
    """A world each tick of which takes so long [s], by a clock of its own."""

    clock, each = 0.0, 0.0

    def _run(self, sessions: Sequence[Session], at_once: int) -> tuple[Sequence[Frame], int]:
        found, ticks = super()._run(sessions, at_once)
        Slow.clock += ticks * self.each
        return found, ticks


@pytest.mark.parametrize("each", [0.001, 0.006, 0.05])
def test_a_frame_of_a_tangle_keeps_its_budget_but_for_a_first_tick_and_time_runs_slower(
    each: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(core.session.stepping, "time", SimpleNamespace(perf_counter=lambda: Slow.clock))
    body = session((0, 0, 0.05))
    world = Slow([body], [table()])
    for now in (each, each / 4, each):  # what a tick costs changes as things come together and part
        Slow.each = now
        for _ in range(3):
            before, time = Slow.clock, body.frame.time
            world.step(0.1, budget=0.02)
            spent, done = Slow.clock - before, body.frame.time - time
            assert done == pytest.approx(1e-3 * spent / now)
            assert spent <= max(0.02, now) + 1e-9
            assert spent >= min(0.02 - 1.001 * now, 100 * now)


def three_balls(backend: str, *, itself: bool = True) -> World:
    """Return a mesh of three balls: two pass through each other, and the third comes down on the first at 2 m/s."""
    points, faces = ball(1, RADIUS)
    n, places = len(points), [(0.0, 0.0, 0.0), (0.05, 0.0, 0.0), (0.0, 0.0, 0.082)]
    mesh = mesh_from_triangles(
        np.concatenate([points + place for place in places]), np.concatenate([faces + k * n for k in range(3)])
    )
    body = Session(build_model(mesh, [SOFT]), backend=backend)
    speed = np.zeros((3, 3 * n))
    speed[2, 2 * n :] = -2.0
    body.body.set_state(body.body.positions(), speed)
    return World([body], itself=[itself], names=["Head"])


def test_faces_that_pass_through_others_of_a_body_at_the_start_are_left_out_of_self_contact_and_nothing_else() -> None:
    world = three_balls("native64")
    found = re.search(r"itself at \((.+), .+, .+\) mm: (\d+) pairs of faces", world.notes[0])
    assert found and 0 < float(found[1]) < 50 and int(found[2]) > 10
    for _ in range(5):
        world.step(1e-3)
        world.check()
    through = three_balls("native64", itself=False)
    through.step(5e-3)
    for x, passes in ((world.sessions[0].body.positions(), False), (through.sessions[0].body.positions(), True)):
        low, high = np.split(x[2], 3)[0::2]
        assert (high.min() < low.max() - 1e-3) == passes


def drift(world: World, body: Session) -> float:
    """Return how far any vertex goes in ten seconds [m], after the body has come to rest within five."""
    world.step(5.0)
    before, most = body.body.positions(), 0.0
    for _ in range(10):
        world.step(1.0)
        most = max(most, float(np.abs(body.body.positions() - before).max()))
    return most


@pytest.mark.parametrize("turn", [(0.3, 0.5, 0.2), (1.0, 0.1, 0.7)])
def test_a_ball_on_a_table_stops_rocking_and_stays(turn: tuple[float, float, float]) -> None:
    body = session((0.001, 0.002, RADIUS + 0.003), turn=turn)
    assert drift(World([body], [table()]), body) < 1e-5


LOW, HIGH = (0.3, 0.5, 0.2), (0.1, 0.2, 0.9)  # [rad]


@pytest.mark.parametrize("off", [pytest.param(0.0, marks=pytest.mark.slow), 0.0002])
def test_a_ball_at_rest_on_another_drifts_by_about_a_tenth_of_a_millimetre_in_ten_seconds(off: float) -> None:
    low = session((0, 0, 0), level=3, turn=LOW, held=True)
    gap, bottom = 1e-3, session((0, 0, 0), level=3, turn=HIGH).model.mesh.rest_positions[:, 2].min()
    body = session((off, 0, low.model.mesh.rest_positions[:, 2].max() - bottom + gap), level=3, turn=HIGH)
    assert drift(World([low, body]), body) < 1.2e-4
    assert body.body.positions()[2].mean() > 1.8 * RADIUS, "it has not rolled off"


def test_a_ball_beside_the_top_of_another_rolls_off() -> None:
    body = session((0.008, 0, 2 * RADIUS), level=3, turn=LOW)
    World([session((0, 0, 0), level=3, turn=LOW, held=True), body]).step(2.0)
    assert body.body.positions()[2].mean() < 0


def test_what_lies_on_a_table_sleeps_with_what_lies_on_it_and_wakes_where_it_was() -> None:
    (flat, squares), top = sheet(8, 0.1), table()
    meshes = [mesh_from_triangles(flat + (0, 0, height), squares) for height in (0.003, 0.006)]
    sheets = [Session(build_model(mesh, [SOFT], gravity=(0, 0, -9.81))) for mesh in meshes]
    world = World(sheets, [top])
    world.step(3.0)
    world.step(1.0)
    assert not any(body.moved for body in sheets)
    before = [body.body.positions() for body in sheets]
    world.step(1.0)
    assert all(np.array_equal(a, body.body.positions()) for a, body in zip(before, sheets, strict=True))
    world.set_colliders([top.positions.T + (1e-5, 0, 0)])
    world.step(1e-3)
    assert all(body.moved for body in sheets)
    assert max(np.abs(a - body.body.positions()).max() for a, body in zip(before, sheets, strict=True)) < 2e-5


@pytest.mark.parametrize(
    ("scene", "start"), [("hand_squeezes_ball", 1), ("balls_pressed_flat", 3), ("vinyl_into_ring", 0)]
)
def test_skin_that_is_squeezed_from_all_sides_comes_nearly_to_rest(scene: str, start: int) -> None:
    played = SCENES[scene](np.random.default_rng(start))
    for tick in range(1, played.ticks + 1):
        played.world.set_colliders([lead and lead(tick / played.ticks) for lead in played.colliders])
        played.world.step(1e-3)
    assert trembling_of(played.world) < 2e-4


@pytest.mark.parametrize("seed", [5, 9])
def test_a_collider_that_slides_over_the_border_of_pinned_skin_throws_no_vertex(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points, faces = icosphere(3, RADIUS)
    points = points @ np.linalg.qr(rng.normal(size=(3, 3)))[0].T
    mesh, pinned = mesh_from_triangles(points, faces), points[:, 0] < 0
    body = Session(build_model(mesh, [replace(SOFT, spread=None)], pinned=pinned))
    tip, tip_faces = icosphere(1, 0.006)
    tip, aside, fastest = tip @ np.linalg.qr(rng.normal(size=(3, 3)))[0].T, rng.uniform(-0.01, 0.01), 0.0
    world = None
    for share in np.linspace(0, 1, 501):
        turn, far = 0.7 - 1.4 * share, np.sqrt(RADIUS**2 - aside**2) + 0.012 - 0.006 * min(1, 4 * share)
        at = tip + (far * np.sin(turn), aside, far * np.cos(turn))
        world = world or World([body], [Collider(at.T.copy(), tip_faces, 0.4)], gravity=(0, 0, 0))
        world.set_colliders([at])
        world.step(1e-3)
        fastest = max(fastest, float(np.linalg.norm(body.body.velocities(), axis=0).max()))
    assert fastest < 5  # [m/s] the tip slides at 0.1 m/s over skin that is 6 mm deep
