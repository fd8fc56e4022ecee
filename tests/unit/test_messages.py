"""Messages are templates with values, so that each can be translated; every template is in every catalogue."""

import ast
import copy
import json
import re
from collections.abc import Iterator
from pathlib import Path
from string import Formatter

import numpy as np
import pytest

from core.errors import DimpleError
from core.message import Message, about, in_a_row, kept, read
from tools.environment import ROOT

CATALOGUES = sorted((ROOT / "addon" / "locale").glob("*.json"))
SOURCES = sorted(path for room in ("core", "operators", "addon") for path in (ROOT / room).rglob("*.py"))
OPTION = re.compile(r"--[a-z]")
# two words or more, or a sentence: what a person reads
SENTENCE = re.compile(r"""[A-Za-z]{2,}[,;:]?["”]? ["“]?[A-Za-z{]|[}"”] [a-z]{3}|^[A-Z][a-z].*\.$""")
UNITS = re.compile(r"\{[^}]*\}|\b(cm|kPa|kg|mm|ms|px|Hz)\b|³")
# what no artist reads: command lines, what is written to files, names in a .blend, the columns of measured files, and
# what only a mistake in our own code raises
UNSEEN = (
    "core/calibration/known_words_and_units.py", "core/device/servo_process.py", "core/native/body.py",
    "core/native/carry.py", "core/native/scene.py", "operators/export/clips.py", "operators/export/command_line.py",
    "operators/bridge/keyframes.py",
    "operators/export/formats.py", "operators/export/sidecar.py",
    "operators/names.py",  # labels and texts, which a test in Blender looks at
)  # fmt: skip
UNSEEN_TEXTS = {
    "import sys, mmap, select, tomllib; print('python', *sys.version_info[:2])", "real time", "force units?",
    "Simulated by Dimple, not measured: {}, {} mm", "Tip: sphere, radius {} mm",
    "Material: K1 {} N/mm, K2 {} N/mm, x0 {} mm", "Object Info", "Dimple Press", ".Dimple Press",
    "Distance x (mm)", "Force F (N)",
    "Dimple Trial", "Dimple Export", "Dimple Frame", "Fingertip {}", "A message of {} bytes is too long.",
    "ABI {}, {}", "Core: {}", "Dimple {}, Blender {}, {}", "%s: everything was ended",  # in a bug report and the log
}  # fmt: skip


def texts(path: Path) -> Iterator[tuple[str, bool]]:
    """Yield the texts of a file that are no docstrings, {} where an f-string has a value; and whether it is one."""
    nodes = list(ast.walk(ast.parse(path.read_text())))
    strings = [node for node in nodes if isinstance(node, ast.JoinedStr)]
    parts = {id(part) for node in strings for part in node.values}
    docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        if isinstance(node, ast.JoinedStr) and id(node) not in parts:
            yield "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values), True
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in parts | docstrings:
            yield node.value, False


def messages() -> Iterator[tuple[str, str, bool]]:
    """Yield (file, text, whether it is an f-string) of what core and the operators say to the artist."""
    for path in SOURCES:
        name = path.relative_to(ROOT).as_posix()
        for text, is_f in texts(path) if name not in UNSEEN and not name.startswith("addon/") else ():
            if SENTENCE.search(text) and re.search("[A-Za-z]{2}", UNITS.sub("", text)) and text not in UNSEEN_TEXTS:
                yield name, text, is_f


def places(text: str) -> list[tuple[str, str, str]]:
    return sorted((name, spec or "", how or "") for _, name, spec, how in Formatter().parse(text) if name is not None)


@pytest.fixture(params=CATALOGUES, ids=lambda path: path.stem)
def catalogue(request: pytest.FixtureRequest) -> dict[str, str]:
    return json.loads(request.param.read_text("utf-8"))


def test_no_message_is_an_f_string() -> None:
    assert [(path, text) for path, text, is_f in messages() if is_f] == []


def test_every_template_is_in_the_catalogue(catalogue: dict[str, str]) -> None:
    said = {(path, text) for path, text, is_f in messages() if not is_f}
    assert len(said) > 400
    assert sorted(each for each in said if each[1] not in catalogue) == []


def test_a_translation_has_the_places_of_its_template(catalogue: dict[str, str]) -> None:
    for english, text in catalogue.items():
        assert places(english) == places(text), english


def test_a_message_is_its_english_text_and_keeps_template_and_values() -> None:
    why = DimpleError("it has {count:,} of {units}", count=np.int64(1200), units=("N", Message("grams")))
    said = about("Ball", str(DimpleError("The {part} is wrong: {why}.", part=Message("tip"), why=why)))
    assert said == '"Ball": The tip is wrong: it has 1,200 of N, grams.'
    for each in (said, copy.deepcopy(said), read(kept(said)), Message(said)):
        inner = each.values["said"].values["why"]
        assert (each, each.template) == (said, '"{name}": {said}')
        assert (inner.template, inner.values) == (why.args[0].template, {"count": 1200, "units": ("N", "grams")})
        assert isinstance(inner.values["units"][1], Message) and not isinstance(inner.values["units"][0], Message)


@pytest.mark.parametrize("text", ["", "Table 2", "{braces}", '{"template": 3}', "{", '{"a": 1}', "[1]", '"x"'])
def test_a_text_that_is_no_kept_message_is_read_as_it_is(text: str) -> None:
    assert read(text) == kept(read(text)) == text and read(text).values == {}


def test_messages_in_a_row_are_one_and_what_says_nothing_is_left_out() -> None:
    assert in_a_row(["One.", "", Message("{n} are two.", n=2)]) == "One. 2 are two."
    assert in_a_row([]) == ""


def options_in_messages(source: str) -> list[tuple[int, str]]:
    """Return line and text of the string literals that name an option, but for options by themselves."""
    found = [
        (node.lineno, node.value)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]
    return [(line, text) for line, text in found if OPTION.search(text) and not re.fullmatch(r"--[a-z0-9-]+", text)]


@pytest.mark.parametrize("path", sorted((ROOT / "core").rglob("*.py")), ids=lambda path: str(path.relative_to(ROOT)))
def test_no_message_of_the_core_names_an_option_of_the_command_line(path: Path) -> None:
    assert options_in_messages(path.read_text()) == []
