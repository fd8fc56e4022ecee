"""Bodies on several threads: the same bits on any number of them, for one body and for many in a call."""

import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from core import native
from core.native import NativeError
from core.native.body import Body, step_many
from core.native.motion import Motion
from tests.bodies import ball
from tests.parity.cases import CASES, build, run
from tools.environment import ROOT

NAMES = ("liquid", "free on the ground", "a hole")


def bodies() -> tuple[list[Body], list[Motion]]:
    made, motions = [], []
    for name in NAMES * 3:
        model, velocities, motion = build(CASES[name])
        body = Body(model, native.library())
        body.set_state(model.matching.rest, velocities)
        made.append(body), motions.append(motion._replace(substeps=model.substeps(motion.tick)))
    return made, motions


@pytest.fixture(autouse=True)
def _two_workers() -> Iterator[None]:
    """Let every test have helpers, also on a machine with one core."""
    native.library().dm_set_workers(2)
    yield
    native.use_cores()


@pytest.mark.parametrize("name", ["liquid", "free on the ground", "lifted by three", "moving pins", "undamped"])
def test_a_large_body_has_the_same_bits_on_any_number_of_threads(name: str) -> None:
    model, velocities, motion = build(replace(CASES[name], shape=lambda: ball(4)))
    motion = motion._replace(substeps=model.substeps(motion.tick))
    found = set()
    for workers in (1, 2, 3, 4, 64):
        native.library().dm_set_workers(workers)
        body = Body(model, native.library())
        frames = [repr(run(body, velocities, motion)), repr(body.step(motion._replace(pins=None)))]
        found.add((*frames, body.positions().tobytes(), body.velocities().tobytes()))
    assert len(found) == 1


@pytest.mark.parametrize("count", [2, 3, 5])
def test_large_bodies_share_the_threads_and_keep_their_bits(count: int) -> None:
    """Some are stepped whole, beside others, and the rest in slices; one is small, and one sleeps."""
    model, velocities, motion = build(replace(CASES["free on the ground"], shape=lambda: ball(4), ticks=3))
    alone, small = [Body(model, native.library()) for _ in range(count)], crowd(3)
    together = [Body(model, native.library()) for _ in range(count)]
    for k, pair in enumerate(zip(alone, together, strict=True)):
        for body in pair:
            body.set_state(model.matching.rest, (1 + k) * velocities)
    motions = [*small[1], *[motion] * count]
    expected = [body.step(each) for body, each in zip([*small[0], *alone], motions, strict=True)]
    assert repr(step_many([*crowd(3)[0], *together], motions)) == repr(expected)
    for body, other in zip(together, alone, strict=True):
        assert np.array_equal(body.positions(), other.positions())


@pytest.mark.skipif(sys.platform != "linux", reason="counts threads as Linux lists them")
@pytest.mark.skipif("DIMPLE_LIBRARY" in os.environ, reason="a sanitizer has threads of its own")
def test_threads_start_for_a_large_body_that_moves_and_end_when_they_are_not_wanted() -> None:
    words = """
import os, time
from dataclasses import replace
from core import native
from core.native.motion import Motion
from tests.bodies import ball
from tests.parity.cases import CASES, build

def threads():
    return len(os.listdir("/proc/self/task"))

native.library().dm_set_workers(3)
before = threads()
cases = (replace(CASES["liquid"], shape=lambda: ball(k)) for k in (2, 4))
small, large = (native.Body(build(case)[0], native.library()) for case in cases)
large.set_state(large.model.matching.rest)
assert large.step(Motion(300, 6, 1e-3)).moved
assert not large.step(Motion(9, 6, 1e-3)).moved, "it must have fallen asleep"
assert threads() == before + 2
native.library().dm_set_workers(1)
while threads() > before:
    time.sleep(0.01)
native.library().dm_set_workers(3)
large.step(Motion(9, 6, 1e-3))
small.step(Motion(9, 6, 1e-3))
assert threads() == before, "for one that sleeps or is small"
large.set_state(large.model.matching.rest)
large.step(Motion(1, 6, 1e-3))
assert threads() == before + 2
"""
    done = subprocess.run([sys.executable, "-c", words], cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr[-2000:]


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


@pytest.mark.parametrize(("workers", "count"), [(1, 3), (2, 3), (2, 9), (5, 5), (20, 9)])
def test_any_number_of_threads_gives_the_bits_of_each_body_alone_also_where_one_is_left_to_another(
    workers: int, count: int
) -> None:
    alone, motions = crowd(count)
    together, _ = crowd(count)
    native.library().dm_set_workers(workers)
    for _ in range(20):
        expected = [body.step(motion) for body, motion in zip(alone, motions, strict=True)]
        assert repr(step_many(together, motions)) == repr(expected)
    for body, other in zip(together, alone, strict=True):
        assert np.array_equal(body.positions(), other.positions(), equal_nan=True)


def test_calls_at_the_same_time_wait_for_no_thread_of_each_other() -> None:
    alone, motions = bodies()
    expected = [body.step(motion) for body, motion in zip(alone, motions, strict=True)]
    groups = [bodies()[0] for _ in range(4)]
    with ThreadPoolExecutor(len(groups)) as pool:
        found = pool.map(lambda group: step_many(group, motions), groups)
    assert all(frames == expected for frames in found)


def test_where_one_motion_is_refused_none_is_run() -> None:
    made, motions = bodies()
    before = [body.positions() for body in made]
    for bad in (motions[-1]._replace(tick=float("nan")), motions[-1]._replace(substeps=0)):
        with pytest.raises(NativeError):
            step_many(made, [*motions[:-1], bad])
    with pytest.raises(NativeError):
        step_many([*made[:-1], made[0]], motions)  # one twice
    assert all(np.array_equal(body.positions(), x) for body, x in zip(made, before, strict=True))
    assert step_many([], []) == []
