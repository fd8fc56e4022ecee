"""Least squares between bounds."""

from __future__ import annotations

import numpy as np

from ..base import Floats

ROUNDS, SETTLED = 10, 1e-9  # steps an unknown at most, and a pull that is none


def bounded(matrix: Floats, wanted: Floats, low: Floats, high: Floats, damped: float) -> Floats:
    """Return y (m,) from low to high with the least |matrix y - wanted|^2 + |damped y|^2, by an active set."""
    normal, right = matrix.T @ matrix + damped**2 * np.eye(len(low)), matrix.T @ wanted
    y = np.clip(np.zeros_like(low), low, high)
    free = (low < y) & (y < high)
    for _ in range(ROUNDS * len(y)):
        whole = y.copy()
        whole[free] = np.linalg.solve(normal[np.ix_(free, free)], right[free] - normal[np.ix_(free, ~free)] @ y[~free])
        beyond = np.where(whole < low, low, np.where(whole > high, high, whole)) != whole
        if beyond.any():  # as far as the first bound
            way = whole - y
            room = np.where(beyond, (np.where(way < 0, low, high) - y) / np.where(beyond, way, 1.0), 1.0)
            first = int(room.argmin())
            y = np.clip(y + max(room[first], 0.0) * way, low, high)
            free[first] = False
            continue
        y, pull = whole, right - normal @ whole
        gain = np.where(free, 0.0, np.where(y <= low, pull, -pull)) * (low < high)
        if gain.max() <= SETTLED * np.abs(right).max():
            break
        free[gain.argmax()] = True
    return y
