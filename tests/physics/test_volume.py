"""What fills a body keeps its volume, or its law."""

from dataclasses import replace

import numpy as np
import pytest

from core.base import AIR_PRESSURE
from core.body.model import build_model
from core.material import PRESETS
from core.mesh.surface import base_vertices
from core.session import Finger, Session
from studies import scenes
from tests.bodies import backends

SCENES = {
    "poke_ball, 42 vertices": lambda: scenes.poke_ball(1),
    "poke_ball, 162 vertices": lambda: scenes.poke_ball(2),
    "poke_cube, 56 vertices": lambda: scenes.poke_cube(3),
    "poke_cube, 218 vertices": lambda: scenes.poke_cube(6),
}


@pytest.mark.parametrize("scene", SCENES if len(backends("numpy", "native")) > 1 else list(SCENES)[::2])
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


def test_pressed_air_gives_way_by_the_adiabatic_law() -> None:
    preset = PRESETS[0]
    mesh = scenes.cube(4, preset.size)
    session = Session(build_model(mesh, [preset.material], held=base_vertices(mesh)))
    top = preset.size / 2 + 0.02
    session.set_fingers([Finger((0, 0, top), 0.02)])
    session.step(0.001)
    session.set_fingers([Finger((0, 0, top - 0.03), 0.02)])
    session.step(0.1)
    frame = session.step(0.2)
    ratio = frame.rest_volume / frame.volume
    assert ratio > 1.02
    assert frame.pressure == pytest.approx(AIR_PRESSURE * (ratio**1.4 - 1), rel=0.02)


def test_a_swollen_body_shrinks_and_an_empty_one_does_not_care() -> None:
    for fill, returns in (("liquid", True), ("none", False)):
        material = PRESETS[2].material
        mesh = scenes.ball(1)
        model = build_model(mesh, [replace(material, fill=fill, K1=1e-6, K2=1e-6, k=1e-6, damping_ratio=0.0)])
        session = Session(model)
        session.body.set_state(1.001 * mesh.rest_positions.T)
        session.step(0.005)
        assert (np.abs(session.body.velocities()).max() > 0.01) == returns
