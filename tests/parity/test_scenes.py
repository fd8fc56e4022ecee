"""A whole press, native beside numpy."""

from functools import cache

import numpy as np
import pytest

from core.base import DimpleError
from core.native.motion import FingertipMotion, Motion
from core.session import Session
from studies import scenes
from studies.reference import create


@pytest.mark.parametrize(("backend", "tolerance"), [("native64", 1e-9), ("native", 1e-4)])
def test_a_thousand_steps_of_the_press_leave_every_vertex_where_numpy_does(backend: str, tolerance: float) -> None:
    """No vertex may differ by more than this share of the radius."""
    (rest, twin), (_, found) = after_a_thousand_steps("numpy"), after_a_thousand_steps(backend)
    assert np.abs(twin - rest).max() > 1e-5 * scenes.BALL_RADIUS
    np.testing.assert_allclose(found, twin, rtol=0, atol=tolerance * scenes.BALL_RADIUS)


@cache
def after_a_thousand_steps(backend: str) -> tuple[np.ndarray, np.ndarray]:
    """Press a ball down by 20 mm, hold, lift; return its shape at rest and where it is then."""
    session = scenes.poke_ball(3)
    ticks = -(-1000 // session.substeps)
    top, parts = scenes.BALL_RADIUS + scenes.FINGERTIP, np.round(ticks * np.array([0, 0.4, 0.7, 1])).astype(int)
    heights, body = (top, top - 0.020, top - 0.020, top), create(session.model, backend=backend)
    for k in range(3):
        count, (start, end) = int(parts[k + 1] - parts[k]), ((0.0, 0.0, heights[k + i]) for i in (0, 1))
        tip = FingertipMotion.straight(start, end, ticks=count, radius=scenes.FINGERTIP, fresh=k == 0)
        body.step(Motion(count, session.substeps, session.clock.tick, (tip,)))
    return session.model.mesh.rest_positions.T, body.positions()


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(DimpleError, match="backend"):
        Session(scenes.poke_ball(1).model, backend="gpu")
