"""The native core does what numpy does: every law, on whole, degenerate and real meshes."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from core.base import Floats
from core.body.model import Model, build_model
from core.material import FINGERTIP
from core.mesh.surface import base_vertices
from core.native import Body
from core.native.motion import Frame, Motion
from studies.motions import straight
from studies.reference import create
from tests.parity.cases import CASES, SIZE, SOFT, TICK, build, run

DOUBLE, SINGLE = 1e-9, 1e-4  # of the size
BACKENDS = pytest.mark.parametrize(("backend", "tolerance"), [("native64", DOUBLE), ("native", SINGLE)])


@cache
def go(name: str, backend: str) -> tuple[Body, Frame]:
    """Run a case, once for all tests that read how it ended."""
    model, velocities, motion = build(CASES[name])
    body = create(model, backend=backend)
    return body, run(body, velocities, motion)


def vectors(frame: Frame, field: str) -> Floats:
    return np.array([getattr(touch, field) for touch in frame.touches if touch])


@pytest.mark.parametrize("name", CASES)
@BACKENDS
def test_motion_pressure_depths_and_forces_are_those_of_numpy(name: str, backend: str, tolerance: float) -> None:
    wanted, expected = go(name, "numpy")
    body, found = go(name, backend)
    speed = np.abs(wanted.velocities()).max() + 1e-3
    assert expected.finite and found.finite and found.ticks == expected.ticks
    np.testing.assert_allclose(body.positions(), wanted.positions(), rtol=0, atol=tolerance * SIZE)
    np.testing.assert_allclose(body.velocities(), wanted.velocities(), rtol=0, atol=300 * tolerance * speed)
    pushed = vectors(expected, "impulse")
    most = np.abs(pushed).max(initial=0.0) + 1e-6
    np.testing.assert_allclose(vectors(found, "impulse"), pushed, rtol=0, atol=100 * tolerance * most)
    assert found.pressure == pytest.approx(expected.pressure, rel=100 * tolerance, abs=1e5 * tolerance)
    assert found.volume == pytest.approx(expected.volume, rel=100 * tolerance, abs=tolerance * SIZE**3)
    for touch, twin in zip(found.touches, expected.touches, strict=True):
        assert touch and twin
        most = 10 * tolerance * SIZE * SOFT.K2 + tolerance * float(np.linalg.norm(twin.force))
        assert touch.depth == pytest.approx(twin.depth, abs=10 * tolerance * SIZE)
        assert touch.force == pytest.approx(twin.force, abs=most)
        assert touch.slope == pytest.approx(twin.slope, rel=100 * tolerance) and touch.friction == twin.friction
        assert touch.law == pytest.approx(twin.law, rel=100 * tolerance)
        np.testing.assert_allclose(touch.outward, twin.outward, atol=max(100 * tolerance, 1e-6))


@pytest.mark.parametrize("weights", [(1, 1, 1), (0, 0, 1)], ids=["face", "vertex"])
@BACKENDS
def test_a_fingertip_whose_centre_lies_on_the_skin_pushes_as_with_numpy(
    backend: str, tolerance: float, weights: tuple[int, ...]
) -> None:
    """The nearest point is the centre itself: no direction may be left to rounding."""
    model, velocities, motion = build(CASES["no fill"])
    corners = model.mesh.triangles[np.argmax(model.mesh.rest_positions[model.mesh.triangles].mean(axis=1)[:, 2])]
    centre = tuple(np.average(model.mesh.rest_positions[corners], axis=0, weights=weights).tolist())
    radius = motion.fingertips[0].radius  # type: ignore[union-attr]
    tip = straight(centre, centre, ticks=1, radius=radius, fresh=True)
    ends = []
    for name in ("numpy", backend):
        body = create(model, backend=name)
        run(body, velocities, motion._replace(ticks=1, fingertips=(tip,)))
        ends.append(body.positions())
    assert np.average((ends[0] - model.matching.rest)[2, corners], weights=weights) < -0.1 * radius
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=tolerance * SIZE)


CRUSHED = {"mirrored": (1, 0.8, -0.6), "flat": (1, 0.8, 0), "nearly flat": (1, 0.8, 1e-9), "a line": (1, 0, 0)}


@pytest.mark.parametrize("name", [*CRUSHED, "a point"])
def test_a_body_that_is_crushed_and_turned_goes_where_that_of_numpy_goes(name: str) -> None:
    """Its shape at rest is turned by the best rotation that is no reflection; about a line and a point any will do."""
    model, _, motion = build(CASES["free"])
    q, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    crushed = (q * np.linalg.det(q)) @ np.diag(CRUSHED.get(name, (0, 0, 0))) @ model.matching.rest
    still, alone, ends = np.zeros_like(crushed), motion._replace(ticks=2, fingertips=()), []
    for kind in ("numpy", "native64"):
        body = create(model, backend=kind)
        assert run(body, still, alone, positions=crushed).finite
        ends.append(body.positions())
    assert np.abs(ends[0] - crushed).max() > 1e-6 * SIZE
    if name in ("mirrored", "flat", "nearly flat"):
        np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=DOUBLE * SIZE)


def test_what_is_held_stays_to_the_last_digit() -> None:
    body, _ = go("liquid", "native")
    pinned = body.model.pinned
    np.testing.assert_array_equal(body.positions()[:, pinned], body.model.matching.rest[:, pinned])


def test_pins_that_arrive_are_where_they_were_sent_to_the_last_digit() -> None:
    model, velocities, motion = build(CASES["moving pins"])
    assert motion.pins
    body = create(model, backend="native")
    run(body, velocities, motion._replace(pins=motion.pins._replace(last=1.0)))
    np.testing.assert_array_equal(body.positions()[:, model.pinned], motion.pins.end)
    body.step(motion._replace(pins=None, fingertips=()))
    np.testing.assert_array_equal(body.positions()[:, model.pinned], motion.pins.end)


def test_a_free_body_far_from_the_origin_moves_as_one_near_it() -> None:
    """Single precision is spent on the body, not on where it is."""
    model, velocities, motion = build(CASES["free"])
    away, ends = np.array([[100.0], [-50.0], [3.0]]), []
    for shift in (0 * away, away):
        body = create(model, backend="native")
        run(body, velocities, motion._replace(fingertips=()), positions=model.matching.rest + shift)
        ends.append(body.positions() - shift)
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-6 * SIZE)


def test_a_body_that_flies_a_hundred_times_its_size_keeps_its_shape() -> None:
    """The origin from which positions are counted follows it, and nothing is lost on the way."""
    model, _, motion = build(CASES["free"])
    speed = 100 * SIZE / 0.2 * np.array([[1.0], [-0.5], [0.2]])
    body = create(model, backend="native")
    frame = run(body, np.zeros_like(model.matching.rest) + speed, motion._replace(ticks=200, fingertips=()))
    assert frame.finite
    flown = body.positions() - model.matching.rest
    np.testing.assert_allclose(flown.mean(axis=1), 0.2 * speed[:, 0], rtol=1e-4)
    assert np.ptp(flown, axis=1).max() < 1e-4 * SIZE


def others(model: Model) -> list[Model]:
    """Return models of the same mesh: other fills, pins and numbers."""
    height = model.mesh.rest_positions[model.mesh.source, 2]
    base, top = base_vertices(model.mesh), height >= height.max() - 0.1 * np.ptp(height)
    air = replace(SOFT, fill="air", K1=300, K2=900)
    return [
        build_model(model.mesh, [SOFT], pinned=base),
        build_model(model.mesh, [replace(SOFT, mass=0.1, K1=3 * SOFT.K1, k=3 * SOFT.k)], pinned=base),
        build_model(model.mesh, [air], pinned=top),
        build_model(model.mesh, [replace(air, pressure=2e4)], pinned=top),
        build_model(model.mesh, [replace(SOFT, fill="none", friction=0.1)], gravity=(0, 0, -9.81)),
        build_model(model.mesh, [replace(SOFT, fill="solid", indenter=FINGERTIP)], pinned=base),
        build_model(model.mesh, [SOFT], pinned=base, softness=np.linspace(0, 1, len(model.mesh.source))),
        build_model(model.mesh, [air], ground=-0.5 * SIZE),
    ]


def test_laws_fill_and_pins_of_a_living_body_change_as_with_numpy() -> None:
    """What the constants say holds from the next tick on, whatever the body was made with."""
    model, _, motion = build(CASES["liquid"])
    models = others(model)
    bodies = [create(models[-1], backend=kind) for kind in ("numpy", "native64")]
    start, stop = (np.array(motion.fingertips[0][row]) for row in (0, 2))
    touched = 0
    for i, each in enumerate((*models, *models[::-1], *models[::2])):
        down, up = (tuple((start + (i / 20 + 0.05 * last) * (stop - start)).tolist()) for last in (0, 1))
        tip = straight(down, up, ticks=2, radius=0.1 * SIZE, fresh=i == 0)
        frames = []
        for body in bodies:
            body.set_constants(each)
            body.step(Motion(0, 1, TICK))
            frames.append(body.step(Motion(2, each.substeps(TICK), TICK, (tip,))))
        assert all(frame.finite for frame in frames)
        np.testing.assert_allclose(bodies[1].positions(), bodies[0].positions(), rtol=0, atol=1e-9 * SIZE)
        assert frames[1].pressure == pytest.approx(frames[0].pressure, rel=1e-6, abs=1e-3)
        twin, touch = (frame.touches[0] for frame in frames)
        assert twin and touch and touch.depth == pytest.approx(twin.depth, rel=1e-6)
        assert touch.force == pytest.approx(twin.force, rel=1e-6, abs=1e-9)
        assert touch.impulse == pytest.approx(twin.impulse, rel=1e-6, abs=1e-12)
        touched += touch.depth > 0
    assert touched >= 14, "at last it is pushed away"


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_fill_that_is_taken_out_leaves_no_pressure(backend: str) -> None:
    model, velocities, motion = build(CASES["liquid"])
    body = create(model, backend=backend)
    assert abs(run(body, velocities, motion).pressure) > 10
    body.set_constants(build_model(model.mesh, [replace(SOFT, fill="none")], pinned=base_vertices(model.mesh)))
    assert body.step(motion._replace(ticks=0)).pressure == 0
    assert body.step(motion).pressure == 0


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_body_that_is_pinned_while_it_lives_stays_where_it_is(backend: str) -> None:
    model, velocities, motion = build(CASES["free"])
    body = create(model, backend=backend)
    run(body, velocities, motion._replace(ticks=50, fingertips=()))
    pinned = build_model(model.mesh, [SOFT], pinned=base_vertices(model.mesh))
    before = body.positions()
    body.set_constants(pinned)
    body.step(motion._replace(ticks=300, fingertips=()))
    np.testing.assert_allclose(body.positions()[:, pinned.pinned], before[:, pinned.pinned], atol=1e-8)
    moved = np.abs(body.positions() - before).max()
    assert moved < 0.05 * SIZE, "it swings out where it was pinned, and does not fly back to where it was at rest"


@pytest.mark.parametrize("backend", ["numpy", "native"])
def test_a_body_that_blows_up_says_so_and_can_be_put_back(backend: str) -> None:
    model, velocities, motion = build(CASES["free"])
    wild = velocities.copy()
    wild[0, 5] = 1e30
    body, alone = create(model, backend=backend), motion._replace(fingertips=())
    for each in (alone, motion):  # a fingertip beside it slows the skin down
        frame = run(body, wild, each)
        assert not frame.finite and frame.ticks < motion.ticks
    assert run(body, velocities, motion).finite and np.isfinite(body.positions()).all()
