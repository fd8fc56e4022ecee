"""The two-piece law of Eq. (1) through a loading curve, with the uncertainty of its constants."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from .parameters import Free, Parameters, jacobian_of, law, pressed_residual, residual_of, sum_of_squares
from .segments import MIN_PIECE, two_pieces

_EXACT = 1e-9  # of the largest force: residuals below are rounding, not noise
_ROWS = 7  # beyond the touch: with that, as many as a table has at least
_LEAST = 20.0  # rows: what even the smoothest systematic misfit is allowed to count as
_STRAY = 4.0  # standard errors that the joint fit may move the contact


@dataclass(frozen=True, slots=True, kw_only=True)
class Constant:
    """A fitted constant: its value, its standard error by least squares, and half the width of its 95 % interval.

    The interval is wider than the standard error says where neighbouring residuals agree with one another.
    """

    value: float
    error: float
    half_width: float

    def text(self, unit: float) -> str:
        """Return value ± half of the interval in a unit."""
        return plus_minus(self.value / unit, self.half_width / unit)


def plus_minus(value: float, half_width: float) -> str:
    """Return a value and half its interval, to two digits of the latter."""
    if half_width < 1e-5 * abs(value):
        return f"{value:.4g} ± 0"
    digits = max(1 - math.floor(math.log10(half_width)), 0)
    return f"{value:.{digits}f} ± {half_width:.{digits}f}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """The law that fits a loading curve best. With one slope K2 equals K1 and x0 is the deepest row.

    model: "one" or "two" slopes.
    K1: slope up to the knee [N/m].
    K2: slope beyond the knee [N/m].
    x0: depth of the knee [m].
    contact: how far the first touch lies beyond depth 0 [m], 0 where it is known.
    tare: force at the first touch [N], 0 where it is known.
    noise: standard deviation of the residuals [N].
    correlation: of neighbouring residuals.
    full_scale: largest force [N].
    knee_bic: by how much a knee lowers the Bayesian information criterion.
    rows: number of rows in contact.
    parameters: constants, contact and tare as they were fitted.
    spread: (p, p) covariance of the parameters, stretched to 95 %.
    widened: how many times wider the intervals are because neighbouring residuals agree.
    falls: the best two pieces would fall, and the constants are the best of those that rise.
    """

    model: str
    K1: Constant
    K2: Constant
    x0: Constant
    contact: Constant
    tare: float
    noise: float
    correlation: float
    full_scale: float
    knee_bic: float
    rows: int
    parameters: Parameters
    spread: Floats
    widened: float
    falls: bool = False

    @property
    def misfit(self) -> float:
        """Return the residuals' RMS as a share of full scale."""
        return self.noise / self.full_scale

    def law(self, x: Floats) -> Floats:
        """Return K(x) [N] at depths [m] below the contact."""
        return law(np.asarray(x, np.float64), self.K1.value, self.K2.value, self.x0.value)

    def band(self, x: Floats) -> Floats:
        """Return half the width [N] of the law's 95 % interval at depths [m] below the contact."""
        slopes = jacobian_of(self.parameters, np.asarray(x, np.float64) + self.parameters.parts(x)[3])
        return np.sqrt(np.maximum(((slopes @ self.spread) * slopes).sum(axis=1), 0))


