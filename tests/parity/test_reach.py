"""What a fingertip may meet is listed with a margin and picked from the lists: the same as searching in each tick."""

import numpy as np
import pytest

from core import native
from core.body.model import build_model
from core.mesh.surface import base_vertices
from core.native.body import Body
from core.solver.motion import FingertipMotion, Motion, Vector
from studies.scenes import BALL, ball, cube

TICK, RADIUS, TOP = 1e-3, 0.015, 0.095  # [s], [m]


def centres(t: int) -> tuple[Vector | None, Vector | None]:
    """Return where two fingertips are after t ticks: one presses fast, the other comes, slides, leaves, comes again."""
    down = TOP - 0.03 * np.interp(t, [0, 60, 120], [0, 1, 0.2])
    slid: Vector = (0.03 * np.sin(t / 15), 0.02, 0.075)
    return (0.0, 0.0, float(down)), None if t % 50 < 20 else slid


@pytest.mark.parametrize("subdivisions", [2, 3])
def test_a_body_whose_lists_hold_has_the_bits_of_one_that_is_searched_in_each_tick(subdivisions: int) -> None:
    mesh = ball(subdivisions)
    model = build_model(mesh, [BALL], pinned=base_vertices(mesh))
    listed, searched = (Body(model, native.library()) for _ in range(2))
    for t in range(120):
        ways = zip(centres(t - 1), centres(t), strict=True)
        tips = tuple(
            FingertipMotion.straight(start or end, end, ticks=1, radius=RADIUS, fresh=not start) if end else None
            for start, end in ways
        )
        motion = Motion(1, model.substeps(TICK), TICK, tips)
        searched.set_load(None)  # whatever is changed from outside ends the lists
        assert listed.step(motion) == searched.step(motion)
    assert np.array_equal(listed.positions(), searched.positions())
    assert np.array_equal(listed.velocities(), searched.velocities())


@pytest.mark.parametrize("radius", [0.015, 0.15])
def test_a_depth_from_the_facets_that_are_listed_is_that_from_all(radius: float) -> None:
    """Down into a cube across its edges and far below, out of its side, beside it, and back at once."""
    mesh = cube(20, 0.1)
    model = build_model(mesh, [BALL], pinned=base_vertices(mesh))
    listed, searched = (Body(model, native.library()) for _ in range(2))
    listed.set_rest(model.matching.rest)
    turns = np.array([[0, 0, 0.07], [0, 0, 0.01], [0.06, 0.04, 0.03], [0.08, 0, -0.03], [0.03, 0, 0.06], [0, 0, 0.07]])
    way = np.array([np.interp(np.linspace(0, 5, 800), range(6), column) for column in turns.T]).T
    way[::97] += 0.02
    for start, end in zip(way[:-1].tolist(), way[1:].tolist(), strict=True):
        tip = FingertipMotion.straight(tuple(end), tuple(end), ticks=0, radius=radius, fresh=start == way[0].tolist())
        searched.set_rest(model.matching.rest)  # which ends the lists
        assert listed.step(Motion(0, 1, TICK, (tip,))) == searched.step(Motion(0, 1, TICK, (tip,)))
