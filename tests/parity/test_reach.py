"""What a fingertip may meet is listed with a margin and picked from the lists: the same as searching in each tick."""

import numpy as np
import pytest

from core import native
from core.body.model import build_model
from core.mesh.surface import base_vertices
from core.native.body import Body
from core.native.motion import Motion, Vector
from studies.motions import straight
from studies.scenes import BALL, ball

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
            straight(start or end, end, ticks=1, radius=RADIUS, fresh=not start) if end else None
            for start, end in ways
        )
        motion = Motion(1, model.substeps(TICK), TICK, tips)
        searched.wake()  # whatever is changed from outside ends the lists
        assert listed.step(motion) == searched.step(motion)
    assert np.array_equal(listed.positions(), searched.positions())
    assert np.array_equal(listed.velocities(), searched.velocities())
