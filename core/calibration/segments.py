"""Least squares of two straight pieces that meet, exactly: no start, no grid, no iteration.

For each parting of the rows into left and right both pieces are free lines in closed form. Where they meet between
the two rows at the parting, that is the optimum of the parting; where they do not, its optimum has the join at a row.
The best over all partings is the global one. Source: Hudson, Fitting segmented curves whose join points have to be
estimated, J. Am. Stat. Assoc. 61 (1966).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Floats, Ints

MIN_PIECE = 3  # rows and distinct depths in a piece
_FINALISTS = 8  # running sums leave rounding: the best few are computed again row by row


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
    joins = _candidates(u, v, left)
    if not len(joins):
        return None
    residuals = _residuals(u, v, joins, left, rising)
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


def _candidates(x: Floats, y: Floats, left: str) -> Floats:
    """Return every join that may be the best: at a row, or where the two free pieces of a parting meet."""
    n = len(x)
    distinct = np.cumsum(np.concatenate([[1], np.diff(x) > 0]))
    enough = np.arange(n) >= MIN_PIECE - 1
    after = np.arange(n) < n - MIN_PIECE
    allowed = enough & after & (distinct >= MIN_PIECE) & (distinct[-1] - distinct >= MIN_PIECE)
    split = np.flatnonzero(allowed)  # the last row of the left piece
    split = split[x[split + 1] > x[split]] if len(split) else split
    if not len(split):
        return np.zeros(0)
    a1, b1 = _left_line(x, y, split, left)
    a2, b2 = _right_line(x, y, split)
    with np.errstate(divide="ignore", invalid="ignore"):
        join = (a1 - a2) / (b2 - b1)
    meets = (join > x[split]) & (join < x[split + 1])
    return np.unique(np.concatenate([join[meets], x[split], x[split + 1]]))


def _left_line(x: Floats, y: Floats, split: Ints, left: str) -> tuple[Floats, Floats]:
    if left == "origin":
        return np.zeros(len(split)), np.cumsum(x * y)[split] / np.maximum(np.cumsum(x * x)[split], 1e-300)
    return _line(x, y, split)


def _right_line(x: Floats, y: Floats, split: Ints) -> tuple[Floats, Floats]:
    return _line(x[::-1], y[::-1], len(x) - 2 - split)


def _line(x: Floats, y: Floats, last: Ints) -> tuple[Floats, Floats]:
    """Return intercepts and slopes of the lines through rows 0 to last, for each last."""
    cx, cy = x.mean(), y.mean()
    dx, dy, n = x - cx, y - cy, last + 1
    sx, sy = np.cumsum(dx)[last], np.cumsum(dy)[last]
    sxx, sxy = np.cumsum(dx * dx)[last] - sx * sx / n, np.cumsum(dx * dy)[last] - sx * sy / n
    slope = sxy / np.maximum(sxx, 1e-300)
    return cy + sy / n - slope * (cx + sx / n), slope


def _residuals(x: Floats, y: Floats, joins: Floats, left: str, rising: bool) -> Floats:
    """Return the sum of squared residuals for each join, from running sums: cheap, and good to pick the best."""
    at = np.searchsorted(x, joins, side="right")
    n = len(x)

    def before(values: Floats) -> Floats:
        return np.concatenate([[0.0], np.cumsum(values)])[at]

    cx, cy, cxx, cxy = before(x), before(y), before(x * x), before(x * y)
    tx, ty, txx, txy = x.sum() - cx, y.sum() - cy, (x * x).sum() - cxx, (x * y).sum() - cxy
    right = n - at
    # columns min(x, j) and max(x - j, 0), and 1 where there is an offset
    aa, bb = cxx + joins**2 * right, txx - 2 * joins * tx + joins**2 * right
    ab = joins * (tx - joins * right)
    ya, yb = cxy + joins * ty, txy - joins * ty
    a1, b1, y1 = cx + joins * right, tx - joins * right, np.full(len(joins), y.sum())
    if left == "origin":
        rows = np.stack([np.stack([aa, ab], -1), np.stack([ab, bb], -1)], -2)
        rhs = np.stack([ya, yb], -1)
    else:
        one = np.full(len(joins), float(n))
        rows = np.stack([np.stack([one, a1, b1], -1), np.stack([a1, aa, ab], -1), np.stack([b1, ab, bb], -1)], -2)
        rhs = np.stack([y1, ya, yb], -1)
    rows = rows + 1e-15 * np.trace(rows, axis1=-2, axis2=-1)[:, None, None] * np.eye(rows.shape[-1])
    solution = np.linalg.solve(rows, rhs[..., None])[..., 0]
    total = (y * y).sum() - (solution * rhs).sum(axis=-1)
    slopes = solution if left == "origin" else solution[:, 1:]
    return np.where(slopes.min(axis=1) > 0, total, np.inf) if rising else np.asarray(total)


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
