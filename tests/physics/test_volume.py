"""What fills a body keeps its volume, or its law."""

from dataclasses import replace

import numpy as np
import pytest

from core.body.model import build_model
from core.body.pressure import volume_and_gradient
from core.body.springs import membrane_stiffness
from core.constants import AIR_PRESSURE, LIQUID_BULK_MODULUS
from core.material import Material, law_force
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.session import Finger, Session
from core.world import Collider, World
from studies import scenes
from studies.paper_objects import PRESETS
from tests.bodies import ball, sheet

SCENES = {
    "poke_ball, 42 vertices": lambda: scenes.poke_ball(1),
    "poke_ball, 162 vertices": lambda: scenes.poke_ball(2),
    "poke_cube, 56 vertices": lambda: scenes.poke_cube(3),
    "poke_cube, 218 vertices": lambda: scenes.poke_cube(6),
}


@pytest.mark.parametrize("scene", SCENES)
def test_liquid_keeps_its_volume_within_half_a_percent(scene: str) -> None:
    session = SCENES[scene]()
    error, depth = 0.0, 0.0
    for frame in scenes.poke(session, frame_rate=100.0):
        error, depth = max(error, abs(frame.volume / frame.rest_volume - 1)), max(depth, frame.depths[0])
        assert frame.finite
    assert depth == pytest.approx(0.02, abs=1e-3)
    assert 0 < error < 0.005


def test_the_pressure_of_a_pressed_liquid_is_its_bulk_modulus_times_what_is_missing() -> None:
    session = scenes.poke_cube(3)
    *_, frame = scenes.poke(session, seconds=0.5)
    assert frame.volume < frame.rest_volume and frame.pressure > 0
    assert frame.pressure == pytest.approx(2e6 * (1 - frame.volume / frame.rest_volume), rel=0.05)


def test_a_liquid_pressed_to_half_its_height_by_plates_gives_way_by_its_pressure_and_by_nothing_else() -> None:
    """Contact, which moves the skin after the pressure, takes none of its volume."""
    mesh, (points, faces) = mesh_from_triangles(*ball(3, 0.05)), sheet(1, 0.4)
    session = Session(build_model(mesh, [PRESETS[2].material]))
    low, high = points - (0, 0, 0.051), points + (0, 0, 0.051)
    world = World([session], [Collider(low.T.copy(), faces, 0.5), Collider(high.T.copy(), faces[:, ::-1], 0.5)])
    for frame in range(30):
        world.set_colliders([None, high - (0, 0, min(frame / 18, 1) * 0.051)])
        world.step(1 / 60)
    volume, _ = volume_and_gradient(session.body.model.pressure, session.body.positions())
    lost = 1 - volume / mesh.volume
    assert np.ptp(session.positions()[:, 2]) == pytest.approx(0.05, abs=1e-3)
    assert 0.001 < lost < 0.004 and lost == pytest.approx(session.frame.pressure / LIQUID_BULK_MODULUS, rel=0.02)


def test_pressed_air_gives_way_by_the_adiabatic_law() -> None:
    preset = PRESETS[0]
    mesh = scenes.cube(4, preset.size)
    session = Session(build_model(mesh, [preset.material], pinned=base_vertices(mesh)))
    top = preset.size / 2 + 0.02
    session.set_fingers([Finger((0, 0, top), 0.02)])
    session.step(0.001)
    session.set_fingers([Finger((0, 0, top - 0.03), 0.02)])
    session.step(0.1)
    frame = session.step(0.2)
    ratio = frame.rest_volume / frame.volume
    assert ratio > 1.02
    assert frame.pressure == pytest.approx(AIR_PRESSURE * (ratio**1.4 - 1), rel=0.02)


RADIUS = 0.08
BALL = mesh_from_triangles(*ball(2, RADIUS))


