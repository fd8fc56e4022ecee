"""A few frames stand for many, and how far off they are is what is said."""

import numpy as np
import pytest

from core.recording.basis import TURN, Basis, distinct, reduce
from core.recording.split import split


def travelling_dent(frames: int = 40, vertices: int = 300) -> np.ndarray:
    """Return samples of a line whose dent deepens and wanders."""
    x = np.linspace(0, 1, vertices)
    samples = np.zeros((frames, vertices, 3), np.float32)
    for frame, sample in enumerate(samples):
        share = frame / (frames - 1)
        sample[:, 0] = x
        sample[:, 2] = -0.2 * share * np.exp(-(((x - 0.3 - 0.3 * share) / 0.15) ** 2))
    return samples


def normals_of(samples: np.ndarray) -> np.ndarray:
    slope = np.gradient(samples[..., 2], axis=1) / np.gradient(samples[..., 0], axis=1)
    normals = np.stack([-slope, 0 * slope, 1 + 0 * slope], axis=-1)
    return (normals / np.linalg.norm(normals, axis=-1, keepdims=True)).astype(np.float32)


def played(samples: np.ndarray, basis: Basis) -> np.ndarray:
    return samples[0] + np.einsum("fk,kvc->fvc", basis.weights, samples[basis.chosen] - samples[0])


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
def test_no_vertex_and_no_normal_is_off_by_more_than_is_allowed(tolerance: float) -> None:
    samples = travelling_dent()
    normals = normals_of(samples)
    basis = reduce(samples, normals, tolerance)
    assert 0 < len(basis.chosen) < 25
    off = np.linalg.norm(played(samples, basis) - samples, axis=2).max()
    assert off == pytest.approx(basis.error, rel=0.01, abs=1e-7) and off <= tolerance * 1.001
    turned = played(normals, basis)
    turned = turned / np.linalg.norm(turned, axis=-1, keepdims=True)
    angle = np.arccos(np.clip((turned * normals).sum(-1), -1, 1)).max()
    assert angle <= basis.turn + 1e-4 <= 1.01 * TURN
    assert basis.weights.min() >= 0 and basis.weights.max() <= 1, "some programs cut off what is not"
    assert np.array_equal(basis.weights[basis.chosen], np.eye(len(basis.chosen))), "a chosen frame is exact"


def test_normals_ask_for_more_frames_than_places_alone() -> None:
    samples = travelling_dent()
    flat = np.zeros_like(samples) + np.float32([0, 0, 1])
    assert len(reduce(samples, normals_of(samples), 1e-2).chosen) > len(reduce(samples, flat, 1e-2).chosen)


def test_a_shape_that_only_grows_is_one_shape() -> None:
    samples = travelling_dent(2)[[0, 1, 0, 1]] * 1.0
    samples[1] = (samples[0] + samples[3]) / 2
    basis = reduce(samples, np.zeros_like(samples), 1e-6)
    assert basis.chosen == [3] and basis.weights[:, 0].tolist() == pytest.approx([0, 0.5, 0, 1])


def test_an_animation_that_stands_still_needs_no_shape() -> None:
    still = np.ones((5, 7, 3), np.float32)
    for basis in (reduce(still, still, 1.0), distinct(still)):
        assert basis.chosen == [] and basis.weights.shape == (5, 0) and basis.error == 0


def test_frames_that_are_alike_share_a_shape_and_those_like_the_first_need_none() -> None:
    samples = travelling_dent(3)[[0, 1, 2, 2, 0, 1]]
    basis = distinct(samples)
    assert basis.chosen == [1, 2] and np.array_equal(played(samples, basis), samples)


def test_a_vertex_is_split_where_its_normals_part_in_any_frame() -> None:
    corners = np.array([0, 1, 2, 2, 1, 3], np.int32)  # two triangles with a common edge
    normals = np.zeros((2, 6, 3), np.float32) + np.float32([0, 0, 1])
    begins, which = split(corners, normals)
    assert corners[begins].tolist() == [0, 1, 2, 3] and which.tolist() == [0, 1, 2, 2, 1, 3]
    normals[1, 4] = normals[1, 3] = (1, 0, 0)  # flat at first, bent later
    begins, which = split(corners, normals)
    assert corners[begins].tolist() == [0, 1, 1, 2, 2, 3]
    assert corners[begins][which].tolist() == corners.tolist() and which[1] != which[4]
