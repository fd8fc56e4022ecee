"""A body under slow fingertips is simulated faster than they go: fewer steps, the same force and the same shape."""

from dataclasses import replace

import numpy as np
import pytest

from core.base import TICK, Floats
from core.body.model import Model, build_model
from core.mesh.surface import base_vertices
from core.reduction.grading import Pressed, pressed_by
from core.reduction.planner import plan
from core.reduction.slow_press import SETTLING, answer_time, times_faster
from core.session import Finger, Session
from studies.scenes import BALL, ball

RADIUS, DEPTH, CLEAR = 0.02, 0.01, 0.5e-3  # [m]
LOOK, FASTER, TOLERANCES = 8e-3, 4, (0.5e-3, 0.1)
FLANK = max(ball(3).rest_positions.tolist(), key=lambda x: 0.6 * x[0] + 0.8 * x[2])  # a vertex
TOP = np.array(FLANK) / np.linalg.norm(FLANK)


@pytest.fixture(scope="module")
def model() -> Model:
    mesh = ball(3)
    return build_model(mesh, [BALL], pinned=base_vertices(mesh))


def centre(model: Model, depth: float) -> Floats:
    return TOP * (np.linalg.norm(model.mesh.rest_positions, axis=1).max() + RADIUS - depth)


def path(model: Model, speed: float) -> Floats:
    """Return where a fingertip is at each look that goes in, stays for 0.2 s, comes out, and is out for 0.5 s."""
    down = (DEPTH + CLEAR) / speed
    time = np.arange(0, 2 * down + 0.7, LOOK)
    depths = speed * np.minimum(np.minimum(time, down), np.maximum(2 * down + 0.2 - time, 0)) - CLEAR
    return np.array([centre(model, depth) for depth in depths])


def start(model: Model, faster: int, slow: float) -> Session:
    session = Session(model)
    session.set_clock(faster * TICK, faster=faster, slow=slow)
    return session


def press(session: Session, centres: Floats) -> tuple[Floats, list[Floats]]:
    """Return the force along the press at each look, and the skin."""
    forces, skins = [], []
    for look, at in enumerate(centres):
        session.set_fingers([Finger(tuple(at), RADIUS)])
        forces.append(float(session.step(LOOK if look else 0.0).finger_forces[0] @ TOP))
        skins.append(session.skin().copy())
    return np.array(forces), skins


def slow_speed(model: Model) -> float:
    """Return a speed [m/s] at which the ball may be simulated FASTER times as fast, and no faster."""
    return 0.05 * DEPTH / answer_time(model, DEPTH) / (FASTER + 0.5)


def test_a_slow_press_takes_a_quarter_of_the_steps_and_has_the_same_force_and_shape(model: Model) -> None:
    speed = slow_speed(model)
    centres = path(model, speed)
    pressed = pressed_by(model.mesh, [centres], RADIUS, LOOK)
    assert pressed and pressed.speed == pytest.approx(speed, rel=1e-3)
    assert 0.8 * DEPTH < pressed.depth <= DEPTH
    faster, share = times_faster(model, pressed, *TOLERANCES)
    assert faster in (FASTER - 1, FASTER) and 0.02 < share <= 0.05
    own, quick = Session(model), start(model, FASTER, 1.01 * speed)
    (goal, skins), (forces, others) = press(own, centres), press(quick, centres)
    assert quick.frame.total_steps == pytest.approx(own.frame.total_steps / FASTER, rel=0.02)
    off = np.abs(forces - goal) / goal.max()
    assert off.max() < 0.1 and np.sqrt((off**2).mean()) < 0.01
    assert max(np.abs(a - b).max() for a, b in zip(skins, others, strict=True)) < 0.25e-3
    assert np.abs(skins[-1] - others[-1]).max() < 0.01e-3, "and it comes to the same rest"
    assert quick.frame.time == pytest.approx(own.frame.time)
    assert quick.frame.work == pytest.approx(own.frame.work, abs=0.02 * goal.max() * DEPTH)


