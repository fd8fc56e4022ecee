"""A few shapes stand for many frames, and how far off they are is what is said."""

import numpy as np
import pytest

from core.recording.basis import Basis, reduce


def travelling_dent(frames: int = 40, vertices: int = 300) -> np.ndarray:
    """Return samples of a line whose dent deepens and wanders."""
    x = np.linspace(0, 1, vertices)
    samples = np.zeros((frames, vertices, 3), np.float32)
    for frame, sample in enumerate(samples):
        share = frame / (frames - 1)
        sample[:, 0] = x
        sample[:, 2] = -0.2 * share * np.exp(-(((x - 0.3 - 0.3 * share) / 0.15) ** 2))
    return samples


def played(samples: np.ndarray, basis: Basis) -> np.ndarray:
    return samples[0] + np.einsum("fk,kvc->fvc", basis.weights, basis.shapes)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4])
def test_no_vertex_is_off_by_more_than_the_tolerance_and_one_shape_less_would_not_do(tolerance: float) -> None:
    samples = travelling_dent()
    basis = reduce(samples, tolerance)
    off = np.linalg.norm(played(samples, basis) - samples, axis=2).max()
    assert off == pytest.approx(basis.error, rel=0.01, abs=1e-7) and off <= tolerance * 1.001
    assert np.abs(basis.weights).max() <= 1 + 1e-6
    fewer = Basis(basis.shapes[:-1], basis.weights[:, :-1], 0.0)
    assert np.linalg.norm(played(samples, fewer) - samples, axis=2).max() > tolerance


def test_a_shape_that_only_grows_is_one_shape() -> None:
    samples = travelling_dent(2)[[0, 1, 0, 1]] * 1.0
    samples[1] = (samples[0] + samples[3]) / 2
    assert reduce(samples, 1e-6).shapes.shape == (1, 300, 3)


def test_an_animation_that_stands_still_needs_no_shape() -> None:
    basis = reduce(np.ones((5, 7, 3), np.float32), 0.0)
    assert basis.shapes.shape == (0, 7, 3) and basis.weights.shape == (5, 0) and basis.error == 0
