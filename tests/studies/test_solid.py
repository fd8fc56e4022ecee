"""`solid`: the finite-element referee against Hertz, Sneddon, and itself on finer elements."""

import csv
from pathlib import Path

import numpy as np
import pytest

from core.material import FINGERTIP, Indenter, Material
from core.other_tip import area
from studies.body.solid import POISSON, Tip, ball_tip, complementary, press_solid
from studies.body.solid_elements import Solid
from studies.body.solid_mesh import BLOCK_EDGE, half_section
from studies.reference.fingertip import layer

PLANE_STRAIN = 1 / (1 - POISSON**2)  # [Pa] modulus of a half-space whose Young's modulus is 1 Pa


@pytest.mark.parametrize("law", ["linear", "neo-hookean"])
@pytest.mark.parametrize("shape, curvature", [pytest.param("block", 0.0, marks=pytest.mark.slow), ("ball", 1 / 0.080)])
def test_a_ball_small_against_the_body_answers_as_hertz_says(shape: str, curvature: float, law: str) -> None:
    radius, depths = 0.002, np.array([3e-5])
    hertz = 4 / 3 * PLANE_STRAIN * (1 / radius + curvature) ** -0.5 * depths**1.5
    assert press_solid(shape, ball_tip(radius), depths, law=law, refine=0.8).force == pytest.approx(hertz, rel=0.02)


def test_a_deep_ball_answers_as_sneddon_says() -> None:
    """The theory of the half-space for a ball that is no paraboloid: contact as wide as 0.9 of its radius."""
    radius, share = 0.001, 0.9
    way = np.log((1 + share) / (1 - share))
    force = PLANE_STRAIN * radius**2 * ((1 + share**2) / 2 * way - share)
    found = press_solid("block", ball_tip(radius), np.array([share * radius / 2 * way]), law="linear").force[0]
    assert found == pytest.approx(force, rel=0.02)


def test_a_flat_punch_answers_in_proportion_and_as_wide_as_it_is() -> None:
    """F = 2 E* a x, of a radius a between the flat and the whole: the edge is rounded by a twentieth."""
    radius, depths = 0.001, np.array([1e-5, 2e-5])
    stiffness = press_solid("block", Tip(radius, radius / 20), depths, law="linear").force / depths
    assert np.all(stiffness > 2 * PLANE_STRAIN * 0.95 * radius)
    assert np.all(stiffness < 2 * PLANE_STRAIN * 1.02 * radius)  # the block is not endless: 1 % more
    assert stiffness[1] == pytest.approx(stiffness[0], rel=0.02)


def test_a_stiffness_is_the_derivative_of_the_stress() -> None:
    solid = Solid(half_section("ball", 0.02, 0.01, 1.0, 0.5), POISSON, 0.02)
    random = np.random.default_rng(5)
    state, way = 1e-4 * random.normal(size=(2, solid.u.N))
    change = (solid.stress(state + 1e-3 * way) - solid.stress(state - 1e-3 * way)) / 2e-3
    assert solid.stiffness(state) @ way == pytest.approx(change, abs=1e-5 * np.abs(change).max())


def test_the_skin_stays_outside_the_tip_and_nothing_pulls() -> None:
    tip, depth = ball_tip(0.010), 0.002
    press = press_solid("block", tip, np.array([depth]), refine=0.5)
    gap = tip.gap(press.r + press.u_r[0], press.z + press.u_z[0], depth)[0]
    assert gap.min() > -1e-8
    assert gap[0] < 1e-5 and press.force[0] > 0
    assert -1e-3 < press.volume[0] < 0


@pytest.mark.parametrize("law", ["linear", pytest.param("neo-hookean", marks=pytest.mark.slow)])
def test_finer_elements_change_force_and_dent_by_less_than_a_hundredth(law: str) -> None:
    depths = np.array([0.001, 0.005, 0.010])
    coarse, fine = (press_solid("ball", ball_tip(0.010), depths, law=law, refine=refine) for refine in (0.8, 1.2))
    assert coarse.force == pytest.approx(fine.force, rel=0.01)
    beside = [np.interp(0.02, each.r, each.u_z[-1]) for each in (coarse, fine)]
    assert beside[0] == pytest.approx(beside[1], abs=0.01 * depths[-1])


def test_each_load_or_its_gap_is_zero() -> None:
    random = np.random.default_rng(3)
    root = random.normal(size=(8, 8))
    compliance, gaps = root @ root.T + np.eye(8), random.normal(size=8)
    loads = complementary(compliance, gaps)
    assert loads is not None
    left = gaps + compliance @ loads
    assert loads.min() >= 0 and left.min() > -1e-9 and np.abs(loads * left).max() < 1e-9


def test_the_block_has_the_volume_of_the_cube_and_no_element_is_turned() -> None:
    for shape in ("ball", "block"):
        solid = Solid(half_section(shape, 0.0175, 0.00025, 1.08), POISSON, 0.0175)
        assert solid.u.mapping.detDF(solid.u.X).max() < 0  # all turned the same way
    volume = 2 * np.pi * np.sum(np.asarray(solid.u.global_coordinates())[0] * solid.u.dx)
    assert volume == pytest.approx(BLOCK_EDGE**3)


KEPT = Path(__file__).parent / "solid"


def test_the_kept_curves_are_what_is_computed() -> None:
    """Made by `python3 dev.py core solid --out tests/studies/solid`."""
    rows = [line.split(",") for line in (KEPT / "solid_force.csv").read_text().splitlines()[1:]]
    kept = {float(row[3]): float(row[4]) for row in rows if row[:3] == ["ball", "linear", "ball 20 mm"]}
    standard = {float(row[3]): float(row[4]) for row in rows if row[:3] == ["ball", "linear", "ball 10 mm"]}
    depths = np.array([0.001, 0.005, 0.020])
    wide = press_solid("ball", ball_tip(0.020), depths, law="linear").force
    young = 3 / press_solid("ball", ball_tip(0.010), depths[1:2], law="linear").force[0]
    assert standard[5.0] == pytest.approx(3.0)
    assert young * wide == pytest.approx([kept[1.0], kept[5.0], kept[20.0]], rel=1e-3)


@pytest.mark.parametrize(("law", "within"), [("linear", 0.075), ("neo-hookean", 0.065)])
@pytest.mark.parametrize("body", ["ball", "block"])
def test_a_ball_twice_as_large_is_predicted_down_to_the_radius_of_the_smaller(
    body: str, law: str, within: float
) -> None:
    """As a fingertip is that is not the tip that measured; deeper, a solid that hardens is up to 18 % above it."""
    kept = csv.DictReader((KEPT / "solid_force.csv").open())
    rows = [row for row in kept if (row["body"], row["law"]) == (body, law)]
    small, large = (
        {float(row["depth_mm"]): float(row["force_n"]) for row in rows if row["tip"] == f"ball {radius} mm"}
        for radius in (10, 20)
    )
    solid = Material(K1=600, K2=1350, x0=0.01, k=1000, density=1000, fill="solid", indenter=FINGERTIP)
    for depth in [each for each in small if 0.5 <= each <= 10]:
        at = np.array([depth * 1e-3])
        wide, narrow = (
            float(area(solid, Indenter(shape="sphere", radius=radius), BLOCK_EDGE, at)[0])
            * layer(float(np.sqrt(radius * at[0])) / BLOCK_EDGE)
            for radius in (0.02, 0.01)
        )
        predicted = wide / narrow
        assert predicted == pytest.approx(large[depth] / small[depth], rel=within)
