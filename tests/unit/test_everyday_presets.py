"""The presets of everyday objects say where they come from, lie within their own limits, and can be pressed."""

import math
import re

import numpy as np
import pytest

from core.body.model import build_model
from core.everyday_presets import OBJECTS, found
from core.material import DEFAULT_MATERIAL, HERTZ, POUND, STANDARD_GRAVITY, Material, Preset
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.other_tip import as_soft, softness
from core.session import Finger, Session
from studies.paper_objects import PRESETS
from tests.bodies import ball

EVERYDAY = [preset for preset in OBJECTS if preset not in PRESETS]


def test_the_paper_has_three_objects_the_day_a_dozen_and_no_two_are_called_the_same() -> None:
    assert len(PRESETS) == 3 and len(EVERYDAY) >= 12
    assert len({preset.name for preset in OBJECTS}) == len({preset.label for preset in OBJECTS}) == len(OBJECTS)


SOURCED = [preset for preset in EVERYDAY if not preset.provenance.startswith("Made up")]


@pytest.mark.parametrize("preset", SOURCED, ids=lambda each: each.name)
def test_a_preset_with_a_source_lies_within_the_limits_it_states(preset: Preset) -> None:
    limits = re.search(r"([\d.]+) to ([\d.]+) N/mm", preset.provenance)
    assert limits, preset.provenance
    low, high = map(float, limits.groups())
    assert low < preset.material.K1 / 1e3 < high
    assert high < 2 * low or "±" in preset.provenance  # people differ


POUND_FORCE = POUND * STANDARD_GRAVITY  # [N]
PSI = POUND_FORCE / 0.0254**2  # [Pa]
KGF_PER_CM2 = 1e4 * STANDARD_GRAVITY  # [Pa]


def middle(low: float, high: float) -> float:
    return (low + high) / 2


def hertz(modulus: float, radius: float, knee: float) -> float:
    """Return K1 [N/m] of the law that a ball measures on an elastic solid."""
    return math.sqrt(radius * (1 + 1 / HERTZ) * knee) / HERTZ * 4 / 3 / 0.75 * modulus


@pytest.mark.parametrize(
    ("name", "stiffness"),
    [
        ("volleyball", 2 * math.pi * 0.105 * middle(0.30, 0.325) * KGF_PER_CM2),
        ("beach_volleyball", 2 * math.pi * 0.1066 * middle(0.175, 0.225) * KGF_PER_CM2),
        ("football", 2 * math.pi * 0.11 * middle(0.6, 1.1) * 101_325),
        ("ecoflex_00_10", 2 * 0.005 * 8 * PSI / 0.75),
        ("ecoflex_00_30", 2 * 0.005 * 10 * PSI / 0.75),
        ("dragon_skin_10", 2 * 0.005 * 22 * PSI / 0.75),
        ("sofa_foam", middle(25, 30) * POUND_FORCE / 0.025),
        ("chair_foam", middle(35, 45) * POUND_FORCE / 0.025),
        ("skin", hertz(26.1e3, 0.010, 0.015)),
        ("flesh", hertz(62.2e3, 0.010, 0.015)),
        ("jelly", middle(0.175, 0.225) * STANDARD_GRAVITY / 0.004),
    ],
)
def test_a_stiffness_follows_from_the_numbers_of_its_source(name: str, stiffness: float) -> None:
    preset = next(each for each in EVERYDAY if each.name == name)
    assert preset.material.K1 == pytest.approx(stiffness, rel=5e-4), "four digits, as in the panel"


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


def test_softness_is_the_depth_at_which_the_law_takes_5_newtons() -> None:
    material = PRESETS[1].material
    assert material.law(softness(material)) == pytest.approx(5.0, rel=1e-5)


@pytest.mark.parametrize("preset", OBJECTS, ids=lambda each: each.name)
@pytest.mark.parametrize("depth", [0.0005, 0.008, 0.06])
def test_a_material_is_as_soft_as_it_is_typed_and_keeps_its_knee(preset: Preset, depth: float) -> None:
    made = as_soft(preset.material, depth)
    assert softness(made) == pytest.approx(depth, rel=1e-3)
    assert made.x0 == preset.material.x0
    assert made.K2 / made.K1 == pytest.approx(preset.material.K2 / preset.material.K1)


def test_the_spread_that_k_gives_moves_with_the_stiffness_and_the_softness_is_right_all_the_same() -> None:
    made = as_soft(Material(K1=610, K2=7230, x0=0.0163, k=9_200, density=100), 0.004)
    assert softness(made) == pytest.approx(0.004, rel=1e-3)


def test_the_presets_go_from_soft_to_hard_and_are_recognised_by_their_constants() -> None:
    depths = [softness(preset.material) for preset in OBJECTS]
    assert depths == sorted(depths, reverse=True)
    assert [found(preset.material) for preset in OBJECTS] == list(OBJECTS)
    assert found(as_soft(PRESETS[1].material, 0.004)) is None
    assert found(DEFAULT_MATERIAL) is PRESETS[1], "whatever it weighs"
    place = {preset.name: number for number, preset in enumerate(OBJECTS)}
    assert place["pillow"] < place["dough"] < place["skin"] < place["flesh"] < place["tennis_ball"] < place["football"]


def test_a_fingertip_pushed_with_5_newtons_goes_as_deep_as_the_softness_says() -> None:
    for name in ("sofa_foam", "tennis_ball", "marshmallow"):  # two that a plate measured
        preset = next(each for each in OBJECTS if each.name == name)
        mesh = mesh_from_triangles(*ball(4, 0.05))
        session = Session(build_model(mesh, [preset.material], pinned=base_vertices(mesh)))
        session.set_fingers([Finger((0.0, 0.0, 0.06), 0.01, 5.0)])
        session.step(1.0)
        assert session.frame.depths[0] == pytest.approx(softness(preset.material), rel=0.05), name
