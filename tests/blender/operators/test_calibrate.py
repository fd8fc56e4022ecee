"""From an instrument's file to constants: read, asked about, refused."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

SAMPLE = Path(__file__).parents[3] / "blend_samples" / "calibration" / "object_2_vinyl_air.csv"
DEPTH = np.linspace(0, 20, 60)
FORCE = 0.6 * np.minimum(DEPTH, 12) + 7 * np.maximum(DEPTH - 12, 0)  # K1 0.6, K2 7 N/mm, x0 12 mm

Write = Callable[..., str]


@pytest.fixture
def scene(empty_file: ModuleType) -> Any:
    return empty_file.context.scene.dimple


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Return a function that writes the law above as a file of some instrument."""

    def write_file(name: str, header: str, row: Callable[[float, float], str], encoding: str = "utf-8") -> str:
        lines = [header, *(row(x, f) for x, f in zip(DEPTH, FORCE, strict=True))]
        path = tmp_path / name
        path.write_text("\n".join(filter(None, lines)) + "\n", encoding=encoding)
        return str(path)

    return write_file


def questions_of(asked: str) -> list[dict]:
    from bl_ext.user_default.dimple.core.message import from_json

    return from_json(asked)["questions"]


def record_of(scene: Any) -> dict:
    from bl_ext.user_default.dimple.core.message import from_json

    return from_json(scene.calibration)


def test_the_sample_becomes_the_constants_it_was_made_from_within_their_errors(bpy: ModuleType, scene: Any) -> None:
    assert bpy.ops.dimple.calibrate(filepath=str(SAMPLE)) == {"FINISHED"}
    result = record_of(scene)
    for name, truth in (("K1", 0.61), ("K2", 7.23), ("x0", 16.3)):
        low, high = result[f"{name}_interval"]
        assert low < truth < high and high - low < 0.1 * truth
    assert result["model"] == "two" and result["source"] == SAMPLE.name
    assert len(result["points"]) <= 160


@pytest.mark.parametrize(
    ("name", "header", "row", "encoding"),
    [
        ("paper.csv", "Distance x (mm),Force F (N)", "{0:.4f},{1:.4f}", "utf-8"),
        ("zwick.txt", "Standardweg;Standardkraft\nmm;N", "{0};{1}", "cp1252"),
        ("japanese.csv", "変位 (mm),荷重 (N)", "{0:.4f},{1:.4f}", "cp932"),
        ("imada.dat", "No.,Force,Unit,Displacement,Unit,", "1,{1:.4f},N,{0:.4f},mm,", "utf-8"),
        ("tabs.tsv", "Compression (mm)\tLoad (mN)", "{0:.4f}\t{2:.4f}", "utf-16"),
    ],
)
def test_files_of_every_kind_give_the_same_constants_without_a_question(
    bpy: ModuleType, scene: Any, write: Write, name: str, header: str, row: str, encoding: str
) -> None:
    def line(x: float, f: float) -> str:
        if name.startswith("zwick"):
            return row.format(f"{x:.4f}".replace(".", ","), f"{f:.4f}".replace(".", ","))
        return row.format(x, f, 1000 * f)

    assert bpy.ops.dimple.calibrate(filepath=write(name, header, line, encoding)) == {"FINISHED"}
    result = record_of(scene)
    assert result["K1"] == pytest.approx(0.6, rel=1e-3)
    assert result["K2"] == pytest.approx(7, rel=1e-3)
    assert result["x0"] == pytest.approx(12, rel=1e-3)


def test_a_script_is_told_what_a_file_leaves_open_and_its_answer_is_taken(
    bpy: ModuleType, scene: Any, write: Write
) -> None:
    path = write("bare.csv", "", lambda x, f: f"{x:.4f},{f:.4f}")
    scene.calibration = '{"kept": 1}'
    with pytest.raises(RuntimeError, match="Which column is the depth.* Give depth_column: '1'"):
        bpy.ops.dimple.calibrate(filepath=path)
    assert scene.calibration == '{"kept": 1}', "nothing is lost"
    with pytest.raises(RuntimeError, match="unit"):
        bpy.ops.dimple.calibrate(filepath=path, depth_column="1", force_column="2")
    answers = {"depth_column": "1", "force_column": "2", "depth_unit": "mm", "force_unit": "N"}
    assert bpy.ops.dimple.calibrate(filepath=path, **answers) == {"FINISHED"}
    assert record_of(scene)["K2"] == pytest.approx(7, rel=1e-3)
    assert bpy.ops.dimple.calibrate(filepath=path, **(answers | {"force_unit": "mN"})) == {"FINISHED"}
    assert record_of(scene)["K2"] == pytest.approx(7e-3, rel=1e-3)


