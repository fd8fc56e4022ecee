"""The two-piece law of Eq. (1) through a loading curve, with the uncertainty of its constants."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from .table import MIN_ROWS
from .two_pieces import MIN_PIECE, PARAMETERS, Law, two_pieces

_EXACT = 1e-9  # of the largest force: residuals below are rounding, not noise
_ROWS = MIN_ROWS - 1  # beyond the touch: with that, as many as a table has at least
_LEAST = 20.0  # rows: what even the smoothest systematic misfit is allowed to count as


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
    fitted: the law with its free parameters.
    spread: (p, p) covariance of the free parameters, stretched to 95 %.
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
    fitted: Law
    spread: Floats
    falls: bool = False

    @property
    def misfit(self) -> float:
        """Return the residuals' RMS as a share of full scale."""
        return self.noise / self.full_scale

    @property
    def widened(self) -> float:
        """Return how many times wider the intervals are because neighbouring residuals agree."""
        return math.sqrt(self.rows / independent_rows(self.rows, self.correlation))

    def law(self, x: Floats) -> Floats:
        """Return K(x) [N] at depths [m] below the contact."""
        return self.fitted.force(np.asarray(x, np.float64))

    def band(self, x: Floats) -> Floats:
        """Return half the width [N] of the law's 95 % interval at depths [m] below the contact."""
        slopes = self.fitted.slopes(np.asarray(x, np.float64))
        return np.sqrt(np.maximum(((slopes @ self.spread) * slopes).sum(axis=1), 0))


def fit_law(depth: Floats, force: Floats, *, free: tuple[str, ...] = ()) -> Fit:
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
    through = float(u @ v / (u @ u))
    slope, offset = np.polyfit(u, v, 1).tolist() if left == "line" else (through, 0.0)
    start = _start((slope, slope, math.inf), offset, free)
    if not _has_rows(start, x) or (free == ("contact",) and slope <= 0):  # no line through the curve begins at a touch
        start = _start((through, through, math.inf), 0.0, free)
    if not _has_rows(start, x):
        raise _too_few(int((x > start.contact).sum()))
    one = _settled(start, x, f)
    pieces, falls = two_pieces(u, v, left=left), False
    if pieces is not None and min(pieces.slope1, pieces.slope2) <= 0:  # no body of the model falls: take the best rise
        pieces, falls = two_pieces(u, v, left=left, rising=True), True
    if pieces is not None:
        start = _start((pieces.slope1, pieces.slope2, pieces.join), pieces.offset, free)
    if pieces is None or not _has_rows(start, x):
        return _result(one, x, f, 0.0)
    two = _settled(start, x, f)
    bic = _knee_gain(one, two, x, f)
    return replace(_result(two if bic > 0 else one, x, f, bic), falls=falls and bic > 0)


def _start(constants: tuple[float, float, float], offset: float, free: tuple[str, ...]) -> Law:
    """Return the law whose first piece begins with an offset [N] at depth 0."""
    K1, K2, join = constants
    contact = -offset / K1 if free == ("contact",) and K1 > 0 else 0.0
    tare = offset if "tare" in free else 0.0
    fitted = ("K1",) if math.isinf(join) else ("K1", "K2", "x0")
    return Law(np.array([K1, K2, join - contact, contact, tare]), (*fitted, *free))


def _has_rows(law: Law, x: Floats) -> bool:
    """Return whether enough rows lie on each piece; a touch or a knee may come to lie beyond them."""
    pressed, beyond = int((x > law.contact).sum()), int((x > law.contact + law.values[2]).sum())
    return min(pressed - beyond, beyond) >= 2 if law.knee else pressed >= _ROWS


def _holds(law: Law, start: Law, x: Floats) -> bool:
    """Return whether slopes that rose at the start still do, and contact and tare can still be told apart."""
    rises = law.values[:2].min() > 0 or start.values[:2].min() <= 0
    both = {"contact", "tare"} <= set(law.free)
    return bool(rises and (not both or len(np.unique(x[x <= law.contact])) >= MIN_PIECE))


def _too_few(rows: int) -> DimpleError:
    return DimpleError(
        "Only {rows} rows lie beyond the first touch; a fit needs at least {least}.", rows=rows, least=_ROWS
    )


