"""A ray meets the nearest face of a mesh, and slips through no edge."""

import numpy as np
import pytest

from core.mesh.ray import ray_hit

SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
SHEETS = np.concatenate([SQUARE, SQUARE + (0, 0, 1)])
FACES = np.array([(0, 1, 2), (0, 2, 3), (4, 6, 5), (4, 7, 6)])


@pytest.mark.parametrize(("x", "y"), [(0.2, 0.1), (0.1, 0.7), (0.5, 0.5), (1.0, 1.0)])
def test_a_ray_meets_the_nearest_face_with_the_normal_toward_its_origin(x: float, y: float) -> None:
    distance, point, normal = ray_hit((x, y, 3.0), (0.0, 0.0, -1.0), SHEETS, FACES)
    assert distance == pytest.approx(2)
    assert point == pytest.approx((x, y, 1))
    assert normal == pytest.approx((0, 0, 1))


def test_a_ray_beside_behind_or_along_the_faces_misses() -> None:
    for origin, direction in (((2, 0, 3), (0, 0, -1)), ((0.5, 0.5, 3), (0, 0, 1)), ((-1, 0.5, 0), (1, 0, 0))):
        assert ray_hit(origin, direction, SHEETS, FACES) is None
    assert ray_hit((0, 0, 1), (0, 0, -1), np.zeros((3, 3)), np.array([(0, 1, 2)])) is None


def test_no_ray_slips_through_a_corner_or_an_edge_of_a_closed_body() -> None:
    corners = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], float)
    faces = np.array([(x, y, z) for x in (0, 1) for y in (2, 3) for z in (4, 5)])
    random = np.random.default_rng(3)
    for _ in range(300):
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        body = corners @ turn + random.normal(size=3)
        a, b = body[faces[random.integers(8)][:2]]
        aim = a + random.choice([0.0, 0.5, 1 / 3]) * (b - a)
        origin = body.mean(axis=0) + 5 * (aim - body.mean(axis=0))
        direction = (aim - origin) / np.linalg.norm(aim - origin)
        hit = ray_hit(tuple(origin), tuple(direction), body, faces)
        assert hit is not None
        assert hit[0] == pytest.approx(np.linalg.norm(aim - origin))
        assert np.dot(hit[2], direction) < 0
