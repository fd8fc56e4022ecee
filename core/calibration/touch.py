"""One model of a press, force = tare + law(depth - touch), and the touch and tare that its points make likely.

A file begins in one of three ways. In the air: the force is level up to the touch, and shows the tare. At the touch, as
a depth of 0 and no force say. Or with a force on the load cell, which was pressed already (tare 0) or not tared (touch
at the first row). Each is fitted by least squares; the Bayesian information criterion tells air from the others.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message
from .beginning import FIRST, SURE, Beginning, beginning, rising_from, squares_of_law, touch_after_air
from .fit import Fit, fit_law, independent_rows
from .press import LoadingCurve
from .question import Answers, Candidate, Question, Undecided
from .strokes import roughness
from .table import SLIGHT
from .two_pieces import MIN_PIECE

_WITHIN = 1.5  # times the noise: residuals of a law that follows its rows
_HARMLESS = 0.02  # of the range of depth: touches nearer to each other give the same constants
# of the criterion: positive and very strong evidence (Kass and Raftery, J. Am. Stat. Assoc. 90, 1995)
_POSITIVE, _VERY_STRONG = 2.0, 10.0


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
    return curve.begun_at(fit.contact.value, fit.tare), fit


def _likeliest(curve: LoadingCurve) -> Fit:
    x, f = curve.depth, curve.force
    first, span = float(x[0]), float(np.ptp(x))
    pressed = beginning(x, f)
    fit = _from_the_first_row(x, f, pressed)
    if (found := _after_air(x, f, pressed, fit)) is not None:
        after, gain = found
        least = _POSITIVE if fit.K1.value > fit.K1.half_width else 0.0  # else nothing is pressed at the first row
        if 0 < least < gain < _VERY_STRONG and _differs(fit, after, span):
            raise Undecided(_hidden(curve, fit, after))
        fit = after if gain > least else fit
    if fit.model == "two" and fit.K1.value * fit.x0.value < SLIGHT * fit.full_scale and fit.x0.value > FIRST * span:
        raise Undecided(_soft_or_air(curve, fit))
    if min(first - fit.contact.value, abs(fit.contact.value)) > _HARMLESS * span:  # and off the file's 0
        raise Undecided(_begun(curve, fit.contact.value, pressed.force))
    return fit


def _after_air(x: Floats, f: Floats, pressed: Beginning, rival: Fit) -> tuple[Fit, float] | None:
    """Return the best fit whose touch has level rows before it, and how much likelier it is than a rival.

    All rows tell where the law follows the first ones, else these alone do.
    """
    rows, noise = pressed.rows, roughness(f)
    touch = touch_after_air(x, f, noise, squares_of_law)
    fit = None if touch is None else _near(x, f, touch)
    if fit is not None and _follows(fit, x, f, pressed):
        some = len(x) if _follows(rival, x, f, pressed) else rows
        return fit, _gain(fit, rival, x[:some], f[:some])
    touch = touch_after_air(x[:rows], f[:rows], noise, lambda u, v, at: rising_from(u, v, at).squares)
    if touch is None:
        return None
    begins = rising_from(x[:rows], f[:rows], touch)
    gain = rows * math.log(max(pressed.squares, 1e-300) / max(begins.squares, 1e-300)) - 2 * math.log(rows)
    return _fit_at(x, f, begins.touch, begins.force), gain


def _from_the_first_row(x: Floats, f: Floats, begins: Beginning) -> Fit:
    """Fit a press that begins at the first row or before.

    With no force it begins at the first row, or at a depth of 0 near it. With one it was pressed already, and with a
    pull the load cell is off, for what is pressed does not pull.
    """
    first, span = float(x[0]), float(np.ptp(x))
    at = 0.0 if abs(first) < _HARMLESS * span else first
    force, error = _force_at_first(x, f, begins)
    if abs(force) <= max(SURE * error, SLIGHT * float(np.ptp(f))):
        return _fit_at(x, f, at)
    if force < 0 or begins.slope <= 0:
        return _follow(x, f, begins, ("tare",), at, force)
    return _follow(x, f, begins, ("contact",), first - force / begins.slope, 0.0)


def _force_at_first(x: Floats, f: Floats, begins: Beginning) -> tuple[float, float]:
    """Return the force at the first row [N] and its standard error, from whatever tells it best.

    That is the whole first piece where it is straight, else the first rows, or the first one alone.
    """
    fit = _fit_at(x, f, float(x[0]), free=("tare",))
    known = [(float(f[0]), roughness(f)), (begins.force, begins.error)]
    if _follows(fit, x, f, begins):
        known.append((fit.tare, math.sqrt(fit.spread[-1, -1]) / 2))
    return min(known, key=lambda pair: pair[1])


def _follow(x: Floats, f: Floats, begins: Beginning, free: tuple[str, ...], touch: float, tare: float) -> Fit:
    """Fit with touch, tare or both free; where the law then leaves the first rows, with those that they tell."""
    start = begins.touch if "contact" in free else touch
    try:
        fit = _fit_at(x, f, start, tare, free=free)
        if _follows(fit, x, f, begins):
            return fit
    except DimpleError:  # too few rows beyond the touch
        pass
    return _fit_at(x, f, touch, tare)


def _follows(fit: Fit, x: Floats, f: Floats, begins: Beginning) -> bool:
    """Return whether a fit meets the first rows within their noise, or about as well as a curve through these alone."""
    u, v, rows = x[: begins.rows], f[: begins.rows], begins.rows
    squares = float(((v - fit.tare - fit.law(u - fit.contact.value)) ** 2).sum())
    return squares <= max(rows * (_WITHIN * roughness(f)) ** 2, begins.squares * math.exp(_VERY_STRONG / rows))


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
    pressed = beginning(x, f)
    after = (x < touch).sum() >= MIN_PIECE
    found = _near(x, f, touch) if after else _from_the_first_row(x, f, pressed)
    if found is not None and abs(found.contact.value - touch) < 1e-5 * (abs(touch) + span):
        return found
    if after:
        return _fit_at(x, f, touch, free=("tare",))
    force, error = _force_at_first(x, f, pressed)
    pulls = force < -max(SURE * error, SLIGHT * float(np.ptp(f)))
    late = touch > first - _HARMLESS * span  # a force there was on the load cell before
    return _follow(x, f, pressed, ("tare",), touch, force) if late or pulls else _fit_at(x, f, touch)


def _near(x: Floats, f: Floats, touch: float) -> Fit | None:
    """Return the best fit with rows before its touch, from a touch [m] nearby; None for too few rows beyond it."""
    try:
        return _fit_at(x, f, touch, float(f[x < touch].mean()), free=("contact", "tare"))
    except DimpleError:
        return None


def _fit_at(x: Floats, f: Floats, touch: float, tare: float = 0.0, free: tuple[str, ...] = ()) -> Fit:
    """Fit from a touch [m] and a tare [N]; those of the fit are the file's own."""
    fit = fit_law(x - touch, f - tare, free=free)
    contact = replace(fit.contact, value=touch + fit.contact.value)
    return replace(fit, contact=contact, tare=tare + fit.tare)


