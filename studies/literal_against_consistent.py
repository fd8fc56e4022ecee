"""The paper's literal equations against the consistent laws: volume and force as a fingertip goes down."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from core.session import Session

from .scenes import poke, poke_cube

DEPTH = 0.024  # [m]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """One moment of a press.

    law_set: "consistent" or "paper".
    depth: of the fingertip [m].
    volume_ratio: volume over that at rest.
    force: on the fingertip [N].
    law_force: K(x) of Eq. (1) [N].
    """

    law_set: str
    depth: float
    volume_ratio: float
    force: float
    law_force: float


def presses(*, cells: int) -> Iterator[Sample]:
    """Press Object 3 down to DEPTH in a quarter of a second with both law sets; stop where one blows up."""
    for law_set in ("consistent", "paper"):
        session: Session = poke_cube(cells, law_set=law_set)
        for frame in poke(session, depth=DEPTH, seconds=0.25):
            if not frame.finite:
                break
            yield Sample(
                law_set=law_set, depth=float(frame.depths[0]), volume_ratio=frame.volume / frame.rest_volume,
                force=float(frame.finger_forces[0, 2]), law_force=float(frame.law_forces[0]),
            )  # fmt: skip
