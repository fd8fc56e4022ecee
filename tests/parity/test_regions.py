"""Regions that rest: the native core steps what its numpy twin steps, tick by tick, and comes to the same place."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from core.base import TICK, Floats
from core.body.model import Model, build_model
from core.body.regions import divide
from core.material import PRESETS, Material
from core.mesh.surface import mesh_from_triangles
from core.native import Body
from core.solver.motion import FingertipMotion, Frame, Motion
from studies.reference import create
from tests.bodies import ball, hemisphere, sheet

RADIUS, SLACK, SPEED = 0.01, 5e-5, 0.1
FOAM = Material(K1=400, K2=1200, x0=0.01, k=500, mass=1.0, fill="none", spread=0.01)
AIR = replace(PRESETS[1].material, spread=0.01)
SHAPES = {
    "sheet": (lambda: sheet(24, 0.6), FOAM), "ball": (lambda: ball(3, 0.3), AIR),
    "hemisphere": (lambda: hemisphere(40, 20, 0.3), AIR),
}  # fmt: skip


def model_of(name: str) -> Model:
    shape, material = SHAPES[name]
    mesh = mesh_from_triangles(*shape())
    low = mesh.rest_positions[:, 2].min()
    x, y, z = mesh.rest_positions.T
    rim = z < low + 0.05 if np.ptp(z) > 0.1 else np.maximum(abs(x - x.mean()), abs(y - y.mean())) > 0.29
    return build_model(mesh, [material], pinned=rim)


def pressed(body: Body, model: Model) -> Iterator[Frame]:
    """Press near the top, slide to one side, rest, and let go; a constant is changed while it rests."""
    rest = model.mesh.rest_positions
    top = rest[rest[:, 2].argmax()] + [0.004, 0.003, 0.0]

    def at(tick: int) -> Floats:
        down, aside = min(tick * TICK * SPEED, 0.008), max(min(tick - 90, 50), 0) * TICK * SPEED
        return top + [aside, 0.0, RADIUS - down]

    for tick in range(420):
        tip = FingertipMotion.straight(
            tuple(at(tick)), tuple(at(tick + 1)), ticks=1, radius=RADIUS, fresh=tick == 0
        ) if tick < 320 else None
        if tick == 250:
            stiffer = [replace(each, K1=1.1 * each.K1) for each in model.materials]
            body.set_constants(build_model(model.mesh, stiffer, pinned=model.pinned))
        yield body.step(Motion(1, model.substeps(TICK) + 1, TICK, (tip,)))


@pytest.mark.parametrize("name", SHAPES)
def test_native_and_numpy_let_the_same_vertices_rest(name: str) -> None:
    model = model_of(name)
    bodies = [create(model, backend=backend, regions=divide(model, SLACK)) for backend in ("native64", "numpy")]
    stepped = []
    for frame, other in zip(*(pressed(body, model) for body in bodies), strict=True):
        (x, v), (there, speed) = ((body.positions(), body.velocities()) for body in bodies)
        assert np.abs(x - there).max() < 1e-11 and np.abs(v - speed).max() < 1e-7
        assert frame.volume == pytest.approx(other.volume, rel=1e-12, abs=1e-15)
        assert frame.pressure == pytest.approx(other.pressure, rel=1e-7, abs=1e-6)
        assert (frame.stepped, frame.moved) == (other.stepped, other.moved)
        stepped.append(frame.stepped)
    n = len(model.mass)
    assert stepped[0] < n - 8 and max(stepped) < n + 8 and len(set(stepped)) > 1


@pytest.mark.parametrize("name", SHAPES)
def test_single_precision_presses_as_hard(name: str) -> None:
    model = model_of(name)
    bodies = [create(model, backend=backend, regions=divide(model, SLACK)) for backend in ("native", "native64")]
    forces = [[frame.touches[0].impulse[2] for frame in pressed(body, model) if frame.touches[0]] for body in bodies]
    assert np.abs(np.diff(forces, axis=0)).max() < 0.01 * np.abs(forces).max()


def test_without_slack_that_anything_keeps_it_is_the_body_stepped_whole() -> None:
    """Every region is awake while a vertex of it moves at all, so nothing rests that would not."""
    model = model_of("ball")
    regions = divide(model, 0.0)
    everything = replace(
        regions, starts=np.arange(len(regions.starts)) * (len(regions.starts) - 1),
        beside=np.tile(np.arange(len(regions.starts) - 1), len(regions.starts) - 1),
    )  # fmt: skip
    ends = [create(model, backend="native64", regions=each) for each in (everything, None)]
    for body in ends:
        list(pressed(body, model))
    assert np.abs(ends[0].positions() - ends[1].positions()).max() < 1e-9
