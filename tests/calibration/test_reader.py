"""The ways instruments write a press, and what is asked where a file leaves something open."""

from pathlib import Path

import numpy as np
import pytest

from core.base import DimpleError
from core.calibration.measurement import read_measurement
from core.calibration.question import Answers, Undecided

REAL = Path(__file__).parents[3] / "shared" / "data" / "calibration"


def table(curve, line, *, head="") -> str:
    """Write one line a row; `line` gets the row number from 1, depth [mm] and force [N]."""
    rows = (line(i, d, f) for i, (d, f) in enumerate(zip(curve.depth, curve.force, strict=True), 1))
    return head + "\n".join(rows) + "\n"


def german(value: float) -> str:
    return f"{value:.5f}".replace(".", ",")


def check(path, curve, answers=None, *, tolerance=1e-4):
    read = read_measurement(path, answers)
    assert np.allclose(read.depth * 1e3, curve.depth, atol=tolerance * 22)
    assert np.allclose(read.force, curve.force, atol=tolerance * 51)
    return read


# what instruments write


def test_plain_csv_with_units_in_brackets(curve, write):
    check(write(table(curve, lambda i, d, f: f"{d:.5f},{f:.5f}", head="Depth (mm),Force (N)\n")), curve)


def test_imada_units_in_columns_statistics_above_and_a_comma_behind(curve, write):
    head = (
        "Maximum,5219.3,@,No.1124,\nMinimum,-0.2,@,No.4,\nAverage,48.56,\nData Quantity,200,\nNumber of NG,0,\n"
        "No.,Force,Unit,Displacement,Unit,Judge,Position,Time,Date,\n"
    )
    grams = 1 / 9.80665e-3
    line = lambda i, d, f: f"{i},{f * grams:.3f},gf,{d:.4f},mm,OK,--,10:30:{i % 60:02d} AM,12/26/2024,"  # noqa: E731
    check(write(table(curve, line, head=head)), curve)


def test_imada_high_resolution_key_value_lines_and_no_header(curve, write):
    head = (
        "MAX FORCE = 5219.3,22.000\nMIN FORCE = -1.4,0.000\nAVERAGE FORCE = 56.00,\nUNIT = gf,mm\nDATA COUNT = 200,\n"
        "RECORDING RATE = 0.0005,\nFILE DATE = 12/26/2024 10:41:29 AM,\nCOMMENT = ,\nMARK POINT ON = ---,---\n"
        "MARK POINT OFF = ---,---\nTHRESHOLD = ---,\n1ST PEAK FORCE = ---,---\n2ND PEAK FORCE = ---,---\n"
    )
    check(write(table(curve, lambda i, d, f: f"{f / 9.80665e-3:.3f},{d:.5f}", head=head)), curve)


def test_bluehill_title_unit_row_quotes_and_kilonewtons(curve, write):
    head = '"Specimen 1 to 1"\n\n"Time","Compressive extension","Compressive load"\n"(s)","(mm)","(kN)"\n'
    check(write(table(curve, lambda i, d, f: f'"{i / 10:.3f}","{d:.5f}","{f / 1e3:.8f}"', head=head)), curve)


def test_zwick_semicolons_decimal_commas_and_german_headers_in_cp1252(curve, write):
    head = "Prüfer;Müller\nWerkstoff;Schaum, weiß\n\nPrüfzeit;Standardweg;Standardkraft\ns;mm;N\n"
    text = table(curve, lambda i, d, f: f"{german(i / 10)};{german(d)};{german(f)}", head=head)
    check(write(text, "cp1252"), curve)


def test_japanese_headers_in_cp932(curve, write):
    head = "試験名,圧縮試験\n試験日,2024/12/26\n時間,試験力,ストローク\n秒,N,mm\n"
    text = table(curve, lambda i, d, f: f"{i / 10:.2f},{f:.5f},{d:.5f}", head=head)
    assert "cp932" in " ".join(check(write(text, "cp932"), curve).remarks.notes)


def test_japanese_headers_with_units_in_full_width_brackets(curve, write):
    text = table(curve, lambda i, d, f: f"{d:.5f}\t{f:.5f}", head="変位（ｍｍ）\t荷重（Ｎ）\n")
    for encoding in ("utf-8", "utf-8-sig", "utf-16", "cp932"):
        check(write(text, encoding), curve)


def test_lines_of_old_macintoshes_and_of_windows(curve, write):
    text = table(curve, lambda i, d, f: f"{d:.5f},{f:.5f}", head="Depth (mm),Force (N)\n")
    check(write(text.replace("\n", "\r")), curve)
    check(write(text.replace("\n", "\r\n")), curve)


def test_blanks_between_columns(curve, write):
    text = table(curve, lambda i, d, f: f"  {d:12.5f}  {f:12.5f}", head="# indentation test\nDepth [mm]   Load [N]\n")
    check(write(text), curve)


def test_units_written_in_every_cell(curve, write):
    check(write(table(curve, lambda i, d, f: f"{d:.5f} mm;{1e3 * f:.2f} mN", head="Weg;Kraft\n")), curve)


