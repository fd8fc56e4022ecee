"""Everything an artist reads on Dimple's buttons exists in Japanese, and nothing is translated that is not there."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

EXTENSION = "bl_ext.user_default.dimple"
BASES = ("Panel", "Menu", "Operator", "PropertyGroup", "AddonPreferences")
# whatever Blender gives to a class of ours is translated by Blender: the name of a preset operator's preset
BLENDERS_OWN = {"rna_type", "name", "remove_name", "remove_active"}

# two words or more, or a sentence: what a person reads
SENTENCE = re.compile(r"""[A-Za-z]{2,}[,;:]?["”]? ["“]?[A-Za-z{]|[}"”] [a-z]{2}|^[A-Z][a-z].*\.$""")
# a place that is a sentence of its own: what stands beside it is a message without it
BESIDE = re.compile(r"(?<=[.?])\s*\{\}$|^\{\}\s(?=[A-Z][a-z])")
# what no artist reads: command lines, what is written to files, names in a .blend, the columns of measured files, and
# what only a mistake in our own code raises
UNSEEN = (
    "core/calibration/export.py", "core/calibration/vocabulary.py", "core/device/servo_process.py",
    "core/native/body.py", "core/native/carry.py", "core/native/scene.py", "core/solver/twin.py",
    "operators/clip.py", "operators/command_line.py", "operators/curves.py", "operators/formats.py",
    "operators/sidecar.py",
)  # fmt: skip
# whose texts are looked up when they are whole: presets, and what a map paints
CHECKED_WHOLE = ("core/everyday.py", "operators/names.py")
UNSEEN_TEXTS = {
    "import sys, mmap, select, tomllib; print('python', *sys.version_info[:2])", "real time", "force units?",
    "Simulated by Dimple, not measured: {}, {} mm", "Tip: sphere, radius {} mm",
    "Material: K1 {} N/mm, K2 {} N/mm, x0 {} mm", "Object Info", "Dimple Press", ".Dimple Press",
    "Dimple Trial", "Dimple Export", "Dimple Frame", "Fingertip {}", "{} mm", "{}: {}, {}, calibrated {}",
}  # fmt: skip


def classes(bpy: ModuleType) -> Iterator[type]:
    def below(base: type) -> Iterator[type]:
        for child in base.__subclasses__():
            yield child
            yield from below(child)

    for base in BASES:
        for cls in below(getattr(bpy.types, base)):
            if cls.__module__.startswith(EXTENSION) and cls.is_registered:
                yield cls


def texts_of_property(each: Any) -> Iterator[tuple[str, str]]:
    yield each.translation_context, each.name
    yield "*", each.description
    for item in each.enum_items_static if each.type == "ENUM" else ():
        yield each.translation_context, item.name
        yield "*", item.description


def properties(bpy: ModuleType, cls: type) -> Any:
    """Return the RNA properties of a class; those of an operator live apart from it."""
    if not issubclass(cls, bpy.types.Operator):
        return cls.bl_rna.properties
    module, _, name = cls.bl_idname.partition(".")
    return getattr(getattr(bpy.ops, module), name).get_rna_type().properties


def context_of(operator: type) -> str:
    """Return the context in which Blender looks up an operator's label, and the text= of its buttons."""
    import bpy

    module, _, name = operator.bl_idname.partition(".")
    return getattr(getattr(bpy.ops, module), name).get_rna_type().translation_context


def texts(bpy: ModuleType) -> Iterator[tuple[str, str]]:
    """Yield context and text of every label and description that Blender knows from our classes."""
    for cls in classes(bpy):
        if issubclass(cls, bpy.types.Operator):
            yield context_of(cls), cls.bl_label
            yield "*", getattr(cls, "bl_description", None) or cls.__doc__ or ""
        elif hasattr(cls, "bl_label"):
            yield cls.bl_translation_context, cls.bl_label
        own = {name for parent in cls.__mro__ for name in parent.__dict__.get("__annotations__", {})}
        for each in properties(bpy, cls):
            if each.identifier in own - BLENDERS_OWN:
                yield from texts_of_property(each)
    from bl_ext.user_default.dimple.addon.tool import DIMPLE_WT_poke

    yield "*", DIMPLE_WT_poke.bl_label
    yield "*", DIMPLE_WT_poke.bl_description


