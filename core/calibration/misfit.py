"""How far a curve is from measured points where it is farthest, beside the just-noticeable difference there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Floats

NOTICEABLE_FORCE = (0.06, 0.08)  # just-noticeable difference of a force, as a share of it: from, to
_PARTS = 20  # of the depth, over which points are averaged: their noise is no error of a curve
_LEAST = 0.05  # of full scale: below, a share of the force says little


@dataclass(frozen=True, slots=True, kw_only=True)
class Miss:
    """The largest error of a force against measured points.

    share: of the force there.
    error: curve less points [N].
    depth: where it is [m].
    """

    share: float
    error: float
    depth: float


def largest_miss(depth: Floats, force: Floats, expected: Floats) -> Miss | None:
    """Find where a curve is farthest from measured points, as a share of their force.

    Args:
        depth: (n,) of the points [m].
        force: (n,) of the points [N].
        expected: (n,) of the curve at their depths [N].

    Returns:
        the largest error of the means over a twentieth of the depth, of those where the force is at least 5 % of full
        scale; None where there is no such force.
    """
    pressed = depth > 0
    x, f, e = depth[pressed], force[pressed], expected[pressed]
    if not len(x) or not f.max() > 0:
        return None
    part = np.minimum((x / x.max() * _PARTS).astype(np.int64), _PARTS - 1)
    counts = np.maximum(np.bincount(part, minlength=_PARTS), 1)
    mx, mf, me = (np.bincount(part, weights=values, minlength=_PARTS) / counts for values in (x, f, e))
    large = mf >= _LEAST * f.max()
    if not large.any():
        return None
    shares = np.where(large, np.abs(me - mf) / np.where(large, mf, 1.0), -1.0)
    at = int(shares.argmax())
    return Miss(share=float(shares[at]), error=float(me[at] - mf[at]), depth=float(mx[at]))
