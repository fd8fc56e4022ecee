"""The psychometric function: how often a level is judged the stiffer, by maximum likelihood, with 95 % intervals.

    psi(x) = lapse + (1 - 2 lapse) Phi((x - m) / s)

m is the point of equality (PSE), and the just-noticeable difference (JND) is from there to where Phi is three quarters.
The lapses, answers at random, are as many on either side and at most MOST_LAPSES; a weak prior says that they are
rare, so the estimate is the maximum of the posterior. An interval holds each value whose posterior, the others fitted
anew, is within that of chi squared with one degree of freedom.

Source: Wichmann and Hill 2001, The psychometric function I; Schuett et al. 2016 for the prior; Venzon and Moolgavkar
1988 for the intervals.
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
MOST_LAPSES: Final = 0.12
LAPSES: Final = np.linspace(0.0, MOST_LAPSES, 13)
RARE: Final = 18.0  # the prior is (1 - lapse)^RARE: Beta(1, 10) for the lapses on each side
POINTS: Final = 33  # of a grid on each axis
ROUNDS: Final = 3  # of finer grids
HALVINGS: Final = 12  # of the steps of the last grid: the estimate is a 4,000th of one
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
        raise DimpleError("A point of equality needs {least} answers at two levels or more.", least=FEWEST)
    if not 0 < k.sum() < n.sum():
        raise DimpleError("All answers are alike: the levels do not reach the point of equality.")
    used = n > 0
    x, n, k = x[used], n[used], k[used]
    span = float(np.ptp(x))
    m_grid, s_grid = np.linspace(x.min() - span, x.max() + span, POINTS), np.geomspace(span / 200, 4 * span, POINTS)
    for number in range(ROUNDS):
        like = _posterior(x, n, k, m_grid, s_grid, LAPSES)
        if number == ROUNDS - 1:
            break
        m_grid = _finer(m_grid, like.max(axis=(1, 2)))
        s_grid = np.exp(_finer(np.log(s_grid), like.max(axis=(0, 2))))
    best = np.unravel_index(int(like.argmax()), like.shape)
    start = np.array([m_grid[best[0]], math.log(s_grid[best[1]]), LAPSES[best[2]]])
    steps = np.array([m_grid[1] - m_grid[0], math.log(s_grid[1] / s_grid[0]), LAPSES[1]])
    (m, log_s, lapse), top = _climb(x, n, k, start, steps)
    m_95 = _interval(m_grid, like.max(axis=(1, 2)), top)
    log_95 = _interval(np.log(s_grid), like.max(axis=(0, 2)), top)
    saturated = _binomial(k, n, k / n).sum()
    below = _binomial(k, n, shares(x, m, math.exp(log_s), lapse)).sum()
    return Psychometric(
        pse=float(m), jnd=QUARTER * math.exp(log_s), pse_95=m_95,
        jnd_95=(QUARTER * math.exp(log_95[0]), QUARTER * math.exp(log_95[1])),
        lapse=float(lapse), deviance=float(2 * (saturated - below)), trials=int(n.sum()),
    )  # fmt: skip


def _posterior(x: Floats, n: Floats, k: Floats, m: Floats, s: Floats, lapses: Floats) -> Floats:
    """Return the log of the posterior over places, spreads and lapses."""
    total = np.zeros((len(m), len(s), len(lapses))) + RARE * np.log1p(-lapses)
    for level, trials, count in zip(x, n, k, strict=True):
        below = shares(np.array(level), m[:, None], s[None, :], 0.0)[:, :, None]
        total += _binomial(count, trials, lapses + (1 - 2 * lapses) * below)
    return total


def _climb(x: Floats, n: Floats, k: Floats, at: Floats, steps: Floats) -> tuple[Floats, float]:
    """Return the place, log spread and lapse where the posterior is highest near a start, and how high.

    It goes to the best of the neighbours, all three at once for they trade for each other; steps are halved at a top.
    """
    high, halvings = -math.inf, 0
    while halvings < HALVINGS:
        m, log_s, lapses = (np.array([-1.0, 0.0, 1.0]) * step + c for c, step in zip(at, steps, strict=True))
        lapses = np.clip(lapses, 0.0, MOST_LAPSES)
        near = _posterior(x, n, k, m, np.exp(log_s), lapses)
        best = np.unravel_index(int(near.argmax()), near.shape)
        if near[best] > high:
            at, high = np.array([m[best[0]], log_s[best[1]], lapses[best[2]]]), float(near[best])
        else:
            steps, halvings = steps / 2, halvings + 1
    return at, high


def _binomial(k: Floats | float, n: Floats | float, p: Floats) -> Floats:
    p = np.clip(p, 1e-12, 1 - 1e-12)
    return np.asarray(k * np.log(p) + (np.asarray(n) - k) * np.log1p(-p))


def _finer(grid: Floats, profile: Floats) -> Floats:
    """Return a grid over what is within three times DROP of the best, a step more to each side."""
    near = np.flatnonzero(profile > profile.max() - 3 * DROP)
    first, last = max(near[0] - 1, 0), min(near[-1] + 1, len(grid) - 1)
    return np.linspace(grid[first], grid[last], len(grid))


def _interval(grid: Floats, profile: Floats, top: float) -> tuple[float, float]:
    """Return where a profile crosses top - DROP on either side of where it is highest."""
    i = int(profile.argmax())
    inside = profile > top - DROP
    low, high = -math.inf, math.inf
    below, above = np.flatnonzero(~inside[:i]), np.flatnonzero(~inside[i:])
    if len(below):
        low = _crossing(grid, profile, int(below[-1]), top - DROP)
    if len(above):
        high = _crossing(grid, profile, i + int(above[0]) - 1, top - DROP)
    return low, high


def _crossing(grid: Floats, profile: Floats, j: int, level: float) -> float:
    """Return where a profile crosses a level between two points."""
    a, b = profile[j], profile[j + 1]
    return float(grid[j] + (level - a) / (b - a) * (grid[j + 1] - grid[j]))
