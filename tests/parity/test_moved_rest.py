"""A shape at rest that moves while the body lives: native as numpy."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from core import native
from core.base import Floats
from core.body.model import Model, build_model
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.native import NativeError
from core.native.motion import Motion, PinMotion
from studies.reference import create
from tests.bodies import ball, hemisphere, sheet
from tests.parity.cases import SIZE, SOFT, TICK, Case, build

AGREE = {"native64": 1e-12, "native": 2e-5}  # of the size


def bent(rest: Floats, by: float = 0.3) -> Floats:
    """Return a shape (3, n) [m] bent about the y axis, the more the higher."""
    x, y, z = rest
    turn = by * z / SIZE
    return np.stack([x * np.cos(turn) + z * np.sin(turn), y, z * np.cos(turn) - x * np.sin(turn)])


def models() -> dict[str, Model]:
    made = {}
    for name, shape in (("ball", lambda: ball(2)), ("a hole", hemisphere), ("a sheet", sheet)):
        points, faces = shape()
        mesh = mesh_from_triangles(points * SIZE / np.ptp(points, axis=0).max(), faces)
        made[f"{name}, free"] = build_model(mesh, [SOFT])
        made[f"{name}, pinned"] = build_model(mesh, [SOFT], pinned=base_vertices(mesh))
        made[f"{name}, rigged"] = build_model(mesh, [SOFT], rigged=True)
        made[f"{name}, rigged and pinned"] = build_model(mesh, [SOFT], pinned=base_vertices(mesh), rigged=True)
    air = replace(SOFT, fill="air", pressure=5e3)
    made["air, rigged"] = build_model(made["ball, free"].mesh, [air], rigged=True)
    return made


MODELS = models()


def motion_of(model: Model, ticks: int) -> Motion:
    tips = build(Case(shape=lambda: ball(2), ticks=ticks))[2].fingertips
    return Motion(ticks=ticks, substeps=model.substeps(TICK), tick=TICK, fingertips=tips)


@pytest.mark.parametrize("backend", AGREE)
@pytest.mark.parametrize("name", MODELS)
def test_a_body_whose_shape_at_rest_moves_goes_where_that_of_numpy_goes(name: str, backend: str) -> None:
    (x, volume, frames), (y, volume_of_twin, of_twin) = moved(name, backend), moved(name, "numpy")
    assert np.abs(x - y).max() < AGREE[backend] * MODELS[name].mesh.size
    assert volume == pytest.approx(volume_of_twin, rel=1e-9)
    for frame, other in zip(frames, of_twin, strict=True):
        assert frame.pressure == pytest.approx(other.pressure, rel=1e-2, abs=1 if backend == "native" else 1e-3)
        for touch, same in zip(frame.touches, other.touches, strict=True):
            assert touch and same and touch.depth == pytest.approx(same.depth, abs=10 * AGREE[backend] * SIZE)
            most = 10 * AGREE[backend] * SIZE * SOFT.K2 + 1e-3 * AGREE[backend]
            assert touch.force == pytest.approx(same.force, rel=100 * AGREE[backend], abs=most)


@cache
def moved(name: str, backend: str) -> tuple[Floats, float, list[Any]]:
    """Bend the shape at rest under a fingertip and straighten it; return positions, volume at rest and frames."""
    model = MODELS[name]
    rest, body, motion = model.matching.rest, create(model, backend=backend), motion_of(model, 6)
    end = bent(rest)
    if model.pinned.any():
        motion = motion._replace(pins=PinMotion(rest[:, model.pinned], end[:, model.pinned], 1 / 6, 1.0))
    rate = (end - rest) / (6 * TICK)
    body.set_rest(end, rate, gain=rate / 2)
    frames = [body.step(motion), body.step(motion._replace(pins=None, fingertips=()))]
    body.set_rest(rest)
    frames.append(body.step(motion._replace(pins=None)))
    return body.positions(), body.rest_volume, frames


@pytest.mark.parametrize("backend", ["native", "numpy"])
def test_a_body_bent_at_once_and_put_there_is_at_rest(backend: str) -> None:
    model = MODELS["ball, rigged"]
    end = bent(model.matching.rest)
    body = create(model, backend=backend)
    body.set_rest(end)
    body.set_state(end)
    frame = body.step(motion_of(model, 50)._replace(fingertips=()))
    assert np.abs(body.positions() - end).max() < 1e-5 * SIZE
    assert frame.volume == pytest.approx(body.rest_volume, rel=1e-4)


def test_a_shape_at_rest_that_is_none_and_that_of_a_proxy_are_refused() -> None:
    model = MODELS["ball, rigged"]
    body = native.Body(model, native.library())
    rest = model.matching.rest
    for bad in (rest[:, 1:], np.where(rest > 0, np.nan, rest)):
        with pytest.raises(NativeError):
            body.set_rest(bad)
    with pytest.raises(NativeError):
        body.set_rest(rest, np.full_like(rest, np.inf))
    proxy = native.Body(model, native.library(), surface=MODELS["a hole, free"])
    with pytest.raises(NativeError):
        proxy.set_rest(rest)
