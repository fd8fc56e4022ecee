"""Object constants: what is allowed, the law they make, Table 2, and the closed-form first guess."""

import math
from dataclasses import replace

import pytest

from core.base import DimpleError
from core.material import PRESETS, Material

SOFT = Material(K1=600.0, K2=2000.0, x0=0.01, k=5000.0, mass=0.1)


@pytest.mark.parametrize("name", ["K1", "K2", "x0", "k", "mass"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, -math.inf, 1e300])
def test_a_constant_that_is_not_positive_nan_or_infinite_is_named(name: str, value: float) -> None:
    with pytest.raises(DimpleError, match=name):
        replace(SOFT, **{name: value})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mass": None}, "mass or a density .it is neither"),
        ({"density": 100.0}, "mass or a density .it is both"),
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


@pytest.mark.parametrize(
    ("depth", "force"), [(-0.01, 0.0), (0.0, 0.0), (0.005, 3.0), (0.01, 6.0), (0.011, 8.0), (0.02, 26.0)]
)
def test_the_force_of_a_depth_is_two_piece_linear(depth: float, force: float) -> None:
    assert SOFT.law(depth) == pytest.approx(force)


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
