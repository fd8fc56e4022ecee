"""Everything an artist reads on Dimple's buttons exists in Japanese, and nothing is translated that is not there."""

import ast
import json
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

STATES = ("PAUSED", "PLAYING")  # the names of what the status bar says while something runs


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
    for path in [*root.glob("addon/*.py"), *root.glob("operators/**/*.py")]:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") in STATES:
                constants = (part for part in ast.walk(node.value) if isinstance(part, ast.Constant))
                yield from (part.value for part in constants if isinstance(part.value, str))
            if not isinstance(node, ast.Call):
                continue
            written = [each.value for each in node.keywords if each.arg in ("text", "heading")]
            if getattr(node.func, "id", "") == "iface_":
                written += node.args
            if getattr(node.func, "id", "") == "draw_notes":
                written += [each for each in node.args if isinstance(each, ast.List)]
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            if name in ("refuse", "tip_", "need"):
                written += node.args[-1:]
            for expression in written:
                yield from (
                    part.value
                    for part in ast.walk(expression)
                    if isinstance(part, ast.Constant) and isinstance(part.value, str)
                )


def measured(bpy: ModuleType) -> Iterator[str]:
    """Yield what the presets are called and where they come from."""
    from bl_ext.user_default.dimple.core.everyday_presets import OBJECTS

    yield from (text for preset in OBJECTS for text in (preset.label, preset.provenance))


def said() -> Iterator[str]:
    """Yield every text in core and the operators: of these are the messages, and the words that fill them."""
    import bl_ext.user_default.dimple as dimple

    root = Path(dimple.__file__).parent
    for path in [*root.glob("core/**/*.py"), *root.glob("operators/**/*.py")]:
        nodes = ast.walk(ast.parse(path.read_text()))
        yield from (each.value for each in nodes if isinstance(each, ast.Constant) and isinstance(each.value, str))


@pytest.fixture
def japanese(bpy: ModuleType) -> dict[tuple[str, str], str]:
    from bl_ext.user_default.dimple.addon.translations import dictionaries

    return dictionaries()["ja_JP"]


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
    from bl_ext.user_default.dimple.addon import translations

    for path in (Path(translations.__file__).parent / "locale").glob("*.json"):
        words = [english for english, _ in json.loads(path.read_text("utf-8"), object_pairs_hook=list)]
        assert words == sorted(set(words)), path


def test_every_word_that_the_panels_write_is_there_in_japanese(bpy: ModuleType, japanese: dict) -> None:
    wanted = {text for text in [*drawn_texts(), *measured(bpy)] if text}
    assert {"Jelly", "Pause", "Force {}", "Select a mesh first"} <= wanted
    assert sorted(wanted - {text for _, text in japanese}) == []


def test_words_that_fill_messages_are_there_in_japanese(bpy: ModuleType, japanese: dict) -> None:
    from bl_ext.user_default.dimple.core.calibration.known_words_and_units import KIND
    from bl_ext.user_default.dimple.core.calibration.reader import _MAGIC
    from bl_ext.user_default.dimple.core.material import FILLS, TIPS

    words = {*FILLS, *TIPS, *KIND, *KIND.values(), *_MAGIC.values(), "softness", "knee", "spread", "pins"}
    assert sorted(words - {text for _, text in japanese}) == []


def test_what_is_reported_goes_through_the_catalogue(bpy: ModuleType) -> None:
    import bl_ext.user_default.dimple as dimple

    paths = Path(dimple.__file__).parent.glob("[ao]*/**/*.py")
    assert [path.name for path in paths if ".report({" in path.read_text()] == []


def test_why_a_button_is_grey_is_looked_up_when_it_is_shown(
    bpy: ModuleType, empty_file: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Blender does not translate it, and has no Japanese in this environment: a replacement looks it up."""
    from bl_ext.user_default.dimple.operators.press import polls

    monkeypatch.setattr(polls, "tip_", lambda text: f"<{text}>")
    for verb in ("measure", "reset", "arm_device"):
        with pytest.raises(RuntimeError, match=r"poll\(\) <.+>"):
            getattr(bpy.ops.dimple, verb)()


def test_no_poll_sets_a_message_that_is_not_looked_up(bpy: ModuleType) -> None:
    import bl_ext.user_default.dimple as dimple

    paths = Path(dimple.__file__).parent.glob("[ao]*/**/*.py")
    assert [path.name for path in paths if "poll_message_set" in path.read_text()] == ["polls.py"]


def test_no_translation_is_left_over(bpy: ModuleType, japanese: dict) -> None:
    used = {text for _, text in texts(bpy)} | {*drawn_texts(), *measured(bpy), *said()}
    assert sorted({text for _, text in japanese} - used - {"Dimple", "Settings of Dimple"}) == []


def test_a_translation_keeps_units_and_is_japanese(japanese: dict) -> None:
    for (_, english), text in japanese.items():
        for part in ("(N/mm)", "(mm)", "(kg)", "(kg/m³)", "(s)"):
            assert (part in english) == (part in text), english
        assert text == text.strip() and text
        words = set(re.findall(r"[A-Za-z]{2,}", re.sub(r"\{.*?\}", "", english))) - {"mm", "Dimple"}
        assert not words or any(ord(character) > 0x2E7F for character in text), english


def test_no_line_of_japanese_begins_with_what_closes_or_ends_with_what_opens(bpy: ModuleType, japanese: dict) -> None:
    from bl_ext.user_default.dimple.operators.reporting import wrapped

    for text in japanese.values():
        for width in (30, 44, 60):
            lines = wrapped(text, width)
            assert "".join("".join(lines).split()) == "".join(text.split())
            assert not any(line[0] in "、。）」』！？ーっゃゅょッャュョ" for line in lines[1:]), lines
            assert not any(line[-1] in "「『（" for line in lines[:-1]), lines
