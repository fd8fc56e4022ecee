"""Sentences for the artist, and how an operator says them."""

import re
from collections.abc import Iterable

import bpy

from .translation import in_a_row

# what stays on one line in Japanese: a character or a Latin word, with what opens before it and closes after it
_PIECE = re.compile(r"[「『（]*(?:[!-~]+|.)[、。」』）！？：・ー〜々ぁぃぅぇぉっゃゅょァィゥェォッャュョ]* ?")
_OF_A_BODY = re.compile(r'"(.+?)": (.*)', re.DOTALL)


class Note(str):
    """A sentence that warns of nothing."""

    __slots__ = ()


def say(operator: bpy.types.Operator, kind: set[str], *sentences: str) -> None:
    """Report messages in a row in the language of the interface; kind: as `Operator.report` takes it."""
    operator.report(kind, in_a_row(sentences))


def report(operator: bpy.types.Operator, sentences: Iterable[str]) -> None:
    """Say sentences: those that are no notes are warnings."""
    for sentence in gathered(sentences):
        say(operator, {"INFO" if isinstance(sentence, Note) else "WARNING"}, sentence)


def conclude(operator: bpy.types.Operator, done: str, sentences: Iterable[str]) -> None:
    """Say notes, then what was done, then warnings: the last is what is seen."""
    report(operator, sorted([*sentences, Note(done)], key=lambda sentence: not isinstance(sentence, Note)))


def gathered(sentences: Iterable[str]) -> list[str]:
    """Return sentences with those said once that several bodies share: "3 bodies: ..."."""
    names: dict[tuple[type[str], str], list[str]] = {}
    for sentence in sentences:
        named = _OF_A_BODY.fullmatch(sentence)
        names.setdefault((type(sentence), named[2] if named else sentence), []).append(named[1] if named else "")
    return [
        kind(f"{len(of)} bodies: {said}" if len(of) > 1 and of[0] else f'"{of[0]}": {said}' if of[0] else said)
        for (kind, said), of in names.items()
    ]


def duration(seconds: float) -> str:
    """Return a time as one reads it: "<1 s", "48 s", "3 min 5 s", "2 h 10 min"."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s" if whole else "<1 s"
    return f"{whole // 60} min {whole % 60} s" if whole < 3600 else f"{whole // 3600} h {whole % 3600 // 60} min"


def megabytes(size: float) -> str:
    """Return a size [bytes] in MB as one reads it: "0.2", "6.4", "213"."""
    return f"{max(size / 1e6, 0.1):.1f}" if size < 1e7 else f"{size / 1e6:.0f}"


def wrapped(sentence: str, width: int) -> list[str]:
    """Break a sentence into lines of at most `width` columns; Japanese breaks anywhere but inside a Latin word, before
    a mark that ends something and after one that begins it.
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
            words[-1] += word + " "  # a number and its unit
        else:
            words.append(word + " ")
    return [piece for word in words for piece in (_PIECE.findall(word) if _columns(word) > len(word) else [word])]


def _columns(text: str) -> int:
    # Japanese characters are two columns wide
    return sum(2 if ord(character) > 0x2E7F else 1 for character in text)
