"""What fills a body: one row for each fill, read by the laws, the panels and the C core."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple


class PressureLaw(IntEnum):
    """The law of pressure over volume (`body/pressure.py`, `native/fill.c`), with its number in C."""

    NONE = 0
    GAS = 1
    BULK = 2


class Fill(NamedTuple):
    """A fill.

    label, description: shown to the artist.
    number: stored in .blend files.
    law: of its pressure.
    reserve: how many times stiffer it becomes when the body is pressed flat, for the stability bound.
    elastic: whether the body is elastic throughout, so that its skin yields and a ball feels Hertz's force.
    """

    label: str
    description: str
    number: int
    law: PressureLaw
    reserve: float = 1.0
    elastic: bool = False


FILLS = {
    "air": Fill("Air", "Full of air: a press compresses it a little", 0, PressureLaw.GAS, reserve=16.0),
    "liquid": Fill(
        "Liquid", "Full of liquid, which keeps its volume: a dent makes the body bulge elsewhere", 1,
        PressureLaw.BULK, reserve=2.0,
    ),
    "solid": Fill(
        "Solid", "Solid to the core, like rubber, jelly or flesh: it keeps its volume, and yields around a fingertip",
        3, PressureLaw.BULK, reserve=2.0, elastic=True,
    ),
    "none": Fill("None", "An empty shell without pressure, for open meshes", 2, PressureLaw.NONE),
}  # fmt: skip
