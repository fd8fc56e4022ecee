"""Scenes, each a function of resolution."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from core.base import Floats
from core.body.model import Model, assemble, build_model
from core.body.on_mesh import constants_on, mass_on
from core.body.springs import membrane_stiffness
from core.material import Material
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.session import Finger, Frame, Session
from studies.meshes.simple import cube as cube
from studies.meshes.simple import icosphere
from studies.paper_objects import PRESETS
from studies.reference.laws import State, initial_state

BALL_RADIUS = 0.08  # [m]
BALL = Material(K1=610, K2=7230, x0=0.0163, k=600, spread=0.02, mass=0.2, fill="liquid")
OSCILLATOR_RADIUS = 0.05  # [m] small enough that its stretch stays short of the knee of Eq. (1)
FINGERTIP = 0.020  # [m] radius of the scenes' fingertip
BUDGET = 0.6  # [s] of each second that the simulation may use, as a scene of Blender has it by default
POKE = ((0.25, 1.0), (0.5, 1.0), (0.75, 0.0), (1.0, 0.0))  # (time [s], share of the depth): down, hold, up, free


def ball(subdivisions: int, radius: float = BALL_RADIUS) -> Mesh:
    """Return an icosphere of 10 * 4**subdivisions + 2 vertices."""
    return mesh_from_triangles(*icosphere(subdivisions, radius))


def oscillator(*, damping_ratio: float = 0.0, stretch: float = 0.1) -> tuple[Model, State]:
    """Return three masses on an equilateral triangle of springs that breathe: every law at work, yet a closed form.

    Along the radius r each vertex is pulled by its two springs with 3 k (r - r0), since |l| = sqrt(3) r, and by shape
    matching with k1 (r - r0) and 3 t (r - r0), since neighbours' displacements are as far apart as their lengths:
    linear at any stretch short of the knee.
    """
    around = np.arange(3) * 2 * np.pi / 3
    corners = OSCILLATOR_RADIUS * np.stack([np.cos(around), np.sin(around), np.zeros(3)], axis=1)
    material = replace(BALL, damping_ratio=damping_ratio, fill="none")
    model = build_model(mesh_from_triangles(corners, np.array([[0, 1, 2]])), [material])
    return model, _placed(model, model.matching.rest * (1 + stretch))


def oscillator_radius(model: Model, time: float, *, stretch: float = 0.1) -> float:
    """Return the distance [m] of `oscillator`'s vertices from their centre at a time [s], in closed form."""
    m, law = float(model.mass[0]), model.springs
    k = 3 * float(law.stiffness[0] + model.matching.tension[0]) + float(model.matching.k1[0])
    rate = (3 * float(law.damping[0]) + float(model.matching.damping[0])) / (2 * m)
    omega = np.sqrt(k / m - rate**2)
    swing = np.exp(-rate * time) * (np.cos(omega * time) + rate / omega * np.sin(omega * time))
    return float(OSCILLATOR_RADIUS * (1 + stretch * swing))


def free_ball(subdivisions: int) -> Session:
    """Return a ball in the air, twisted about z and stretched: nothing holds it."""
    model, state = twisted_ball(subdivisions)
    session = Session(model)
    session.body.set_state(state.positions)
    return session


def twisted_ball(
    subdivisions: int, *, amount: float = 1.0, damping_ratio: float = BALL.damping_ratio
) -> tuple[Model, State]:
    """Return what `free_ball` is before it is let go.

    Args:
        amount: of the twist; up to 0.4 nothing reaches the knee of Eq. (1) and the motion is smooth.
    """
    model = build_model(ball(subdivisions), [replace(BALL, damping_ratio=damping_ratio)])
    x = model.mesh.rest_positions
    angle = 2.0 * x[:, 2] / BALL_RADIUS * 0.3 * amount
    twisted = np.stack(
        [x[:, 0] * np.cos(angle) - x[:, 1] * np.sin(angle), x[:, 0] * np.sin(angle) + x[:, 1] * np.cos(angle), x[:, 2]]
    )
    return model, _placed(model, twisted * (1 + amount * np.array([[0.1], [0.0], [-0.05]])))


def poke_ball(subdivisions: int) -> Session:
    """Return a liquid ball of 8 cm and 0.2 kg on its base, a 20 mm fingertip above it."""
    return _under_a_fingertip(ball(subdivisions), BALL)


def poke_cube(cells: int) -> Session:
    """Return Object 3, the cube of vinyl and water, on its base, a 20 mm fingertip above it."""
    preset = PRESETS[2]
    return _under_a_fingertip(cube(cells, preset.size), preset.material)


def whole_skin(mesh: Mesh, material: Material) -> Model:
    """Return a body pinned at its base with all of k in its skin, which the press that was measured contradicts."""
    model = build_model(mesh, [material], pinned=base_vertices(mesh))
    return reassembled(model, stiffness=membrane_stiffness(mesh, np.full(len(mesh.springs), material.k)))


def reassembled(model: Model, **constants: Floats) -> Model:
    """Return a model with other constants of its vertices and edges, named as `assemble` has them."""
    mesh, materials = model.mesh, model.materials
    assert model.maps
    given: dict[str, Any] = {**constants_on(mesh, materials, model.maps), **constants}
    return assemble(
        mesh, materials, mass=mass_on(mesh, materials), pinned=model.pinned,
        fill=model.pressure.fill, rest_pressure=model.pressure.rest_pressure, gravity=model.gravity,
        ground=model.ground, **given,
    )  # fmt: skip


def poke(session: Session, *, depth: float = 0.020, frame_rate: float = 60.0, seconds: float = 1.0) -> Iterator[Frame]:
    """Press a body's top straight down, hold, lift and let be; yield each frame.

    Args:
        depth: how far the fingertip goes [m].
        frame_rate: frames a second.
        seconds: of the second the press takes, how many to run.
    """
    x = session.model.mesh.rest_positions
    top = x[:, 2].max() + FINGERTIP
    times, shares = zip((0.0, 0.0), *POKE, strict=True)
    session.set_fingers([Finger((0.0, 0.0, top), FINGERTIP)])
    frames = np.arange(1, round(seconds * frame_rate) + 1)
    for height in (top - depth * np.interp(frames / frame_rate, times, shares)).tolist():
        session.set_fingers([Finger((0.0, 0.0, height), FINGERTIP)])
        yield session.step(1 / frame_rate)


def _placed(model: Model, positions: Floats) -> State:
    state = initial_state(model)
    state.positions[:] = positions
    return state


def _under_a_fingertip(mesh: Mesh, material: Material) -> Session:
    model: Model = build_model(mesh, [material], pinned=base_vertices(mesh))
    return Session(model)
