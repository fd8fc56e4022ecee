"""Least-squares fit of the law of Eq. (1), with a touch and a tare, and the uncertainty of its constants.

For a given touch and knee the law is linear in the other parameters, and running sums give its squares. So touch and
knee are searched for on a grid, which then narrows round the best pair.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from ..constants import EXACT

PARAMETERS = ("K1", "K2", "x0", "contact", "tare")
MIN_PIECE = 3  # distinct depths in a piece, at least: one more than determine a line
_KNEES = np.linspace(0, 1, 201)[1:]  # tried at first, as shares of the range of depth
TOUCH_STEP = 1 / 80  # of the range of depth: between touches, and how far round one it is searched for at first
_AROUND = np.linspace(-1, 1, 7)  # the grid round the best pair, in units of a width that is halved
_STEPS = 40  # grids: some thirty halvings, to a billionth of the first width
_LEAST = 20.0  # effective number of independent rows, at least, however strongly a systematic misfit correlates them


@dataclass(frozen=True, slots=True, kw_only=True)
class Constant:
    """A fitted constant: its value, its standard error by least squares, and half the width of its 95 % interval.

    The interval is wider than the standard error implies if neighbouring residuals are correlated.
    """

    value: float
    error: float
    half_width: float

    def text(self, unit: float) -> str:
        """Return value ± half-width of the interval in a unit, given as a multiple of the SI unit."""
        return plus_minus(self.value / unit, self.half_width / unit)

    def widened(self, by: float) -> Constant:
        """Return the constant with a wider interval."""
        return replace(self, half_width=self.half_width + by)


def plus_minus(value: float, half_width: float) -> str:
    """Return "value ± half-width", both rounded to two significant digits of the half-width."""
    if half_width < 1e-5 * abs(value):
        return f"{value:.4g} ± 0"
    digits = max(1 - math.floor(math.log10(half_width)), 0)
    return f"{value:.{digits}f} ± {half_width:.{digits}f}"


@dataclass(frozen=True, slots=True)
class Law:
    """Eq. (1) with a touch and a tare, and the names of its fitted parameters.

    values: K1 [N/m], K2 [N/m], x0 [m], contact [m], tare [N]; with one slope K2 equals K1, and x0 is infinite.
    free: names of the fitted parameters.
    """

    values: Floats
    free: tuple[str, ...]

    @property
    def knee(self) -> bool:
        """Return whether there are two slopes."""
        return "x0" in self.free

    @property
    def contact(self) -> float:
        """Return the depth of the first touch [m]."""
        return float(self.values[3])

    def force(self, x: Floats) -> Floats:
        """Return K(x) of Eq. (1), (n,) [N], at depths (n,) below the contact [m]."""
        K1, K2, x0 = self.values[:3]
        x = np.maximum(x, 0)
        return np.asarray(K1 * np.minimum(x, x0) + K2 * np.maximum(x - x0, 0))

    def slopes(self, x: Floats) -> Floats:
        """Return the derivatives (n, p) of the force by each free parameter at depths (n,) below the contact [m]."""
        K1, K2, x0 = self.values[:3]
        y, beyond = np.maximum(x, 0), x > x0
        contact = -np.where(beyond, K2, K1) * (x > 0)
        columns = (np.minimum(y, x0), np.maximum(y - x0, 0), (K1 - K2) * beyond, contact, np.ones_like(x))
        return np.stack([columns[PARAMETERS.index(name)] for name in self.free], axis=1)

    def residual(self, x: Floats, f: Floats) -> Floats:
        """Return forces (n,) [N] at depths (n,) [m] minus the law and the tare, (n,) [N]."""
        return np.asarray(f - self.values[4] - self.force(x - self.contact))

    def squares(self, x: Floats, f: Floats) -> float:
        """Return the sum of the squared residuals [N2]."""
        return float((self.residual(x, f) ** 2).sum())


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """The law that fits a press best. With one slope K2 equals K1 and x0 is the deepest row.

    model: "one" or "two" slopes.
    K1: slope up to the knee [N/m].
    K2: slope beyond the knee [N/m].
    x0: depth of the knee below the touch [m].
    contact: depth of the first touch [m].
    tare: force at the first touch [N].
    noise: standard deviation of the residuals [N].
    correlation: correlation of neighbouring residuals.
    full_scale: largest force above the tare [N].
    rows: number of rows in contact.
    fitted: the law with its free parameters.
    spread: (p, p) covariance of the free parameters, scaled up to 95 % intervals.
    """

    model: str
    K1: Constant
    K2: Constant
    x0: Constant
    contact: Constant
    tare: Constant
    noise: float
    correlation: float
    full_scale: float
    rows: int
    fitted: Law
    spread: Floats

    @property
    def misfit(self) -> float:
        """Return the standard deviation of the residuals as a share of full scale."""
        return self.noise / self.full_scale

    def law(self, x: Floats) -> Floats:
        """Return K(x) [N] at depths [m] below the contact."""
        return self.fitted.force(np.asarray(x, np.float64))

    def band(self, x: Floats) -> Floats:
        """Return the half-width [N] of the law's 95 % interval at depths [m] below the contact."""
        slopes = self.fitted.slopes(np.asarray(x, np.float64))
        return np.sqrt(np.maximum(((slopes @ self.spread) * slopes).sum(axis=1), 0))


