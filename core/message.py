"""Messages for the artist: an English template and the values that fill it, which are translated separately.

A message is also a string, its English text, so code that compares, joins or prints strings works with it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any, Self

ABOUT = '"{name}": {said}'
IN_A_ROW = "{first} {then}"
COMMA = ", "


class Message(str):
    """A text for the artist: a template filled with values.

    template: English, with the placeholders of `str.format`: "{depth:.3g} mm".
    values: numbers, names, messages, or tuples of these, which are joined with commas.
    """

    template: str
    values: dict[str, Any]

    def __new__(cls, template: str, /, **values: Any) -> Self:
        """Fill a template; a message keeps its own template and values."""
        if isinstance(template, Message):
            return cls(template.template, **template.values)
        values = {name: _plain(value) for name, value in values.items()}
        made = super().__new__(cls, filled(template, values))
        made.template, made.values = template, values
        return made

    def __str__(self) -> str:
        """Return the message itself, so that `str(error)` is a message."""
        return self


def filled(template: str, values: dict[str, Any], comma: str = COMMA) -> str:
    """Return a template filled with its values; without values, braces are plain text."""
    listed = {name: comma.join(each) if isinstance(each, tuple) else each for name, each in values.items()}
    return template.format(**listed) if values else template


def about(name: str, said: str) -> Message:
    """Return a message with the name of its object in front."""
    kind = type(said) if isinstance(said, Message) else Message
    return kind(ABOUT, name=name, said=Message(said))


def in_a_row(messages: Iterable[str]) -> Message:
    """Join messages into one, with a space between; empty ones are left out."""
    first, *others = [Message(each) for each in messages if each] or [Message("")]
    for then in others:
        first = Message(IN_A_ROW, first=first, then=then)
    return first


def to_json(value: Any) -> str:
    """Return data that may contain messages as JSON."""
    return json.dumps(_as_data(value), ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def from_json(text: str) -> Any:
    """Return the data of a text from `to_json`.

    Raises:
        ValueError: the text is not from `to_json`.
    """
    return json.loads(text, object_hook=_from_data)


def kept(message: str) -> str:
    """Return the text that stores a message in a file: JSON, or the message itself if it has no values."""
    return to_json(message) if isinstance(message, Message) and message.values else message


def read(text: str) -> Message:
    """Return the message in a text from `kept`; any other text becomes a message without values."""
    try:
        found = from_json(text) if text.startswith("{") else text
    except ValueError:
        found = text
    return found if isinstance(found, Message) else Message(text)


def _as_data(value: Any) -> Any:
    if isinstance(value, Message):
        return {"template": value.template, "values": _as_data(value.values)}
    if isinstance(value, dict):
        return {name: _as_data(each) for name, each in value.items()}
    return [_as_data(each) for each in value] if isinstance(value, list | tuple) else value


def _from_data(made: dict[str, Any]) -> Any:
    """Return the message that a JSON object represents, or the object itself."""
    if made.keys() != {"template", "values"}:
        return made
    values = {name: tuple(each) if isinstance(each, list) else each for name, each in made["values"].items()}
    return Message(made["template"], **values)


def _plain(value: Any) -> Any:
    """Return a value in a form that JSON can hold: an error as its text, a numpy number as a Python number."""
    if isinstance(value, tuple):
        return tuple(str(_plain(each)) for each in value)
    if isinstance(value, str | int | float):
        return value
    return value.item() if hasattr(value, "item") else str(value)
