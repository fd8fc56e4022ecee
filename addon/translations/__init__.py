"""The interface in Japanese; a test compares the dictionary with every label and description."""

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

# Blender translates some of our words in another sense: its "Air" is air drag. A context of our own avoids that
CONTEXT = "Dimple"

# one file for each subject: OPERATORS (labels of operators, which Blender looks up in a context of their own) and
# WORDS (the rest); the messages of core and operators lie with the operators, which recognise them
SUBJECTS = (general, calibration, planner, devices, experiments, exports, polls, tuning, everyday, contact, fingertips)
OPERATORS = {english: text for subject in SUBJECTS for english, text in subject.OPERATORS.items()}
EVERYTHING = OPERATORS | {english: text for subject in SUBJECTS for english, text in subject.WORDS.items()} | MESSAGES
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
