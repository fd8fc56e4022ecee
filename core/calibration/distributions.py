"""Student's t and Fisher's F, from the incomplete beta function: numpy has neither."""

from __future__ import annotations

import math

_TINY = 1e-300
_STEPS = 500
_FINE = 1e-12


def beta_share(a: float, b: float, x: float) -> float:
    """Return the regularised incomplete beta function I_x(a, b).

    Its continued fraction by Lentz's method. Source: Numerical Recipes, 6.4.
    """
    if x <= 0 or x >= 1:
        return float(x >= 1)
    if x > (a + 1) / (a + b + 2):  # the fraction converges fast below
        return 1 - beta_share(b, a, 1 - x)
    front = math.exp(
        a * math.log(x) + b * math.log1p(-x) + math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b)
    ) / a  # fmt: skip
    c, d = 1.0, 1 / _away(1 - (a + b) * x / (a + 1))
    value = d
    for m in range(1, _STEPS):
        for term in (
            m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)),
        ):
            d = 1 / _away(1 + term * d)
            c = _away(1 + term / c)
            value *= d * c
        if abs(d * c - 1) < 1e-15:
            break
    return front * value


def t_quantile(p: float, freedom: float) -> float:
    """Return the t that a Student's variable of so many degrees of freedom stays below with probability p > 0.5."""
    low, high = 0.0, 1.0
    while _t_below(high, freedom) < p:
        high *= 2
    while high - low > _FINE * high:
        middle = (low + high) / 2
        low, high = (middle, high) if _t_below(middle, freedom) < p else (low, middle)
    return (low + high) / 2


def f_above(f: float, freedom_above: float, freedom_below: float) -> float:
    """Return the probability of an F ratio greater than f."""
    if f <= 0:
        return 1.0
    return beta_share(freedom_below / 2, freedom_above / 2, freedom_below / (freedom_below + freedom_above * f))


def _t_below(t: float, freedom: float) -> float:
    return 1 - beta_share(freedom / 2, 0.5, freedom / (freedom + t * t)) / 2


def _away(x: float) -> float:
    return x if abs(x) > _TINY else _TINY
