"""A whole scene through `Session`, native beside numpy."""

import numpy as np
import pytest

from core import native
from core.base import DimpleError
from core.body.model import initial_state
from core.session import Session
from core.solver import semi_implicit
from core.solver.path import FingerPath
from studies import scenes
from studies.methods.registry import Run


def pressed(backend: str, subdivisions: int, seconds: float) -> list[np.ndarray]:
    session = Session(scenes.poke_ball(subdivisions).model, backend=backend)
    assert session.backend == backend and session.backend_note == ""
    return [frame.positions.copy() for frame in scenes.poke(session, seconds=seconds)]


def test_a_press_of_the_ball_through_a_session_ends_where_it_does_with_numpy() -> None:
    expected = pressed("numpy", 2, 0.5)
    single, double = (pressed(backend, 2, 0.5) for backend in ("native", "native64"))
    radius = scenes.BALL_RADIUS
    np.testing.assert_allclose(single[-1], expected[-1], rtol=0, atol=1e-4 * radius)
    for frame, right in zip(double, expected, strict=True):
        np.testing.assert_allclose(frame, right, rtol=0, atol=1e-7 * radius)  # a frame is in single precision


@pytest.mark.parametrize(("run", "tolerance"), [(native.run64, 1e-9), (native.run, 1e-4)], ids=["f64", "f32"])
def test_a_thousand_steps_of_the_press_leave_every_vertex_where_numpy_does(run: Run, tolerance: float) -> None:
    """Down by 20 mm, hold, up; no vertex may differ by more than this share of the radius."""
    session = scenes.poke_ball(3)
    ticks = -(-1000 // session.substeps)
    top, turn = scenes.BALL_RADIUS + scenes.FINGERTIP, np.linspace(0, 1, ticks + 1)
    centres = np.zeros((1, ticks + 1, 3))
    centres[0, :, 2] = top - 0.020 * np.interp(turn, (0, 0.4, 0.7, 1), (0, 1, 1, 0))
    path, ends = FingerPath(centres=centres, radii=np.array([scenes.FINGERTIP])), []
    for stepper in (semi_implicit.run, run):
        state = initial_state(session.model)
        stepper(session.model, state, path, tick=session.tick, substeps=session.substeps)
        ends.append(state.positions)
    assert np.abs(ends[0] - session.model.mesh.rest_positions.T).max() > 1e-5 * scenes.BALL_RADIUS
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=tolerance * scenes.BALL_RADIUS)


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(DimpleError, match="backend"):
        Session(scenes.poke_ball(1).model, backend="gpu")