def test_a_unit_that_changes_within_the_file_is_refused(curve, write):
    line = lambda i, d, f: f"{1e3 * f:.3f},mN,{d:.5f},mm" if f < 1 else f"{f:.6f},N,{d:.5f},mm"  # noqa: E731
    with pytest.raises(DimpleError, match="unit of Force changes within the file"):
        read_measurement(write(table(curve, line, head="Force,Unit,Travel,Unit\n")))


def test_counts_are_asked_about(curve, write):
    head = "Force Units:,N\nCounts per Unit Force:,1000000\nDisplacement (mm),Force\n"
    assert asked(write(table(curve, lambda i, d, f: f"{d:.5f},{round(1e6 * f)}", head=head))) == ("force_unit",)


def test_two_columns_of_decimal_commas_are_not_three_columns(write):
    rows = [f"{x:.4f};{0.6 * x:.4f}".replace(".", ",") for x in np.linspace(0, 20, 40)]
    path = write("Standardweg;Standardkraft\nmm;N\n" + "\n".join(rows))
    assert read_measurement(path).force.max() == pytest.approx(12)


def test_quoted_decimal_commas_between_commas(curve, write):
    text = table(curve, lambda i, d, f: f'"{german(d)}","{german(f)}"', head='"Weg [mm]","Kraft [N]"\n')
    check(write(text), curve)


def test_thousands_are_grouped(curve, write):
    text = table(curve, lambda i, d, f: f'"{1e3 * d:,.2f}","{1e3 * f:,.2f}"', head='"Travel [um]","Force [mN]"\n')
    check(write(text), curve)


def test_metres_inches_and_pounds_are_converted(curve, write):
    text = table(curve, lambda i, d, f: f"{d / 25.4:.7f},{f / 4.4482216:.7f}", head="Position (in),Load (lbf)\n")
    check(write(text), curve)
    check(write(table(curve, lambda i, d, f: f"{d / 1e3:.8f},{f:.5f}", head="Displacement/m,Force/N\n")), curve)


def test_columns_that_say_the_same_need_no_question(curve, write):
    head = "Time (s),Extension (mm),Compressive extension (mm),Load (N)\n"
    check(write(table(curve, lambda i, d, f: f"{i},{d:.5f},{-d:.5f},{f:.5f}", head=head)), curve)


def test_stress_strain_and_raw_counts_are_not_force_or_depth(curve, write):
    head = "Steps,Travel (mm),Scale raw,Scale (grams),Engineering Strain [-],Engineering Stress (kPa)\n"
    line = lambda i, d, f: f"{i},{d:.5f},{9999 * f:.1f},{f / 9.80665e-3:.4f},{d / 30:.5f},{f / 2:.4f}"  # noqa: E731
    read = check(write(table(curve, line, head=head)), curve)
    assert (read.depth_header, read.force_header) == ("Travel (mm)", "Scale (grams)")


def test_rows_without_a_value_are_left_out_and_counted(curve, write):
    text = table(
        curve, lambda i, d, f: f"{d:.5f},{'---' if i in (7, 8) else f'{f:.5f}'}", head="Depth (mm),Force (N)\n"
    )
    read = read_measurement(write(text))
    assert len(read.depth) == len(curve.depth) - 2
    assert "2 of 200 rows" in " ".join(read.remarks.notes)


def test_a_file_cut_in_a_row_is_read(curve, write):
    text = table(curve, lambda i, d, f: f"{d:.5f},{f:.5f}", head="Depth (mm),Force (N)\n")
    assert len(read_measurement(write(text[:-5])).depth) >= len(curve.depth) - 1


@pytest.mark.skipif(not REAL.is_dir(), reason="the shared data is not here")
@pytest.mark.parametrize(
    ("name", "rows", "depth", "force"),
    [
        ("ecoflex_EF10_0T_A1.csv", 1202, 20.0, 499.3),
        ("ecoflex_EF10_100T_B2.csv", 1202, 20.0, 74.81),
        ("rubber_dome_120g.csv", 1558, 3.895, 2.503),
        ("rubber_dome_heavy.csv", 1489, 3.72, 2.484),
    ],
)
def test_real_files_are_read_without_a_question(name, rows, depth, force):
    read = read_measurement(REAL / name)
    assert len(read.depth) == rows
    assert read.depth.max() * 1e3 == pytest.approx(depth, rel=1e-3)
    assert read.force.max() == pytest.approx(force, rel=1e-3)


# what is asked


def asked(path, answers=None) -> tuple[str, ...]:
    with pytest.raises(Undecided) as caught:
        read_measurement(path, answers)
    assert all(question.text in str(caught.value) for question in caught.value.questions)
    return tuple(question.name for question in caught.value.questions)


def test_without_a_header_the_columns_and_then_the_units_are_asked(curve, write):
    path = write(table(curve, lambda i, d, f: f"{f:.5f},{d:.5f}"))
    assert asked(path) == ("depth_column", "force_column")
    assert asked(path, Answers(depth_column="2", force_column="1")) == ("depth_unit", "force_unit")
    check(path, curve, Answers(depth_column="2", force_column="1", depth_unit="mm", force_unit="N"))