def pumped(pressure: float, *, bed: float, k: float, fill: str = "air", pinned: bool = False) -> Session:
    """Return a ball that has swollen: its bed [N/m3], the springs of its skin [N/m]."""
    material = Material(K1=600, K2=600, x0=0.01, k=k, mass=0.5, damping_ratio=1.0, fill=fill, pressure=pressure)
    model = build_model(BALL, [material], pinned=base_vertices(BALL) if pinned else None)
    stiffness = membrane_stiffness(BALL, np.full(len(BALL.springs), k))
    held = bed * BALL.vertex_areas
    model = scenes.reassembled(model, k1=held, k2=held, stiffness=stiffness, tension=0 * stiffness)
    session = Session(model)
    for _ in range(6):
        session.step(0.25)
    return session


@pytest.mark.parametrize("fill", ["air", "liquid"])
@pytest.mark.parametrize(("bed", "k"), [(4e5, 1e-3), (1e-3, 600.0), (1e5, 600.0)], ids=["bed", "skin", "both"])
@pytest.mark.parametrize("pressure", [-5e3, 2e3, 2e4])
def test_a_pumped_ball_swells_until_its_bed_and_its_skin_hold_the_pressure(
    fill: str, bed: float, k: float, pressure: float
) -> None:
    """A bed displaced by R (s - 1) on the area at rest; a skin of k (3^1/2)(s - 1)/s across each line, 2 T / (R s)."""
    if k == 600 and pressure < 0:
        bed = max(bed, 4e5)  # a skin alone would buckle
    frame = pumped(pressure, bed=bed, k=k, fill=fill).frame
    ratio = frame.volume / frame.rest_volume
    wider = ratio ** (1 / 3)
    holds = (bed * RADIUS + 2 * np.sqrt(3) * k / RADIUS) * (wider - 1) / wider**2
    assert frame.pressure == pytest.approx(holds, rel=0.03) and (ratio > 1) == (pressure > 0)
    law = (AIR_PRESSURE + pressure) * ratio**-1.4 - AIR_PRESSURE
    law = LIQUID_BULK_MODULUS * (1 - ratio) + pressure if fill == "liquid" else law
    assert frame.pressure == pytest.approx(law, abs=0.002 * abs(pressure))


@pytest.mark.parametrize("pressure", [-2e4, 2e4, 1e5])
def test_a_pumped_ball_answers_by_its_law_from_where_its_surface_is_then(pressure: float) -> None:
    session = pumped(pressure, bed=1e5, k=600, pinned=True)
    top = session.positions()[:, 2].max() + 0.02
    session.set_fingers([Finger((0, 0, top), 0.02)])
    session.step(0.3)
    session.set_fingers([Finger((0, 0, top - 0.015), 0.02)])
    session.step(0.3)
    touch = session.frame.touches[0]
    assert touch and touch.depth == pytest.approx(0.015, rel=0.02)
    assert session.frame.pushes[0] == pytest.approx(law_force(touch.depth, *touch.law), rel=1e-6)


@pytest.mark.parametrize("fill", ["air", "liquid"])
def test_every_pressure_that_can_be_set_finds_a_rest(fill: str) -> None:
    mesh, ratios = scenes.cube(6, PRESETS[1].size), []
    for pressure in (-1e5, -1e4, 0.0, 1e4, 1e5, 1e6):
        material = replace(PRESETS[1].material, fill=fill, pressure=pressure)
        session = Session(build_model(mesh, [material], pinned=base_vertices(mesh)))
        volumes = [session.step(0.5).volume for _ in range(3)]
        assert session.frame.finite and volumes[2] == pytest.approx(volumes[1], rel=5e-3)
        ratios.append(volumes[2] / session.frame.rest_volume)
    assert ratios == sorted(ratios) and ratios[2] == pytest.approx(1, abs=1e-4)


def test_without_an_inside_a_pressure_does_nothing() -> None:
    material = replace(PRESETS[1].material, pressure=1e5)
    mesh = mesh_from_triangles(*sheet())
    session = Session(build_model(mesh, [material]))
    frame = session.step(0.1)
    assert frame.pressure == 0 and np.abs(session.positions() - mesh.rest_positions).max() < 1e-6