def drawn_texts() -> Iterator[str]:
    """Yield what our code writes: text=, heading=, iface_(), draw_notes(), what a run does, why a poll refuses."""
    import bl_ext.user_default.dimple as dimple

    root = Path(dimple.__file__).parent
    for path in [*root.glob("addon/*.py"), *root.glob("operators/*.py")]:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in ("PAUSED", "PAUSED_POKE"):
                yield from (part.value for part in ast.walk(node.value) if isinstance(part, ast.Constant))
            if not isinstance(node, ast.Call):
                continue
            written = [each.value for each in node.keywords if each.arg in ("text", "heading")]
            if getattr(node.func, "id", "") == "iface_":
                written += node.args
            if getattr(node.func, "id", "") == "draw_notes":
                written += [each for each in node.args if isinstance(each, ast.List)]
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            if name == "open_run":
                written += node.args[2:]
            if name in ("refuse", "tip_"):
                written += node.args
            for expression in written:
                yield from (
                    part.value
                    for part in ast.walk(expression)
                    if isinstance(part, ast.Constant) and isinstance(part.value, str)
                )


def measured(bpy: ModuleType) -> Iterator[str]:
    """Yield what the presets are called and where they come from, what an experiment says."""
    from bl_ext.user_default.dimple.core.everyday import OBJECTS
    from bl_ext.user_default.dimple.core.experiment.plan import CONSENT, STEPS

    yield from (CONSENT, *STEPS)
    yield from (text for preset in OBJECTS for text in (preset.label, preset.provenance))


def spoken() -> Iterator[tuple[str, str]]:
    """Yield (file, template) of every text in core and the operators that is no docstring; {} is where a value goes."""
    import bl_ext.user_default.dimple as dimple

    root = Path(dimple.__file__).parent
    for path in sorted([*root.glob("core/**/*.py"), *root.glob("operators/*.py")]):
        tree = ast.parse(path.read_text())
        nodes = list(ast.walk(tree))
        parts = {id(each) for node in nodes if isinstance(node, ast.JoinedStr) for each in ast.walk(node)} - {
            id(node) for node in nodes if isinstance(node, ast.JoinedStr)
        }
        parts |= {id(node.value) for node in nodes if isinstance(node, ast.Expr)}  # docstrings
        inner = [each for node in nodes if isinstance(node, ast.FormattedValue) for each in ast.walk(node.value)]
        parts -= {id(each) for each in inner if isinstance(each, ast.Constant)}
        for node in nodes:
            if id(node) not in parts and (text := template(node)):
                yield path.relative_to(root).as_posix(), BESIDE.sub("", text).strip()


def template(node: ast.AST) -> str:
    """Return a text of our code as a key of the catalogue, "" for what is none."""
    pieces = node.values if isinstance(node, ast.JoinedStr) else [node]
    texts = [each.value if isinstance(each, ast.Constant) else "{}" for each in pieces]
    if not isinstance(node, ast.JoinedStr | ast.Constant) or not all(isinstance(text, str) for text in texts):
        return ""
    return re.sub(r"\{[^}]*\}", "{}", "".join(texts))


@pytest.fixture
def japanese(bpy: ModuleType) -> dict[tuple[str, str], str]:
    from bl_ext.user_default.dimple.addon.translations import JAPANESE

    return JAPANESE


def test_every_label_and_description_is_there_in_japanese(bpy: ModuleType, japanese: dict) -> None:
    wanted = {(context, text) for context, text in texts(bpy) if text}
    assert len(wanted) > 100
    assert sorted(wanted - japanese.keys()) == []


