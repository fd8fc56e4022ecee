"""Bodies at rest are not stepped, and whatever could move them wakes them at once, in the very state they were in."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from core.body.model import Model, build_model
from core.mesh.surface import base_vertices
from core.native.motion import FingertipMotion, Motion
from core.session import Finger, Session
from studies import scenes
from studies.reference import create

EVERY = ["native64", "native"]
TOP = float(scenes.ball(1).rest_positions[:, 2].max())
CLEAR = Finger((0.0, 0.0, TOP + 0.0225), 0.02)


def model(**more: object) -> Model:
    mesh = scenes.ball(1)
    return build_model(mesh, [scenes.BALL], pinned=base_vertices(mesh), **more)  # type: ignore[arg-type]


def asleep(backend: str) -> Session:
    """Return a session of a body that was pressed, let go, and has come to rest beside a fingertip."""
    session = Session(model(), backend=backend)
    for place in ((0.0, 0.0, TOP + 0.02), (0.0, 0.0, TOP + 0.01)):
        session.set_fingers([Finger(place, 0.02)])
        session.step(0.02)
    session.set_fingers([CLEAR])
    for _ in range(40):
        session.step(0.05)
        if not session.moved:
            return session
    raise AssertionError("it never came to rest")


@pytest.mark.parametrize("backend", EVERY)
def test_a_body_at_rest_is_not_stepped_and_says_what_it_said(backend: str) -> None:
    session = asleep(backend)
    before, velocities, shown = session.body.positions(), session.body.velocities(), session.frame
    session.set_fingers([Finger((0.001, 0.0, TOP + 0.0225), 0.02)])
    after = session.step(0.1)
    assert not session.moved and after.steps == 100
    assert np.array_equal(session.body.positions(), before) and np.array_equal(session.body.velocities(), velocities)
    assert (after.pressure, after.volume) == (shown.pressure, shown.volume)
    assert np.abs(before - session.model.matching.rest).max() < 1e-5


@pytest.mark.parametrize("backend", EVERY)
def test_a_woken_body_goes_on_as_one_that_never_slept(backend: str) -> None:
    """From the same positions and velocities a new body makes the same motion."""
    session = asleep(backend)
    other = create(session.model, backend=backend)
    other.set_state(session.body.positions(), session.body.velocities())
    tip = FingertipMotion.straight((0.0, 0.0, TOP + 0.0225), (0.0, 0.0, TOP + 0.012), ticks=20, radius=0.02)
    motion = Motion(20, session.substeps, 1e-3, (tip,))
    first, second = session.body.step(motion), other.step(motion)
    assert first.moved and first.touches[0] and second.touches[0]
    assert first.touches[0].impulse[2] > 1e-3
    assert first.touches[0].impulse == pytest.approx(second.touches[0].impulse, abs=1e-6)
    assert session.body.positions() == pytest.approx(other.positions(), abs=1e-7)


WAKES: dict[str, Callable[[Session], None]] = {
    "a fingertip comes near": lambda s: s.set_fingers([Finger((0.0, 0.0, TOP + 0.0195), 0.02)]),
    "gravity is switched on": lambda s: s.change(model(gravity=(0.0, 0.0, -9.81))),
    "a constant is changed": lambda s: s.change(build_model(
        s.model.mesh, [replace(scenes.BALL, K1=300.0)], pinned=s.model.pinned
    )),
    "what holds it moves": lambda s: s.set_pins(s.model.mesh.rest_positions + [0.001, 0.0, 0.0]),
    "its pins are let go": lambda s: s.change(build_model(s.model.mesh, [scenes.BALL])),
}  # fmt: skip


@pytest.mark.parametrize("backend", EVERY)
@pytest.mark.parametrize("cause", WAKES)
def test_it_wakes_at_once(cause: str, backend: str) -> None:
    session = asleep(backend)
    WAKES[cause](session)
    session.step(0.001)
    assert session.moved


@pytest.mark.parametrize("backend", EVERY)
def test_it_sleeps_on_while_what_holds_it_is_led_nowhere(backend: str) -> None:
    session = asleep(backend)
    session.set_pins(session.model.mesh.rest_positions)
    session.step(0.01)
    assert not session.moved


@pytest.mark.parametrize("backend", EVERY)
def test_what_falls_or_drifts_does_not_sleep(backend: str) -> None:
    mesh = scenes.ball(1)
    for gravity, speed in ((-1e-3, 0.0), (0.0, 1e-4)):  # [m/s2], [m/s]: slower than REST_SPEED for all of the time
        free = build_model(mesh, [scenes.BALL], gravity=(0.0, 0.0, gravity))
        body = create(free, backend=backend)
        body.set_state(free.matching.rest, np.full(free.matching.rest.shape, speed))
        for _ in range(3):
            assert body.step(Motion(100, free.substeps(1e-3), 1e-3)).moved
        went = speed * 0.3 + 0.5 * gravity * 0.3**2
        assert (body.positions() - free.matching.rest).mean(axis=1)[2] == pytest.approx(went, rel=0.02)


@pytest.mark.parametrize(("first", "second"), [("native64", "native64"), ("native", "native"), ("numpy", "native64")])
def test_the_same_ticks_sleep_alike_however_they_are_called(first: str, second: str) -> None:
    """It sleeps while the fingertip comes, and is woken in the middle of a call."""
    one, many = (create(model(), backend=backend) for backend in (first, second))
    start, end, ticks, steps = (0.0, 0.0, TOP + 0.08), (0.0, 0.0, TOP + 0.01), 350, model().substeps(1e-3)
    way = FingertipMotion.straight(start, end, ticks=ticks, radius=0.02)
    one.step(Motion(ticks, steps, 1e-3, (way,)))
    moved, here = 0, start
    for tick in range(ticks):
        there = tuple(a + (b - a) * tick / (ticks - 1) for a, b in zip(way.first, end, strict=True))
        moved += many.step(Motion(1, steps, 1e-3, (FingertipMotion(here, there, there, 0.02),))).moved
        here = there
    assert 250 <= moved < 320
    assert one.positions() == pytest.approx(many.positions(), abs=1e-8)
