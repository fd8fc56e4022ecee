"""The interface in other languages: each file in locale/ translates every English text of the add-on."""

import inspect
import json
from collections.abc import Iterator
from pathlib import Path

import bpy

from ..operators.translation import CONTEXT

CONTEXTS = ("*", CONTEXT)  # descriptions are looked up without a context


def dictionaries() -> dict[str, dict[tuple[str, str], str]]:
    """Return the dictionary of each language in Blender's form; a text has the same translation in both contexts."""
    paths = (Path(__file__).parent / "locale").glob("*.json")
    texts = {path.stem: json.loads(path.read_text("utf-8")) for path in paths}
    return {
        language: {(context, english): text for context in CONTEXTS for english, text in own.items()}
        for language, own in texts.items()
    }


def register() -> None:
    """Register the dictionaries, and set the context of our classes and properties before these are registered."""
    kinds = bpy.types
    for cls in _ours(kinds.Operator, kinds.Panel, kinds.Menu, kinds.PropertyGroup, kinds.AddonPreferences):
        cls.bl_translation_context = CONTEXT
        for part in filter(_is_ours, cls.__mro__):
            for each in inspect.get_annotations(part).values():  # its own ones; from Python 3.14 on evaluated lazily
                if hasattr(each, "keywords"):  # a property
                    each.keywords.setdefault("translation_context", CONTEXT)
    bpy.app.translations.register(__name__, dictionaries())


def _ours(*bases: type) -> Iterator[type]:
    """Yield the classes of the extension that derive from base classes of Blender, directly or not."""
    for base in bases:
        for cls in base.__subclasses__():
            if _is_ours(cls):
                yield cls
            yield from _ours(cls)


def _is_ours(cls: type) -> bool:
    return cls.__module__.startswith(__package__.partition(".addon")[0])


def unregister() -> None:
    bpy.app.translations.unregister(__name__)
