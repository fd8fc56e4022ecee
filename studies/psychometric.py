"""The psychometric function: how often a level is judged the stiffer, by maximum likelihood, with 95 % intervals.

    psi(x) = lapse + (1 - 2 lapse) Phi((x - m) / s)

m is the point of equality (PSE), and the just-noticeable difference (JND) is from there to where Phi is three quarters.
The lapses, answers at random, are equally frequent on both sides; a weak prior says that they are rare, so the
estimate is the maximum of the posterior, found on a grid that is narrowed around it and never leaves its first box. An
interval holds each value whose posterior, maximised over the other parameters, is within that of chi squared with one
degree of freedom.

Source: Wichmann and Hill 2001, The psychometric function I; Schuett et al. 2016 for the prior; Venzon and Moolgavkar
1988 for the intervals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Final

import numpy as np

from core.base import DimpleError, Floats

QUARTER: Final = NormalDist().inv_cdf(0.75)  # standard deviations from the middle to three quarters
DROP: Final = NormalDist().inv_cdf(0.975) ** 2 / 2  # half of the 95 % quantile of chi squared
MOST_LAPSES: Final = 0.12  # share of answers on each side: who answers more of them at random is not judging
RARE: Final = 18.0  # the prior is (1 - lapse)^RARE: Beta(1, 10) for the lapses on each side
FEWEST: Final = 20  # trials: with fewer, the interval of the JND is as wide as the range of the levels
POINTS: Final = (33, 33, 13)  # of the grid of m, log s and lapse: about ten to an interval once it is narrowed
SPANS: Final = (3.0, 3.0, 3.0, 0.3, 0.03)  # DROPs within which each grid lies: the third gives the intervals
_ERF: Final = np.vectorize(math.erf, otypes=[np.float64])  # numpy has none


@dataclass(frozen=True, slots=True, kw_only=True)
class Psychometric:
    """A fitted function.

    pse, jnd: estimates, with their 95 % intervals; an end that the answers leave open is inf, or 0.
    lapse: share of answers at random, on each side.
    deviance: of the fit from the answers, about as large as the number of levels where it fits.
    trials: number of answers.
    """

    pse: float
    jnd: float
    pse_95: tuple[float, float]
    jnd_95: tuple[float, float]
    lapse: float
    deviance: float
    trials: int


def shares(x: Floats, m: Floats | float, s: Floats | float, lapse: Floats | float) -> Floats:
    """Return psi(x), broadcast."""
    return np.asarray(lapse + (1 - 2 * np.asarray(lapse)) * (1 + _ERF((x - m) / (s * math.sqrt(2)))) / 2)


def fit(levels: Sequence[float], stiffer: Sequence[int], trials: Sequence[int]) -> Psychometric:
    """Fit the function.

    Args:
        levels: (k,) of the test.
        stiffer: (k,) how often it was judged the stiffer.
        trials: (k,) of how many, 1 or more.

    Raises:
        DimpleError: too few answers, answers that do not rise with the level, or a point of equality beyond the levels.
    """
    x, n, k = (np.asarray(a, np.float64) for a in (levels, trials, stiffer))
    if n.sum() < FEWEST or len(x) < 2:
        raise DimpleError("A point of equality needs {least} answers at two levels or more.", least=FEWEST)
    if not 0 < k.sum() < n.sum():
        raise DimpleError("All answers are alike: the levels do not reach the point of equality.")
    span = float(np.ptp(x))
    box = (x.min() - span, x.max() + span), (math.log(span / 200), math.log(4 * span)), (0.0, MOST_LAPSES)
    grids = [np.linspace(*ends, count) for ends, count in zip(box, POINTS, strict=True)]
    profiles, intervals = [np.zeros(count) for count in POINTS], [(0.0, 0.0)] * 3
    for number, drops in enumerate(SPANS):
        grids = [_narrowed(grid, profile, drops * DROP) for grid, profile in zip(grids, profiles, strict=True)]
        posterior = _posterior(x, n, k, *grids)
        profiles = [posterior.max(axis=tuple({0, 1, 2} - {axis})) for axis in range(3)]
        if number == 2:
            intervals = [_interval(*each) for each in zip(grids, profiles, strict=True)]
    m, log_s, lapse = (float(grid[profile.argmax()]) for grid, profile in zip(grids, profiles, strict=True))
    fitted = _binomial(k, n, shares(x, m, math.exp(log_s), lapse)).sum()
    if fitted - _binomial(k, n, np.asarray(k.sum() / n.sum())).sum() < DROP:
        raise DimpleError("The answers do not rise with the stiffness, so they have no point of equality.")
    if not x.min() <= m <= x.max():
        raise DimpleError("The levels do not reach the point of equality.")
    low, high = intervals[1]
    return Psychometric(
        pse=m, jnd=QUARTER * math.exp(log_s), pse_95=intervals[0],
        jnd_95=(QUARTER * math.exp(low), QUARTER * math.exp(high)), lapse=lapse,
        deviance=float(2 * (_binomial(k, n, k / n).sum() - fitted)), trials=int(n.sum()),
    )  # fmt: skip


def _posterior(x: Floats, n: Floats, k: Floats, m: Floats, log_s: Floats, lapses: Floats) -> Floats:
    """Return the log of the posterior over places, spreads and lapses."""
    total = np.zeros((len(m), len(log_s), len(lapses))) + RARE * np.log1p(-lapses)
    for level, trials, count in zip(x, n, k, strict=True):
        below = shares(np.array(level), m[:, None], np.exp(log_s), 0.0)[:, :, None]
        total += _binomial(count, trials, lapses + (1 - 2 * lapses) * below)
    return total


def _binomial(k: Floats | float, n: Floats | float, p: Floats) -> Floats:
    p = np.clip(p, 1e-12, 1 - 1e-12)
    return np.asarray(k * np.log(p) + (np.asarray(n) - k) * np.log1p(-p))


def _narrowed(grid: Floats, profile: Floats, drop: float) -> Floats:
    """Return a grid over the points that are within a drop of the best, and one point more on each side."""
    near = np.flatnonzero(profile > profile.max() - drop)
    return np.linspace(grid[max(near[0] - 1, 0)], grid[min(near[-1] + 1, len(grid) - 1)], len(grid))


def _interval(grid: Floats, profile: Floats) -> tuple[float, float]:
    """Return where a profile is DROP below its highest point, on either side of it; infinite where it never is."""
    top, edge = int(profile.argmax()), profile.max() - DROP
    low, high = -math.inf, math.inf
    if len(below := np.flatnonzero(profile[:top] <= edge)):
        at = below[-1]
        low = float(np.interp(edge, profile[at : at + 2], grid[at : at + 2]))
    if len(above := np.flatnonzero(profile[top:] <= edge)):
        at = top + above[0]
        high = float(np.interp(edge, profile[[at, at - 1]], grid[[at, at - 1]]))
    return low, high
