"""The presets of everyday objects say where they come from, lie within their own limits, and can be pressed."""

import re

import numpy as np
import pytest

from core.body.model import build_model
from core.calibration.identify import identification
from core.calibration.indent import find_site
from core.everyday import EVERYDAY, MADE_UP
from core.material import PRESETS, Preset
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.session import Finger, Session
from core.steps import result_of
from studies.scenes import cube
from tests.bodies import ball


def test_there_are_a_dozen_and_no_two_are_called_the_same() -> None:
    names = [preset.name for preset in (*PRESETS, *EVERYDAY)]
    assert len(EVERYDAY) >= 12 and len(set(names)) == len(names)
    assert len({preset.label for preset in EVERYDAY}) == len(EVERYDAY)


SOURCED = [preset for preset in EVERYDAY if not preset.provenance.startswith(MADE_UP)]


@pytest.mark.parametrize("preset", SOURCED, ids=lambda each: each.name)
def test_a_preset_with_a_source_lies_within_the_limits_it_states(preset: Preset) -> None:
    limits = re.search(r"([\d.]+) to ([\d.]+) N/mm", preset.provenance)
    assert limits, preset.provenance
    low, high = map(float, limits.groups())
    assert low < preset.material.K1 / 1e3 < high and high < 2 * low


@pytest.mark.parametrize("preset", EVERYDAY, ids=lambda each: each.name)
def test_a_preset_can_be_pressed_with_a_finger_and_comes_back(preset: Preset) -> None:
    radius = preset.size / 2
    mesh = mesh_from_triangles(*ball(3, radius))
    session = Session(build_model(mesh, [preset.material], pinned=base_vertices(mesh)))
    tip = min(0.01, preset.size / 5)
    session.set_fingers([Finger((0.0, 0.0, radius + tip), tip, 2.0)])
    session.step(0.6)
    assert session.frame.finite and not session.frame.note
    assert 0 < session.frame.depths[0] < 0.6 * preset.size
    session.set_fingers([])
    session.step(1.0)
    assert np.abs(session.skin() - mesh.rest_positions).max() < 0.01 * preset.size


def test_a_silicone_rubber_measured_by_a_flat_punch_answers_fingertips_of_any_radius_as_hertz_says() -> None:
    """F = 4/3 E* (R x^3)^(1/2), with E* from K = 2 a E*; with another fill they are up to 1.8 times apart."""
    preset = next(each for each in EVERYDAY if each.name == "ecoflex_00_30")
    mesh, measured = cube(25, preset.size), preset.material.indenter
    found = result_of(identification(mesh, preset.material, measured, find_site(mesh, measured), 0.01))
    session = Session(build_model(mesh, [found.material], pinned=base_vertices(mesh)))
    over = []
    for tip in (0.005, 0.010, 0.020):
        session.reset()
        for depth in (0.0, 0.002, 0.008):
            session.set_fingers([Finger((0.0, 0.0, preset.size / 2 + tip - depth), tip)])
            session.step(0.5)
            force = float(session.step(0.05).finger_forces[0][2])
            if depth:
                over.append(force / (4 / 3 * preset.material.K1 / (2 * measured.radius) * (tip * depth**3) ** 0.5))
    assert 0.7 < min(over) and max(over) < 1.35 * min(over)
