"""`dimple.Body`, the front door for scripts: it presses, lets go and bakes, and shows nothing until then."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.point_cache import cache_of, read_point_cache


@pytest.fixture
def vinyl_ball(bpy: ModuleType, ball: Callable[..., Any]) -> Any:
    """A ball of the paper's second object, fine enough for its fingertip."""
    obj = ball(subdivisions=4)
    obj.dimple.simulated = "MESH"
    bpy.context.object.dimple.material = "object_2_vinyl_air"
    return obj


def body_of(obj: Any) -> Any:
    from bl_ext.user_default.dimple import Body

    return Body.from_object(obj)


def test_a_press_by_depth_meets_the_measured_force_and_leaves_the_object_alone(
    vinyl_ball: Any, coordinates: Callable[[Any], bytes]
) -> None:
    before = coordinates(vinyl_ball)
    body = body_of(vinyl_ball)
    body.press(depth=0.010)
    body.step(0.5)
    law = body.session.model.materials[0].law(0.010)
    assert body.depth == pytest.approx(0.010, rel=1e-3) and body.force == pytest.approx(law, rel=0.01)
    dent = 1.0 - body.positions()[:, 2].max()
    assert 0 < dent * body.link.scale < 0.011 and np.abs(body.offsets()).max() > 0.05
    assert coordinates(vinyl_ball) == before and not vinyl_ball.modifiers


def test_it_presses_as_the_operator_does(
    bpy: ModuleType, vinyl_ball: Any, coordinates: Callable[[Any], bytes], shown: Callable[[Any], np.ndarray]
) -> None:
    body = body_of(vinyl_ball)
    body.press((0.0, 0.0, 1.0), force=5.0, radius=0.010, seconds=0.25)
    body.step(0.25)
    bpy.ops.dimple.poke(location=(0.0, 0.0, 1.0), force_n=5.0, radius_mm=10.0, release_s=0.0, keep=True)
    rest = np.frombuffer(coordinates(vinyl_ball), np.float32).reshape(-1, 3)
    assert np.allclose(shown(vinyl_ball) - rest, body.offsets(), atol=1e-6)


def test_a_fingertip_that_is_released_leaves_no_force_and_no_dent(vinyl_ball: Any) -> None:
    body = body_of(vinyl_ball)
    body.press(depth=0.010)
    body.release()
    body.step(1.0)
    assert body.force == 0.0 and body.depth == 0.0
    assert np.abs(body.offsets()).max() * body.link.scale < 1e-4


def test_two_fingertips_pinch(vinyl_ball: Any) -> None:
    body = body_of(vinyl_ball)
    body.press((-1.0, 0.0, 0.0), depth=0.008, finger=1)
    body.press((1.0, 0.0, 0.0), depth=0.008, finger=2)
    assert (body.frame.depths[:2] > 0.007).all()


def test_a_press_through_the_whole_body_is_refused(vinyl_ball: Any) -> None:
    from bl_ext.user_default.dimple import DimpleError

    with pytest.raises(DimpleError, match="would go through it"):
        body_of(vinyl_ball).press(depth=1.0)


def test_it_bakes_its_object_by_the_keyframed_fingertips(bpy: ModuleType, scene: Any, pressed: Any) -> None:
    obj = pressed()
    body_of(obj).bake(1, 6)
    assert len(read_point_cache(cache_of(obj).filepath)[2]) == 6
