"""Warnings about a calibration: each is a headline and, after a line break, its meaning."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..base import Floats
from ..message import Message
from .fit import Fit, slope_of
from .press import LoadingCurve
from .table import MIN_ROWS
from .touch import SURE

_PARTS = 20  # intervals of depth in which points are averaged, so that their noise does not count as an error
_SEEN = 0.05  # share of the force, or of full scale: just below the just-noticeable difference
_FAR = 0.2  # share of the force, or of the depth, from which on an error or a gap is worth a warning
_DEPTHS, _FORCES = (2e-5, 0.5), (1e-3, 2e4)  # [m], [N] plausible ranges: outside them the unit is probably wrong


@dataclass(frozen=True, slots=True, kw_only=True)
class Miss:
    """The largest error of a curve of force at the measured points.

    share: the error as a share of the force there.
    error: curve minus points [N].
    depth: where the error occurs [m].
    """

    share: float
    error: float
    depth: float


def largest_miss(depth: Floats, force: Floats, expected: Floats) -> Miss | None:
    """Find the largest error of a curve at measured points, as a share of their force.

    Args:
        depth: (n,) depths of the points [m].
        force: (n,) forces of the points [N].
        expected: (n,) forces of the curve at these depths [N].

    Returns:
        the largest error of the means over each twentieth of the depth, among those whose mean force is at least 5 % of
        full scale; None if there is no force.
    """
    pressed = depth > 0
    x, f, e = depth[pressed], force[pressed], expected[pressed]
    if not len(x) or not f.max() > 0:
        return None
    part = np.minimum((x / x.max() * _PARTS).astype(np.int64), _PARTS - 1)
    counts = np.maximum(np.bincount(part, minlength=_PARTS), 1)
    mx, mf, me = (np.bincount(part, weights=values, minlength=_PARTS) / counts for values in (x, f, e))
    large = mf >= _SEEN * f.max()
    if not large.any():
        return None
    shares = np.where(large, np.abs(me - mf) / np.where(large, mf, 1.0), -1.0)
    at = int(shares.argmax())
    return Miss(share=float(shares[at]), error=float(me[at] - mf[at]), depth=float(mx[at]))


def doubts(fit: Fit, loading: LoadingCurve, miss: Miss | None, as_solid: Miss | None) -> Iterator[str]:
    """Yield warnings about the constants: about the knee, the shape, the intervals, the units and the touch.

    Args:
        miss: largest error of the law.
        as_solid: largest error of a solid's law with the same constants, None if it is the same two-slope law.
    """
    deepest = float(loading.depth.max())
    if fit.model == "one":
        yield Message(
            "No knee was found down to {depth:.3g} mm.\nOne slope fits as well as two, so K2 equals K1, and x0 is "
            "the depth of the deepest row.",
            depth=1e3 * deepest,
        )
    elif fit.K2.value < fit.K1.value:
        yield (
            "The object softens beyond the knee (K2 < K1).\nThat is unusual: check whether it buckled or tore, and "
            "whether the columns of depth and force are swapped."
        )
    first = float(loading.depth[loading.depth > 0].min())
    if first > _FAR * deepest:
        yield Message(
            "The file begins {first:.3g} mm after the first touch.\nThe force before that was not measured: K1 and "
            "x0 are right only if the curve is straight from the touch on.",
            first=1e3 * first,
        )
    if miss and (fit.misfit > _SEEN or miss.share > _FAR):
        yield Message(
            "The law misses the measured points by up to {share:.0f} % of the force.\nThat is {error:+.3g} N at "
            "{depth:.3g} mm, and {misfit:.1f} % of full scale (RMS) overall: the curve does not consist of two "
            "straight slopes.",
            share=100 * miss.share,
            error=miss.error,
            depth=1e3 * miss.depth,
            misfit=100 * fit.misfit,
        )
    if miss and as_solid and miss.share > _SEEN and as_solid.share < miss.share / 2:
        yield Message(
            "The curve is that of a solid: choose Fill: Solid.\nWith the same constants, the law of a solid misses "
            "the measured points by up to {share:.0f} % of the force, and two slopes miss them by {miss:.0f} %.",
            share=100 * as_solid.share,
            miss=100 * miss.share,
        )
    unknown = [name for name in ("K1", "K2", "x0") if (c := getattr(fit, name)).half_width >= abs(c.value)]
    if unknown:
        yield Message(
            "The curve does not determine {unknown}.\n0 lies within the 95 % interval.", unknown=tuple(unknown)
        )
    if not _DEPTHS[0] < deepest < _DEPTHS[1] or not _FORCES[0] < fit.full_scale < _FORCES[1]:
        yield Message(
            "{depth:.3g} mm and {full_scale:.3g} N are unlikely for a press: check the units.",
            depth=1e3 * deepest,
            full_scale=fit.full_scale,
        )
    before = loading.depth < 0
    if before.sum() >= MIN_ROWS:
        slope, error = slope_of(loading.depth[before], loading.force[before])
        if abs(slope) > SURE * error:
            change = slope * float(np.ptp(loading.depth[before]))
            yield Message(
                "The force changes by {change:+.2g} N before the touch.\nEither the load cell drifts, and the slopes "
                "are off by {per_mm:+.2g} N/mm, or the touch was earlier.",
                change=change,
                per_mm=slope / 1e3,
            )
    if fit.K1.value <= 0:
        yield "The force does not grow with the depth.\nNo material has these constants."