def fit_law(
    depth: Floats, force: Floats, *, touch: float | Floats = 0.0, tare: float = 0.0, free: tuple[str, ...] = ()
) -> Fit:
    """Fit F = tare + K1 x up to x0, then tare + K1 x0 + K2 (x - x0), for depths x below the touch.

    Args:
        depth: (n,) [m].
        force: (n,) [N].
        touch: depth of the first touch [m]; if "contact" is free, one or several starting values.
        tare: force at the touch [N].
        free: which of "contact" and "tare" are fitted too; their uncertainty then widens that of the constants.

    Raises:
        DimpleError: too few rows.
    """
    x, f, touches = np.asarray(depth, np.float64), np.asarray(force, np.float64), np.atleast_1d(touch)
    if len(free) == 2 and len(np.unique(x[x <= touches.max()])) < MIN_PIECE:  # touch and tare cannot be distinguished
        free = ("contact",)
    if not free:
        x, f = x[x > touches[0]], f[x > touches[0]]
    one, two = (_least_squares(x, f, touches, tare, free, knee=knee) for knee in (False, True))
    if one is None:
        raise DimpleError(
            "Only {rows} rows lie beyond the first touch; a fit needs at least {least}.",
            rows=int((x > touches.min()).sum()),
            least=MIN_PIECE + 1,
        )
    return _result(two if two and _knee_gain(one, two, x, f) > 0 else one, x, f)


def slope_of(x: Floats, y: Floats) -> tuple[float, float]:
    """Return the slope of the line through rows (n,), and its standard error."""
    centred = x - x.mean()
    squares = float(centred @ centred)
    slope = float(centred @ y) / squares
    residual = y - y.mean() - slope * centred
    return slope, float(np.sqrt(residual @ residual / max(len(x) - 2, 1) / squares))


def _least_squares(
    x: Floats, f: Floats, touches: Floats, tare: float, free: tuple[str, ...], *, knee: bool
) -> Law | None:
    """Return the least-squares law with one or two slopes, None if too few rows lie on a piece.

    The law must rise on both pieces, as a body of the model must; a single slope may fall, for want of a better one.
    """
    low, span, high = float(x.min()), float(np.ptp(x)) or 1.0, float(np.abs(f - tare).max()) or 1.0
    order = np.argsort(x, kind="stable")
    u, v = (x[order] - low) / span, (f[order] - tare) / high
    distinct, sums = np.unique(u), _running_sums(u, v)
    cs, ts = (touches - low) / span, _KNEES if knee else _KNEES[-1:]
    around = np.array([TOUCH_STEP if len(free) == 2 else 0.0, _KNEES[0] if knee else 0.0])
    terms, best = [0, *([1] if knee else []), *([2] if free else [])], np.empty(0)
    for _ in range(_STEPS):
        c, t = (each.ravel() for each in np.meshgrid(cs, ts, indexing="ij"))
        left, right = (np.searchsorted(distinct, each, "right") for each in (c, t))
        enough = (len(distinct) - left > MIN_PIECE) & (left >= MIN_PIECE * (len(free) - 1))
        if knee:
            enough &= (right - left >= MIN_PIECE) & (len(distinct) - right >= MIN_PIECE)
        c, t = c[enough], t[enough]
        if not len(c):
            return None
        solution, squares = _solutions(u, sums, c, t, terms)
        rises = solution[:, : 1 + knee].min(axis=1) > 0
        if knee and not rises.any():
            return None
        at = int(np.where(rises | ~rises.any(), squares, np.inf).argmin())
        found = np.array([c[at], t[at], *solution[at]])
        if not len(best) or (np.abs(found - best)[:2] <= 0.9 * around).all():  # else it lies at the edge: move on first
            around = around / 2
        best = found
        cs, ts = best[:2, None] + around[:, None] * _AROUND
        if not around.any():
            break
    K1, K2 = best[2] * high / span, best[2 + knee] * high / span
    contact, join, offset = low + best[0] * span, low + best[1] * span, high * best[-1] if free else 0.0
    if free == ("contact",):  # all rows are in contact: extend the first piece back to zero force
        contact, offset = contact - offset / K1 if K1 > 0 else contact, 0.0
        if (x > contact).sum() <= MIN_PIECE or contact >= join:
            return None
    values = np.array([K1, K2, join - contact if knee else math.inf, contact, tare + offset])
    return Law(values, (*(("K1", "K2", "x0") if knee else ("K1",)), *free))


def _running_sums(u: Floats, v: Floats) -> Floats:
    """Return the sums (n + 1, 3, 3) of the products of (depth, 1, force) over the first rows, from none to all."""
    rows = np.stack([u, np.ones_like(u), v], axis=1)
    return np.concatenate([np.zeros((1, 3, 3)), np.cumsum(rows[:, :, None] * rows[:, None, :], axis=0)])


