"""The paper's tables and figures, made again by the command."""

import csv

import pytest

from core.calibration.calibrate import calibrate
from studies.__main__ import main
from studies.law import paper
from studies.paper_objects import PRESETS

# Table 2 of the paper: K1, K2 [N/mm], x0 [mm], k [N/mm]
TABLE_2 = {
    "1": {"K1": 0.59, "K2": 2.24, "x0": 36.3, "k": 54.8},
    "2": {"K1": 0.61, "K2": 7.23, "x0": 16.3, "k": 9.2},
    "3": {"K1": 0.62, "K2": 9.13, "x0": 13.7, "k": 9.2},
}


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Make it all on cubes of 386 vertices."""
    out = tmp_path_factory.mktemp("paper")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paper, "CELLS", 8)
        assert main(["paper", "--out", str(out)]) == 0
    return out


def test_table_2_stands_beside_what_is_printed(folder):
    table = rows(folder / "table_2.csv")
    assert [row["constant"] for row in table] == ["K1", "K2", "x0", "k"] * 3
    for row in table:
        printed = float(row["printed"])
        assert printed == pytest.approx(TABLE_2[row["object"]][row["constant"]])
        if row["constant"] != "k":
            assert float(row["from_the_curve"]) == pytest.approx(printed, abs=2 * float(row["half_width_95"]))
            assert float(row["from_a_virtual_press"]) == pytest.approx(printed, rel=0.01)


def test_a_virtual_press_is_a_file_like_any_other(folder):
    for preset in PRESETS:
        fit = calibrate(folder / f"virtual_press_{preset.name}.csv").fit
        assert fit.model == "two"
        assert fit.x0.value == pytest.approx(preset.material.x0, rel=0.01)


def test_the_tension_of_fig_7_b_is_proportional_to_its_stretch_by_eq_10_alone(folder):
    series = [row for row in rows(folder / "fig_7b.csv") if row["panel"].startswith("by Eqs.")]
    for preset in PRESETS:
        slopes = [float(r["y"]) / float(r["x"]) for r in series if r["series"] == preset.label and float(r["x"]) > 1e-3]
        assert slopes == pytest.approx([preset.material.k / 1e3] * len(slopes), rel=1e-3)


def test_the_figures_are_drawn(folder):
    pytest.importorskip("matplotlib")
    for name in ("fig_7a", "fig_7b"):
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert "<svg" in (folder / f"{name}.svg").read_text(encoding="utf-8")
