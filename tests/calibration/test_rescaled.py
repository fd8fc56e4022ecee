"""Constants that were identified for one material answer for another that is not far from it."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from core.body.estimate import between, estimate, rescaled
from core.calibration.indent import press
from core.calibration.place import typical_site
from core.material import FINGERTIP, PRESETS
from studies.scenes import ball, cube
from studies.virtual_press import identify

_, OBJECT_2, OBJECT_3 = PRESETS
BEYOND = 1.5  # knees: how deep is pressed
MESHES = {
    "cube": (OBJECT_2, cube(28, OBJECT_2.size)), "ball": (OBJECT_3, ball(4, OBJECT_3.size / 2)),
}  # fmt: skip


@functools.cache
def identified(name):
    preset, mesh = MESHES[name]
    site = typical_site(mesh, FINGERTIP)
    return site, identify(mesh, preset.material, FINGERTIP, site, BEYOND * preset.material.x0).material


def changed(material, **times):
    values = {name: factor * getattr(material, name) for name, factor in times.items()}
    return replace(material, constants=None, **values)


def off(mesh, material, site, constants):
    """Return the error of a press at twelve depths as a share of full scale."""
    depths = BEYOND * material.x0 * np.arange(1, 13) / 12
    stations = press(mesh, replace(material, constants=constants), FINGERTIP, site, depths.tolist())
    wanted = np.array([material.law(depth) for depth in depths.tolist()])
    return np.sqrt((((np.array([station.force for station in stations]) - wanted) / wanted.max()) ** 2).mean())


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize(
    ("times", "most"),
    [({"K1": 0.5}, 0.035), ({"K1": 2.0}, 0.035), ({"K2": 2.0}, 0.035), ({"x0": 0.8}, 0.05),
     ({"K1": 1.4, "K2": 0.7, "x0": 1.2}, 0.05)],
    ids=str,
)  # fmt: skip
def test_what_was_identified_for_one_law_answers_another_within_a_few_percent(name, times, most):
    mesh, (site, found) = MESHES[name][1], identified(name)
    wanted = changed(found, **times)
    constants = rescaled(found.constants, found, wanted, mesh.size)
    error = off(mesh, wanted, site, constants)
    print(name, times, f"{error:.3f}", f"closed form {off(mesh, wanted, site, estimate(wanted, mesh.size)):.3f}")
    assert error < most and error < 0.6 * off(mesh, wanted, site, estimate(wanted, mesh.size))


def test_what_did_not_change_leaves_the_constants_as_they_were():
    _, found = identified("cube")
    same = rescaled(found.constants, found, replace(found, friction=0.1, pressure=3e3), OBJECT_2.size)
    assert same == found.constants


@pytest.mark.parametrize(
    "other", [{"K1": 6000.0}, {"K2": 60e3}, {"x0": 0.04}, {"spread": 0.0}, {"fill": "liquid"}, {"indenter": "10 mm"}]
)
def test_a_material_that_is_far_from_the_identified_one_is_left_to_the_closed_form(other):
    _, found = identified("cube")
    if "indenter" in other:
        other = {"indenter": replace(FINGERTIP, radius=0.007)}
    assert rescaled(found.constants, found, replace(found, constants=None, **other), OBJECT_2.size) is None


def test_a_knee_that_softens_away_takes_what_was_added_beyond_it_along():
    _, found = identified("cube")
    straight = replace(found, constants=None, K2=0.9 * found.K1)
    constants = rescaled(found.constants, found, straight, OBJECT_2.size)
    assert all(stiffness == 0 for knee, stiffness in constants.pieces if knee >= 0.95 * found.x0)


def test_between_two_that_were_identified_the_forces_lie_between_theirs_too():
    site, found = identified("ball")
    mesh = MESHES["ball"][1]
    other = identify(mesh, changed(found, K1=3.0), FINGERTIP, site, BEYOND * found.x0).material
    for times in (1.0, 1.5, 2.2, 3.0):
        wanted = changed(found, K1=times)
        constants = between([found, other], wanted, mesh.size)
        assert off(mesh, wanted, site, constants) < 0.02
    assert between([found, other], found, mesh.size) == found.constants
    assert between([found], wanted, mesh.size) == rescaled(found.constants, found, wanted, mesh.size)
