"""The law of Eq. (1), and least squares of two straight pieces that meet, exactly: no start, no grid, no iteration.

For each parting of the rows into left and right both pieces are free lines in closed form. Where they meet between
the two rows at the parting, that is the optimum of the parting; where they do not, its optimum has the join at a row.
The best over all partings is the global one. Source: Hudson, Fitting segmented curves whose join points have to be
estimated, J. Am. Stat. Assoc. 61 (1966).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..base import Floats

PARAMETERS = ("K1", "K2", "x0", "contact", "tare")
MIN_PIECE = 3  # rows and distinct depths in a piece
_FINALISTS = 8  # running sums leave rounding: the best few are computed again row by row


@dataclass(frozen=True, slots=True)
class Law:
    """Eq. (1) with a touch and a tare, and which of its parameters are fitted.

    values: K1 [N/m], K2 [N/m], x0 [m], contact [m], tare [N]; with one slope K2 is K1, and x0 is infinite.
    free: the names of those that are fitted.
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

    def moved(self, step: Floats) -> Law:
        """Return the law with a step (p,) of its free parameters added."""
        values = self.values.copy()
        values[[PARAMETERS.index(name) for name in self.free]] += step
        if not self.knee:
            values[1] = values[0]
        return replace(self, values=values)

    def force(self, x: Floats) -> Floats:
        """Return K(x) of Eq. (1), (n,) [N], at depths (n,) below the contact [m]."""
        K1, K2, x0 = self.values[:3]
        x = np.maximum(x, 0)
        return np.asarray(K1 * np.minimum(x, x0) + K2 * np.maximum(x - x0, 0))

    def slopes(self, x: Floats) -> Floats:
        """Return the slopes (n, p) of the force in each free parameter at depths (n,) below the contact [m]."""
        K1, K2, x0 = self.values[:3]
        y, beyond = np.maximum(x, 0), x > x0
        contact = -np.where(beyond, K2, K1) * (x > 0)
        columns = (np.minimum(y, x0), np.maximum(y - x0, 0), (K1 - K2) * beyond, contact, np.ones_like(x))
        return np.stack([columns[PARAMETERS.index(name)] for name in self.free], axis=1)

    def residual(self, x: Floats, f: Floats) -> Floats:
        """Return how far forces (n,) [N] at depths (n,) [m] are above the law and the tare, (n,) [N]."""
        return np.asarray(f - self.values[4] - self.force(x - self.contact))

    def pressed_residual(self, x: Floats, f: Floats) -> Floats:
        """Return the residuals of the rows in contact: those before it may be many, and quieter."""
        return self.residual(x, f)[x > self.contact]

    def squares(self, x: Floats, f: Floats) -> float:
        """Return the sum of the squared residuals [N2]."""
        return float((self.residual(x, f) ** 2).sum())


@dataclass(frozen=True, slots=True, kw_only=True)
class Pieces:
    """Two straight pieces, y = offset + slope1 min(x, join) + slope2 max(x - join, 0).

    offset: y at x = 0.
    slope1: of the first piece.
    slope2: of the second piece.
    join: x where they meet.
    residual: sum of squared residuals.
    """

    offset: float
    slope1: float
    slope2: float
    join: float
    residual: float


def two_pieces(x: Floats, y: Floats, *, left: str, rising: bool = False) -> Pieces | None:
    """Fit two pieces.

    Args:
        x, y: (n,) in any order.
        left: the first piece: "origin" (a line through 0, 0) or "line" (any line).
        rising: take the best of those whose pieces both rise.

    Returns:
        the best pieces, or None where there are too few rows or none that rise.
    """
    order = np.argsort(x, kind="stable")
    x, y = np.asarray(x, np.float64)[order], np.asarray(y, np.float64)[order]
    scale_x, scale_y = np.abs(x).max(initial=0) or 1.0, np.abs(y).max(initial=0) or 1.0
    u, v = x / scale_x, y / scale_y
    before, after = _moments(u, v)
    joins = _candidates(u, before, after, left)
    if not len(joins):
        return None
    residuals = _residuals(u, before, after, joins, left, rising)
    nearly_best = joins[np.argsort(residuals, kind="stable")[:_FINALISTS]]
    if np.isinf(residuals).all():
        return None
    best = min((_solve(u, v, float(join), left) for join in nearly_best), key=lambda pieces: pieces.residual)
    return Pieces(
        offset=best.offset * scale_y, slope1=best.slope1 * scale_y / scale_x, slope2=best.slope2 * scale_y / scale_x,
        join=best.join * scale_x, residual=best.residual * scale_y**2,
    )  # fmt: skip


