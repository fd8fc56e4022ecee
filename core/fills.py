"""What is inside a body: a row for each fill, from which the laws, the panels and the C core take all they need."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple


class PressureLaw(IntEnum):
    """Name the law of the pressure over the volume (`body/pressure.py`, `native/step.c`), with the number in C."""

    NONE = 0
    GAS = 1
    BULK = 2


class Fill(NamedTuple):
    """A fill.

    label, description: for the artist.
    number: that .blend files keep.
    law: of its pressure.
    reserve: how many times stiffer than at rest it gets in a body pressed flat, for the stability bound.
    elastic: the body is elastic to the core, so its skin gives way under a fingertip and a ball meets Hertz's force.
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
        "Liquid", "Full of liquid, which keeps its volume: where a dent goes in, the body bulges elsewhere", 1,
        PressureLaw.BULK, reserve=2.0,
    ),
    "solid": Fill(
        "Solid", "Solid to the core, like rubber, jelly or flesh: it keeps its volume, and gives way round a fingertip",
        3, PressureLaw.BULK, reserve=2.0, elastic=True,
    ),
    "none": Fill("None", "An empty shell without pressure. Suits open meshes", 2, PressureLaw.NONE),
}  # fmt: skip
