"""Scenes in which soft bodies meet colliders, each other and themselves, harder than anybody should: judged by
`python3 dev.py contact`.

Each is a function of a random generator, which jitters the start, and returns what is to happen.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import trimesh

from core.base import Bools, Floats
from core.body.model import build_model
from core.material import DEFAULT_MATERIAL, Material
from core.mesh.surface import mesh_from_triangles
from core.session import Session
from core.world import Collider, World
from studies.meshes.simple import Shape, grid, icosphere

Lead = Callable[[float], Floats]  # vertices (m, 3) [m] at a share of the time, 0 to 1

SOFT = Material(K1=600, K2=4000, x0=0.02, k=400, mass=0.15, friction=0.4)
LIGHT = Material(K1=600, K2=4000, x0=0.01, k=400, mass=0.02, friction=0.4)
SHEET = Material(K1=60, K2=60, x0=0.01, k=60, mass=0.02, friction=0.3)
JITTER = 5e-4  # [m]


@dataclass(slots=True, kw_only=True)
class Played:
    """One start of a scene.

    world: what is stepped.
    ticks: for how long.
    colliders: where each collider goes, None where it rests.
    pins: where the vertices of each body would go if they were all pinned, None where it has none.
    """

    world: World
    ticks: int
    colliders: Sequence[Lead | None] = ()
    pins: Sequence[Lead | None] = field(default_factory=tuple)


def hand_squeezes_ball(rng: np.random.Generator) -> Played:
    """Curl a sheet of fingers round a ball until it would be far smaller than the ball."""
    ball = moved(icosphere(3, 0.04), rng)
    flat = grid(28, 16, 0.26, 0.08)

    def curl(share: float) -> Floats:
        radius = 0.055 - 0.03 * share
        x, y = flat[0][:, 0], flat[0][:, 1]
        turn = x / 0.055 * (0.75 + 0.3 * share)
        return np.stack([radius * np.sin(turn), y, -radius * np.cos(turn)], axis=1)

    return _play([ball], [(curl(0.0), flat[1])], ticks=250, leads=[curl])


def balls_pressed_flat(rng: np.random.Generator) -> Played:
    """Press five balls of 30 mm flat to 5 mm between two plates."""
    places = [(0.0, 0.0), (0.034, 0.0), (-0.034, 0.0), (0.0, 0.034), (0.0, -0.034)]
    balls = [moved(icosphere(2, 0.015), rng, (*place, 0.016)) for place in places]
    low, high = grid(2, 2, 0.4, 0.4), grid(2, 2, 0.4, 0.4)
    down = _along(high[0] + (0, 0, 0.034), (0, 0, -0.029), rest=0.8)
    return _play(balls, [low, (down(0.0), high[1])], ticks=250, leads=[None, down])


def ball_through_ring(rng: np.random.Generator) -> Played:
    """Push a ball through a ring whose hole is two thirds as wide."""
    ring = trimesh.creation.torus(0.037, 0.01, major_sections=40, minor_sections=16)
    punch = icosphere(2, 0.012)
    push = _along(punch[0] + (0, 0, 0.09), (0, 0, -0.09), rest=0.8)
    ball = moved(icosphere(3, 0.04), rng, (0, 0, 0.035))
    return _play([ball], [_of(ring), (push(0.0), punch[1])], ticks=300, leads=[None, push])


def vinyl_into_ring(rng: np.random.Generator) -> Played:
    """Push a ball of the default material halfway through a ring whose hole is three quarters as wide."""
    ring, radius = trimesh.creation.torus(0.0825, 0.0206, major_sections=48, minor_sections=12), 0.0825
    punch = _box(0.058, 0.058, 0.058)
    push = _along(punch[0] + (0, 0, 0.2), (0, 0, -0.13), rest=0.6)
    ball = moved(icosphere(4, radius), rng, (0, 0, radius))
    return _play([ball], [_of(ring), (push(0.0), punch[1])], ticks=700, leads=[None, push], material=DEFAULT_MATERIAL)


def needle(rng: np.random.Generator) -> Played:
    """Stick a needle through where a ball lies."""
    cone = trimesh.creation.cone(0.003, 0.08, sections=12)
    cone.vertices[:, 2] = 0.08 - cone.vertices[:, 2]
    down = _along(np.array(cone.vertices) + (0, 0, 0.09), (0, 0, -0.08), rest=0.8)
    ball = moved(icosphere(3, 0.04), rng, (0, 0, 0.042))
    return _play([ball], [grid(2, 2, 0.4, 0.4), (down(0.0), np.array(cone.faces)[:, ::-1])], ticks=250,
                 leads=[None, down])  # fmt: skip


def twisted_bar(rng: np.random.Generator) -> Played:
    """Twist a bar by one and a half turns: it buckles and meets itself."""
    bar = _bar(0.16, 0.03, 20, 4)
    points = bar[0] + rng.normal(0, 1e-5, bar[0].shape)
    pinned = np.abs(points[:, 0]) > 0.079

    def twist(share: float) -> Floats:
        turn = 3 * np.pi * share * (points[:, 0] > 0)
        c, s = np.cos(turn), np.sin(turn)
        x, y, z = points.T
        return np.stack([x * (1 - 0.25 * share), c * y - s * z, s * y + c * z], axis=1)

    return _play([(points, bar[1])], [], ticks=400, pinned=[pinned], pins=[twist], itself=True, material=SOFT)


def two_lips(rng: np.random.Generator) -> Played:
    """Press two lips that nearly touch at rest together, and open them again."""
    lip = trimesh.creation.icosphere(3, 0.02).vertices * (2.5, 1, 0.6)
    faces = np.array(trimesh.creation.icosphere(3).faces)
    upper, lower = lip + (0, 0, 0.0122) + rng.uniform(-1, 1, 3) * (JITTER, JITTER, 0), lip - (0, 0, 0.0122)
    leads, pinned = [], []
    for points, way in ((upper, -1), (lower, 1)):
        pinned.append(points[:, 2] * -way > 0.018)
        leads.append(_there_and_back(points, (0, 0, 0.006 * way)))
    return _play([(upper, faces), (lower, faces)], [], ticks=300, pinned=pinned, pins=leads)


def folded_sheet(rng: np.random.Generator) -> Played:
    """Fold a sheet over onto itself by leading one edge, and press it down on the table."""
    points, faces = grid(24, 12, 0.16, 0.08)
    points = points + (0, 0, 0.004) + rng.normal(0, 1e-5, points.shape)
    pinned = np.abs(points[:, 0]) > 0.0799

    def fold(share: float) -> Floats:
        x, y, z = points.T
        angle = np.pi * 0.98 * share * (x > 0)
        return np.stack([np.where(x > 0, 0.08 * np.cos(angle), x), y, z + 0.08 * np.sin(angle) * (x > 0)], axis=1)

    table = grid(2, 2, 0.5, 0.5)
    return _play([(points, faces)], [table], ticks=400, pinned=[pinned], pins=[fold], itself=True, material=SHEET)


def pile_of_twenty(rng: np.random.Generator) -> Played:
    """Drop twenty balls into a box."""
    box = trimesh.creation.box((0.11, 0.11, 0.3))
    box.apply_translation((0, 0, 0.15))
    open_box = np.array(box.vertices), np.array(box.faces)[np.array(box.face_normals)[:, 2] < 0.5]
    balls = []
    for layer in range(5):
        for x, y in ((-0.026, -0.026), (0.026, -0.026), (-0.026, 0.026), (0.026, 0.026)):
            balls.append(moved(icosphere(2, 0.024), rng, (x, y, 0.026 + 0.052 * layer)))
    return _play(balls, [open_box], ticks=300, material=LIGHT)


def fast_fist(rng: np.random.Generator) -> Played:
    """Hit a ball on a table with a fist of 5 m/s, until it is nearly flat."""
    fist = trimesh.creation.box((0.06, 0.06, 0.06))
    down = _along(np.array(fist.vertices) + (0, 0, 0.16), (0, 0, -0.12), until=0.024 / 0.12)
    ball = moved(icosphere(3, 0.04), rng, (0, 0, 0.042))
    return _play([ball], [grid(2, 2, 0.4, 0.4), (down(0.0), np.array(fist.faces))], ticks=120, leads=[None, down])


def collider_ends_inside(rng: np.random.Generator) -> Played:
    """Lead a ball-shaped collider to the middle of a body that is pinned."""
    tip = icosphere(2, 0.015)
    way = _along(tip[0] + (0.06, 0, 0), (-0.06, 0, 0), rest=0.6)
    ball = moved(icosphere(3, 0.04), rng)
    return _play([ball], [(way(0.0), tip[1])], ticks=300, pinned=[ball[0][:, 0] < -0.03], leads=[way])


def weights_in_bowl(rng: np.random.Generator) -> Played:
    """Let six weights and a ball fall into an open bowl, on each other."""
    dish = trimesh.creation.icosphere(3, 0.15)
    dish.update_faces(dish.triangles[:, :, 2].max(axis=1) < 0.02)
    dish.remove_unreferenced_vertices()
    weights = [moved(_box(0.05, 0.04, 0.03), rng, (0.03 * (-1) ** k, 0.02 * (k % 3 - 1), 0.05 * k)) for k in range(6)]
    return _let_fall([moved(icosphere(2, 0.04), rng, (0, 0, -0.08))], [_of(dish)], weights, ticks=500)


def weights_struck(rng: np.random.Generator) -> Played:
    """Strike a stack of three weights on a table with a fist at 5 m/s, against a ball behind it."""
    fist, stack = icosphere(2, 0.04), [moved(_box(0.05, 0.05, 0.03), rng, (0, 0, 0.04 + 0.08 * k)) for k in range(3)]
    strike = _along(fist[0] + (-0.2, 0, 0.041), (0.5, 0, 0), rest=0.5)
    ball = moved(icosphere(2, 0.04), rng, (0.12, 0, 0.05))
    played = _let_fall([ball], [grid(8, 4, 1.2, 0.6), (strike(0.0), fist[1])], stack, ticks=200)
    played.colliders = [None, strike, *[None] * 3]
    return played


SCENES: dict[str, Callable[[np.random.Generator], Played]] = {
    make.__name__: make
    for make in (
        hand_squeezes_ball, balls_pressed_flat, ball_through_ring, vinyl_into_ring, needle, twisted_bar, two_lips,
        folded_sheet, pile_of_twenty, fast_fist, collider_ends_inside, weights_in_bowl, weights_struck,
    )
}  # fmt: skip


def _play(
    bodies: Sequence[Shape],
    colliders: Sequence[Shape],
    *,
    ticks: int,
    pinned: Sequence[Bools] = (),
    leads: Sequence[Lead | None] = (),
    pins: Sequence[Lead | None] = (),
    itself: bool = True,
    material: Material = SOFT,
) -> Played:
    sessions = []
    for i, (points, faces) in enumerate(bodies):
        mesh = mesh_from_triangles(points, faces)
        its = pinned[i] if pinned else None
        sessions.append(Session(build_model(mesh, [material], pinned=its, gravity=(0, 0, -9.81))))
    world = World(
        sessions, [Collider(points.T.copy(), faces, 0.4) for points, faces in colliders],
        itself=[itself] * len(sessions),
    )  # fmt: skip
    return Played(
        world=world, ticks=ticks, colliders=leads or [None] * len(colliders), pins=pins or [None] * len(sessions)
    )


def _let_fall(bodies: Sequence[Shape], led: Sequence[Shape], props: Sequence[Shape], *, ticks: int) -> Played:
    gravity = (0.0, 0.0, -9.81)
    sessions = [
        Session(build_model(mesh_from_triangles(*body), [SOFT], pinned=np.zeros(len(body[0]), bool), gravity=gravity))
        for body in bodies
    ]
    colliders = [Collider(points.T.copy(), faces, 0.4) for points, faces in (*led, *props)]
    masses = [*[None] * len(led), *[0.2] * len(props)]
    world = World(sessions, colliders, masses=masses, itself=[True] * len(sessions))
    return Played(world=world, ticks=ticks, colliders=[None] * len(colliders), pins=[None] * len(sessions))


def _box(*size: float) -> Shape:
    return _of(trimesh.creation.box(size))


def _of(mesh: trimesh.Trimesh) -> Shape:
    return np.array(mesh.vertices), np.array(mesh.faces, np.int64)


def moved(shape: Shape, rng: np.random.Generator, to: Sequence[float] = (0.0, 0.0, 0.0)) -> Shape:
    """Turn a shape at random and put it somewhere, up to half a millimetre off."""
    turn = trimesh.transformations.random_rotation_matrix(rng.random(3))[:3, :3]
    return shape[0] @ turn.T + np.asarray(to) + rng.uniform(0, JITTER, 3), shape[1]


def _bar(length: float, side: float, along: int, across: int) -> Shape:
    """Return a square bar along x, its sides of equal squares."""
    parts = []
    for normal in range(3):
        for sign in (-1, 1):
            sizes = [(length, along) if axis == 0 else (side, across) for axis in range(3) if axis != normal]
            points, faces = grid(sizes[0][1], sizes[1][1], sizes[0][0], sizes[1][0])
            whole = np.insert(points[:, :2], normal, sign * (length if normal == 0 else side) / 2, axis=1)
            parts.append((whole, faces if (sign > 0) != (normal == 1) else faces[:, ::-1]))
    starts = np.cumsum([0, *(len(points) for points, _ in parts)])
    mesh = trimesh.Trimesh(
        np.concatenate([points for points, _ in parts]),
        np.concatenate([faces + start for (_, faces), start in zip(parts, starts, strict=False)]),
    )
    mesh.merge_vertices()
    return _of(mesh)


def _along(points: Floats, way: Sequence[float], *, rest: float = 1.0, until: float | None = None) -> Lead:
    """Return a straight motion that is over at a share of the time, and rests then."""
    over = until if until is not None else rest
    return lambda share: points + min(share / over, 1.0) * np.asarray(way)


def _there_and_back(points: Floats, way: Sequence[float]) -> Lead:
    return lambda share: points + min(2 * share, 2 - 2 * share) * np.asarray(way)
