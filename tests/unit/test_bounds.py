"""Planes between what is near: neither of two passes theirs, and that of what is rigid moves with it."""

import numpy as np

from studies.reference.bounds import bounds_of, is_allowed, left_of, moved, renewed, settle
from studies.reference.crossing import find_crossings
from studies.reference.proximity import Surfaces, find_pairs, join_surfaces

GAP = 1e-3  # [m] between two squares


def squares() -> Surfaces:
    """Return two squares that face each other."""
    square = np.array([[0.0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0], [0, 0.01, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return join_surfaces([square, square[:, [1, 0, 2]] + (0.001, 0.002, GAP)], [faces, faces])


def test_whatever_is_tried_two_squares_never_pass_through_each_other() -> None:
    rng, s = np.random.default_rng(0), squares()
    for bodies in (2, 1):  # of which the second is rigid in turn, and rests
        x, planes = s.rest.copy(), set()
        b = bounds_of(x, np.full(8, np.inf), find_pairs(s, x, 0, 1, reach=5 * GAP, closest=1e-8, bodies=bodies))
        for _ in range(60):
            wanted, last = x + rng.normal(0, 0.2 * GAP, x.shape), x.copy()
            wanted[4:] = wanted[4:] if bodies == 2 else x[4:]
            b = moved(b, wanted, last)
            for vertex in range(4 * bodies):
                x[vertex] = settle(b, vertex, wanted[vertex], last[vertex], None, 1e-12)[0]
            assert find_crossings(s, x, np.ones(2, bool), [0, 0], np.zeros(8, bool)).pairs == 0
            b = renewed(b, rng.choice(len(b.pairs.gap), 9), x, np.full(8, 1e-8))
            planes.add(float(b.pairs.level.sum()))
        assert len(planes) > 10


def test_skin_is_kept_ahead_of_what_is_rigid_however_far_that_goes() -> None:
    s = squares()
    x, last = s.rest.copy(), s.rest.copy()
    b = bounds_of(x, np.full(8, np.inf), find_pairs(s, x, 0, 1, reach=5 * GAP, closest=1e-8, bodies=1))
    way = np.array([0.0, 0.0, -20 * GAP])
    x[4:] += way
    b = moved(b, x, last)
    assert (left_of(b, x) < 0).any()
    for vertex in range(4):
        x[vertex], allowed = settle(b, vertex, x[vertex], last[vertex], way, 1e-12)
        assert allowed and is_allowed(b, vertex, x[vertex])
    assert x[:4, 2].max() < x[4:, 2].min()
