"""What is fitted: the constants of Eq. (1) with touch and tare, what they leave over, and their slopes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Floats

Free = tuple[str, ...]  # of "contact" and "tare", in this order


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """What is fitted: K1; K2 and x0 where there is a knee; then contact and tare where they are free.

    knee: whether there is one.
    free: of "contact" and "tare".
    values: (p,) [N/m], [N/m], [m], [m], [N].
    """

    knee: bool
    free: Free
    values: Floats

    def parts(self, x: Floats) -> tuple[float, float, float, float, float]:
        """Return K1, K2, x0, contact, tare."""
        v = [float(value) for value in self.values]
        known = {"contact": 0.0, "tare": 0.0} | dict(zip(self.free, v[3 if self.knee else 1 :], strict=True))
        contact, tare = known["contact"], known["tare"]
        return (v[0], v[1], v[2], contact, tare) if self.knee else (v[0], v[0], float(x.max()) - contact, contact, tare)

    def index(self, name: str) -> int | None:
        """Return where the values hold "contact" or "tare", None where it is known."""
        return len(self.values) - len(self.free) + self.free.index(name) if name in self.free else None


def law(x: Floats, K1: float, K2: float, x0: float) -> Floats:
    """Return K(x) of Eq. (1), (n,) [N], at depths (n,) [m]."""
    x = np.maximum(x, 0)
    return K1 * np.minimum(x, x0) + K2 * np.maximum(x - x0, 0)


def residual_of(parameters: Parameters, x: Floats, f: Floats) -> Floats:
    """Return how far forces (n,) [N] at depths (n,) [m] are above the law and the tare, (n,) [N]."""
    K1, K2, x0, contact, tare = parameters.parts(x)
    return f - tare - law(x - contact, K1, K2, x0)


def jacobian_of(parameters: Parameters, x: Floats) -> Floats:
    """Return the slopes (n, p) of the law in each parameter."""
    K1, K2, x0, contact, _ = parameters.parts(x)
    y = np.maximum(x - contact, 0)
    beyond = y > x0
    columns = [np.minimum(y, x0), np.maximum(y - x0, 0), (K1 - K2) * beyond] if parameters.knee else [y]
    of = {"contact": -np.where(beyond, K2, K1) * (y > 0), "tare": np.ones_like(x)}
    columns += [of[name] for name in parameters.free]
    return np.stack([np.asarray(column, np.float64) for column in columns], axis=1)


def sum_of_squares(parameters: Parameters, x: Floats, f: Floats) -> float:
    """Return the sum of the squared residuals [N2]."""
    return float((residual_of(parameters, x, f) ** 2).sum())


def pressed_residual(parameters: Parameters, x: Floats, f: Floats) -> Floats:
    """Return the residuals of the rows in contact: those before it may be many, and quieter."""
    return residual_of(parameters, x, f)[x > parameters.parts(x)[3]]
