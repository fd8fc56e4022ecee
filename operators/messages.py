"""Sentences for the artist, and how an operator says them."""

from collections.abc import Iterable

import bpy


class Note(str):
    """A sentence that warns of nothing."""

    __slots__ = ()


def report(operator: bpy.types.Operator, sentences: Iterable[str]) -> None:
    """Say sentences: those that are no notes are warnings."""
    for sentence in sentences:
        operator.report({"INFO" if isinstance(sentence, Note) else "WARNING"}, sentence)
