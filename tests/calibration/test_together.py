"""Several curves of one object fit one set of constants: two tips tell how far a dent reaches, one does not."""

import csv
import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.base import DimpleError
from core.body.estimate import bed_area, estimate
from core.calibration.joint_fit import Curve
from core.calibration.together import Together, fit_together
from core.material import DEFAULT_MATERIAL, Indenter
from studies.__main__ import main

SOLID = Path(__file__).parents[1] / "studies/solid/solid_force.csv"
KAPPA, KNEE = 6e5, 0.012  # [N/m3], [m]
DEPTHS = np.linspace(0, 0.02, 81)[1:]


def sphere(radius_mm: float) -> Indenter:
    return Indenter(shape="sphere", radius=radius_mm / 1e3)


def punch(radius_mm: float) -> Indenter:
    return Indenter(shape="punch", radius=radius_mm / 1e3)


def measured(tips: Sequence[Indenter], spread: float, noise: float = 0.01, seed: int = 0) -> list[Curve]:
    """Return the curves that the closed form of a bed under a membrane gives, with noise [of full scale]."""
    random, curves = np.random.default_rng(seed), []
    for i, tip in enumerate(tips):
        force = np.array([KAPPA * bed_area(tip, 0.165, spread, x)[0] * x for x in DEPTHS.tolist()])
        sigma = noise * force.max()
        noisy = force + random.normal(0, sigma, len(force))
        curves.append(Curve(name=f"{i}.csv", tip=tip, depth=DEPTHS, force=noisy, noise=sigma))
    return curves


@pytest.mark.parametrize("spread", [0.005, 0.02, 0.05])
def test_two_tips_of_different_radius_determine_the_spread(spread: float) -> None:
    found = fit_together(measured([sphere(5), punch(15)], spread))
    low, high = found.interval
    assert found.determined and found.spread.value == pytest.approx(spread, rel=0.08)
    assert low < spread < high < 1.5 * low
    assert all(curve.rms < 0.015 for curve in found.curves) and not found.knee


@pytest.mark.slow
def test_the_interval_of_the_spread_holds_it_in_nineteen_of_twenty() -> None:
    held = 0
    for seed in range(40):
        low, high = fit_together(measured([punch(3), punch(12)], 0.02, seed=seed)).interval
        held += low < 0.02 < high
    assert held >= 34


def test_one_radius_alone_does_not_determine_the_spread() -> None:
    found = fit_together(measured([punch(10), punch(10)], 0.02))
    assert not found.determined and found.interval[1] == math.inf
    area = bed_area(punch(10), 0.165, 0.02, 0.01)[0]
    assert found.K1.value == pytest.approx(KAPPA * area, rel=0.02), "what they do determine is right"


def test_the_material_of_a_joint_fit_is_the_one_that_was_measured() -> None:
    """Its closed form has the stiffness and the tension that the curves were made with."""
    tips = [sphere(10), punch(4)]
    found = fit_together(measured(tips, 0.015, noise=0.001))
    material = replace(
        DEFAULT_MATERIAL, K1=found.K1.value, K2=found.K2.value, x0=found.x0.value, spread=found.spread.value,
        indenter=tips[0],
    )  # fmt: skip
    assert estimate(material, 0.165).kappa1 == pytest.approx(KAPPA, rel=0.05)


def test_a_knee_that_all_curves_have_is_found_and_none_where_there_is_none() -> None:
    curves = measured([punch(4), punch(12)], 0.02)
    assert not fit_together(curves).knee
    more = [(4e4, 9e4)[i] * np.maximum(DEPTHS - KNEE, 0) for i in range(2)]
    bent = [replace(curve, force=curve.force + more[i]) for i, curve in enumerate(curves)]
    found = fit_together(bent)
    assert found.knee and found.x0.value == pytest.approx(KNEE, rel=0.1) and found.K2.value > 2 * found.K1.value


def test_a_noisy_curve_counts_less_than_a_quiet_one() -> None:
    quiet, noisy = measured([punch(10), punch(10)], 0.02, noise=0.002)
    wrong = replace(noisy, force=1.3 * noisy.force, noise=0.1 * float(noisy.force.max()))
    alone = KAPPA * bed_area(punch(10), 0.165, 0.02, 0.01)[0]
    assert fit_together([quiet, wrong]).K1.value == pytest.approx(alone, rel=0.02)
    assert fit_together([quiet, replace(wrong, noise=quiet.noise)]).K1.value > 1.05 * alone


def test_a_touch_that_is_an_estimate_may_be_a_little_off() -> None:
    curves = measured([sphere(5), sphere(20)], 0.02, noise=0.002)
    late = [replace(curve, depth=curve.depth + 0.0003, shifts=True) for curve in curves]
    assert fit_together(late).spread.value == pytest.approx(0.02, rel=0.1)


def solid(body: str, law: str) -> list[Curve]:
    """Return the curves of a solid computed by finite elements, under two balls and a punch."""
    rows: dict[str, list[tuple[float, float]]] = {}
    with SOLID.open(newline="") as file:
        for row in csv.DictReader(file):
            if (row["body"], row["law"]) == (body, law):
                rows.setdefault(row["tip"], []).append((float(row["depth_mm"]) / 1e3, float(row["force_n"])))
    curves = []
    for tip, points in rows.items():
        kind, radius, _ = tip.split()
        depth, force = np.array(points).T
        made = sphere(float(radius)) if kind == "ball" else punch(float(radius))
        curves.append(Curve(name=tip, tip=made, depth=depth, force=force, noise=0.0))
    return curves


@pytest.mark.parametrize("body", ["ball", "block"])
@pytest.mark.parametrize("law", ["linear", "neo-hookean"])
def test_a_solid_under_several_tips_is_met_by_one_set_of_constants(body: str, law: str) -> None:
    """No membrane on springs is a solid: it is met within a twentieth of full scale."""
    found: Together = fit_together(solid(body, law))
    assert found.determined and 0.005 < found.spread.value < 0.02
    assert len(found.curves) >= 2 and max(curve.rms for curve in found.curves) < 0.05


def test_what_cannot_be_fitted_together_is_said() -> None:
    curve = measured([punch(5)], 0.02)[0]
    with pytest.raises(DimpleError, match="two curves or more"):
        fit_together([curve])
    with pytest.raises(DimpleError, match="only 3 depths"):
        fit_together([curve, replace(curve, depth=curve.depth[:3], force=curve.force[:3])])


def test_the_command_line_takes_several_files_each_with_its_tip(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for curve in measured([sphere(5), punch(15)], 0.02):
        rows = zip([0, *(1e3 * curve.depth)], [0, *curve.force], strict=True)
        (tmp_path / curve.name).write_text("Depth (mm),Force (N)\n" + "".join(f"{x:.5f},{f:.6f}\n" for x, f in rows))
    files, result = [str(tmp_path / name) for name in ("0.csv", "1.csv")], tmp_path / "out.json"
    assert main(["calibrate", *files, "--tip", "sphere:5", "--tip", "punch:15", "--json", str(result)]) == 0
    assert "spread = 2" in capsys.readouterr().out
    record = json.loads(result.read_text())
    low, high = record["spread_interval"]
    assert low < 20 < high and [each["tip"] for each in record["curves"]] == ["sphere", "punch"]
