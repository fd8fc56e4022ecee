"""A whole scene through `Session`, native beside numpy."""

import numpy as np
import pytest

from core.base import DimpleError
from core.session import Session
from core.study import scenes


def pressed(backend: str, subdivisions: int, seconds: float) -> list[np.ndarray]:
    session = Session(scenes.poke_ball(subdivisions).model, backend=backend)
    assert session.backend == backend and session.backend_note == ""
    return [frame.positions.copy() for frame in scenes.poke(session, seconds=seconds)]


@pytest.mark.parametrize(("subdivisions", "seconds"), [(2, 1.0), (3, 0.5)])
def test_a_press_of_the_ball_ends_where_it_does_with_numpy(subdivisions: int, seconds: float) -> None:
    """1,000 steps and more: 1,000 ticks of the small one, 3,000 substeps of the other."""
    expected = pressed("numpy", subdivisions, seconds)
    single, double = (pressed(backend, subdivisions, seconds) for backend in ("native", "native64"))
    radius = scenes.BALL_RADIUS
    np.testing.assert_allclose(single[-1], expected[-1], rtol=0, atol=1e-4 * radius)
    for frame, right in zip(double, expected, strict=True):
        np.testing.assert_allclose(frame, right, rtol=0, atol=1e-7 * radius)  # a frame is in single precision


def test_an_unknown_backend_is_refused() -> None:
    with pytest.raises(DimpleError, match="backend"):
        Session(scenes.poke_ball(1).model, backend="gpu")
