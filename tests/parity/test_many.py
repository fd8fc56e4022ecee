"""Several bodies in one call: the bits of each alone, on any number of threads."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from core import native
from core.native import NativeError
from core.native.body import Body, step_many
from core.native.motion import Motion
from tests.parity.cases import CASES, build

NAMES = ("liquid", "free on the ground", "a hole")


def bodies() -> tuple[list[Body], list[Motion]]:
    made, motions = [], []
    for name in NAMES * 3:
        model, velocities, motion = build(CASES[name])
        body = Body(model, native.library())
        body.set_state(model.matching.rest, velocities)
        made.append(body), motions.append(motion._replace(substeps=model.substeps(motion.tick)))
    return made, motions


@pytest.mark.parametrize("workers", [1, 2, 5, 20])
def test_any_number_of_threads_gives_the_bits_of_each_body_alone(workers: int) -> None:
    alone, motions = bodies()
    expected = [body.step(motion) for body, motion in zip(alone, motions, strict=True)]
    together, motions = bodies()
    assert step_many(together, motions, workers=workers) == expected
    for body, other in zip(together, alone, strict=True):
        assert np.array_equal(body.positions(), other.positions())
        assert np.array_equal(body.velocities(), other.velocities())


def crowd(count: int) -> tuple[list[Body], list[Motion]]:
    """Return bodies of which a thread leaves one for another: a few as dear, one asleep, one that blows up."""
    model, velocities, motion = build(CASES["liquid"])
    made = [Body(model, native.library()) for _ in range(count)]
    for k, body in enumerate(made):
        body.set_state(model.matching.rest, velocities * (1e9 if k == 1 else 1 + k))
    made[-1].set_state(model.matching.rest)
    made[-1].step(Motion(4000, model.substeps(1e-3), 1e-3, (None,) * 3))
    motions = [motion._replace(ticks=40 - k % 3, substeps=model.substeps(motion.tick)) for k in range(count)]
    return made, [*motions[:-1], Motion(0, 1, 1e-3, (None,) * 3)]


@pytest.mark.parametrize("count", [3, 5, 9])
def test_a_body_that_goes_from_thread_to_thread_keeps_its_bits(count: int) -> None:
    alone, motions = crowd(count)
    together, _ = crowd(count)
    for _ in range(20):
        expected = [body.step(motion) for body, motion in zip(alone, motions, strict=True)]
        assert repr(step_many(together, motions, workers=2)) == repr(expected)
    for body, other in zip(together, alone, strict=True):
        assert np.array_equal(body.positions(), other.positions(), equal_nan=True)


def test_calls_at_the_same_time_wait_for_no_thread_of_each_other() -> None:
    alone, motions = bodies()
    expected = [body.step(motion) for body, motion in zip(alone, motions, strict=True)]
    groups = [bodies()[0] for _ in range(4)]
    with ThreadPoolExecutor(len(groups)) as pool:
        found = pool.map(lambda group: step_many(group, motions, workers=2), groups)
    assert all(frames == expected for frames in found)


def test_where_one_motion_is_refused_none_is_run() -> None:
    made, motions = bodies()
    before = [body.positions() for body in made]
    for bad in (motions[-1]._replace(tick=float("nan")), motions[-1]._replace(substeps=0)):
        with pytest.raises(NativeError):
            step_many(made, [*motions[:-1], bad], workers=2)
    with pytest.raises(NativeError):
        step_many([*made[:-1], made[0]], motions, workers=2)  # one twice
    with pytest.raises(NativeError):
        step_many(made, motions, workers=-1)
    assert all(np.array_equal(body.positions(), x) for body, x in zip(made, before, strict=True))
    assert step_many([], [], workers=2) == []