def fit_law(depth: Floats, force: Floats, *, free: Free = ()) -> Fit:
    """Fit F = K1 x up to x0, then K1 x0 + K2 (x - x0).

    Args:
        depth: (n,) [m] from the contact; rows before it have negative depth.
        force: (n,) [N], tared.
        free: "contact" where depth 0 is an estimate of the first touch, "tare" where force 0 is one of the force
            there: refined together with the constants, and their uncertainty is part of that of the constants.

    Raises:
        DimpleError: too few rows.
    """
    if len(free) == 2 and len(np.unique(depth[depth <= 0])) < MIN_PIECE:  # nothing tells one from the other
        free = ("contact",)
    pressed = np.ones(len(depth), bool) if free else depth > 0
    x, f = np.asarray(depth, np.float64)[pressed], np.asarray(force, np.float64)[pressed]
    inside = x > 0
    if inside.sum() < _ROWS or len(np.unique(x[inside])) < 4:
        raise _too_few(int(inside.sum()))
    # without rows before the touch the first piece need not begin at 0, 0: either may be off, not both
    left = "line" if len(free) == 1 and inside.sum() > len(x) - MIN_PIECE else "origin"
    u, v = x[inside], f[inside]
    slope, offset = np.polyfit(u, v, 1) if left == "line" else (u @ v / (u @ u), 0.0)
    start = _start([float(slope)], float(offset), free)
    if not _has_rows(start, x) or (free == ("contact",) and slope <= 0):  # no line through the curve begins at a touch
        start = _start([float(u @ v / (u @ u))], 0.0, free)
    if not _has_rows(start, x):
        raise _too_few(int((x > start.parts(x)[3]).sum()))
    one = _settled(start, x, f)
    pieces, falls = two_pieces(u, v, left=left), False
    if pieces is not None and min(pieces.slope1, pieces.slope2) <= 0:  # no body of the model falls: take the best rise
        pieces, falls = two_pieces(u, v, left=left, rising=True), True
    if pieces is not None:
        start = _start([pieces.slope1, pieces.slope2, pieces.join], pieces.offset, free)
    if pieces is None or not _has_rows(start, x):
        return _result(one, x, f, 0.0)
    two = _settled(start, x, f)
    bic = _knee_gain(one, two, x, f)
    return replace(_result(two if bic > 0 else one, x, f, bic), falls=falls and bic > 0)


def _start(values: list[float], offset: float, free: Free) -> Parameters:
    """Return parameters whose first piece begins with an offset [N] at depth 0."""
    contact = -offset / values[0] if free == ("contact",) and values[0] > 0 else 0.0
    if len(values) > 1:
        values = [*values[:2], values[2] - contact]
    known = {"contact": contact, "tare": offset}
    return Parameters(knee=len(values) > 1, free=free, values=np.array([*values, *(known[name] for name in free)]))


def _has_rows(parameters: Parameters, x: Floats) -> bool:
    """Return whether enough rows lie on each piece; a touch or a knee may come to lie beyond them."""
    _, _, x0, contact, _ = parameters.parts(x)
    pressed, beyond = int((x > contact).sum()), int((x > contact + x0).sum())
    return min(pressed - beyond, beyond) >= 2 if parameters.knee else pressed >= _ROWS


def _holds(parameters: Parameters, start: Parameters, x: Floats) -> bool:
    """Return whether slopes that rose at the start still do, and contact and tare can still be told apart."""
    slopes, before = slice(2 if start.knee else 1), x[x <= parameters.parts(x)[3]]
    rises = parameters.values[slopes].min() > 0 or start.values[slopes].min() <= 0
    return bool(rises and (len(start.free) < 2 or len(np.unique(before)) >= MIN_PIECE))


def _too_few(rows: int) -> DimpleError:
    return DimpleError(
        "Only {rows} rows lie beyond the first touch; a fit needs at least {least}.", rows=rows, least=_ROWS
    )


def _settled(start: Parameters, x: Floats, f: Floats) -> Parameters:
    """Move contact, tare and constants together to the least squares of all rows (Gauss-Newton).

    The start is kept where that would lead the contact away from it: then the law does not hold near the touch.
    """
    if not start.free:
        return start
    best, least = start, sum_of_squares(start, x, f)
    for _ in range(20):
        jacobian = jacobian_of(best, x)
        scale = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
        step = np.linalg.lstsq(jacobian / scale, residual_of(best, x, f), rcond=None)[0] / scale
        candidates = [replace(best, values=best.values + share * step) for share in (1.0, 0.5, 0.2, 0.05)]
        candidate = min(candidates, key=lambda each: sum_of_squares(each, x, f))
        total = sum_of_squares(candidate, x, f)
        if not total < least or not _has_rows(candidate, x) or not _holds(candidate, start, x):
            break
        settled = least - total < 1e-14 * least
        best, least = candidate, total
        if settled:
            break
    at = best.index("contact")
    if at is None:
        return best
    moved, error = best.values[at] - start.values[at], math.sqrt(_covariance(best, x, f)[at, at])
    return best if abs(moved) <= _STRAY * error else start


