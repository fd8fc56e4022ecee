"""The interface in Japanese; a test compares the dictionary with every label and description."""

import inspect
from collections.abc import Iterator

import bpy

from ...operators.japanese import MESSAGES
from . import (
    calibration,
    contact,
    devices,
    everyday,
    experiments,
    exports,
    fingertips,
    general,
    planner,
    polls,
    tuning,
)

# Blender translates some of our words in another sense: its "Air" is air drag, its "Measure" a ruler. A context of our
# own avoids that: of every class of ours and its properties, and so of their labels and buttons
CONTEXT = "Dimple"

# one file for each subject; the messages of core and operators lie with the operators, which recognise them
SUBJECTS = (general, calibration, planner, devices, experiments, exports, polls, tuning, everyday, contact, fingertips)
EVERYTHING = {english: text for subject in SUBJECTS for english, text in subject.WORDS.items()} | MESSAGES
JAPANESE = {(context, english): text for context in ("*", CONTEXT) for english, text in EVERYTHING.items()}


def register() -> None:
    """Hand the dictionary to Blender, before it is told of the classes whose words are looked up there."""
    kinds = bpy.types
    for cls in _ours(kinds.Operator, kinds.Panel, kinds.Menu, kinds.PropertyGroup, kinds.AddonPreferences):
        cls.bl_translation_context = CONTEXT
        for part in filter(_is_ours, cls.__mro__):
            for each in inspect.get_annotations(part).values():  # of its own; from Python 3.14 on made when asked for
                if hasattr(each, "keywords"):  # of a property
                    each.keywords.setdefault("translation_context", CONTEXT)
    bpy.app.translations.register(__package__, {"ja_JP": JAPANESE})


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
    """Take the dictionary back."""
    bpy.app.translations.unregister(__package__)