def slope_of(x: Floats, y: Floats) -> tuple[float, float]:
    """Return the slope of the line through rows (n,), and its standard error."""
    centred = x - x.mean()
    squares = float(centred @ centred)
    slope = float(centred @ y) / squares
    residual = y - y.mean() - slope * centred
    return slope, float(np.sqrt(residual @ residual / max(len(x) - 2, 1) / squares))


def _moments(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the sums (n + 1, 3, 3) of products of (x, 1, y) over the rows before each parting, and after it."""
    rows = np.stack([x, np.ones_like(x), y], axis=1)
    products, none = rows[:, :, None] * rows[:, None, :], np.zeros((1, 3, 3))
    before, after = (np.concatenate([none, np.cumsum(each, axis=0)]) for each in (products, products[::-1]))
    return before, after[::-1]


def _candidates(x: Floats, before: Floats, after: Floats, left: str) -> Floats:
    """Return every join that may be the best: at a row, or where the two free pieces of a parting meet."""
    distinct = np.cumsum(np.concatenate([[1], np.diff(x) > 0]))
    parting = np.arange(MIN_PIECE, len(x) - MIN_PIECE + 1)  # rows of the left piece
    many = (distinct[parting - 1] >= MIN_PIECE) & (distinct[-1] - distinct[parting - 1] >= MIN_PIECE)
    parting = parting[many & (x[parting] > x[parting - 1])]
    (a1, b1), (a2, b2) = _line(before[parting], left), _line(after[parting], "line")
    with np.errstate(divide="ignore", invalid="ignore"):
        join = (a1 - a2) / (b2 - b1)
    meets = (join > x[parting - 1]) & (join < x[parting])
    return np.unique(np.concatenate([join[meets], x[parting - 1], x[parting]]))


def _line(moments: Floats, left: str) -> tuple[Floats, Floats]:
    """Return offsets and slopes of the lines with moments (m, 3, 3): through 0, 0, or any."""
    xx, x, xy = moments[:, 0, 0], moments[:, 0, 1], moments[:, 0, 2]
    n, y = moments[:, 1, 1], moments[:, 1, 2]
    if left == "origin":
        return np.zeros(len(n)), xy / np.maximum(xx, 1e-300)
    slope = (xy - x * y / n) / np.maximum(xx - x * x / n, 1e-300)
    return (y - slope * x) / n, slope


def _residuals(x: Floats, before: Floats, after: Floats, joins: Floats, left: str, rising: bool) -> Floats:
    """Return the sum of squared residuals for each join, from running sums: cheap, and good to pick the best."""
    at = np.searchsorted(x, joins, side="right")
    # min(x, join), max(x - join, 0), 1 and y of the rows on either side, by x, 1 and y
    near, far = (np.zeros((len(joins), 4, 3)) for _ in range(2))
    near[:, 0, 0] = far[:, 1, 0] = near[:, 2, 1] = far[:, 2, 1] = near[:, 3, 2] = far[:, 3, 2] = 1
    far[:, 0, 1], far[:, 1, 1] = joins, -joins
    sums = near @ before[at] @ near.swapaxes(1, 2) + far @ after[at] @ far.swapaxes(1, 2)
    terms = 2 if left == "origin" else 3
    normal, rhs = sums[:, :terms, :terms], sums[:, :terms, 3]
    normal = normal + 1e-15 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(terms)
    solution = np.linalg.solve(normal, rhs[..., None])[..., 0]
    total = sums[:, 3, 3] - (solution * rhs).sum(axis=1)
    return np.where(solution[:, :2].min(axis=1) > 0, total, np.inf) if rising else np.asarray(total)


def _solve(x: Floats, y: Floats, join: float, left: str) -> Pieces:
    """Solve for the rest at a given join, which is linear."""
    columns = [np.maximum(x - join, 0), np.minimum(x, join)]
    if left != "origin":
        columns.append(np.ones_like(x))
    design = np.stack(columns, axis=1)
    solution, *_ = np.linalg.lstsq(design, y, rcond=None)
    return Pieces(
        offset=float(solution[-1]) if left != "origin" else 0.0,
        slope1=float(solution[1]),
        slope2=float(solution[0]), join=join, residual=float(((y - design @ solution) ** 2).sum()),
    )  # fmt: skip