@pytest.mark.parametrize("why", ["fast", "put down inside", "changed", "gravity"])
def test_what_is_not_slow_is_simulated_in_its_own_time(model: Model, why: str) -> None:
    looks = round(SETTLING / 2 / LOOK)
    centres = np.array([centre(model, -0.01 if why == "gravity" else DEPTH)] * looks)
    if why == "fast":
        centres = np.array([centre(model, depth) for depth in np.linspace(-CLEAR, DEPTH, looks)])
    if why == "gravity":
        model = replace(model, gravity=np.array((0.0, 0.0, -9.81)))
    own, quick = Session(model), start(model, FASTER, 1e-3)
    if why == "changed":
        softer = replace(model, matching=replace(model.matching, k1=model.matching.k1 / 2))
        for each in (own, quick):
            press(each, np.array([centre(model, DEPTH * min(t, 1.0)) for t in np.linspace(-0.02, 3, 150)]))
            each.change(softer)
    before = own.frame.total_steps, quick.frame.total_steps
    assert why != "changed" or before[0] > 1.4 * before[1]
    (goal, skins), (forces, others) = press(own, centres), press(quick, centres)
    assert quick.frame.total_steps - before[1] == own.frame.total_steps - before[0] > 0
    assert np.abs(skins[-1] - model.mesh.rest_positions).max() > 1e-5, "something happens"
    np.testing.assert_allclose(forces, goal, rtol=1e-3, atol=1e-3)
    assert max(np.abs(a - b).max() for a, b in zip(skins, others, strict=True)) < 2e-6


def test_only_a_slow_press_on_a_pinned_body_is_simulated_faster(model: Model) -> None:
    slow = Pressed(((0.0, 0.0, 0.08),), RADIUS, DEPTH, slow_speed(model))
    assert times_faster(model, slow, *TOLERANCES)[0] == FASTER
    assert times_faster(model, slow._replace(speed=slow.speed / 100), *TOLERANCES)[0] == 8, "and no more"
    free = build_model(model.mesh, [BALL])
    rigged = replace(model, rigged=True)
    for other in (free, rigged):
        assert times_faster(other, slow, *TOLERANCES) == (1, 0.0)
    for press in (
        slow._replace(speed=5 * slow.speed), slow._replace(depth=DEPTH / 5), slow._replace(depth=0.0), slow.where,
        slow._replace(speed=0.0),
    ):  # fmt: skip
        assert times_faster(model, press, *TOLERANCES) == (1, 0.0)
    assert times_faster(model, slow, TOLERANCES[0], 0.02)[0] == 1, "a tolerance that is tighter"
    assert times_faster(model, slow, 0.1e-3, 0.1)[0] == 1
    soft = replace(model.matching, k1=np.where(np.arange(len(model.mass)) == 5, 1 / 25, 1.0) * model.matching.k1)
    assert times_faster(replace(model, matching=soft), slow, *TOLERANCES)[0] == 1, "a part of it answers slowly"


def test_the_planner_simulates_the_full_mesh_faster_where_that_makes_it_live(model: Model) -> None:
    slow = Pressed(((0.0, 0.0, 0.08),), RADIUS, DEPTH, slow_speed(model))
    cost = plan(model, budget=1e9).cost
    quick = plan(model, budget=0.3 * cost, radius=RADIUS, pressed=slow)
    assert (quick.proxy, quick.faster) == (None, FASTER) and quick.cost == pytest.approx(cost / FASTER)
    assert "runs live with 1/4 of its steps, within 4% of the force: 642 vertices" in quick.reason
    assert plan(model, budget=0.3 * cost, radius=RADIUS, pressed=slow._replace(speed=1.0)).faster == 1
    assert plan(model, budget=0.3 * cost, radius=RADIUS).faster == 1
    assert plan(model, budget=cost, radius=RADIUS, pressed=slow).faster == 1, "it runs live as it is"


def test_pins_are_led_in_steps_that_are_no_whole_ticks(model: Model) -> None:
    """The first part of a tick may begin before the step does: pins wait for it where they are."""
    session, places = start(model, FASTER, np.inf), model.mesh.rest_positions
    for step in range(1, 8):
        session.set_pins(places + (1e-3 * step, 0, 0))
        session.step(2.5 * TICK * FASTER)
    assert session.frame.finite
    session.step(2.5 * TICK * FASTER)
    moved = session.positions()[base_vertices(model.mesh)] - places[base_vertices(model.mesh)]
    np.testing.assert_allclose(moved, np.broadcast_to((7e-3, 0, 0), moved.shape), atol=1e-6)