def test_a_force_where_the_file_begins_is_asked_and_the_touch_can_be_said(
    bpy: ModuleType, scene: Any, write: Write
) -> None:
    path = write("pressed.csv", "Depth (mm),Force (N)", lambda x, f: f"{x - 6:.4f},{f:.4f}" if x > 6 else "")
    with pytest.raises(RuntimeError, match="At which depth was the first touch.* Give contact_mm: .*not tared"):
        bpy.ops.dimple.calibrate(filepath=path)
    assert bpy.ops.dimple.calibrate(filepath=path, contact_mm=-6) == {"FINISHED"}
    assert record_of(scene)["x0"] == pytest.approx(12, rel=1e-3)
    assert bpy.ops.dimple.calibrate(filepath=path, contact_mm=0) == {"FINISHED"}
    assert record_of(scene)["x0"] == pytest.approx(6, rel=0.1), "K1 alone tells no touch: 0 is as was said"
    assert record_of(scene)["K1"] == pytest.approx(0.6, rel=1e-3)


def test_a_torn_specimen_is_asked_about_and_its_range_can_be_cut(bpy: ModuleType, scene: Any, write: Write) -> None:
    path = write("torn.csv", "Depth (mm),Force (N)", lambda x, f: f"{x:.4f},{f if x < 17 else 1.0:.4f}")
    with pytest.raises(RuntimeError, match="did the specimen tear.* Give until_mm: '17.1"):
        bpy.ops.dimple.calibrate(filepath=path)
    assert bpy.ops.dimple.calibrate(filepath=path, until_mm=17.1) == {"FINISHED"}
    assert record_of(scene)["K2"] == pytest.approx(7, rel=1e-3) and record_of(scene)["deepest"] < 17
    assert bpy.ops.dimple.calibrate(filepath=path, until_mm=17.1, press="positive") == {"FINISHED"}


def test_the_result_names_its_columns_and_warnings_have_headlines(bpy: ModuleType, scene: Any, tmp_path: Path) -> None:
    from bl_ext.user_default.dimple.addon import calibration as calibrated

    path = tmp_path / "bent.csv"
    path.write_text("Depth (mm),Force (N)\n" + "".join(f"{x:.4f},{(x / 4) ** 3:.4f}\n" for x in DEPTH))
    assert bpy.ops.dimple.calibrate(filepath=str(path)) == {"FINISHED"}
    record = record_of(scene)
    rows = dict(calibrated.rows(record))
    assert rows["Depth Column"] == "1: Depth (mm), mm" and rows["Force Column"] == "2: Force (N), N"
    assert rows["Largest Error from Points"].endswith("%")
    headlines = calibrated.headlines(record)
    assert headlines and all("\n" not in line and len(line) < 110 for line in headlines)
    assert any(line.startswith(headlines[0]) and len(line) > len(headlines[0]) for line in calibrated.sentences(record))


def test_every_answer_has_a_property_of_its_name(bpy: ModuleType) -> None:
    from dataclasses import fields

    from bl_ext.user_default.dimple.core.calibration.question import Answers

    shown = bpy.ops.dimple.calibrate.get_rna_type().properties
    for field in fields(Answers):
        assert shown[field.name].name


class Asked:
    """Stand for the operator in its dialog, which background Blender does not have; note what opens next."""

    def __init__(self, bpy: ModuleType, monkeypatch: pytest.MonkeyPatch, path: str) -> None:
        from bl_ext.user_default.dimple.operators.calibrate import from_file

        self.bpy, self.calibrate, self.opened, self.reports = bpy, from_file, [], []
        self.rna = bpy.ops.dimple.calibrate.get_rna_type()
        app = SimpleNamespace(background=False)
        dimple = SimpleNamespace(calibrate=lambda _how, **given: self.opened.append(given))
        monkeypatch.setattr(from_file.bpy, "app", app, raising=False)
        monkeypatch.setattr(from_file.bpy, "ops", SimpleNamespace(dimple=dimple), raising=False)
        self.opened.append({"filepath": path})

    def answer(self, *choices: str) -> set[str]:
        """Run the operator that was opened last, with a choice for each of its questions."""
        given = self.opened[-1]
        operator = self.calibrate.DIMPLE_OT_calibrate
        rna = self.rna.properties
        values = {name: rna[name].default for name in (*self.calibrate._ANSWERS, *self.calibrate._KEPT)}
        values |= {"asked": "", "found": "", **given, **{f"answer_{i}": choice for i, choice in enumerate(choices)}}
        methods = vars(self.calibrate.polls.Declared) | vars(self.calibrate.Tip) | vars(operator)
        stub = type("Stub", (), {k: v for k, v in methods.items() if callable(v) and not k.startswith("__")})()
        for name, value in values.items():
            setattr(stub, name, value)
        stub.report = lambda level, text: self.reports.append((*level, text))
        stub.properties = SimpleNamespace(is_property_set=lambda name: getattr(stub, name) != rna[name].default)
        self.shown = stub
        return stub.execute(self.bpy.context)


