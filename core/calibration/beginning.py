"""How a stroke begins: in the air, or in contact at its first row."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base import Floats
from .strokes import roughness
from .table import MIN_ROWS
from .two_pieces import MIN_PIECE, slope_of, two_pieces

SURE = 3.0  # standard errors: by chance once in 400 files
FIRST = 0.1  # of the range of force: what a press begins with, far from any knee
_TOUCHES = 80  # that are tried along the depth, and then between
_ENOUGH = 1000  # rows to compare touches by


@dataclass(frozen=True, slots=True)
class Beginning:
    """How a stroke begins: up to a touch, the first row or one after air, its force is level; then it rises.

    rows: number of rows from which this is known.
    touch: [m].
    force: at the touch [N].
    error: standard error of that [N].
    slope: from there on, on average [N/m].
    squares: sum of squared residuals [N2].
    """

    rows: int
    touch: float
    force: float
    error: float
    slope: float
    squares: float


def beginning(x: Floats, f: Floats) -> Beginning:
    """Return how a stroke begins where its first row is in contact."""
    rows = _first_rows(f)
    return rising_from(x[:rows], f[:rows], float(x[0]))


def _first_rows(f: Floats) -> int:
    """Return how many rows a stroke begins with before its force has risen for good."""
    rest = float(np.median(f[: max(3, len(f) // 50)]))
    above = f > rest + max(FIRST * (f.max() - rest), SURE * roughness(f))
    three = above[:-2] & above[1:-1] & above[2:]
    return max(int(three.argmax()) if three.any() else len(f), min(MIN_ROWS, len(f) // 2))


def rising_from(x: Floats, f: Floats, touch: float) -> Beginning:
    """Return the beginning with a given touch: after it the force is straight, or bent where that is likelier."""
    u = np.maximum(x - touch, 0) / max(float(np.ptp(x)), 1e-300)
    slope = float(np.polyfit(x, f, 1, w=(u > 0) + 1e-9)[0]) if np.ptp(u) > 0 else 0.0
    found, least = None, math.inf
    for terms in (2, 3):
        design = u[:, None] ** np.arange(terms)
        solution = np.linalg.lstsq(design, f, rcond=None)[0]
        squares = max(float(((f - design @ solution) ** 2).sum()), 1e-300)
        criterion = len(f) * math.log(squares) + terms * math.log(len(f))
        if criterion < least:
            variance = squares / max(len(f) - terms, 1) * np.linalg.pinv(design.T @ design)[0, 0]
            found, least = Beginning(len(f), touch, float(solution[0]), math.sqrt(variance), slope, squares), criterion
    assert found is not None
    return found


def touch_after_air(x: Floats, f: Floats, noise: float, squares: Callable[..., float]) -> float | None:
    """Return the touch [m] with level rows before it that leaves the least squares, None where there is none."""
    step = -(-len(x) // _ENOUGH)
    u, v = x[::step], f[::step]

    def loss(touch: float) -> float:
        before = u < touch
        if len(np.unique(u[before])) < MIN_PIECE or not _is_air(u[before], v[before], noise):
            return math.inf
        return squares(u, v, touch)

    width = float(np.ptp(x)) / _TOUCHES
    best = min((x[0] + width * np.arange(1, _TOUCHES)).tolist(), key=loss)
    for _ in range(3):
        best = min((best + width * np.linspace(-1, 1, 9)).tolist(), key=loss)
        width /= 4
    return None if math.isinf(loss(best)) else best


def squares_of_law(x: Floats, f: Floats, touch: float) -> float:
    """Return the sum of squared residuals of a level force before the touch and two rising pieces after it."""
    before = x < touch
    tare = float(f[before].mean())
    pieces = two_pieces(x[~before] - touch, f[~before] - tare, left="origin", rising=True)
    return float(((f[before] - tare) ** 2).sum()) + (pieces.residual if pieces else math.inf)


def _is_air(x: Floats, f: Floats, noise: float) -> bool:
    """Return whether a force does not rise by more than chance, or by more than its noise."""
    slope, error = slope_of(x, f)
    return slope < SURE * error or slope * float(np.ptp(x)) < noise
