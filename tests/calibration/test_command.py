"""`dev.py core calibrate`, its JSON and its exit codes; samples and safe export."""

import json
import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from core.base import DimpleError
from core.calibration.calibrate import calibrate, provenance, source_of_k, to_record
from core.calibration.question import Answers
from core.calibration.surface_constant import surface_constant
from core.calibration.virtual_press import text_cell, write_press
from studies.__main__ import main
from studies.law.paper import DEEPEST, write_samples
from studies.meshes.mesh_file import load_triangles
from studies.meshes.simple import sized
from studies.paper_objects import PRESETS
from studies.reference.paper import surface_stretch, surface_tension
from tools.environment import ROOT

SAMPLES = ROOT / "blend_samples" / "calibration"
# by the force balance [N/mm], of the files as they are; Table 2 prints another k, which no curve determines
K_OF_SAMPLES = {"object_1_nylon_air": "0.237", "object_2_vinyl_air": "10.5", "object_3_vinyl_water": "22.5"}
KEYS = {"K1", "K2", "x0", "K1_se", "K2_se", "x0_se", "model", "warnings"}


def run(*words: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "studies", *map(str, words)], cwd=ROOT, capture_output=True, text=True, timeout=60
    )


def test_the_command_writes_constants_in_the_units_of_the_paper(tmp_path):
    out = tmp_path / "out.json"
    done = run("calibrate", SAMPLES / "object_3_vinyl_water.csv", "--length-mm", 165, "--json", out)
    assert done.returncode == 0, done.stderr
    report = json.loads(out.read_text())
    assert report.keys() >= KEYS
    assert report["model"] == "two"
    assert (report["K1"], report["K2"], report["x0"]) == pytest.approx((0.62, 9.13, 13.7), rel=0.03)
    for name in ("K1", "K2", "x0"):
        low, high = report[f"{name}_interval"]
        assert low < report[name] < high
    assert report["k"] > 0 and any("of a string of length l" in note for note in report["notes"])


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply"])
def test_a_mesh_in_any_unit_is_read_in_the_size_of_the_object(suffix, tmp_path):
    path = tmp_path / f"box.{suffix}"
    trimesh.creation.box((2, 4, 1)).export(path)
    mesh = sized(*load_triangles(path))
    assert len(mesh.rest_positions) == 8
    assert np.ptp(mesh.rest_positions, axis=0) == pytest.approx([0.0825, 0.165, 0.04125])
    assert mesh.volume == pytest.approx(0.0825 * 0.165 * 0.04125)


@pytest.mark.parametrize(
    ("name", "content"),
    [("a.blend", b"BLENDER"), ("a.stl", b"solid\n"), ("a.obj", b""), ("a.ply", b"ply\nform"), ("no.ply", None)],
)
def test_a_file_that_is_no_mesh_is_refused_in_words(name, content, tmp_path):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(DimpleError, match=re.escape(str(path))):
        sized(*load_triangles(path))


def test_an_open_question_exits_with_3_and_the_option(write, tmp_path):
    out = tmp_path / "out.json"
    path = write("Depth (mm),Force\n" + "\n".join(f"{i / 10},{i / 20 + (i % 3) / 90:.4f}" for i in range(200)) + "\n")
    assert main(["calibrate", str(path), "--json", str(out)]) == 3
    (question,) = json.loads(out.read_text())["questions"]
    assert question["option"] == "--force-unit"
    assert {candidate["value"] for candidate in question["candidates"]} >= {"N", "gf"}
    assert main(["calibrate", str(path), "--force-unit", "N"]) == 0


def test_an_unusable_file_exits_with_2_and_says_why(write, capsys):
    assert main(["calibrate", str(write(b"PK\x03\x04" + bytes(100)))]) == 2
    assert "ZIP" in capsys.readouterr().err
    assert main(["calibrate", "nowhere.csv"]) == 2


def test_a_picture_is_drawn_where_matplotlib_is(tmp_path):
    pytest.importorskip("matplotlib")
    out = tmp_path / "out.png"
    assert main(["calibrate", str(SAMPLES / "object_1_nylon_air.csv"), "--plot", str(out)]) == 0
    assert out.read_bytes().startswith(b"\x89PNG")


