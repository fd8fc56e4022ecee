"""Where fingertips are during a run of ticks."""

from __future__ import annotations

from dataclasses import dataclass

from core.base import Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class FingerPath:
    """Centres (k, ticks + 1, 3) [m] of k fingertips at the ends of ticks, their radii (k,) [m], and which they are."""

    centres: Floats
    radii: Floats
    fingers: tuple[int, ...] = (0, 1, 2)
