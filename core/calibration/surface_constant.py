"""The surface's spring constant k of Eq. (4) from a press: by the paper's Eqs. (9) and (10), and by the force balance.

A string of length l pressed in its middle to a depth x by F makes two sides of length h = sqrt((l/2)^2 + x^2):

    the paper:       S = F x / (2 h),     lambda = S l / (2 A E)
    force balance:   F = 2 S x / h,       stretch = 2 h - l

The paper's lambda is S times a constant, so its slope is k = 2 A E / l whatever was measured. The balance measures
the slope of S over the stretch; what S is left without stretch is tension the surface had before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import DimpleError, Floats
from .fit import Constant, slope_of

_CLEAR = 0.05  # of the deepest: nearer the touch the tension is 0/0, all of it noise
PAPER_ASSUMES = (
    "Eqs. (9) and (10): a simply supported beam of section A and Young's modulus E; k = 2 A E / l follows from these "
    "alone and says nothing about the measured curve."
)
BALANCE_ASSUMES = (
    "Force balance of a string of length l pressed in its middle: all of the force is carried by the surface, none by "
    "what is inside, and k is the slope of its tension over its stretch; an upper bound of what the surface adds."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Surface:
    """The surface's k [N/m] by either way, and its tension before the press [N]; None where it is not known."""

    paper_k: float | None
    balance_k: Constant | None
    pretension: float | None

    @property
    def k(self) -> Constant | None:
        """Return the k [N/m] that a material gets: by Eqs. (9), (10) where they could be used, else by the balance."""
        if self.paper_k is not None:
            return Constant(value=self.paper_k, error=0.0, half_width=0.0)
        return self.balance_k if self.balance_k is not None and self.balance_k.value > 0 else None

    def to_record(self) -> dict[str, dict[str, Any]]:
        """Return k [N/mm] by either way as plain data, with what it assumes."""
        paper, balance = self.paper_k, self.balance_k
        return {
            "equations_9_10": {"value": paper and paper / 1e3, "assumes": PAPER_ASSUMES},
            "force_balance": {
                "value": balance and balance.value / 1e3, "half_width": balance and balance.half_width / 1e3,
                "pretension": self.pretension, "assumes": BALANCE_ASSUMES,
            },
        }  # fmt: skip


def surface_constants(
    depth: Floats, force: Floats, length: float, *, section: float | None = None, youngs_modulus: float | None = None
) -> Surface:
    """Work out k both ways.

    Args:
        depth, force: (n,) of the loading, from the touch [m], [N].
        length: l, the edge of the object [m].
        section: A of the surface as a beam [m2].  youngs_modulus: E [Pa]; Eq. (10) needs both.

    Source: Eqs. (9), (10).
    """
    if not length > 0 or not math.isfinite(length):
        raise DimpleError("The length of the object must be greater than 0 mm (it is {length:g}).", length=1e3 * length)
    stretch, tension = string_balance(depth, force, length)
    known = section is not None and youngs_modulus is not None
    paper_k = 2 * section * youngs_modulus / length if known else None  # type: ignore[operator]
    clear = depth > _CLEAR * depth.max()
    slope = _line(stretch[clear], tension[clear])
    return Surface(paper_k=paper_k, balance_k=slope and slope[0], pretension=slope and slope[1])


def string_balance(depth: Floats, force: Floats, length: float) -> tuple[Floats, Floats]:
    """Return the stretch (n,) [m] and tension (n,) [N] of a string pressed in its middle."""
    h = np.hypot(length / 2, depth)
    return 2 * h - length, force * h / (2 * np.where(depth > 0, depth, np.inf))


def _line(x: Floats, y: Floats) -> tuple[Constant, float] | None:
    """Return the slope of a line with its error, and where it starts; rows are taken as independent."""
    if len(x) < 8 or np.ptp(x) == 0:
        return None
    slope, error = slope_of(x, y)
    return Constant(value=slope, error=error, half_width=1.96 * error), float(y.mean() - slope * x.mean())
