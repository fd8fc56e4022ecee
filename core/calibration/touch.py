"""The most likely touch and tare of a press, with the model force = tare + law(depth - touch).

A file begins in one of three ways. In the air: the force is level up to the touch, at the tare. At the touch: the first
row has no force. Or with a force on the load cell: either the object was pressed already (tare 0), or the cell was not
tared (touch at the first row). Each case is fitted by least squares; the Bayesian information criterion decides between
air and the others. If the law does not follow the first rows of a curved press, a fit to these rows alone gives touch
and tare.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..base import DimpleError, Floats
from ..message import Message
from .fit import MIN_PIECE, TOUCH_STEP, Fit, fit_law, independent_rows, slope_of
from .press import LoadingCurve
from .question import Answers, Question, Undecided
from .strokes import roughness
from .table import MIN_ROWS, SLIGHT

SURE = 3.0  # [standard errors] significant: by chance once in 400 files
_LIKELY = 2.0  # [standard errors] a force at the first row that may still be 0
_FIRST = 0.1  # share of the range of force, or of depth: the beginning of a press, far from any knee
_WITHIN = 1.5  # times the noise: RMS residual up to which a law follows its rows
_HARMLESS = 0.02  # share of the range of depth: touches closer together give the same constants
_FARTHEST = 20.0  # ranges of depth: a touch farther before the first row would leave a twentieth of the press measured
_VERY_STRONG = 10.0  # evidence, as a difference of the criterion. Source: Kass and Raftery 1995


class _Begun(NamedTuple):
    """A fit to all rows, and the fit that gave its touch and tare: the same one, or a fit to the first rows alone."""

    whole: Fit
    first: Fit

    @property
    def follows(self) -> bool:
        """Return whether the law follows the first rows."""
        return self.whole is self.first


def settle(curve: LoadingCurve, answers: Answers | None = None) -> tuple[LoadingCurve, Fit]:
    """Fit a press, with the touch and the tare that the user gave or the most likely ones.

    Returns:
        the curve with depths from the touch and forces without the tare, and the fit.

    Raises:
        Undecided: two touches are plausible, and would give different constants; never if the user gave either.
        DimpleError: too few rows, or a touch or tare far outside them.
    """
    touch, tare = (None, None) if answers is None else (answers.contact_mm, answers.tare_n)
    curve = curve.begun_at(0.0, tare or 0.0)
    fit, question = _likeliest(curve) if touch is None else (_as_given(curve, curve.inward * touch / 1e3), None)
    if tare is not None:
        fit = _as_tared(curve, fit, tare, found=touch is None)
    elif question:
        raise Undecided(question)
    return curve.begun_at(fit.contact.value, fit.tare.value), fit


def _likeliest(curve: LoadingCurve) -> tuple[Fit, Question | None]:
    """Return the likeliest fit, and the question for the touch if another one is plausible."""
    x, f = curve.depth, curve.force
    first, span = float(x[0]), float(np.ptp(x))
    pressed, force = _from_the_first_row(x, f)
    fit = pressed.whole
    if (air := _after_air(x, f)) is not None:
        rows = len(x) if air.follows and pressed.follows else first_rows(f)
        if _gain(air.first, fit if air.follows else pressed.first, x[:rows], f[:rows]) > 0:
            fit = air.whole
    if fit.model == "two" and fit.K1.value * fit.x0.value < SLIGHT * fit.full_scale and fit.x0.value > _FIRST * span:
        return fit, _soft_or_air(curve, fit)
    if min(first - fit.contact.value, abs(fit.contact.value)) > _HARMLESS * span:  # and far from the file's 0
        return fit, _loaded(curve, max(fit.contact.value, first - span), force)
    return fit, None


def first_rows(f: Floats) -> int:
    """Return the number of rows of a stroke up to where its force has clearly risen, plus MIN_ROWS."""
    rest = float(np.median(f[: max(3, len(f) // 50)]))
    above = f > rest + max(_FIRST * (f.max() - rest), SURE * roughness(f))
    three = above[:-2] & above[1:-1] & above[2:]
    return min(int(three.argmax()) + MIN_ROWS, len(f)) if three.any() else len(f)


def _from_the_first_row(x: Floats, f: Floats) -> tuple[_Begun, float]:
    """Fit a press that begins at the first row or before it; return the fit and the force at that row [N].

    Without a force there, the touch is the first row, or the depth 0 if it is near. A positive force means that the
    object was pressed already; a negative one means that the load cell is off, since a press does not pull.
    """
    first = float(x[0])
    at = 0.0 if abs(first) < _HARMLESS * float(np.ptp(x)) else first
    untared = _begun(x, f, first, ("tare",))
    tare = untared.first.tare
    by_row, by_fit = (float(f[0]), roughness(f)), (tare.value, tare.half_width / 2)
    force, error = min(by_row, by_fit, key=lambda pair: pair[1])  # the more accurate one
    if abs(force) <= max(_LIKELY * error, SLIGHT * float(np.ptp(f))):
        fit = fit_law(x, f, touch=at)
        return _Begun(fit, fit), force
    if force < 0:
        return _begun(x, f, at, ("tare",)), force
    return _begun(x, f, first, ("contact",)), force


def _begun(x: Floats, f: Floats, touch: float | Floats, free: tuple[str, ...]) -> _Begun:
    """Fit all rows with `fit_law`; if the law then misses the first rows, take touch and tare from a fit to these."""
    rows, whole = first_rows(f), fit_law(x, f, touch=touch, free=free)
    u, v = x[:rows], f[:rows]
    try:
        first = fit_law(u, v, touch=touch, free=free)
    except DimpleError:  # too few of them beyond the touch
        return _Begun(whole, whole)
    noise = rows * (_WITHIN * roughness(f)) ** 2
    if _squares(whole, u, v) <= max(noise, _squares(first, u, v) * math.exp(_VERY_STRONG / rows)):
        return _Begun(whole, whole)
    begins = min(first.contact.value, float(np.max(touch)))  # beyond it the force has risen already
    fit = fit_law(x, f, touch=begins, tare=first.tare.value)
    if "contact" in free and fit.K1.value > 0:  # how far off it is by the law, which misses the first row
        off = abs(float(fit.fitted.residual(x[:1], f[:1])[0])) / fit.K1.value
        fit = replace(fit, contact=fit.contact.widened(off), x0=fit.x0.widened(off))
    return _Begun(fit, first)


def _after_air(x: Floats, f: Floats) -> _Begun | None:
    """Fit a press that begins in the air, None if its first rows show no air."""
    touches, noise = x[0] + float(np.ptp(x)) * np.arange(TOUCH_STEP, 1, TOUCH_STEP), roughness(f)
    after = np.array([touch for touch in touches if _is_air(x[x < touch], f[x < touch], noise)])
    try:
        return _begun(x, f, after, ("contact", "tare")) if len(after) else None
    except DimpleError:  # too few rows beyond the touch
        return None


def _is_air(x: Floats, f: Floats, noise: float) -> bool:
    """Return whether a force is level but for its noise."""
    if len(np.unique(x)) < MIN_PIECE or f.std() > SURE * noise:
        return False
    slope, error = slope_of(x, f)
    return slope < SURE * error or slope * float(np.ptp(x)) < noise


def _as_tared(curve: LoadingCurve, fit: Fit, tare: float, *, found: bool) -> Fit:
    """Fit the rows in contact of a curve without its tare [N], from the touch of a fit on: it was found, or given."""
    pressed, free = curve.depth > fit.contact.value, ("contact",) if found and "contact" in fit.fitted.free else ()
    try:  # the rows in contact alone say where the force is 0
        fit = fit_law(curve.depth[pressed], curve.force[pressed], touch=fit.contact.value, free=free)
        credible = fit.K1.value >= 0 and fit.contact.value >= _earliest(curve)
    except DimpleError:  # too few rows are left: where the force would be 0 lies behind them
        credible = False
    if credible:
        return fit
    raise DimpleError(
        "With a tare of {tare:.6g} N the file holds no press: its forces run from {least:.4g} to {most:.4g} N. Under "
        "Tare, type the force before the touch, or open the file again to have it detected.",
        tare=tare, least=curve.force.min() + tare, most=curve.force.max() + tare
    )  # fmt: skip


def _earliest(curve: LoadingCurve) -> float:
    """Return the earliest depth [m] that is credible for the touch."""
    return float(curve.depth[0] - _FARTHEST * np.ptp(curve.depth))


def _as_given(curve: LoadingCurve, touch: float) -> Fit:
    """Fit with the touch at a depth [m]; if a fit finds the same touch, return that fit with its interval of the touch.

    The rows before the touch give the tare; if there are too few, the first rows do.
    """
    x, f = curve.depth, curve.force
    first, span = float(x[0]), float(np.ptp(x))
    if not _earliest(curve) <= touch < x.max():
        raise DimpleError(
            "The touch at {contact_mm} mm lies outside the depths of the file.", contact_mm=curve.reading(touch)
        )
    after = (x < touch).sum() >= MIN_PIECE
    free = ("contact", "tare")
    found = fit_law(x, f, touch=touch, free=free) if after else _from_the_first_row(x, f)[0].whole
    if abs(found.contact.value - touch) < 1e-5 * (abs(touch) + span):
        return found
    if after:
        return fit_law(x, f, touch=touch, free=("tare",))
    late = touch > first - _HARMLESS * span  # then a force there was on the load cell before the touch
    return _begun(x, f, touch, ("tare",)).whole if late else fit_law(x, f, touch=touch)


def _squares(fit: Fit, x: Floats, f: Floats) -> float:
    return max(fit.fitted.squares(x, f), 1e-300)


def _gain(one: Fit, other: Fit, x: Floats, f: Floats) -> float:
    """Return the advantage of one fit over another by the Bayesian information criterion.

    The touch of the first one was searched for, so it counts as two parameters, and so does a knee.
    """
    rows = independent_rows(len(x), one.correlation)
    more = 1 + len(one.fitted.free) + one.fitted.knee - len(other.fitted.free) - other.fitted.knee
    return rows * math.log(_squares(other, x, f) / _squares(one, x, f)) - more * math.log(rows)


def _which_touch(curve: LoadingCurve, text: str, *answers: tuple[float, str]) -> Question:
    """Return the question for the touch, with the likeliest depth [m] first."""
    candidates = [(f"{curve.reading(at):.6g}", label) for at, label in answers]
    return Question("contact_mm", text, *candidates, default=candidates[0][0])


def _loaded(curve: LoadingCurve, before: float, force: float) -> Question:
    first = float(curve.depth[0])
    return _which_touch(
        curve,
        Message(
            "The force is {loaded:.3g} N where the file begins, at {first:.4g} mm. At which depth was the first touch?",
            loaded=force,
            first=curve.reading(first),
        ),
        (before, "before the file begins: the object was pressed already"),
        (first, "where the file begins: the load cell was not tared"),
    )


def _soft_or_air(curve: LoadingCurve, fit: Fit) -> Question:
    touch, rise = fit.contact.value, fit.K1.value * fit.x0.value
    return _which_touch(
        curve,
        Message(
            "The force rises by only {rise:.2g} N over the first {depth:.3g} mm. At which depth was the first touch?",
            rise=rise,
            depth=1e3 * fit.x0.value,
        ),
        (touch + fit.x0.value, "where it begins to rise: there was air before"),
        (touch, "before: the object is that soft at first"),
    )
