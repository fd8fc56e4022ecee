"""Messages for the artist, and how an operator reports them."""

import logging
import re
from collections.abc import Iterable

import bpy

from ..core.message import ABOUT, Message, about, in_a_row
from .translation import translated

LOG = logging.getLogger("dimple")
# an unbreakable piece of Japanese text: a character or a Latin word, with opening marks before and closing ones after
_PIECE = re.compile(r"[「『（]*(?:[!-~]+|.)[、。」』）！？：・ー〜々ぁぃぅぇぉっゃゅょァィゥェォッャュョ]* ?")


class Note(Message):
    """A message that informs and does not warn."""


def say(operator: bpy.types.Operator, kind: set[str], *messages: str) -> None:
    """Log messages and report them as one, in the language of the interface; kind: the type of `Operator.report`."""
    said = in_a_row(messages)
    LOG.log(logging.WARNING if kind & {"WARNING", "ERROR"} else logging.INFO, said)
    operator.report(kind, translated(said))


def report(operator: bpy.types.Operator, messages: Iterable[str]) -> None:
    """Report messages: notes as information, all others as warnings."""
    for each in gathered(messages):
        say(operator, {"INFO" if isinstance(each, Note) else "WARNING"}, each)


def gathered(messages: Iterable[str]) -> list[Message]:
    """Return messages, with equal ones about several bodies merged into one: "3 bodies: ..."."""
    names: dict[tuple[bool, str], list[str]] = {}
    for each in map(_message, messages):
        of_one = each.template == ABOUT
        said = each.values["said"] if of_one else each
        names.setdefault((isinstance(each, Note), said), []).append(each.values["name"] if of_one else "")
    return [(Note if note else Message)(_shared(said, of)) for (note, said), of in names.items()]


def _message(said: str) -> Message:
    return said if isinstance(said, Message) else Message(said)


def _shared(said: str, names: list[str]) -> Message:
    if len(names) > 1 and names[0]:
        return Message("{count} bodies: {said}", count=len(names), said=said)
    return about(names[0], said) if names[0] else Message(said)


def duration(seconds: float) -> Message:
    """Return a readable time: "<1 s", "48 s", "3 min 5 s", "2 h 10 min"."""
    whole = round(seconds)
    if whole < 60:
        return Message("{seconds} s", seconds=whole) if whole else Message("<1 s")
    if whole < 3600:
        return Message("{minutes} min {seconds} s", minutes=whole // 60, seconds=whole % 60)
    return Message("{hours} h {minutes} min", hours=whole // 3600, minutes=whole % 3600 // 60)


def beyond_end(last: int, scene_end: int) -> list[Message]:
    """Return a sentence if an animation ends after the last frame of the scene, else nothing."""
    end = Message("That is after the last frame of the scene, {last_frame}.", last_frame=scene_end)
    return [end] if last > scene_end else []


def megabytes(size: float) -> str:
    """Return a size [bytes] as a readable number of megabytes: "0.2", "6.4", "213"."""
    return f"{max(size / 1e6, 0.1):.1f}" if size < 1e7 else f"{size / 1e6:.0f}"


def wrapped(sentence: str, width: int) -> list[str]:
    """Break a sentence into lines of at most `width` columns; Japanese breaks anywhere except inside a Latin word,
    before a closing mark and after an opening one.
    """
    lines, line = [], ""
    for word in _words(sentence):
        if line and _columns(line + word.rstrip()) > width:
            lines.append(line.rstrip())
            line = ""
        line += word
    return [*lines, line.rstrip()]


def _words(sentence: str) -> list[str]:
    words: list[str] = []
    for word in sentence.split():
        if words and words[-1][-2:-1].isdigit() and " " not in words[-1][:-1] and _columns(word) == len(word):
            words[-1] += word + " "  # keep a number and its unit together
        else:
            words.append(word + " ")
    return [piece for word in words for piece in (_PIECE.findall(word) if _columns(word) > len(word) else [word])]


def _columns(text: str) -> int:
    # Japanese characters are two columns wide
    return sum(2 if ord(character) > 0x2E7F else 1 for character in text)