def test_of_two_bare_columns_one_answer_settles_both(curve, write):
    path = write(table(curve, lambda i, d, f: f"{f:.5f},{d:.5f}"))
    check(path, curve, Answers(depth_column="2", depth_unit="mm", force_unit="N"))


def test_a_missing_unit_is_asked_with_what_it_would_mean(curve, write):
    path = write(table(curve, lambda i, d, f: f"{d:.5f},{f:.5f}", head="Depth (mm),Force\n"))
    with pytest.raises(Undecided, match=r"the unit of Force.* 'gf' \(then it reaches"):
        read_measurement(path)
    check(path, curve, Answers(force_unit="N"))


def test_capitals_that_mean_two_units_are_asked(curve, write):
    assert asked(write(table(curve, lambda i, d, f: f"{d:.5f},{f:.5f}", head="DEPTH (MM),FORCE (MN)\n"))) == (
        "force_unit",
    )


def test_two_different_forces_are_asked(curve, write):
    text = table(curve, lambda i, d, f: f"{d:.5f},{f:.5f},{f / 3 + i % 7:.5f}", head="Depth (mm),Fx (N),Fz (N)\n")
    path = write(text)
    assert asked(path) == ("force_column",)
    check(path, curve, Answers(force_column="Fx"))


def test_numbers_that_may_be_thousands_or_decimals_are_asked(write):
    rows = "\n".join(f"{i}.{(37 * i) % 900 + 100};{2 * i}.{(53 * i) % 900 + 100}" for i in range(1, 60))
    path = write("Weg (mm);Kraft (N)\n" + rows)
    assert asked(path) == ("decimal",)
    assert read_measurement(path, Answers(decimal=".")).depth[0] * 1e3 == pytest.approx(1.137)
    assert read_measurement(path, Answers(decimal=",")).depth[0] * 1e3 == pytest.approx(1137)


def test_several_tables_are_asked(curve, write):
    one = table(curve, lambda i, d, f: f"{d:.5f},{f:.5f}", head="Depth (mm),Force (N)\n")
    two = table(curve, lambda i, d, f: f"{d:.5f},{f / 2:.5f}", head="Weg (mm),Kraft (N)\n")
    path = write(one + "\n" + two)
    assert asked(path) == ("table",)
    check(path, curve, Answers(table=1))
    assert np.allclose(read_measurement(path, Answers(table=2)).force, curve.force / 2, atol=1e-4)


def test_unknown_words_above_the_columns_are_asked_and_shown(curve, write):
    path = write(table(curve, lambda i, d, f: f"{d:.5f},{f:.5f}", head="alpha,beta\n"))
    with pytest.raises(Undecided, match="alpha: .*from"):
        read_measurement(path)


# what cannot be used


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "empty"),
        (b"   \n\n", "empty"),
        (b"PK\x03\x04" + bytes(1000), "ZIP"),
        (b"\x1f\x8b\x08" + bytes(1000), "binary"),
        (bytes(range(256)) * 50, "binary"),
        (b"MATLAB 5.0 MAT-file" + bytes(1000), "Export the measurement as CSV"),
        (b"Dear Sir,\nthe measurement went well.\nYours\n" * 20, "no table"),
        (b"Depth (mm)\n" + b"1.5\n" * 50, "no table"),
        (b"Depth (mm),Force (N)\n1,2\n2,3\n3,4\n", "rows"),
        (b"1,2," * 20000, "characters"),
        (b"1,2\n" * 30 + b"9" * 100000, "characters"),
    ],
)
def test_unusable_files_say_what_is_wrong(content, words, write):
    with pytest.raises(DimpleError, match=words):
        read_measurement(write(content))


def test_missing_files_and_folders_are_refused(tmp_path):
    with pytest.raises(DimpleError, match="cannot be read"):
        read_measurement(tmp_path / "nothing.csv")
    with pytest.raises(DimpleError, match="not a file"):
        read_measurement(tmp_path)


def test_a_long_recording_is_thinned_and_says_so(make, write):
    curve = make(rows=250_000)
    read = read_measurement(write(table(curve, lambda i, d, f: f"{d:.5f},{f:.4f}", head="Depth (mm),Force (N)\n")))
    assert "One in 3" in " ".join(read.remarks.notes)
    assert 80_000 < len(read.depth) < 100_001
    assert np.ptp(read.depth) * 1e3 == pytest.approx(22, rel=1e-3)


def test_answers_that_name_nothing_are_refused(curve, write):
    path = write(table(curve, lambda i, d, f: f"{d:.5f},{f:.5f}", head="Depth (mm),Force (N)\n"))
    with pytest.raises(DimpleError, match="does not name one column"):
        read_measurement(path, Answers(force_column="Kraft"))
    with pytest.raises(DimpleError, match="not a unit of force"):
        read_measurement(path, Answers(force_unit="furlong"))
    with pytest.raises(DimpleError, match="no table 4"):
        read_measurement(path, Answers(table=4))
    with pytest.raises(DimpleError, match="both"):
        read_measurement(path, Answers(depth_column="2", force_column="2"))
