"""Messages in the language of the interface: core writes English, for it knows no Blender."""

from collections.abc import Callable
from typing import Any

from bpy.app.translations import pgettext_tip

from ..core.messages import COMMA, Message, filled

# Blender translates some of our words in another sense: its "Air" is air drag, its "Measure" a ruler. A context of our
# own avoids that
CONTEXT = "Dimple"
Lookup = Callable[[str], str]


def tip_(text: str) -> str:
    """Translate a text of ours into the language of the interface."""
    return pgettext_tip(text, CONTEXT)


def translated(said: str, lookup: Lookup = tip_) -> str:
    """Translate a message: its template is looked up, and filled with its values, of which messages are translated.

    Args:
        said: a text that is no message is looked up as it is.
        lookup: gives a text of the catalogue in the language of the interface, any other text as it is.
    """
    if not isinstance(said, Message):
        return lookup(said)
    values = {name: _value(value, lookup) for name, value in said.values.items()}
    return filled(lookup(said.template), values, lookup(COMMA))


def _value(value: Any, lookup: Lookup) -> Any:
    """Return a value in another language: a number or a name is the same in all."""
    if isinstance(value, tuple):
        return tuple(_value(each, lookup) for each in value)
    return translated(value, lookup) if isinstance(value, Message) else value