def test_words_of_ours_are_looked_up_where_blender_has_none_of_its_own(bpy: ModuleType) -> None:
    """Its "Reset" is no rest shape, its "Measure" a ruler; a button's text= is looked up as its operator is."""
    from bl_ext.user_default.dimple.addon.translations import CONTEXT

    for cls in classes(bpy):
        own = {name for parent in cls.__mro__ for name in parent.__dict__.get("__annotations__", {})} - BLENDERS_OWN
        used = {each.translation_context for each in properties(bpy, cls) if each.identifier in own}
        assert used <= ({CONTEXT, "*"} if cls.__name__ == "DIMPLE_OT_export_animation" else {CONTEXT}), cls
        if issubclass(cls, bpy.types.Operator):
            assert context_of(cls) == CONTEXT, cls
        elif issubclass(cls, bpy.types.Panel):
            assert cls.bl_rna.translation_context == CONTEXT, cls


def test_nothing_is_translated_twice() -> None:
    from bl_ext.user_default.dimple.addon.translations import SUBJECTS

    words = [english for subject in SUBJECTS for english in subject.WORDS]
    assert sorted({each for each in words if words.count(each) > 1}) == []


def test_every_word_that_the_panels_write_is_there_in_japanese(bpy: ModuleType, japanese: dict) -> None:
    wanted = {text for text in [*drawn_texts(), *measured(bpy)] if text}
    assert {"Jelly", "Pause", "Force {}", "Baking: Esc cancels", "Select a mesh first"} <= wanted
    assert sorted(wanted - {text for _, text in japanese}) == []


def test_every_message_of_core_and_operators_is_there_in_japanese(bpy: ModuleType, japanese: dict) -> None:
    known = {text for _, text in japanese}
    said = {(path, text) for path, text in spoken() if path not in UNSEEN and SENTENCE.search(text)}
    said = {(path, text) for path, text in said if text not in UNSEEN_TEXTS and path not in CHECKED_WHOLE}
    assert len(said) > 450
    assert sorted(each for each in said if each[1] not in known) == []


def test_a_message_with_numbers_is_recognised_and_filled_in_japanese(bpy: ModuleType, japanese: dict) -> None:
    from bl_ext.user_default.dimple.operators.japanese import MESSAGES
    from bl_ext.user_default.dimple.operators.translation import translated

    def lookup(text: str) -> str:
        return japanese.get(("*", text), text)

    for english, text in MESSAGES.items():
        values = [f"ab{i}7" for i in range(english.count("{}"))]
        said = english.format(*values)
        assert translated(said, lookup).rstrip("。") == text.format(*values).rstrip("。"), english
        assert translated(said, lambda text: text) == said  # where the interface is English


@pytest.mark.parametrize(
    ("english", "text"),
    [
        (
            '"Cube": Every vertex is pinned, so nothing can move. Set Pinned to None, pin fewer vertices or subdivide '
            'the mesh. "Depth": Holes closed for the pressure only: 3.',
            '"Cube": すべての頂点が固定されていて動けません。「固定」を「なし」にするか、固定する頂点を減らすか、'
            'メッシュを細分化してください。"Depth": 圧力の計算でのみふさぐ穴: 3 個。',
        ),
        (
            '"Cube" is soft: "Vinyl cube, air, 165 mm", 165 mm across. Press it with the left mouse button.',
            '"Cube" を柔らかくしました: "Vinyl cube, air, 165 mm"、大きさ 165 mm。左マウスボタンで押せます。',
        ),
        (
            "The fill must be one of air, liquid, solid, none (it is jelly). Change it in Material > Dimple.",
            "中身は 空気、液体、固体、なし のいずれかにしてください（現在 jelly）。マテリアル > Dimple で変更して"
            "ください。",
        ),
        (
            "The mass must be greater than 0 kg (it is -1). Change it in Material > Dimple.",
            "質量は 0 kg より大きくしてください（現在 -1）。マテリアル > Dimple で変更してください。",
        ),
        (
            "Its materials differ in fill or pressure: air, 7.5 kPa acts, on the most area.",
            "マテリアルの中身か圧力がそれぞれ違います。面積が最も大きい 空気、7.5 kPa を使います。",
        ),
        ("What nobody wrote. The file is empty. Export the measurement again.",
         "What nobody wrote. ファイルが空です。測定をもう一度書き出してください。"),
    ],
)  # fmt: skip
def test_messages_in_messages_and_in_a_row_are_translated_and_names_are_not(
    bpy: ModuleType, japanese: dict, english: str, text: str
) -> None:
    from bl_ext.user_default.dimple.operators.translation import translated

    assert translated(english, lambda text: japanese.get(("*", text), text)) == text


