"""Translate messages into the language of the interface; the core is independent of Blender and writes English."""

from collections.abc import Callable
from typing import Any

from bpy.app.translations import pgettext_tip

from ..core.message import COMMA, Message, filled

# Blender's own translations give some of our words another sense: its "Air" is air drag, its "Measure" a ruler. A
# separate context avoids that
CONTEXT = "Dimple"
Lookup = Callable[[str], str]


def tip_(text: str) -> str:
    """Translate one of our texts into the language of the interface."""
    return pgettext_tip(text, CONTEXT)


def translated(said: str, lookup: Lookup = tip_) -> str:
    """Translate a message: look up its template, and fill it with its values, translating those that are messages.

    Args:
        said: a message; any other text is looked up as a whole.
        lookup: returns the translation of a text, or the text itself if there is none.
    """
    if not isinstance(said, Message):
        return lookup(said)
    values = {name: _value(value, lookup) for name, value in said.values.items()}
    return filled(lookup(said.template), values, lookup(COMMA))


def _value(value: Any, lookup: Lookup) -> Any:
    """Translate a value of a message; numbers and names stay as they are."""
    if isinstance(value, tuple):
        return tuple(_value(each, lookup) for each in value)
    return translated(value, lookup) if isinstance(value, Message) else value
