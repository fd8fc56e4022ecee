"""What may be wrong with a calibration, in words: a headline, and after a line break what it means."""

from __future__ import annotations

from ..messages import Message
from .fit import Fit
from .misfit import Miss
from .prepare import LoadingCurve

_POOR = 0.05  # of full scale, RMS: a law that misses the curve by more gets a warning
_FAR = 0.25  # of the force: points that the law misses by more get one too
_LATE = 0.2  # of the depth: a press whose first row lies deeper has begun before
_VISIBLE, _BETTER = 0.05, 0.5  # of the force: two slopes that miss by more, where a solid does by so many times less
_WIDENED = 2.0  # times wider intervals are explained
_DEPTHS, _FORCES = (2e-5, 0.5), (1e-3, 2e4)  # [m], [N]: presses outside have the wrong unit more often than not


def doubts(
    fit: Fit, loading: LoadingCurve, length: float | None, miss: Miss | None, as_solid: Miss | None
) -> tuple[str, ...]:
    """Return what a reader of the constants should know: of the knee, the shape, the intervals and the units.

    Args:
        length: of the object [m].
        miss: largest error of the law.
        as_solid: that of the law of a solid with the same constants, None where a solid has no other.
    """
    found: list[str] = []
    deepest = float(loading.depth.max())
    if fit.model == "one":
        found.append(Message(
            "No knee was found down to {depth:.3g} mm.\nOne slope says as much as two (F test p = {knee_p:.2g}): K2 "
            "equals K1 and x0 is the deepest row.",
            depth=1e3 * deepest, knee_p=fit.knee_p
        ))  # fmt: skip
    elif fit.falls:
        found.append(
            "The force falls while the depth grows.\nThe best two pieces would fall; these are the best of those that "
            "rise, as a body of the model must."
        )
    elif fit.K2.value < fit.K1.value:
        found.append(
            "The object softens beyond the knee (K2 < K1).\nThat is unusual: see whether it buckles or is torn, and "
            "whether the columns of depth and force are exchanged."
        )
    first = float(loading.depth[loading.depth > 0].min())
    if first > _LATE * deepest:
        found.append(Message(
            "The file begins {first:.3g} mm after the first touch.\nWhat the object answers before that was not "
            "measured: K1 and x0 hold only if it is straight down to the touch.",
            first=1e3 * first
        ))  # fmt: skip
    if miss and (fit.misfit > _POOR or miss.share > _FAR):
        found.append(Message(
            "The law misses the measured points by up to {share:.0f} % of the force.\nThat is {error:+.3g} N at "
            "{depth:.3g} mm, and {misfit:.1f} % of full scale (RMS) over all: the curve has another shape than two "
            "straight slopes.",
            share=100 * miss.share, error=miss.error, depth=1e3 * miss.depth, misfit=100 * fit.misfit
        ))  # fmt: skip
    if miss and as_solid and miss.share > _VISIBLE and as_solid.share < _BETTER * miss.share:
        found.append(Message(
            "The curve is that of a solid: choose Fill: Solid.\nIts law with the same constants misses the measured "
            "points by up to {share:.0f} % of the force, two slopes by {miss:.0f} %.",
            share=100 * as_solid.share, miss=100 * miss.share
        ))  # fmt: skip
    if fit.widened > _WIDENED:
        found.append(Message(
            "The curve bends where the law is straight.\nNeighbouring residuals agree with each other (r = "
            "{correlation:.2f}), so the 95 % intervals are {widened:.1f} times wider than independent rows would "
            "give.",
            correlation=fit.correlation, widened=fit.widened
        ))  # fmt: skip
    unknown = [name for name in ("K1", "K2", "x0") if (c := getattr(fit, name)).half_width >= abs(c.value)]
    if unknown:
        found.append(
            Message("The curve does not determine {unknown}.\n0 lies within the 95 % interval.", unknown=tuple(unknown))
        )
    if not _DEPTHS[0] < deepest < _DEPTHS[1] or not _FORCES[0] < fit.full_scale < _FORCES[1]:
        found.append(Message(
            "{depth:.3g} mm and {full_scale:.3g} N are unlikely for a press: check the units.",
            depth=1e3 * deepest, full_scale=fit.full_scale
        ))  # fmt: skip
    if length is not None and deepest > length:
        found.append(Message(
            "The press is {depth:.3g} mm deep, more than the object's {length:.3g} mm: check the units.",
            depth=1e3 * deepest, length=1e3 * length
        ))  # fmt: skip
    if fit.K1.value <= 0:
        found.append("The force does not grow with the depth.\nThere is no material with these constants.")
    return tuple(found)