def _variance(parameters: Parameters, x: Floats, f: Floats) -> float:
    residual = pressed_residual(parameters, x, f)
    return float((residual**2).sum()) / max(len(residual) - len(parameters.values), 1)


def _covariance(parameters: Parameters, x: Floats, f: Floats) -> Floats:
    """Return the covariance (p, p) of the parameters: s^2 (J^T J)^-1."""
    jacobian = jacobian_of(parameters, x)
    scale = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
    inverse = np.linalg.pinv(jacobian / scale) / scale[:, None]
    return np.asarray(_variance(parameters, x, f) * inverse @ inverse.T)


def _correlation(residual: Floats) -> float:
    """Return how far neighbouring residuals agree, 0 where that may be chance."""
    total = float(residual @ residual)
    share = float(residual[1:] @ residual[:-1]) / total if total > 0 else 0.0
    return min(share, 0.999) if share > 2 / math.sqrt(len(residual)) else 0.0


def independent_rows(n: int, correlation: float) -> float:
    """Return as how many independent rows n rows count whose residuals are correlated: n (1 - r) / (1 + r)."""
    return min(float(n), max(n * (1 - correlation) / (1 + correlation), _LEAST))


def _knee_gain(one: Parameters, two: Parameters, x: Floats, f: Floats) -> float:
    """Return by how much two slopes lower the Bayesian information criterion against one.

    A knee costs 3 log n: a slope, and a place that is searched for, which weighs as two (Zhang and Siegmund,
    Biometrics 63, 2007).
    """
    before, after = pressed_residual(one, x, f), pressed_residual(two, x, f)
    n = independent_rows(len(after), _correlation(after))
    floor = (_EXACT * float(np.abs(f).max())) ** 2
    s1, s2 = max(float((before**2).mean()), floor), max(float((after**2).mean()), floor)
    return n * math.log(s1 / s2) - 3 * math.log(max(n, 2.0))


def t_95(freedom: float) -> float:
    """Return the t that Student's variable stays within with 95 %, to 1 % from 3 degrees of freedom on.

    Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 26.7.5.
    """
    return 1.960 + 2.372 / freedom + 2.823 / freedom**2 + 2.556 / freedom**3


def _result(parameters: Parameters, x: Floats, f: Floats, bic: float) -> Fit:
    K1, K2, x0, contact, tare = parameters.parts(x)
    residual = pressed_residual(parameters, x, f)
    r = _correlation(residual)
    count = independent_rows(len(residual), r)
    covariance = _covariance(parameters, x, f)
    errors = np.sqrt(np.diag(covariance))
    wider = math.sqrt(len(residual) / count)
    reach = t_95(max(count - len(parameters.values), 1.0)) * wider

    def constant(value: float, at: int | None) -> Constant:
        error = 0.0 if at is None else float(errors[at])
        return Constant(value=value, error=error, half_width=reach * error)

    knee = parameters.knee
    return Fit(
        model="two" if knee else "one",
        K1=constant(K1, 0),
        K2=constant(K2, 1 if knee else 0),
        x0=constant(x0, 2 if knee else None),
        contact=constant(contact, parameters.index("contact")),
        tare=tare,
        noise=math.sqrt(_variance(parameters, x, f)),
        correlation=r,
        full_scale=float(np.abs(f - tare).max()),
        knee_bic=bic,
        rows=len(residual),
        parameters=parameters,
        spread=reach**2 * covariance,
        widened=wider,
    )
