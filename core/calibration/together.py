"""One material through several curves of one object, measured with tips of different radius or at several places.

A tip's force is the closed form of `core.body.estimate`: a bed of springs under a membrane. One tip measures bed and
membrane together; a second one, of another radius, tells them apart, and with them the spread of a dent. Each curve
counts by its own errors, not by its number of rows, and its touch may be a little off where it is an estimate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from ..body.estimate import BEYOND
from ..material import Indenter
from ..messages import Message
from .calibrate import Calibration
from .distributions import t_quantile
from .fit import CONFIDENCE, Constant
from .joint_fit import (
    SPREADS,
    Curve,
    Found,
    Means,
    at_spread,
    closer,
    force_of,
    means_of,
    profile,
    residuals,
    slopes_of,
)
from .misfit import Miss, largest_miss

NARROW, WIDE = 0.02, 50.0  # times the radii of the tips: the spreads that are tried, from, to
KNEE_WORTH = 10.0  # by which a knee has to lower the Bayesian information criterion


@dataclass(frozen=True, slots=True, kw_only=True)
class Fitted:
    """How well the common constants follow one curve.

    name, tip: of the curve.
    depth: (m,) of the means that were fitted, from the touch as fitted [m].
    force: (m,) measured there [N].
    expected: (m,) from the common constants [N].
    rms: error as a share of full scale.
    miss: where it is off the most, None where there is no force.
    """

    name: str
    tip: Indenter
    depth: Floats
    force: Floats
    expected: Floats
    rms: float
    miss: Miss | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Together:
    """One set of constants through several curves.

    K1, K2, x0: of the law as the first curve's tip measures it; with one slope K2 equals K1 and x0 is the deepest row.
    spread: how far a dent reaches beyond the fingertip [m]; its interval is infinite where the curves do not tell it.
    interval: (2,) of the spread, 95 % [m].
    knee: whether there is one.
    tip: of the first curve.
    curves: what each comes to.
    """

    K1: Constant
    K2: Constant
    x0: Constant
    spread: Constant
    interval: tuple[float, float]
    knee: bool
    tip: Indenter
    curves: tuple[Fitted, ...]

    @property
    def determined(self) -> bool:
        """Tell whether the curves determine the spread."""
        return math.isfinite(self.interval[1])


def curve_of(alone: Calibration) -> Curve:
    """Return the curve of a file that was calibrated alone."""
    return Curve(
        name=alone.measurement.source, tip=alone.tip, depth=alone.loading.depth, force=alone.loading.force,
        noise=alone.fit.noise, shifts="contact" in alone.loading.free,
    )  # fmt: skip


def fit_together(curves: Sequence[Curve], *, size: float = 0.0) -> Together:
    """Fit one set of constants to several curves.

    Args:
        curves: of one object; the first one's tip is that of the result.
        size: of the object [m], for a point, which is a patch that grows with it.

    Raises:
        DimpleError: fewer than two curves, or one of them has too few rows in contact.
    """
    if len(curves) < 2:
        raise DimpleError("Give two curves or more of one object, measured with different tips or at several places.")
    means = [means_of(curve, size) for curve in curves]
    radii = [each.radius for each in means]
    spreads = np.geomspace(NARROW * min(radii), WIDE * max(radii), SPREADS)
    found = {knee: profile(means, spreads, knee) for knee in (False, True)}
    rows = sum(len(each.depth) for each in means)
    best = {knee: closer(means, fits, knee) for knee, fits in found.items()}
    gain = rows * math.log(max(best[False].cost, 1e-30) / max(best[True].cost, 1e-30)) - 2 * math.log(rows)
    knee = gain > KNEE_WORTH
    return _result(means, found[knee], best[knee], knee)


def _result(means: Sequence[Means], fits: Sequence[Found], best: Found, knee: bool) -> Together:
    """Return the constants of the best fit, with intervals from how the cost grows away from it."""
    r = residuals(means, best, knee)
    freedom = max(len(r) - len(best.values) - 1, 1)
    variance = max(best.cost / freedom, 1.0)
    t = t_quantile((1 + CONFIDENCE) / 2, freedom)
    within = best.cost + variance * t**2
    interval = _interval(fits, best, within)
    slopes = slopes_of(means, best, knee, r)
    covariance = np.asarray(variance * np.linalg.pinv(slopes.T @ slopes), np.float64)
    ends = [at_spread(means, end, knee) if 0 < end < math.inf else best for end in interval]
    names = [_object_constants(each, means[0], knee) for each in (best, *ends)]
    # the error of the spread is by the profile, of the others by that and by what is left at the best spread
    along = np.abs(np.array(names[2]) - names[1]) / (2 * t)
    errors = np.hypot(along, _object_errors(best, means[0], knee, covariance)).tolist()
    constants = [Constant(value=v, error=e, half_width=t * e) for v, e in zip(names[0], errors, strict=True)]
    half = (interval[1] - interval[0]) / 2
    spread = Constant(value=best.spread, error=half / t, half_width=half)
    return Together(
        K1=constants[0], K2=constants[1], x0=constants[2], spread=spread, interval=interval, knee=knee,
        tip=means[0].curve.tip, curves=tuple(_fitted(means, best, knee)),
    )  # fmt: skip


def _interval(fits: Sequence[Found], best: Found, within: float) -> tuple[float, float]:
    """Return between which spreads [m] the cost stays so small; 0 and infinity where it does beyond those tried."""
    low, high = 0.0, math.inf
    for below in (True, False):
        before = best
        beyond = [each for each in (reversed(fits) if below else fits) if (each.spread < best.spread) == below]
        for each in beyond:
            if each.spread != best.spread and each.cost > within:
                end = _crossing(before, each, within)
                low, high = (end, high) if below else (low, end)
                break
            before = each
    return low, high


def _crossing(inside: Found, outside: Found, within: float) -> float:
    """Return the spread [m] at which the cost passes a bound, by a parabola from the one inside."""
    share = math.sqrt(max(within - inside.cost, 0.0) / max(outside.cost - inside.cost, 1e-30))
    return float(math.exp(math.log(inside.spread) + share * math.log(outside.spread / inside.spread)))


def _object_constants(found: Found, means: Means, knee: bool) -> tuple[float, float, float]:
    """Return K1, K2 [N/m] and x0 [m] of a fit, as the tip of these means measures them."""
    shape, deepest = found.shapes[0], float(means.depth.max())
    x0 = math.exp(found.values[1]) if knee else deepest
    at_knee = float(force_of(shape, found.spread, found.values[:1], False, np.array([x0]))[0])
    K1 = at_knee / x0
    if not knee:
        return K1, K1, x0
    kappa, root = math.exp(found.values[0]), math.exp(found.values[2])
    a = float(np.interp(x0, shape.depth, shape.contact))
    more = math.pi * a**2 * root**2 + BEYOND * 2 * math.pi * a * found.spread * root
    return K1, K1 + kappa * more, x0


def _object_errors(found: Found, means: Means, knee: bool, covariance: Floats) -> Floats:
    """Return the standard errors (3,) of K1, K2 and x0 at the best spread."""
    here, count = np.array(_object_constants(found, means, knee)), 3 if knee else 1
    slopes = np.zeros((3, len(found.values)))
    for i in range(count):
        values = found.values.copy()
        values[i] += 1e-5
        slopes[:, i] = (np.array(_object_constants(replace(found, values=values), means, knee)) - here) / 1e-5
    return np.sqrt(np.maximum(np.einsum("ip,pq,iq->i", slopes, covariance, slopes), 0.0))


def _fitted(means: Sequence[Means], found: Found, knee: bool) -> list[Fitted]:
    """Return how well each curve is followed."""
    rows, at, count = [], 0, 3 if knee else 1
    for each, shape in zip(means, found.shapes, strict=True):
        shift = 0.0
        if each.curve.shifts:
            shift = float(found.values[count + at])
            at += 1
        depth = each.depth - shift
        expected = force_of(shape, found.spread, found.values, knee, depth)
        rms = float(np.sqrt(((expected - each.force) ** 2).mean()) / each.force.max())
        rows.append(Fitted(
            name=each.curve.name, tip=each.curve.tip, depth=depth, force=each.force, expected=expected, rms=rms,
            miss=largest_miss(depth, each.force, expected),
        ))  # fmt: skip
    return rows


def lines(found: Together) -> list[str]:
    """Return a joint fit as lines of text: the constants, then each curve with its error."""
    law = f"K1 = {found.K1.text(1e3)} N/mm (95 %)"
    if found.knee:
        law += f", K2 = {found.K2.text(1e3)} N/mm, x0 = {found.x0.text(1e-3)} mm"
    low, high = (1e3 * end for end in found.interval)
    spread = Message(
        "spread = {spread:.3g} mm, from {low:.3g} to {high:.3g} mm (95 %)",
        spread=1e3 * found.spread.value, low=low, high=high
    )  # fmt: skip
    if not found.determined:
        spread = Message("The spread is not determined: measure with tips of different radius.")
    first = Message(
        "{count} curves together, for a {tip}: {law}", count=len(found.curves), tip=_tip_text(found.tip), law=law
    )
    return [first, spread, *map(_error_line, found.curves)]


def _error_line(curve: Fitted) -> Message:
    tip = _tip_text(curve.tip)
    if curve.miss is None:
        said = "{name}, {tip}: error {rms:.1f} % of full scale (RMS)"
        return Message(said, name=curve.name, tip=tip, rms=100 * curve.rms)
    return Message(
        "{name}, {tip}: error {rms:.1f} % of full scale (RMS), {worst:.0f} % at worst",
        name=curve.name, tip=tip, rms=100 * curve.rms, worst=100 * curve.miss.share
    )  # fmt: skip


def _tip_text(tip: Indenter) -> Message:
    return Message("{tip} of {radius:.3g} mm", tip=Message(tip.shape), radius=1e3 * tip.radius)
