"""A settled dent is smooth; how that is measured is tested on dents known exactly."""

import itertools
import re
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from core.calibration.calibrate import calibrate
from core.calibration.virtual_press import write_press
from core.material import DEFAULT_MATERIAL, HERTZ, POINT, Indenter
from core.reduction.proxy import mean_spacing
from studies.__main__ import main
from studies.body import beside_solid
from studies.body.dent_shape import Profile, profile, turned_onto, vertex_roughness
from studies.body.dents import ball, planned, roughness, settle
from studies.body.solid_mesh import BALL_RADIUS

VINYL = replace(DEFAULT_MATERIAL, spread=None)  # as wide as k makes it
OTHERS = ("ball", 20), ("block", 10), ("block", 20)


def round_dent(depth: float, width: float = 0.02) -> Profile:
    """Return a dent that is a bell in the way along the skin, straight down."""
    way = np.linspace(0, 0.08, 400)
    return Profile(
        way, BALL_RADIUS * np.sin(way / BALL_RADIUS),
        BALL_RADIUS * (np.cos(way / BALL_RADIUS) - 1) - depth * np.exp(-((way / width) ** 2)),
    )  # fmt: skip


@pytest.mark.parametrize("subdivisions", [4, 5], ids=["2,562 vertices", "10,242 vertices"])
def test_a_dent_is_smooth(subdivisions: int) -> None:
    """Within 1 percent of its depth, where springs alone are pleated by 1.3 to 2.1 percent."""
    mesh = ball(subdivisions)
    for one in settle(mesh, VINYL, 0.010, (0.005, 0.010, 0.015)):
        assert roughness(mesh, one) < 0.01


@pytest.mark.parametrize(
    "radius, friction, depths",
    [(0.010, 0.5, (0.010, 0.020, 0.025)), (0.020, 0.5, (0.010, 0.025)), (0.010, 2.0, (0.025,))],
    ids=["2.5 radii deep", "a tip twice as large", "more friction"],
)  # fmt: skip
def test_a_dent_is_as_smooth_on_the_proxy_of_a_session(
    radius: float, friction: float, depths: tuple[float, ...]
) -> None:
    mesh, material = ball(5), replace(VINYL, friction=friction)
    for one in settle(mesh, material, radius, depths, proxy=planned(mesh, material)):
        assert roughness(mesh, one) < 0.006


@pytest.mark.parametrize("body, tip", [("ball", 10), *(pytest.param(*case, marks=pytest.mark.slow) for case in OTHERS)])
def test_a_solid_measured_through_one_tip_is_dented_alike_by_another(body: str, tip: int) -> None:
    """Dents of both tips within 5 % of their depth, 6.5 where it is deepest, volume within two thousandths.

    Full of liquid instead, a shallow dent is half as far off again, or more.
    """
    rows = beside_solid.rows(5, bodies=[body], laws=["linear"], tips=[tip])
    found = [dict(zip(beside_solid.HEAD, row, strict=True)) for row in rows]
    solid, liquid = ([row for row in found if row["fill"] == fill] for fill in ("solid", "liquid"))

    def most(row: dict[str, object], name: str, depths: tuple[int, ...]) -> float:
        return max(abs(float(str(row[f"{name}_{mm}_mm_percent"]))) for mm in depths)

    for row in solid:
        assert most(row, "dent", (5, 10)) < 5 and most(row, "dent", (20,)) < 6.5
        assert float(str(row["volume_percent"])) < 0.2
    for row, other in zip(solid, liquid, strict=True):
        assert most(other, "dent", (5,)) > 1.4 * most(row, "dent", (5,))


@pytest.mark.parametrize("subdivisions, floor", [(4, 0.004), (5, 0.002)])
def test_a_round_dent_is_measured_as_smooth(subdivisions: int, floor: float) -> None:
    mesh, depth = ball(subdivisions), 0.010
    x = turned_onto(round_dent(depth), mesh.rest_positions)
    spacing = mean_spacing(mesh, len(x))
    assert vertex_roughness(mesh.rest_positions, x, spacing) < floor * depth
    found = profile(mesh.rest_positions, x, spacing)
    assert found.inward()[0] == pytest.approx(depth, rel=0.01)
    assert found.reach(0.5) == pytest.approx(0.02 * np.log(2) ** 0.5, rel=0.02)
    # pleats of a height h have an RMS of h / sqrt 2
    x[:, 2] += 5e-4 * np.cos(7 * np.arctan2(x[:, 1], x[:, 0]))
    assert vertex_roughness(mesh.rest_positions, x, spacing) == pytest.approx(5e-4 / 2**0.5, rel=0.1)


def test_a_dent_converges_as_the_mesh_is_refined() -> None:
    """On 642, 2,562 and 10,242 vertices, beside 40,962: the edge of the tip is a kink, and still it is second order."""
    shapes = []
    for subdivisions in (3, 4, 5, 6):
        mesh = ball(subdivisions)
        (one,) = settle(mesh, VINYL, 0.020, [0.020])
        shapes.append(profile(mesh.rest_positions, one.positions, mean_spacing(mesh, len(mesh.rest_positions))))
    way = np.linspace(0, 0.04, 100)
    coarse, middle, fine, finest = (np.interp(way, shape.way, shape.inward()) for shape in shapes)
    off = [float(np.sqrt(np.mean((each - finest) ** 2))) for each in (coarse, middle, fine)]
    assert off[1] < off[0] / 2 and off[2] < off[1] / 2


def test_the_command_writes_tables_and_pictures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(beside_solid, "rows", partial(beside_solid.rows, bodies=["block"], laws=["linear"], tips=[10]))
    assert main(["dents", "--quick", "--out", str(tmp_path)]) == 0
    names = {"roughness.csv", "beside_solid.csv", "finite_elements.csv", "finite_elements.png"}
    assert {path.name for path in tmp_path.iterdir()} == names
    assert "roughness_percent" in capsys.readouterr().out


def test_two_slopes_tell_the_power_law_of_an_elastic_solid() -> None:
    """Whatever its law, shape and tip: within 4 % at each depth, where two slopes are up to twice the force."""
    for body, law, tip in itertools.product(beside_solid.BODIES, beside_solid.LAWS, beside_solid.TIPS):
        material = beside_solid.measured(body, law, tip)
        solid = replace(material, fill="solid")
        wanted = np.interp(beside_solid.DEPTHS, *beside_solid.curve(body, law, tip))
        assert 1.4 < solid.power <= HERTZ
        assert [solid.law(depth) for depth in beside_solid.DEPTHS] == pytest.approx(wanted, rel=0.04)
        assert material.law(0.001) > 1.6 * wanted[0]


@pytest.mark.parametrize(("tip", "said"), [(10, True), (20, True), (0, False)], ids=["10 mm", "20 mm", "a point"])
def test_the_file_of_a_solid_is_told_from_that_of_a_hollow_body(tip: int, said: bool, tmp_path: Path) -> None:
    """If a sphere pressed it: two slopes miss the points by 11 to 20 % of the force, the law of a solid by 2 %."""
    depths, forces = beside_solid.curve("block", "linear", tip or 10)
    write_press(tmp_path / "solid.csv", depths, forces)
    indenter = Indenter(shape="sphere", radius=1e-3 * tip) if tip else POINT
    done = calibrate(tmp_path / "solid.csv", tip=indenter)
    hints = [warning for warning in done.warnings if "choose Fill: Solid" in warning]
    assert bool(hints) == said
    if said:
        as_solid, as_slopes = (int(each) for each in re.findall(r"(\d+) %", hints[0]))
        assert as_solid < 4 < 10 < as_slopes