def test_the_dialog_asks_until_nothing_is_open(
    bpy: ModuleType, scene: Any, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    from bl_ext.user_default.dimple.operators.calibrate import from_file

    asked = Asked(bpy, monkeypatch, write("bare.csv", "", lambda x, f: f"{x:.4f},{f:.4f}"))
    assert asked.answer() == {"CANCELLED"} and len(asked.opened) == 2
    questions = questions_of(asked.opened[-1]["asked"])
    assert [question["name"] for question in questions] == ["depth_column", "force_column"]
    previews = [text for _, _, text in from_file._items(asked.opened[-1]["asked"], 0)]
    assert "0, 0.339, 0.678, ... from 0 to 20" in previews[1]
    assert asked.answer("0", "NONE") == {"CANCELLED"} and scene.calibration == ""
    assert asked.opened[-1]["asked"] == asked.opened[-2]["asked"], "what has no answer is asked again"
    asked.answer("0", "1")
    questions = questions_of(asked.opened[-1]["asked"])
    assert [question["name"] for question in questions] == ["depth_unit", "force_unit"]
    units = [candidate["value"] for candidate in questions[1]["candidates"]]
    assert asked.answer("0", str(units.index("N"))) == {"FINISHED"}
    assert record_of(scene)["K2"] == pytest.approx(7, rel=1e-3)


def test_touch_and_tare_that_were_found_stand_in_their_fields_and_the_fit_follows_them(
    bpy: ModuleType, scene: Any, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    noise = np.random.default_rng(0).normal(size=len(DEPTH)).tolist()

    def row(x: float, f: float) -> str:
        tared = 0.6 * max(x - 5, 0) + 6.4 * max(x - 14, 0) + 2 + 0.02 * noise.pop()
        return f"{x:.4f},{tared:.4f}"

    asked = Asked(bpy, monkeypatch, write("air.csv", "Depth (mm),Force (N)", row))
    assert asked.answer() == {"FINISHED"}
    shown, found = asked.shown, record_of(scene)
    assert (shown.contact_mm, shown.tare_n) == pytest.approx((found["contact"], found["tare"]))
    assert (shown.contact_mm, shown.tare_n) == pytest.approx((5, 2), abs=0.3)
    shown.execute(bpy.context)
    assert record_of(scene) == found, "nothing was changed"
    shown.contact_mm = 6.0
    shown.execute(bpy.context)
    moved = record_of(scene)
    assert moved["contact"] == pytest.approx(6) and shown.tare_n == pytest.approx(moved["tare"]) != found["tare"]
    shown.tare_n = 1.5
    shown.execute(bpy.context)
    assert (record_of(scene)["contact"], record_of(scene)["tare"]) == pytest.approx((6, 1.5))


def test_the_likeliest_answer_is_chosen_when_the_dialog_opens(
    bpy: ModuleType, write: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write("preload.csv", "Depth (mm),Force (N)", lambda x, f: f"{x - 6:.4f},{f:.4f}" if x > 6 else "")
    asked = Asked(bpy, monkeypatch, path)
    asked.answer()
    shown = SimpleNamespace(
        asked=asked.opened[-1]["asked"], properties=SimpleNamespace(is_property_set=lambda name: False)
    )
    manager = SimpleNamespace(invoke_props_dialog=lambda *args, **how: {"RUNNING_MODAL"})
    shown.take_size = lambda context: None
    context = SimpleNamespace(object=None, window_manager=manager)
    asked.calibrate.DIMPLE_OT_calibrate.invoke(shown, context, None)
    (question,) = questions_of(shown.asked)
    assert question["candidates"][int(shown.answer_0)]["value"] == question["default"]
    assert float(question["default"]) == pytest.approx(-6, abs=0.01)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04rest", b"no table here\n", b"1,2\n3,4\n", b"\x00\xff" * 400])
def test_a_bad_file_is_told_and_nothing_is_lost(bpy: ModuleType, scene: Any, tmp_path: Path, content: bytes) -> None:
    (tmp_path / "bad.csv").write_bytes(content)
    bpy.ops.dimple.calibrate(filepath=str(SAMPLE))
    before = scene.calibration
    with pytest.raises(RuntimeError) as error:
        bpy.ops.dimple.calibrate(filepath=str(tmp_path / "bad.csv"))
    assert "Traceback" not in str(error.value) and "--" not in str(error.value)
    assert scene.calibration == before


def test_a_file_dropped_into_a_viewport_and_only_there_is_calibrated(bpy: ModuleType) -> None:
    handler = bpy.types.DIMPLE_FH_force_depth
    assert handler.bl_import_operator == "dimple.calibrate"
    assert {".csv", ".txt", ".tsv", ".dat"} <= set(handler.bl_file_extensions.split(";"))
    filepath = bpy.ops.dimple.calibrate.get_rna_type().properties["filepath"]
    assert filepath.subtype == "FILE_PATH" and filepath.is_skip_save
    for area, taken in (("VIEW_3D", True), ("TEXT_EDITOR", False)):
        assert handler.poll_drop(SimpleNamespace(area=SimpleNamespace(type=area))) is taken
    assert not handler.poll_drop(SimpleNamespace(area=None))


def test_a_damaged_record_in_a_file_is_no_calibration(bpy: ModuleType, scene: Any) -> None:
    from bl_ext.user_default.dimple.operators.calibrate import results

    for text in ("", "{", "[1]", "7"):
        assert results.load(text) == {}
    scene.calibration = "{"
    assert not bpy.ops.dimple.apply_calibration.poll()
