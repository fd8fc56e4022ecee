"""The rotation nearest to a matrix: the quaternion in C against numpy's singular values."""

import numpy as np
import pytest

from core import native
from core.base import Floats
from core.body.shape_matching import fit_pose


def rotation_of(h: Floats) -> Floats:
    """Return the best rotation for h = sum of w x q^T, as the native core finds it."""
    r = np.empty((3, 3))
    h = np.ascontiguousarray(h)
    assert native.library().dm_fit_rotation(h.ctypes.data, r.ctypes.data) == 0
    return r


def random_rotation(rng: np.random.Generator) -> Floats:
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


# bodies, flat, straight and mirrored: the singular values of h
SHAPES = {"body": (3, 2, 1), "ball": (1, 1, 1), "flat": (3, 2, 0), "disc": (2, 2, 0), "nearly flat": (3, 2, 1e-9)}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_the_rotation_is_that_of_the_singular_value_decomposition(name: str, scale: float) -> None:
    rng = np.random.default_rng(5)
    for _ in range(50):
        turn, axes = random_rotation(rng), random_rotation(rng)
        h = scale * turn @ axes @ np.diag(SHAPES[name]) @ axes.T
        np.testing.assert_allclose(rotation_of(h), turn, atol=1e-12)


def test_a_mirrored_body_gets_the_best_proper_rotation() -> None:
    rng = np.random.default_rng(6)
    for _ in range(50):
        q = rng.normal(size=(3, 40))
        x = np.diag([1, 1, -1.0]) @ random_rotation(rng) @ q + 0.1 * rng.normal(size=(3, 40))
        weight = np.ones(40)
        expected, _ = fit_pose(q, x, weight)
        centred = (x - x.mean(axis=1)[:, None]) @ (q - q.mean(axis=1)[:, None]).T
        np.testing.assert_allclose(rotation_of(centred), expected, atol=1e-9)


@pytest.mark.parametrize("values", [(2, 0, 0), (0, 0, 0)])
def test_a_straight_line_and_a_point_get_some_rotation_that_carries_them(values: tuple[float, ...]) -> None:
    rng = np.random.default_rng(8)
    for _ in range(50):
        turn, axes = random_rotation(rng), random_rotation(rng)
        r = rotation_of(turn @ axes @ np.diag(values) @ axes.T)
        np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(r) == pytest.approx(1)
        if values[0]:
            np.testing.assert_allclose(r @ axes[:, 0], turn @ axes[:, 0], atol=1e-9)
