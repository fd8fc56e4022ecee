"""The presets of everyday objects say where they come from, lie within their own limits, and can be pressed."""

import re

import numpy as np
import pytest

from core.body.model import build_model
from core.everyday import EVERYDAY, MADE_UP
from core.material import PRESETS, Preset
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.session import Finger, Session
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
