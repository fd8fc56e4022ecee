"""The rotation of the shape at rest: the quaternion in C against the turn that was given, and singular values."""

import numpy as np
import pytest

from core import native
from core.base import Floats
from core.body.model import Model, build_model
from core.body.shape_matching import fit_pose
from core.mesh.surface import mesh_from_triangles
from core.native.motion import FingertipMotion, Motion
from studies import scenes

BALL = build_model(scenes.ball(1, radius=1.0), [scenes.BALL])  # alike in all directions: only its stretch counts
MIDDLE, FAR, WIDE = (0.0, 0.0, 0.0), 1e6, 4e8  # [m]
IN_THE_MIDDLE = FingertipMotion(MIDDLE, MIDDLE, MIDDLE, 0.1)


def far_below(axis: int) -> Model:
    """Return a wide triangle far down an axis: above it, that axis is the way out of the surface."""
    corners = np.array([[2 * WIDE, 0, -FAR], [-WIDE, 2 * WIDE, -FAR], [-WIDE, -2 * WIDE, -FAR]])
    return build_model(mesh_from_triangles(np.roll(corners, axis + 1, 1), np.array([[0, 1, 2]])), [scenes.BALL])


@pytest.fixture(scope="module")
def bodies() -> list[native.Body]:
    """Return three alike, below each of which lies another triangle."""
    return [native.Body(BALL, native.library(), bits=64, surface=far_below(axis)) for axis in range(3)]


def rotation_of(bodies: list[native.Body], x: Floats) -> Floats:
    """Return the rotation of the shape at rest of a free ball whose vertices are at x (3, n) [m]."""
    columns = []
    for body in bodies:
        body.set_state(x)
        touch = body.step(Motion(0, 1, 1e-3, (IN_THE_MIDDLE,))).touches[0]
        assert touch
        columns.append(touch.outward)
    return np.transpose(columns)


def random_rotation(rng: np.random.Generator) -> Floats:
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


# how long the ball becomes along three axes
SHAPES = {"body": (3, 2, 1), "ball": (1, 1, 1), "flat": (3, 2, 0), "disc": (2, 2, 0), "nearly flat": (3, 2, 1e-9)}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_a_ball_that_is_stretched_and_turned_has_the_rotation_it_was_turned_by(
    bodies: list[native.Body], name: str, scale: float
) -> None:
    rng = np.random.default_rng(5)
    for _ in range(50):
        turn, axes = random_rotation(rng), random_rotation(rng)
        x = scale * turn @ axes @ np.diag(SHAPES[name]) @ axes.T @ BALL.matching.rest
        np.testing.assert_allclose(rotation_of(bodies, x), turn, atol=1e-12)


def test_a_mirrored_body_gets_the_best_proper_rotation(bodies: list[native.Body]) -> None:
    rng, law = np.random.default_rng(6), BALL.matching
    for _ in range(50):
        x = np.diag([1, 1, -1.0]) @ random_rotation(rng) @ law.rest + 0.1 * rng.normal(size=law.rest.shape)
        expected, _ = fit_pose(law.rest, x, law.k1, law.pull)
        np.testing.assert_allclose(rotation_of(bodies, x), expected, atol=1e-9)


@pytest.mark.parametrize("values", [(2, 0, 0), (0, 0, 0)])
def test_a_straight_line_and_a_point_get_some_rotation_that_carries_them(
    bodies: list[native.Body], values: tuple[float, ...]
) -> None:
    rng = np.random.default_rng(8)
    for _ in range(50):
        turn, axes = random_rotation(rng), random_rotation(rng)
        r = rotation_of(bodies, turn @ axes @ np.diag(values) @ axes.T @ BALL.matching.rest)
        np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(r) == pytest.approx(1)
        if values[0]:
            np.testing.assert_allclose(r @ axes[:, 0], turn @ axes[:, 0], atol=1e-9)