def _gain(one: Fit, other: Fit, x: Floats, f: Floats) -> float:
    """Return by how much the Bayesian information criterion prefers one fit to another.

    The touch of the one was searched for, which weighs as two parameters, as with a knee.
    """

    def squares(fit: Fit) -> float:
        return max(float(((f - fit.tare - fit.law(x - fit.contact.value)) ** 2).sum()), 1e-300)

    rows = independent_rows(len(x), one.correlation)
    more = 1 + len(one.fitted.free) - len(other.fitted.free)
    return rows * math.log(squares(other) / squares(one)) - more * math.log(rows)


def _differs(one: Fit, other: Fit, span: float) -> bool:
    """Return whether touches differ, and with them the constants by more than their intervals."""
    pairs = [(getattr(one, name), getattr(other, name)) for name in ("K1", "K2", "x0")]
    apart = any(abs(a.value - b.value) > max(a.half_width, b.half_width) for a, b in pairs)
    return apart and abs(one.contact.value - other.contact.value) > _HARMLESS * span


def _which_touch(curve: LoadingCurve, text: str, *answers: tuple[float, str]) -> Question:
    """Ask for the touch, with the likeliest depth [m] first."""
    candidates = tuple(Candidate(f"{curve.reading(at):.6g}", label) for at, label in answers)
    return Question(name="contact_mm", text=text, candidates=candidates, default=candidates[0].value)


def _begun(curve: LoadingCurve, before: float, force: float) -> Question:
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
    air = _near(curve.depth, curve.force, touch + fit.x0.value)
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