def _solutions(u: Floats, sums: Floats, c: Floats, t: Floats, terms: list[int]) -> tuple[Floats, Floats]:
    """Return least-squares solutions (p, len(terms)) for touches c and knees t (p,), and their sums of squares (p,).

    The columns of the law are min(x, t) - c and max(x - t, 0), both 0 before the touch, and 1. Their products with one
    another and with the force follow from the running sums over the rows before the touch, between touch and knee, and
    beyond the knee.

    Args:
        u: (n,) depths in ascending order.
        sums: their running sums.
        terms: the columns that are fitted.
    """
    at_touch, at_knee = (sums[np.searchsorted(u, each, "right")] for each in (c, t))
    maps = np.zeros((3, len(c), 4, 3))
    maps[:, :, 2, 1] = maps[:, :, 3, 2] = 1
    maps[1, :, 0, 0] = maps[2, :, 1, 0] = 1
    maps[1, :, 0, 1], maps[2, :, 0, 1], maps[2, :, 1, 1] = -c, t - c, -t
    parts = np.stack([at_touch, at_knee - at_touch, sums[-1] - at_knee])
    products = (maps @ parts @ maps.swapaxes(2, 3)).sum(axis=0)
    normal, rhs = products[:, terms][:, :, terms], products[:, terms, 3]
    normal = normal + 1e-15 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(len(terms))
    solution = np.linalg.solve(normal, rhs[..., None])[..., 0]
    return solution, products[:, 3, 3] - (solution * rhs).sum(axis=1)


def _correlation(residual: Floats) -> float:
    """Return the correlation of neighbouring residuals, 0 if it may be chance."""
    total = float(residual @ residual)
    share = float(residual[1:] @ residual[:-1]) / total if total > 0 else 0.0
    return min(share, 0.999) if share > 2 / math.sqrt(len(residual)) else 0.0


def independent_rows(n: int, correlation: float) -> float:
    """Return the effective number of independent rows among n rows with correlated residuals: n (1 - r) / (1 + r)."""
    return min(float(n), max(n * (1 - correlation) / (1 + correlation), _LEAST))


def _knee_gain(one: Law, two: Law, x: Floats, f: Floats) -> float:
    """Return the decrease of the Bayesian information criterion from one slope to two.

    A knee costs 3 log n: one parameter for the slope, and two for the position because it is searched for. Source:
    Zhang and Siegmund, Biometrics 63, 2007.
    """
    pressed = x > min(one.contact, two.contact)  # the same rows for both: one slope may take the first piece for air
    before, after = one.residual(x, f)[pressed], two.residual(x, f)[pressed]
    n = independent_rows(len(after), _correlation(after))
    floor = (EXACT * float(np.abs(f).max())) ** 2  # smaller residuals are rounding, not noise
    s1 = max(float((before**2).sum()) / (len(before) - 1), floor)  # with few rows two slopes absorb the scatter
    s2 = max(float((after**2).sum()) / max(len(after) - 4, 1), floor)
    return n * math.log(s1 / s2) - 3 * math.log(max(n, 2.0))


def t_95(freedom: float) -> float:
    """Return the two-sided 95 % quantile of Student's t, accurate to 1 % from 3 degrees of freedom on.

    Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 26.7.5.
    """
    return 1.960 + 2.372 / freedom + 2.823 / freedom**2 + 2.556 / freedom**3


def _result(law: Law, x: Floats, f: Floats) -> Fit:
    """Return the fit of a law with its errors: the covariance of its parameters is s^2 (J^T J)^-1."""
    # of the rows in contact only: those before it may be many, and have less noise
    residual, slopes = law.residual(x, f)[x > law.contact], law.slopes(x - law.contact)
    rows, r, p = len(residual), _correlation(residual), len(law.free)
    count = independent_rows(rows, r)
    reach = t_95(max(count - p, 1.0)) * math.sqrt(rows / count)
    variance = float((residual**2).sum()) / max(rows - p, 1)
    scale = np.maximum(np.linalg.norm(slopes, axis=0), 1e-300)
    inverse = np.linalg.pinv(slopes / scale) / scale[:, None]
    covariance = variance * inverse @ inverse.T
    values = dict(zip(PARAMETERS, law.values.tolist(), strict=True))
    values["x0"] = min(values["x0"], float(x.max()) - law.contact)
    errors = dict(zip(law.free, np.sqrt(np.diag(covariance)).tolist(), strict=True))
    errors.setdefault("K2", errors["K1"])  # one slope
    K1, K2, x0, contact, tare = (
        Constant(value=value, error=errors.get(name, 0.0), half_width=reach * errors.get(name, 0.0))
        for name, value in values.items()
    )
    return Fit(
        model="two" if law.knee else "one", K1=K1, K2=K2, x0=x0, contact=contact, tare=tare, noise=math.sqrt(variance),
        correlation=r, full_scale=float(np.abs(f - tare.value).max()), rows=rows, fitted=law,
        spread=reach**2 * covariance,
    )  # fmt: skip
