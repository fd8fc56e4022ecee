"""The interface in Japanese. A test walks every label and description of ours and misses none."""

import bpy

from . import calibration, devices, general, planner, polls

# Blender has words of its own for some of ours, and they win: its "Air" is the drag of air. In a context, ours win
CONTEXT = "Dimple"

# a file a subject: OPERATORS (labels of operators, looked up in a context of their own) and WORDS (the rest)
SUBJECTS = (general, calibration, planner, devices, polls)
OPERATORS = {english: text for subject in SUBJECTS for english, text in subject.OPERATORS.items()}
EVERYTHING = OPERATORS | {english: text for subject in SUBJECTS for english, text in subject.WORDS.items()}
JAPANESE = {
    **{("Operator", english): text for english, text in OPERATORS.items()},
    **{(context, english): text for context in ("*", CONTEXT) for english, text in EVERYTHING.items()},
}


def register() -> None:
    """Hand the dictionary to Blender."""
    bpy.app.translations.register(__package__, {"ja_JP": JAPANESE})


def unregister() -> None:
    """Take the dictionary back."""
    bpy.app.translations.unregister(__package__)
