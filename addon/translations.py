"""The interface in other languages: each file in locale/ translates every English text of the add-on."""

import inspect
import json
from collections.abc import Iterator
from pathlib import Path

import bpy

from ..operators.translation import CONTEXT

CONTEXTS = ("*", CONTEXT)  # descriptions are looked up without a context


def dictionaries() -> dict[str, dict[tuple[str, str], str]]:
    """Return the dictionary of every language, as Blender takes it; a text means the same in both contexts."""
    paths = (Path(__file__).parent / "locale").glob("*.json")
    texts = {path.stem: json.loads(path.read_text("utf-8")) for path in paths}
    return {
        language: {(context, english): text for context in CONTEXTS for english, text in own.items()}
        for language, own in texts.items()
    }


def register() -> None:
    """Hand the dictionaries to Blender, and give the context to our classes and properties before it learns of them."""
    kinds = bpy.types
    for cls in _ours(kinds.Operator, kinds.Panel, kinds.Menu, kinds.PropertyGroup, kinds.AddonPreferences):
        cls.bl_translation_context = CONTEXT
        for part in filter(_is_ours, cls.__mro__):
            for each in inspect.get_annotations(part).values():  # of its own; from Python 3.14 on made when asked for
                if hasattr(each, "keywords"):  # of a property
                    each.keywords.setdefault("translation_context", CONTEXT)
    bpy.app.translations.register(__name__, dictionaries())


def _ours(*bases: type) -> Iterator[type]:
    """Yield the classes of the extension that are made of others."""
    for base in bases:
        for cls in base.__subclasses__():
            if _is_ours(cls):
                yield cls
            yield from _ours(cls)


def _is_ours(cls: type) -> bool:
    return cls.__module__.startswith(__package__.partition(".addon")[0])


def unregister() -> None:
    bpy.app.translations.unregister(__name__)
