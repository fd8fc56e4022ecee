"""Planes between what is near: what keeps them, and what gets new ones."""

from dataclasses import replace

import numpy as np

from core.base import Floats
from studies.reference.bounds import Bounds, bounds_of, hold_back, is_allowed, renewed
from studies.reference.crossing import find_crossings
from studies.reference.proximity import Surfaces, find_pairs, join_surfaces

GAP = 1e-3  # [m] between two squares


def squares() -> Surfaces:
    """Return two squares that face each other."""
    square = np.array([[0.0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0], [0, 0.01, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return join_surfaces([square, square[:, [1, 0, 2]] + (0.001, 0.002, GAP)], [faces, faces])


def bounds_of_squares() -> tuple[Bounds, Floats]:
    """Return their bounds, with planes that were set anew, and their vertices (8, 3) [m]."""
    s = squares()
    x = s.rest.copy()
    pairs = find_pairs(s, x, 0, 1, reach=5 * GAP, closest=1e-8)
    b = bounds_of(x, np.full(8, 2.5 * GAP), pairs)
    return replace(b, anew=np.ones_like(b.anew)), x


def moved(
    b: Bounds, x: Floats, vertices: list[int], way: tuple[float, float, float], *, stride: float = 0.0
) -> tuple[Bounds, Floats]:
    """Return the bounds after some vertices have gone a way, which go a stride [m] in each substep."""
    x, v = x.copy(), np.zeros_like(x)
    x[vertices] += way
    v[vertices] = stride / 1e-3 * np.array(way) / np.linalg.norm(way)
    return renewed(b, vertices, x, v, np.full(8, 1e-8), np.ones(8, bool), 1e-3), x


def test_what_moves_along_its_planes_keeps_them_and_may_go_as_far_again() -> None:
    b, x = bounds_of_squares()
    after, there = moved(b, x, [0, 1, 2, 3], (0.3 * GAP, 0.0, 0.0))
    flat = np.abs(b.pairs.normal[:, 2]) > 0.999
    assert flat.any()
    for name in ("normal", "level", "keep"):
        assert (getattr(after.pairs, name)[flat] == getattr(b.pairs, name)[flat]).all()
    assert (after.since[:4] == there[:4]).all()
    assert (after.roam[:4] > 0).all()


def test_what_goes_slowly_along_planes_of_the_query_or_away_from_them_keeps_them() -> None:
    b, x = bounds_of_squares()
    b = replace(b, anew=np.zeros_like(b.anew))
    near = np.abs(b.pairs.gap - GAP) < 1e-9  # what is farther apart stands between others at a slant
    assert near.any()
    for way in ((0.4 * GAP, 0.0, 0.0), (0.0, 0.0, -0.4 * GAP)):
        for stride, kept in ((0.01 * GAP, True), (0.1 * GAP, False)):
            after, there = moved(b, x, [0, 1, 2, 3], way, stride=stride)
            assert (~after.anew[near]).all() == kept
            assert after.anew[near].all() != kept
            assert all(is_allowed(after, vertex, there[vertex]) for vertex in range(4))


def test_what_goes_together_keeps_its_planes() -> None:
    b, x = bounds_of_squares()
    after, _ = moved(b, x, list(range(8)), (0.0, 0.0, 0.2 * GAP))
    assert (after.pairs.level == b.pairs.level).all()
    assert not (after.since == b.since).all()


def test_what_comes_near_to_a_plane_gets_a_new_one_that_lets_it_go_farther() -> None:
    b, x = bounds_of_squares()
    after, there = moved(b, x, [0, 1, 2, 3], (0.0, 0.0, 0.4 * GAP))
    flat = (np.abs(b.pairs.normal[:, 2]) > 0.999) & (np.abs(b.pairs.gap - GAP) < 1e-9)
    assert flat.any()
    assert (after.pairs.level[flat] != b.pairs.level[flat]).all()
    for vertex in range(4):
        deeper = there[vertex] + (0.0, 0.0, 0.2 * GAP)
        assert is_allowed(after, vertex, deeper)
        assert not is_allowed(b, vertex, deeper)


def test_whatever_is_tried_two_squares_never_pass_through_each_other() -> None:
    rng = np.random.default_rng(0)
    (b, x), s, planes = bounds_of_squares(), squares(), set()
    for _ in range(60):
        wanted, last = x + rng.normal(0, 0.2 * GAP, x.shape), x.copy()
        for vertex in range(8):
            held = not is_allowed(b, vertex, wanted[vertex])
            x[vertex] = hold_back(b, vertex, wanted[vertex], last[vertex]) if held else wanted[vertex]
        some = rng.choice(8, 3, replace=False).tolist()
        b = renewed(b, some, x, np.zeros_like(x), np.full(8, 1e-8), np.ones(8, bool), 1e-3)
        planes.add(float(b.pairs.level.sum()))
        assert all(is_allowed(b, vertex, x[vertex]) for vertex in range(8))
        assert find_crossings(s, x, np.ones(2, bool), [0, 0], np.zeros(8, bool)).pairs == 0
    assert len(planes) > 10