def test_without_matplotlib_the_picture_is_refused_in_words(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("studies.files.util.find_spec", lambda name: None)
    assert main(["calibrate", str(SAMPLES / "object_1_nylon_air.csv"), "--plot", str(tmp_path / "out.png")]) == 2
    assert "matplotlib" in capsys.readouterr().err


def test_the_samples_are_what_the_code_writes_and_say_they_are_reconstructed(tmp_path):
    for path in write_samples(tmp_path):
        text = path.read_text()
        assert text == (SAMPLES / path.name).read_text()
        assert "RECONSTRUCTED" in text


@pytest.mark.parametrize("preset", PRESETS, ids=lambda preset: preset.name)
def test_each_sample_gives_its_row_of_table_2_back(preset):
    done = calibrate(SAMPLES / f"{preset.name}.csv", length=preset.size)
    truth = preset.material
    for constant, value in ((done.fit.K1, truth.K1), (done.fit.K2, truth.K2), (done.fit.x0, truth.x0)):
        assert abs(constant.value - value) <= 1.5 * constant.half_width
    assert done.warnings == ()
    assert done.loading.depth.max() == pytest.approx(DEEPEST[preset.name])
    line = provenance(done)
    assert f"{preset.name}.csv" in line and line.endswith("point of 2 mm radius")
    assert source_of_k(done) == f"k {K_OF_SAMPLES[preset.name]} N/mm by the force balance"


def test_the_press_of_a_calibration_begins_at_the_touch_that_was_fitted(make, write):
    curve = make(approach=5.0, noise=0.003)
    rows = "".join(f"{x + 31:.5f},{f + 2:.5f}\n" for x, f in zip(curve.depth, curve.force, strict=True))
    path = write("mm,N\n" + rows)
    done = calibrate(path, Answers(depth_column="1", force_column="2"))
    beyond = done.loading.depth > 0
    off = done.loading.force[beyond] - done.fit.law(done.loading.depth[beyond])
    assert np.sqrt((off**2).mean()) == pytest.approx(done.fit.noise, rel=0.05)
    assert to_record(done)["contact"] == pytest.approx(31, abs=0.2)
    assert to_record(done)["tare"] == pytest.approx(2, abs=0.05)


def test_k_by_the_paper_is_a_slope_of_section_modulus_and_length_alone():
    depth = np.linspace(0.001, 0.02, 50)
    section, modulus, length = 2e-6, 3.8e8, 0.165
    for force in (600 * depth, 9000 * depth**2):
        tension = np.array([surface_tension(f, x, length) for f, x in zip(force, depth, strict=True)])
        stretch = np.array([surface_stretch(s, length, section, modulus) for s in tension])
        assert np.polyfit(stretch, tension, 1)[0] == pytest.approx(2 * section * modulus / length, rel=1e-9)


def test_k_by_the_force_balance_is_that_of_a_string():
    length, k, before = 0.165, 9200.0, 12.0
    depth = np.linspace(0, 0.03, 200)
    h = np.hypot(length / 2, depth)
    force = 2 * (before + k * (2 * h - length)) * depth / h
    assert surface_constant(depth, force, length) == pytest.approx(k, rel=1e-6)


@pytest.mark.parametrize("evil", ["=cmd|' /C calc'!A0", "+1+1", "-2+3", "@SUM(A1)", "\t=1", "a\n=1", 'x",=1', "x;=1"])
def test_no_text_written_is_a_formula_to_a_spreadsheet(evil, tmp_path):
    path = tmp_path / "out.csv"
    write_press(path, np.linspace(0, 0.02, 50), np.linspace(0, 9, 50), about=(evil,))
    first = path.read_text().split("\n")[0]
    assert first == text_cell(evil)
    assert first.startswith('"') and first.endswith('"') and '"' not in first[1:-1]
    assert first[1] not in "=+-@\t\r|%"


def test_what_is_written_is_read_back(tmp_path):
    depth, force = np.linspace(0, 0.02, 80), 30 * np.linspace(0, 1, 80) ** 2
    path: Path = tmp_path / "out.csv"
    write_press(path, depth, force, about=("=1+1, a virtual press", "@home"))
    done = calibrate(path)
    assert done.fit.full_scale == pytest.approx(30)
    assert math.isclose(done.loading.depth.max(), 0.02)