def _settled(start: Law, x: Floats, f: Floats) -> Law:
    """Move contact, tare and constants together to the least squares of all rows (Gauss-Newton)."""
    if not {"contact", "tare"} & set(start.free):
        return start
    best, least = start, start.squares(x, f)
    for _ in range(20):
        slopes = best.slopes(x - best.contact)
        scale = np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
        step = np.linalg.lstsq(slopes / scale, best.residual(x, f), rcond=None)[0] / scale
        law = min((best.moved(share * step) for share in (1.0, 0.5, 0.2, 0.05)), key=lambda each: each.squares(x, f))
        gained = least - law.squares(x, f)
        if not gained > 0 or not _has_rows(law, x) or not _holds(law, start, x):
            break
        best, least = law, least - gained
        if gained < 1e-14 * (least + gained):
            break
    return best


def _variance(law: Law, x: Floats, f: Floats) -> float:
    residual = law.pressed_residual(x, f)
    return float((residual**2).sum()) / max(len(residual) - len(law.free), 1)


def _covariance(law: Law, x: Floats, f: Floats) -> Floats:
    """Return the covariance (p, p) of the free parameters: s^2 (J^T J)^-1."""
    slopes = law.slopes(x - law.contact)
    scale = np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
    inverse = np.linalg.pinv(slopes / scale) / scale[:, None]
    return np.asarray(_variance(law, x, f) * inverse @ inverse.T)


def _correlation(residual: Floats) -> float:
    """Return how far neighbouring residuals agree, 0 where that may be chance."""
    total = float(residual @ residual)
    share = float(residual[1:] @ residual[:-1]) / total if total > 0 else 0.0
    return min(share, 0.999) if share > 2 / math.sqrt(len(residual)) else 0.0


def independent_rows(n: int, correlation: float) -> float:
    """Return as how many independent rows n rows count whose residuals are correlated: n (1 - r) / (1 + r)."""
    return min(float(n), max(n * (1 - correlation) / (1 + correlation), _LEAST))


def _knee_gain(one: Law, two: Law, x: Floats, f: Floats) -> float:
    """Return by how much two slopes lower the Bayesian information criterion against one.

    A knee costs 3 log n: a slope, and a place that is searched for, which weighs as two (Zhang and Siegmund,
    Biometrics 63, 2007).
    """
    before, after = one.pressed_residual(x, f), two.pressed_residual(x, f)
    n = independent_rows(len(after), _correlation(after))
    floor = (_EXACT * float(np.abs(f).max())) ** 2
    s1, s2 = max(float((before**2).mean()), floor), max(float((after**2).mean()), floor)
    return n * math.log(s1 / s2) - 3 * math.log(max(n, 2.0))


def t_95(freedom: float) -> float:
    """Return the t that Student's variable stays within with 95 %, to 1 % from 3 degrees of freedom on.

    Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 26.7.5.
    """
    return 1.960 + 2.372 / freedom + 2.823 / freedom**2 + 2.556 / freedom**3


def _result(law: Law, x: Floats, f: Floats, bic: float) -> Fit:
    residual = law.pressed_residual(x, f)
    rows, r = len(residual), _correlation(residual)
    count = independent_rows(rows, r)
    reach = t_95(max(count - len(law.free), 1.0)) * math.sqrt(rows / count)
    covariance = _covariance(law, x, f)
    values = dict(zip(PARAMETERS, law.values.tolist(), strict=True))
    values["x0"] = min(values["x0"], float(x.max()) - law.contact)
    errors = dict(zip(law.free, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    errors.setdefault("K2", errors["K1"])  # one slope
    K1, K2, x0, contact, _ = (
        Constant(value=value, error=errors.get(name, 0.0), half_width=reach * errors.get(name, 0.0))
        for name, value in values.items()
    )
    return Fit(
        model="two" if law.knee else "one", K1=K1, K2=K2, x0=x0, contact=contact, tare=values["tare"],
        noise=math.sqrt(_variance(law, x, f)), correlation=r, full_scale=float(np.abs(f - values["tare"]).max()),
        knee_bic=bic, rows=rows, fitted=law, spread=reach**2 * covariance,
    )  # fmt: skip
