"""Messages in the language of the interface: core writes English, for it knows no Blender; they are translated here.

A message is a template of the catalogue with its places {} filled in. The template is recognised, looked up, and filled
with the same values; those are translated too, unless they stand in quotes, as names do.
"""

import functools
import re
from collections.abc import Callable, Iterable
from typing import NamedTuple

from bpy.app.translations import pgettext_tip

from .japanese import MESSAGES

Lookup = Callable[[str], str]

_PLACE = "{}"
_END = re.compile(r"(?<=[.?!])\s+(?!\()|\n")  # of a sentence
_NAMED = '"{}": '
_SAMPLE = next(iter(MESSAGES))
_QUOTES = ('"', "“")


class Template(NamedTuple):
    """A message of the catalogue.

    text: its key, with places for the values.
    longest: what of it stands between two places: where that is not, the pattern need not be tried.
    pattern: what recognises it.
    names: whether the value of each place is a name.
    """

    text: str
    longest: str
    pattern: re.Pattern[str]
    names: tuple[bool, ...]


def translated(text: str, lookup: Lookup = pgettext_tip) -> str:
    """Translate a message, or several in a row; what is not in the catalogue stays as it is.

    Args:
        lookup: gives a template of the catalogue in the language of the interface.
    """
    if not text or not _speaks(lookup):
        return text
    if (found := lookup(text)) != text:
        return found
    ends = [end.end() for end in _END.finditer(text) if end.end() < len(text)]
    for at in reversed([*ends, len(text)][: 2 * _sentences()]):  # a template, and what fills its last place
        if found := _filled(text[:at].strip(), lookup):
            return _joined(found, text[:at], translated(text[at:], lookup))
    return _joined(text[: ends[0]].strip(), text[: ends[0]], translated(text[ends[0] :], lookup)) if ends else text


def in_a_row(sentences: Iterable[str], lookup: Lookup = pgettext_tip) -> str:
    """Translate sentences, each by itself, and put them in a row."""
    row = ""
    for sentence in sentences:
        found = translated(sentence, lookup)
        row += found if not row or row[-1] in "。？" else f" {found}"
    return row


def _speaks(lookup: Lookup) -> bool:
    """Tell whether the catalogue is in the language of the interface."""
    return lookup(_SAMPLE) != _SAMPLE


@functools.cache
def _sentences() -> int:
    """Return how many sentences the longest template has."""
    return max(1 + len(_END.findall(text)) for text in MESSAGES)


def _joined(first: str, before: str, rest: str) -> str:
    """Join sentences; a line that ended `before` it was translated ends still, and Japanese has no space."""
    return first + ("\n" if before.endswith("\n") else "" if not rest or first[-1] in "。？" else " ") + rest


def _filled(text: str, lookup: Lookup) -> str:
    """Return one message in another language, "" where it is not in the catalogue or the language is English."""
    match = _match(text)
    if match is None or (found := lookup(match[0].text)) == match[0].text:
        return ""
    pairs = zip(match[1], match[0].names, strict=True)
    return found.format(*(value if name else _value(value, lookup) for value, name in pairs)).replace("。。", "。")


def _value(value: str, lookup: Lookup) -> str:
    """Return what fills a place: a message of the catalogue, a list of them, or what is the same everywhere."""
    if whole := _filled(value.strip(), lookup):
        return whole
    parts = [_filled(part, lookup) for part in value.strip().split(", ")]
    return "、".join(parts) if all(parts) else value


@functools.lru_cache(maxsize=500)
def _match(text: str) -> tuple[Template, tuple[str, ...]] | None:
    """Return the template that a text was made of, and its values: those of several sentences are messages too."""
    for template in _templates():
        found = template.longest in text and template.pattern.fullmatch(text)
        if found and all(not _END.search(value) or _match(value.strip()) for value in found.groups()):
            return template, found.groups()
    return None


@functools.cache
def _templates() -> list[Template]:
    """Return every template: with a name in front first, for others take it for a value; then the longest first."""
    ordered = sorted(MESSAGES, key=lambda text: (not text.startswith(_NAMED), -len(text.replace(_PLACE, ""))))
    return [_template(text) for text in ordered]


def _template(text: str) -> Template:
    parts = text.split(_PLACE)
    pattern = "(.*?)".join(map(re.escape, parts))
    if text.endswith("."):  # a message in the midst of another has none
        pattern += "?"
    longest = max(parts, key=len).removesuffix(".")
    return Template(text, longest, re.compile(pattern, re.DOTALL), tuple(part.endswith(_QUOTES) for part in parts[:-1]))
