"""Object constants: what is allowed, the law they make, Table 2, and the closed-form first guess."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.base import DimpleError
from core.material import FINGERTIP, POINT, Material
from studies.paper_objects import PRESETS

SOFT = Material(K1=600.0, K2=2000.0, x0=0.01, k=5000.0, mass=0.1)


@pytest.mark.parametrize("name", ["K1", "K2", "x0", "k", "mass"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, -math.inf, 1e300])
def test_a_constant_that_is_not_positive_nan_or_infinite_is_named(name: str, value: float) -> None:
    with pytest.raises(DimpleError, match=name):
        replace(SOFT, **{name: value})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mass": None}, "mass or a density .set now: neither"),
        ({"density": 100.0}, "mass or a density .set now: both"),
        ({"mass": None, "density": 0.0}, "density must be greater"),
        ({"mass": None, "density": math.nan}, "density must be greater"),
        ({"damping_ratio": -0.1}, "damping ratio"),
        ({"damping_ratio": 2.1}, "damping ratio"),
        ({"damping_ratio": math.nan}, "damping ratio"),
        ({"friction": -0.1}, "friction"),
        ({"friction": math.inf}, "friction"),
        ({"fill": "jelly"}, "air, liquid, solid, none"),
        ({"pressure": -1.1e5}, r"between -100 kPa and 1000 kPa .it is -110 kPa"),
        ({"pressure": 2e6}, r"between -100 kPa and 1000 kPa .it is 2000 kPa"),
        ({"pressure": math.nan}, "pressure must"),
        ({"spread": -0.005}, "spread must not be negative .it is -5 mm"),
    ],
)
def test_a_setting_out_of_range_is_refused_with_the_rule(change: dict[str, object], words: str) -> None:
    with pytest.raises(DimpleError, match=words):
        replace(SOFT, **change)  # type: ignore[arg-type]


def test_zero_damping_and_friction_are_allowed() -> None:
    assert replace(SOFT, damping_ratio=0.0, friction=0.0).law(0.001) == pytest.approx(0.6)


@pytest.mark.parametrize("hardens", [1.3, 2.1, 2.25])
def test_a_solid_under_a_sphere_answers_a_power_law_of_the_same_energy_without_a_bend(hardens: float) -> None:
    two_slopes = replace(SOFT, K2=hardens * SOFT.K1, indenter=FINGERTIP)
    solid = replace(two_slopes, fill="solid")
    p, depths = math.sqrt(hardens), np.linspace(0, 4 * SOFT.x0, 4001)
    forces = np.array([solid.law(depth) for depth in depths])
    straight = np.array([two_slopes.law(depth) for depth in depths])
    assert solid.power == pytest.approx(p)
    assert forces.sum() == pytest.approx(straight.sum(), rel=1e-5)
    bend = np.abs(np.diff(forces, 2)) / (depths[1] * SOFT.K1)
    assert bend[1000:].max() < 2e-3, "where two slopes jump"
    begins = depths < (1 + 1 / p) * SOFT.x0
    np.testing.assert_allclose(forces[begins], forces[1] * (depths[begins] / depths[1]) ** p, rtol=1e-9)
    np.testing.assert_allclose(forces[~begins], straight[~begins], rtol=1e-9)


def test_what_hardens_more_than_an_elastic_solid_keeps_a_knee_and_only_a_sphere_meets_a_power() -> None:
    solid = replace(SOFT, fill="solid", indenter=FINGERTIP)
    hard, elastic = replace(solid, K2=12 * SOFT.K1), replace(solid, K2=2.25 * SOFT.K1)
    assert hard.power == elastic.power == 1.5
    assert hard.law(SOFT.x0) == elastic.law(SOFT.x0) == pytest.approx(1.162 * SOFT.K1 * SOFT.x0, rel=1e-3)
    assert hard.law(3 * SOFT.x0) == pytest.approx(25 * SOFT.K1 * SOFT.x0)
    assert solid.law(0.004) != SOFT.law(0.004)
    for other in (replace(solid, fill="liquid"), replace(solid, indenter=POINT), replace(solid, K2=0.5 * SOFT.K1)):
        assert other.power == 1 and other.law(SOFT.x0) == SOFT.K1 * SOFT.x0


@pytest.mark.parametrize("hardens", [0.5, 1.0, 1.3, 2.25, 12.0])
def test_the_slope_of_a_law_is_that_of_its_force(hardens: float) -> None:
    for fill in ("liquid", "solid"):
        material = replace(SOFT, K2=hardens * SOFT.K1, fill=fill, indenter=FINGERTIP)
        for depth in (0.002, 0.0099, 0.0101, 0.016, 0.03):
            found = (material.law(depth + 1e-8) - material.law(depth - 1e-8)) / 2e-8
            assert material.slope(depth) == pytest.approx(found, rel=1e-4)
        assert material.slope(SOFT.x0) == pytest.approx(material.slope(SOFT.x0 - 1e-9), rel=1e-4)


def test_the_presets_are_table_2() -> None:
    table = {
        "object_1_nylon_air": (50, 0.59, 2.24, 36.3, 54.8, "air"),
        "object_2_vinyl_air": (165, 0.61, 7.23, 16.3, 9.2, "air"),
        "object_3_vinyl_water": (165, 0.62, 9.13, 13.7, 9.2, "liquid"),
    }
    assert [p.name for p in PRESETS] == list(table)
    for preset in PRESETS:
        m = preset.material
        found = (preset.size * 1e3, m.K1 / 1e3, m.K2 / 1e3, m.x0 * 1e3, m.k / 1e3)
        assert found == pytest.approx(table[preset.name][:5]) and m.fill == table[preset.name][5]
        assert preset.provenance and preset.label


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("K1", 1e36, r"1e\+33 N/mm"), ("K1", math.inf, "inf N/mm"), ("k", 2e36, r"2e\+33 N/mm"),
        ("x0", 1e30, r"1e\+33 mm"), ("mass", 1e33, r"1e\+33 kg"),
    ],
)  # fmt: skip
def test_a_number_beyond_all_measure_is_called_so_in_the_unit_that_it_is_typed_in(
    name: str, value: float, said: str
) -> None:
    with pytest.raises(DimpleError, match=rf"^(The )?{name} is out of range \(it is {said}\)"):
        replace(SOFT, **{name: value})
