"""A press to write down in the ways of instruments: Object 2 of Table 2, with 1 % of noise."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest


class Curve(NamedTuple):
    """Depth [mm] and force [N] of a press, and the constants behind it [N/mm], [mm]."""

    depth: np.ndarray
    force: np.ndarray
    K1: float = 0.61
    K2: float = 7.23
    x0: float = 16.3


@pytest.fixture
def curve() -> Curve:
    return make_curve()


def make_curve(*, rows: int = 200, approach: float = 0.0, noise: float = 0.01, seed: int = 0) -> Curve:
    """Return a press to 22 mm, from `approach` mm before the touch."""
    depth = np.linspace(-approach, 22.0, rows)
    inside = np.maximum(depth, 0)
    force = 0.61 * np.minimum(inside, 16.3) + 7.23 * np.maximum(inside - 16.3, 0)
    return Curve(depth, force + noise * force.max() * np.random.default_rng(seed).normal(size=rows))


@pytest.fixture
def make() -> Callable[..., Curve]:
    return make_curve


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    def write_file(content: str | bytes, encoding: str = "utf-8", name: str = "press.csv") -> Path:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        return path

    return write_file
