"""What is seen of a skin is where its proxy carries it, as near as can be seen; what does not move costs nothing."""

from functools import partial

import numpy as np
import pytest

from core import native
from core.base import Floats, Singles
from core.body.model import Model, build_model
from core.mesh.surface import Mesh, base_vertices
from core.reduction.binding import carry
from core.reduction.kept_skin import SLACK, KeptSkin, edge_lengths
from core.reduction.proxy import Proxy, build_proxy
from core.session import Finger, Session
from studies import bodies
from studies.reference.carry import carry_moved

RADIUS, FRAME = 0.016, 1 / 60


@pytest.fixture(scope="module")
def model() -> Model:
    mesh = bodies.head(50, 0.2)
    return build_model(mesh, [bodies.GEL], pinned=base_vertices(mesh))


@pytest.fixture(scope="module")
def proxy(model: Model) -> Proxy:
    return build_proxy(model, 1000)


def press(session: Session, depth: float | None) -> None:
    """Go on by a frame with a fingertip so deep [m] in the top, None where it is lifted."""
    x, y, z = session.model.mesh.rest_positions[session.model.mesh.rest_positions[:, 2].argmax()].tolist()
    session.set_fingers([None if depth is None else Finger((x, y, z + RADIUS - depth), RADIUS)])
    session.step(FRAME)


def turned(mesh: Mesh, one: Singles, other: Singles) -> float:
    """Return the largest angle [degrees] between a face of one surface and that of another."""
    a, b = (faces / np.linalg.norm(faces, axis=1, keepdims=True) for faces in (across(mesh, one), across(mesh, other)))
    return float(np.degrees(2 * np.arcsin(np.linalg.norm(a - b, axis=1).max() / 2)))


def across(mesh: Mesh, skin: Singles) -> Floats:
    a, b, c = skin[mesh.triangles].astype(np.float64).transpose(1, 0, 2)
    return np.asarray(np.cross(b - a, c - a))


def off(proxy: Proxy, seen: Singles, skin: Singles) -> float:
    """Return how far what is seen is off at most, over what may be."""
    return float(np.linalg.norm(seen - skin, axis=1).max() / (SLACK * proxy.spacing))


def test_what_is_seen_of_a_press_is_where_it_is_and_slopes_as_it_does(model: Model, proxy: Proxy) -> None:
    session = Session(model, proxy=proxy)
    for frame in range(120):
        press(session, min(frame, 60) * 8e-5 if frame < 80 else None)
        seen, skin = session.seen(), session.positions()
        assert off(proxy, seen, skin) < 1.5
        assert frame % 7 or turned(model.mesh, seen, skin) < 0.3


def test_a_slow_motion_is_never_farther_off_however_long_it_lasts(proxy: Proxy) -> None:
    kept, rest = KeptSkin(proxy.binding), proxy.model.matching.rest
    for call in range(400):
        now = rest + call * 2e-3 * SLACK * proxy.spacing * np.sin(30 * rest[::-1])
        kept.follow(now)
        assert call % 20 or off(proxy, kept.positions, carry(proxy.binding, now)) < 1.5


def test_a_slow_press_carries_some_of_the_skin_and_one_that_is_held_none(model: Model, proxy: Proxy) -> None:
    session, kept, shares = Session(model, proxy=proxy), KeptSkin(proxy.binding), []
    for frame in range(120):
        press(session, min(frame, 60) * 5e-5)
        shares.append(kept.follow(session.body.positions()) / (len(proxy.binding.first) - 1))
    assert 0.05 < np.mean(shares[5:60]) < 0.6 and np.count_nonzero(shares[80:]) < 4


def test_what_does_not_move_is_the_same_array_and_what_sleeps_is_seen_to_the_bit(model: Model, proxy: Proxy) -> None:
    session = Session(model, proxy=proxy)
    assert np.array_equal(session.seen(), model.mesh.rest_positions.astype(np.float32))
    seen = []
    for frame in range(100):
        press(session, min(frame, 20) * 2e-4)
        seen.append(session.seen())
    assert seen[30] is not seen[0] and len({id(each) for each in seen[-40:]}) <= 2
    for _ in range(200):
        press(session, None)
        session.seen()
    assert not session.moved and np.array_equal(session.seen(), session.positions())


def test_pins_that_are_led_are_seen_where_they_are(model: Model, proxy: Proxy) -> None:
    session = Session(model, proxy=proxy)
    session.seen()
    rest = model.mesh.rest_positions
    for frame in range(10):
        session.set_pins(rest + (1e-5 * frame, 0, 0))
        session.step(FRAME)
        assert np.array_equal(session.seen()[proxy.still], session.positions()[proxy.still])


def test_the_native_core_carries_what_has_moved_as_numpy_does(proxy: Proxy) -> None:
    rest, lengths, m = proxy.model.matching.rest, edge_lengths(proxy.binding), len(proxy.seeds)
    follows = partial(native.carry_moved, native.library()), carry_moved
    states = [(*np.zeros((2, m, 12), np.float32), proxy.binding.rest.copy()) for _ in follows]
    counts = set()
    for call in range(40):
        now = rest + call**2 * 1e-7 * np.exp(-(((rest[:, :1] - rest) ** 2).sum(axis=0)) / 0.03**2)
        slack = 0.0 if call == 30 else SLACK
        ours, twins = (
            follow(proxy.binding, now, lengths, slack, 1 << call % 5, *state)
            for follow, state in zip(follows, states, strict=True)
        )
        counts.add(ours)
        assert ours == twins
        np.testing.assert_allclose(states[0][2], states[1][2], atol=1e-7)
    assert len(counts) > 5 and 0 in counts
