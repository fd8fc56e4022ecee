"""The closed form of a press against independent solutions of the same equation."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_bvp, trapezoid
from scipy.sparse import diags
from scipy.sparse.linalg import spsolve
from scipy.special import k0, k1

from core.body.estimate import bed_area, estimate, falloff, reach, solid_area, spread_on
from core.body.model import build_model
from core.material import POINT, Indenter, Preset
from core.mesh.surface import mesh_from_triangles
from studies.paper_objects import PRESETS
from tests.bodies import sheet

SPREAD = 0.02  # [m]
FINE = np.concatenate([np.linspace(0, 0.03, 241)[:-1], np.linspace(0.03, 0.3, 271)])  # [m] from the axis
PUNCH, BALL = Indenter(shape="punch", radius=0.005), Indenter(shape="sphere", radius=0.01)


@pytest.mark.parametrize("z", [1e-3, 0.1, 1.0, 10.0, 100.0])
def test_the_falloff_is_the_ratio_of_bessel_functions(z: float) -> None:
    assert falloff(z * SPREAD, SPREAD) == pytest.approx(SPREAD * k1(z) / k0(z), rel=1e-5)


def test_a_surface_without_a_spread_is_a_bed_of_springs() -> None:
    area, radius = bed_area(PUNCH, 0.165, 0.0, 0.01)
    assert area == pytest.approx(math.pi * PUNCH.radius**2, rel=5e-3) and radius == PUNCH.radius


@pytest.mark.parametrize("depth", [0.001, 0.005, 0.02])
@pytest.mark.parametrize("indenter", [PUNCH, BALL], ids=lambda i: i.shape)
def test_the_force_of_the_closed_form_solves_the_membrane_on_its_bed(indenter: Indenter, depth: float) -> None:
    """w'' + w' / r = w / lambda^2 beyond the contact, by collocation; the force is that of the bed on all of it."""
    area, a = bed_area(indenter, 0.165, SPREAD, depth)
    ball = indenter.shape == "sphere"
    rim = depth - indenter.radius + math.sqrt(indenter.radius**2 - a**2) if ball else depth
    r = np.linspace(a, a + 15 * SPREAD, 400)
    found = solve_bvp(
        lambda r, y: np.stack([y[1], y[0] / SPREAD**2 - y[1] / r]),
        lambda first, last: np.array([first[0] - rim, last[0]]),
        r, np.stack([rim * np.exp(-(r - a) / SPREAD), 0 * r]), tol=1e-8, max_nodes=20000,
    )  # fmt: skip
    inside = np.linspace(0, a, 2000)
    under = depth - indenter.radius + np.sqrt(indenter.radius**2 - inside**2) if ball else depth + 0 * inside
    bed = trapezoid(2 * np.pi * inside * under, inside) + trapezoid(2 * np.pi * found.x * found.y[0], found.x)
    slope = float(found.sol(a)[1])
    # the tension at the rim is carried by the tip unless the surface leaves it smoothly
    assert area * depth == pytest.approx(bed if ball else bed, rel=2e-3)
    if ball and a < 0.999 * indenter.radius:
        assert slope == pytest.approx(-a / math.sqrt(indenter.radius**2 - a**2), rel=2e-3)


@pytest.mark.parametrize("skin", [40.0, 1000.0])
@pytest.mark.parametrize("spread", [0.02, 0.03])
@pytest.mark.parametrize("radius", [0.005, 0.01, 0.02])
def test_the_closed_form_of_a_solid_is_that_of_a_skin_in_series(radius: float, spread: float, skin: float) -> None:
    """lambda^2 lap w = w - skin (u - w) under the tip, by finite volumes."""
    for depth, near in ((0.1 * radius, 0.13), (0.5 * radius, 0.09), (radius, 0.06), (1.5 * radius, 0.02)):
        area = solid_area(Indenter(shape="sphere", radius=radius), 0.165, spread, depth, skin)
        assert area * depth == pytest.approx(force_of_skin_in_series(radius, spread, depth, skin), rel=near)


def force_of_skin_in_series(radius: float, spread: float, depth: float, skin: float) -> float:
    """Return the force [m3] over the stiffness of the bed: the tip presses the skin where it is below the bed."""
    faces = (FINE[1:] + FINE[:-1]) / 2
    rings = np.diff(np.concatenate([[0.0], faces**2 / 2, [FINE[-1] ** 2 / 2]]))
    flux = spread**2 * faces / np.diff(FINE)
    bed = diags([rings + np.append(flux, 0) + np.append(0, flux), -flux, -flux], [0, 1, -1])
    tip = depth - radius + np.sqrt(np.maximum(radius**2 - FINE**2, 0))
    pressed = (tip > 0) & (FINE < radius)
    while True:
        springs = np.where(pressed, skin * rings, 0)
        down = spsolve((bed + diags([springs], [0])).tocsc(), springs * tip)
        now = (tip > down) & (FINE < radius)
        if (now == pressed).all():
            return float(2 * np.pi * (springs * (tip - down)).sum())
        pressed = now


@pytest.mark.parametrize("preset", PRESETS, ids=lambda p: p.name)
def test_the_estimate_answers_k1_x0_at_the_knee(preset: Preset) -> None:
    m = replace(preset.material, indenter=BALL)
    constants = estimate(m, preset.size)
    area, _ = bed_area(BALL, preset.size, spread_on(m, preset.size), m.x0)
    assert constants.kappa1 * area == pytest.approx(m.K1)
    assert constants.d0 == m.x0 and constants.kappa2 > constants.kappa1


def test_a_point_is_a_patch_that_grows_with_the_body() -> None:
    assert reach(POINT, 0.165) == pytest.approx(0.165 / 16) and reach(POINT, 0.01) == POINT.radius
    assert reach(PUNCH, 0.165) == PUNCH.radius


def test_the_tension_on_a_model_is_that_of_its_material() -> None:
    """On a flat sheet of leaning triangles a displacement whose gradient is 1 has the energy T / 2 an area, exactly."""
    material = PRESETS[1].material
    points, faces = sheet(8, 0.1)
    points[:, 0] -= 0.3 * points[:, 1]
    mesh = mesh_from_triangles(points, faces)
    law = build_model(mesh, [material]).matching
    along = np.array([0.6, 0.8, 0.0])
    u = np.array([[1.0], [-2.0], [2.0]]) / 3 * (along @ law.rest)
    energy = law.tension @ ((u[:, law.pairs[:, 0]] - u[:, law.pairs[:, 1]]) ** 2).sum(axis=0) / 2
    tension = estimate(material, mesh.size).tension
    assert energy == pytest.approx(tension * mesh.triangle_areas.sum() / 2)