def test_what_is_reported_goes_through_the_catalogue(bpy: ModuleType) -> None:
    import bl_ext.user_default.dimple as dimple

    paths = Path(dimple.__file__).parent.glob("[ao]*/*.py")
    assert [path.name for path in paths if ".report({" in path.read_text()] == []


def test_why_a_button_is_grey_is_looked_up_when_it_is_shown(
    bpy: ModuleType, empty_file: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Blender does not translate it, and has no Japanese in this environment: a replacement looks it up."""
    from bl_ext.user_default.dimple.operators import polls

    monkeypatch.setattr(polls, "pgettext_tip", lambda text: f"<{text}>")
    for verb in ("measure", "record", "reset", "arm_device"):
        with pytest.raises(RuntimeError, match=r"poll\(\) <.+>"):
            getattr(bpy.ops.dimple, verb)()


def test_no_poll_sets_a_message_that_is_not_looked_up(bpy: ModuleType) -> None:
    import bl_ext.user_default.dimple as dimple

    paths = Path(dimple.__file__).parent.glob("[ao]*/*.py")
    assert [path.name for path in paths if "poll_message_set" in path.read_text()] == ["polls.py"]


def test_no_translation_is_left_over(bpy: ModuleType, japanese: dict) -> None:
    used = {text for _, text in texts(bpy)} | {*drawn_texts(), *measured(bpy)} | {text for _, text in spoken()}
    used |= {text.partition(" must")[0] for text in used}  # a limit that is exceeded goes by the name of its rule
    assert sorted({text for _, text in japanese} - used - {"Dimple", "Settings of Dimple"}) == []


def test_a_translation_keeps_numbers_units_and_places(japanese: dict) -> None:
    """What stands in brackets is a unit, and {} is where a number goes."""
    for (_, english), text in japanese.items():
        places = [re.findall(r"\{\d?\}", each) for each in (english, text)]
        assert len(places[0]) == len(places[1]) or english.startswith('"{}" is {} {}, not a mesh'), english
        for part in ("(N/mm)", "(mm)", "(kg)", "(kg/m³)", "(s)"):
            assert (part in english) == (part in text), english
        assert text == text.strip() and text
        words = set(re.findall(r"[A-Za-z]{2,}", english)) - {"mm", "Dimple"}  # the rest is numbers, places and units
        assert not words or any(ord(character) > 0x2E7F for character in text), english


def test_no_line_of_japanese_begins_with_what_closes_or_ends_with_what_opens(bpy: ModuleType, japanese: dict) -> None:
    from bl_ext.user_default.dimple.operators.messages import wrapped

    for text in japanese.values():
        for width in (30, 44, 60):
            lines = wrapped(text, width)
            assert "".join("".join(lines).split()) == "".join(text.split())
            assert not any(line[0] in "、。）」』！？ーっゃゅょッャュョ" for line in lines[1:]), lines
            assert not any(line[-1] in "「『（" for line in lines[:-1]), lines
