"""The psychometric function: how often a level is judged the stiffer, by maximum likelihood, with 95 % intervals.

    psi(x) = lapse + (1 - 2 lapse) Phi((x - m) / s)

m is the point of equality (PSE), and the just-noticeable difference (JND) is from there to where Phi is three quarters.
The lapses, answers at random, are as many on either side and at most MOST_LAPSES. An interval holds each value whose
likelihood, the others fitted anew, is within that of chi squared with one degree of freedom.

Source: Wichmann and Hill 2001, The psychometric function I; Venzon and Moolgavkar 1988 for the intervals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ..base import Floats
from ..errors import DimpleError

QUARTER: Final = 0.674489750196082  # standard deviations from the middle to three quarters
DROP: Final = 1.920729410347062  # half of the 95 % quantile of chi squared
MOST_LAPSES: Final = 0.08
LAPSES: Final = np.linspace(0.0, MOST_LAPSES, 9)
FEW_LAPSES: Final = 9.0 * np.log1p(-LAPSES)  # a weak belief that they are rare; Source: Schuett et al. 2016
POINTS: Final = 33  # of a grid on each axis
ROUNDS: Final = 3  # of finer grids
FEWEST: Final = 20  # trials


@dataclass(frozen=True, slots=True, kw_only=True)
class Psychometric:
    """A fitted function.

    pse, jnd: estimates, with their 95 % intervals; an end that the answers leave open is inf, or 0.
    lapse: share of answers at random, on each side.
    deviance: of the fit from the answers, about as large as there are levels where it fits.
    trials: how many answers.
    """

    pse: float
    jnd: float
    pse_95: tuple[float, float]
    jnd_95: tuple[float, float]
    lapse: float
    deviance: float
    trials: int


_TABLE = np.linspace(-9.0, 9.0, 18_001)
_BELOW = np.array([0.5 * math.erfc(-z / math.sqrt(2.0)) for z in _TABLE])  # numpy has no erfc


def shares(x: Floats, m: Floats | float, s: Floats | float, lapse: Floats | float) -> Floats:
    """Return psi(x), broadcast; Phi within 1e-7."""
    below = np.interp((x - m) / s, _TABLE, _BELOW)
    return np.asarray(lapse + (1 - 2 * np.asarray(lapse)) * below)


def fit(levels: Sequence[float], stiffer: Sequence[int], trials: Sequence[int]) -> Psychometric:
    """Fit the function.

    Args:
        levels: (k,) of the test.
        stiffer: (k,) how often it was judged the stiffer.
        trials: (k,) of how many.

    Raises:
        DimpleError: too few answers, or all of them alike.
    """
    x, n, k = (np.asarray(a, np.float64) for a in (levels, trials, stiffer))
    if n.sum() < FEWEST or len(np.unique(x[n > 0])) < 2:
        raise DimpleError(f"A point of equality needs {FEWEST} answers at two levels or more.")
    if not 0 < k.sum() < n.sum():
        raise DimpleError("All answers are alike: the levels do not reach the point of equality.")
    used = n > 0
    x, n, k = x[used], n[used], k[used]
    span = float(np.ptp(x))
    m_grid, s_grid = np.linspace(x.min() - span, x.max() + span, POINTS), np.geomspace(span / 200, 4 * span, POINTS)
    for number in range(ROUNDS):
        like = _likelihood(x, n, k, m_grid, s_grid)
        best = np.unravel_index(int(like.argmax()), like.shape)
        lapse = float(LAPSES[best[2]])
        if number == ROUNDS - 1:
            break
        m_grid = _finer(m_grid, like.max(axis=(1, 2)))
        s_grid = np.exp(_finer(np.log(s_grid), like.max(axis=(0, 2))))
    top = float(like.max())
    m, m_95 = _profile(m_grid, like.max(axis=(1, 2)), top)
    log_s, log_95 = _profile(np.log(s_grid), like.max(axis=(0, 2)), top)
    saturated = _binomial(k, n, k / n).sum()
    return Psychometric(
        pse=m, jnd=QUARTER * math.exp(log_s), pse_95=m_95,
        jnd_95=(QUARTER * math.exp(log_95[0]), QUARTER * math.exp(log_95[1])),
        lapse=lapse, deviance=float(2 * (saturated - top)), trials=int(n.sum()),
    )  # fmt: skip


def _likelihood(x: Floats, n: Floats, k: Floats, m: Floats, s: Floats) -> Floats:
    """Return the log likelihoods over places, spreads and lapses."""
    total = np.zeros((len(m), len(s), len(LAPSES))) + FEW_LAPSES
    for level, trials, count in zip(x, n, k, strict=True):
        below = shares(np.array(level), m[:, None], s[None, :], 0.0)[:, :, None]
        total += _binomial(count, trials, LAPSES + (1 - 2 * LAPSES) * below)
    return total


def _binomial(k: Floats | float, n: Floats | float, p: Floats) -> Floats:
    p = np.clip(p, 1e-12, 1 - 1e-12)
    return np.asarray(k * np.log(p) + (np.asarray(n) - k) * np.log1p(-p))


def _finer(grid: Floats, profile: Floats) -> Floats:
    """Return a grid over what is within three times DROP of the best, a step more to each side."""
    near = np.flatnonzero(profile > profile.max() - 3 * DROP)
    first, last = max(near[0] - 1, 0), min(near[-1] + 1, len(grid) - 1)
    return np.linspace(grid[first], grid[last], len(grid))


def _profile(grid: Floats, profile: Floats, top: float) -> tuple[float, tuple[float, float]]:
    """Return where a profile is highest, by the parabola through three points, and where it crosses top - DROP."""
    i = int(profile.argmax())
    at = float(grid[i])
    if 0 < i < len(grid) - 1:
        a, b, c = profile[i - 1 : i + 2]
        if a - 2 * b + c < 0:
            at += float(0.5 * (a - c) / (a - 2 * b + c) * (grid[1] - grid[0]))
    inside = profile > top - DROP
    low, high = -math.inf, math.inf
    below, above = np.flatnonzero(~inside[:i]), np.flatnonzero(~inside[i:])
    if len(below):
        low = _crossing(grid, profile, int(below[-1]), top - DROP)
    if len(above):
        high = _crossing(grid, profile, i + int(above[0]) - 1, top - DROP)
    return at, (low, high)


def _crossing(grid: Floats, profile: Floats, j: int, level: float) -> float:
    """Return where a profile crosses a level between two points."""
    a, b = profile[j], profile[j + 1]
    return float(grid[j] + (level - a) / (b - a) * (grid[j + 1] - grid[j]))
