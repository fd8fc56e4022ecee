"""One model of a press, force = tare + law(depth - touch), and the touch and tare that its points make likely.

A file begins in one of three ways. In the air: the force is level up to the touch, and shows the tare. At the touch, as
a depth of 0 and no force say. Or with a force on the load cell, which was pressed already (tare 0) or not tared (touch
at the first row). Each is fitted by least squares; the Bayesian information criterion tells air from the others. Where
the law does not follow the first rows of a bent curve, its fit to these alone tells touch and tare.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message
from .fit import MIN_PIECE, Fit, fit_law, independent_rows, slope_of
from .press import LoadingCurve
from .question import Answers, Question, Undecided
from .strokes import roughness
from .table import MIN_ROWS, SLIGHT

SURE = 3.0  # standard errors: by chance once in 400 files
_LIKELY = 2.0  # standard errors: of a force that leaves the touch open
_FIRST = 0.1  # of the range of force: what a press begins with, far from any knee
_TOUCHES = 80  # that are tried along the depth; Gauss-Newton finds the place between them
_WITHIN = 1.5  # times the noise: residuals of a law that follows its rows
_HARMLESS = 0.02  # of the range of depth: touches nearer to each other give the same constants
# of the criterion: positive and very strong evidence (Kass and Raftery, J. Am. Stat. Assoc. 90, 1995)
_POSITIVE, _VERY_STRONG = 2.0, 10.0


class _Begun(NamedTuple):
    """A fit of all rows, and the one that its touch and tare are from: the same, or that of the first rows alone."""

    whole: Fit
    first: Fit

    @property
    def follows(self) -> bool:
        """Return whether the law follows the first rows."""
        return self.whole is self.first


def settle(curve: LoadingCurve, answers: Answers | None = None) -> tuple[LoadingCurve, Fit]:
    """Fit a press, with the touch as it is given or as the points have it.

    Returns:
        the curve from the touch, without the tare, and the fit.

    Raises:
        Undecided: two touches are as likely, and differ in the constants.
        DimpleError: too few rows, or a touch far outside of them.
    """
    given = None if answers is None else answers.contact_mm
    fit = _likeliest(curve) if given is None else _as_given(curve, curve.inward * given / 1e3)
    return curve.begun_at(fit.contact.value, fit.tare.value), fit


def _likeliest(curve: LoadingCurve) -> Fit:
    x, f = curve.depth, curve.force
    first, span = float(x[0]), float(np.ptp(x))
    pressed, force = _from_the_first_row(x, f)
    fit = pressed.whole
    if (air := _after_air(x, f)) is not None:
        rows = len(x) if air.follows and pressed.follows else first_rows(f)
        gain = _gain(air.first, fit if air.follows else pressed.first, x[:rows], f[:rows])
        least = _POSITIVE if fit.K1.value > fit.K1.half_width else 0.0  # else nothing is pressed at the first row
        if 0 < least < gain < _VERY_STRONG and _differs(fit, air.whole, span):
            raise Undecided(_hidden(curve, fit, air.whole))
        fit = air.whole if gain > least else fit
    if fit.model == "two" and fit.K1.value * fit.x0.value < SLIGHT * fit.full_scale and fit.x0.value > _FIRST * span:
        raise Undecided(_soft_or_air(curve, fit))
    if min(first - fit.contact.value, abs(fit.contact.value)) > _HARMLESS * span:  # and off the file's 0
        raise Undecided(_loaded(curve, fit.contact.value, force))
    return fit


def first_rows(f: Floats) -> int:
    """Return how many rows a stroke begins with before its force has risen for good, and some beyond."""
    rest = float(np.median(f[: max(3, len(f) // 50)]))
    above = f > rest + max(_FIRST * (f.max() - rest), SURE * roughness(f))
    three = above[:-2] & above[1:-1] & above[2:]
    return min(int(three.argmax()) + MIN_ROWS, len(f)) if three.any() else len(f)


def _from_the_first_row(x: Floats, f: Floats) -> tuple[_Begun, float]:
    """Fit a press that begins at the first row or before, and return the force there [N] too.

    With no force it begins at the first row, or at a depth of 0 near it. With one it was pressed already, and with a
    pull the load cell is off, for what is pressed does not pull.
    """
    first = float(x[0])
    at = 0.0 if abs(first) < _HARMLESS * float(np.ptp(x)) else first
    untared = _begun(x, f, first, ("tare",))
    force, error = _force_at_first(f, untared)
    if abs(force) <= max(_LIKELY * error, SLIGHT * float(np.ptp(f))):
        fit = fit_law(x, f, touch=at)
        return _Begun(fit, fit), force
    if force < 0:
        return _begun(x, f, at, ("tare",)), force
    return _begun(x, f, first, ("contact",)), force


def _force_at_first(f: Floats, untared: _Begun) -> tuple[float, float]:
    """Return the force at the first row [N] and its error, from that row alone or the rows beyond: what tells more."""
    tare = untared.first.tare
    return min((float(f[0]), roughness(f)), (tare.value, tare.half_width / 2), key=lambda pair: pair[1])


def _begun(x: Floats, f: Floats, touch: float | Floats, free: tuple[str, ...]) -> _Begun:
    """Fit all rows as `fit_law` does; where the law then leaves the first rows, with the touch and tare of those."""
    rows, whole = first_rows(f), fit_law(x, f, touch=touch, free=free)
    u, v = x[:rows], f[:rows]
    try:
        first = fit_law(u, v, touch=touch, free=free)
    except DimpleError:  # too few of them beyond the touch
        return _Begun(whole, whole)
    noise = rows * (_WITHIN * roughness(f)) ** 2
    if _squares(whole, u, v) <= max(noise, _squares(first, u, v) * math.exp(_VERY_STRONG / rows)):
        return _Begun(whole, whole)
    begins = min(first.contact.value, float(np.max(touch)))  # not where the force has risen already
    return _Begun(fit_law(x, f, touch=begins, tare=first.tare.value), first)


def _after_air(x: Floats, f: Floats) -> _Begun | None:
    """Fit a press that begins in the air, None where its first rows are none."""
    touches, noise = x[0] + float(np.ptp(x)) * np.arange(1, _TOUCHES) / _TOUCHES, roughness(f)
    after = np.array([touch for touch in touches if _is_air(x[x < touch], f[x < touch], noise)])
    try:
        return _begun(x, f, after, ("contact", "tare")) if len(after) else None
    except DimpleError:  # too few rows beyond the touch
        return None


def _is_air(x: Floats, f: Floats, noise: float) -> bool:
    """Return whether a force does not rise by more than chance, or by more than its noise."""
    if len(np.unique(x)) < MIN_PIECE:
        return False
    slope, error = slope_of(x, f)
    return slope < SURE * error or slope * float(np.ptp(x)) < noise


def _as_given(curve: LoadingCurve, touch: float) -> Fit:
    """Fit with the touch at a depth [m]; one that was found keeps its interval.

    The rows before it tell the tare, and without them the first ones.
    """
    x, f = curve.depth, curve.force
    first, span = float(x[0]), float(np.ptp(x))
    if not first - 20 * span <= touch < x.max():
        raise DimpleError(
            "The touch at {contact_mm} mm lies outside the depths of the file.", contact_mm=curve.reading(touch)
        )
    after = (x < touch).sum() >= MIN_PIECE
    found = _near(curve, touch) if after else _from_the_first_row(x, f)[0].whole
    if found is not None and abs(found.contact.value - touch) < 1e-5 * (abs(touch) + span):
        return found
    if after:
        return fit_law(x, f, touch=touch, free=("tare",))
    untared = _begun(x, f, touch, ("tare",))
    force, error = _force_at_first(f, untared)
    pulls = force < -max(SURE * error, SLIGHT * float(np.ptp(f)))
    late = touch > first - _HARMLESS * span  # a force there was on the load cell before
    return untared.whole if late or pulls else fit_law(x, f, touch=touch)


def _near(curve: LoadingCurve, touch: float) -> Fit | None:
    """Return the best fit with rows before its touch, from a touch [m] nearby; None for too few rows beyond it."""
    try:
        return fit_law(curve.depth, curve.force, touch=touch, free=("contact", "tare"))
    except DimpleError:
        return None


def _squares(fit: Fit, x: Floats, f: Floats) -> float:
    return max(fit.fitted.squares(x, f), 1e-300)


def _gain(one: Fit, other: Fit, x: Floats, f: Floats) -> float:
    """Return by how much the Bayesian information criterion prefers one fit to another.

    The touch of the one was searched for, which weighs as two parameters, as with a knee.
    """
    rows = independent_rows(len(x), one.correlation)
    more = 1 + len(one.fitted.free) - len(other.fitted.free)
    return rows * math.log(_squares(other, x, f) / _squares(one, x, f)) - more * math.log(rows)


def _differs(one: Fit, other: Fit, span: float) -> bool:
    """Return whether touches differ, and with them the constants by more than their intervals."""
    pairs = [(getattr(one, name), getattr(other, name)) for name in ("K1", "K2", "x0")]
    apart = any(abs(a.value - b.value) > max(a.half_width, b.half_width) for a, b in pairs)
    return apart and abs(one.contact.value - other.contact.value) > _HARMLESS * span


def _which_touch(curve: LoadingCurve, text: str, *answers: tuple[float, str]) -> Question:
    """Ask for the touch, with the likeliest depth [m] first."""
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


def _hidden(curve: LoadingCurve, fit: Fit, air: Fit) -> Question:
    likely = [(one.contact.value, Message("then K1 is {K1} N/mm", K1=one.K1.text(1e3))) for one in (air, fit)]
    return _which_touch(curve, "The noise hides the first touch. At which depth was it?", *likely)


def _soft_or_air(curve: LoadingCurve, fit: Fit) -> Question:
    touch, rise = fit.contact.value, fit.K1.value * fit.x0.value
    air = _near(curve, touch + fit.x0.value)
    return _which_touch(
        curve,
        Message(
            "The force rises by no more than {rise:.2g} N over the first {depth:.3g} mm. At which depth was the "
            "first touch?",
            rise=rise,
            depth=1e3 * fit.x0.value,
        ),
        (touch + fit.x0.value if air is None else air.contact.value, "where it begins to rise: there was air before"),
        (touch, "before: the object is that soft at first"),
    )
