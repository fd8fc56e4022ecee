"""The library and its numpy twin let bodies meet alike."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from core import native
from core.body.model import Model, build_model
from core.material import Material
from core.mesh.surface import mesh_from_triangles
from core.native.motion import Motion
from core.native.scene import Collider, ColliderMotion
from core.session import Session
from core.world import World
from studies.contact.meeting import met
from studies.reference.twin import Twin
from studies.reference.twin_scene import TwinScene
from tests.bodies import ball, block, sheet

SOFT = Material(K1=600, K2=7000, x0=0.01, k=600, mass=0.2)


@pytest.fixture
def in_either(monkeypatch: pytest.MonkeyPatch) -> None:
    """A world of twins is stepped by the twin of a scene."""
    own = native.Scene

    def scene(bodies: Sequence[Any], colliders: Sequence[Collider], library: Any, **options: Any) -> Any:
        if isinstance(bodies[0], Twin):
            return TwinScene(bodies, colliders, **options)
        return own(bodies, colliders, library, **options)

    monkeypatch.setattr(native, "Scene", scene)


def sessions(model: Model) -> list[Session]:
    """Return a session of the library and one of its twin."""
    pair = [Session(model, backend="native64") for _ in range(2)]
    pair[1].body = Twin(model)
    return pair


@pytest.mark.parametrize("offsets", [(), (1e-3, 0.0)], ids=["by edges", "as given"])
def test_two_balls_on_a_moving_sheet_go_the_same_way(offsets: tuple[float, ...]) -> None:
    models = []
    for fill, at in (("air", (0.003, 0.001, 0.0525)), ("solid", (0.008, 0.002, 0.1575))):
        (points, faces), material = ball(1, 0.05), replace(SOFT, fill=fill)
        models.append(build_model(mesh_from_triangles(points + at, faces), [material], gravity=(0, 0, -9.81)))
    floor, faces = sheet(5, 0.4)
    collider, start = Collider(floor.T.copy(), faces, 0.5), floor.T.copy()
    substeps = max(model.substeps(1e-3) for model in models)
    own, twins = [native.Body(m, native.library(), bits=64) for m in models], [Twin(m) for m in models]
    scenes = (
        native.Scene(own, [collider], native.library(), itself=[True, False], offsets=offsets),
        TwinScene(twins, [collider], itself=[True, False], offsets=offsets),
    )
    most = 0
    for _ in range(5):
        way = ColliderMotion(start, start + [[3e-4], [0.0], [0.0]])
        found = [scene.step([Motion(10, substeps, 1e-3)] * 2, [way], 0.1, 1.0) for scene in scenes]
        start, most = way.end, max(most, found[0].touching)
        assert found[0].touching == found[1].touching
        assert np.abs(found[0].impulses - found[1].impulses).max() < 1e-9
        for body, twin in zip(own, twins, strict=True):
            assert np.abs(body.positions() - twin.positions()).max() < 1e-9
    assert most >= 2


def test_a_sheet_slides_alike_over_squares_finer_than_its_own() -> None:
    (points, faces), (flat, squares), rng = sheet(3, 0.06), sheet(12, 0.12), np.random.default_rng(0)
    points = points @ [[0.92, 0.39, 0], [-0.39, 0.92, 0], [0, 0, 1]] + (0, 0, 2.2e-3)
    points[:, 2] += rng.uniform(0, 3e-4, len(points))
    flat[:, 2] += rng.uniform(-4e-4, 4e-4, len(flat))
    model = build_model(mesh_from_triangles(points, faces), [SOFT], gravity=(0, 0, -9.81))
    collider = [Collider(flat.T.copy(), squares, 0.3)]
    bodies = own, twin = native.Body(model, native.library(), bits=64), Twin(model)
    scenes = (
        native.Scene([own], collider, native.library(), itself=[False]),
        TwinScene([twin], collider, itself=[False]),
    )
    for body in bodies:
        body.set_state(model.mesh.rest_positions.T, np.full((3, 16), [[0.5], [0.1], [0.0]]))
    for _ in range(2):
        found = [scene.step([Motion(5, model.substeps(1e-3), 1e-3)], [None], 0.1, 1.0) for scene in scenes]
        assert np.abs(found[0].impulses - found[1].impulses).max() < 1e-9 < np.abs(found[0].impulses[0]).max()
        assert np.abs(found[0].given - found[1].given).max() < 1e-9 < np.abs(found[0].given).max()
        assert np.abs(own.positions() - twin.positions()).max() < 1e-9


def test_neither_lets_a_collider_through_however_fast() -> None:
    points, faces = ball(1, 0.05)
    model = build_model(mesh_from_triangles(points, faces), [SOFT], gravity=(0, 0, 0), pinned=points[:, 2] < -0.02)
    tip, tip_faces = ball(0, 0.015)
    start = (tip + (0.002, 0.001, 0.08)).T.copy()
    collider, motion = Collider(start, tip_faces, 0.5), [Motion(20, model.substeps(1e-3), 1e-3)]
    way = ColliderMotion(start, start - [[0.0], [0.0], [0.14]])  # through what is pinned too
    for scene in (
        native.Scene([native.Body(model, native.library())], [collider], native.library(), itself=[True]),
        TwinScene([Twin(model)], [collider], itself=[True]),
    ):
        frame = scene.step(motion, [way], 0.05, 1.0)
        assert frame.frames[0].finite and frame.late[1] > 0
        assert scene.crossings().pairs == 0


def test_a_body_that_sleeps_wakes_alike_before_another_touches_it() -> None:
    models = []
    for at in ((0.0, 0.0, 0.0), (0.003, 0.002, 0.16)):
        points, faces = ball(0, 0.05)
        models.append(build_model(mesh_from_triangles(points + at, faces), [SOFT], gravity=(0, 0, 0)))
    own, twins = [native.Body(m, native.library(), bits=64) for m in models], [Twin(m) for m in models]
    for bodies in (own, twins):
        bodies[1].set_state(models[1].mesh.rest_positions.T, np.full((3, 12), [[0.0], [0.0], [-0.2]]))
    scenes = native.Scene(own, [], native.library(), itself=[False] * 2), TwinScene(twins, [], itself=[False] * 2)
    slept = []
    for _ in range(8):
        found = [scene.step([Motion(50, 4, 1e-3)] * 2, [], 0.1, 1.0) for scene in scenes]
        assert [f.moved for f in found[0].frames] == [f.moved for f in found[1].frames]
        slept.append(not found[0].frames[0].moved)
        for body, twin in zip(own, twins, strict=True):
            assert np.abs(body.positions() - twin.positions()).max() < 1e-9
    assert slept[5] and not slept[-1]
    assert own[0].velocities()[2].mean() < -0.01


@pytest.mark.usefixtures("in_either")
def test_props_fall_alike_on_each_other_on_a_table_and_on_the_ground() -> None:
    size, turns = (0.06, 0.05, 0.03), [(0.1, 0.1, 0.3), (0.1, 0.05, 1.3)]
    boxes = [block(size, (1 + 0.01 * k, 0.003 * k, 0.026 + 0.034 * k), turn) for k, turn in enumerate(turns)]
    boxes.append(block(size, (2.0, 0.0, 0.026), (0.2, 0.1, 0.3)))
    points, faces = sheet(2, 0.6)
    shapes = [(points + [1.0, 0.0, 0.0], faces), *boxes]
    colliders = [Collider(np.ascontiguousarray(x.T), corners) for x, corners in shapes]
    points, faces = ball(0, 0.05)
    model = build_model(mesh_from_triangles(points, faces), [SOFT], pinned=points[:, 2] < 0)
    worlds = [World([each], colliders, masses=[None, 0.5, 0.3, 0.2], ground=0.0) for each in sessions(model)]
    for world in worlds:
        for state in [prop.state for prop in world.props.values()]:
            state.velocity = np.array([0.1, 0.0, -0.3])
    most = 0
    for _ in range(8):
        found = [met(world, 0.005) for world in worlds]
        most = max(most, found[0].touching)
        assert found[0].touching == found[1].touching and found[0].truncated == found[1].truncated
        assert np.abs(found[0].forces - found[1].forces).max() < 1e-8
        for one, twin in zip(*([prop.state for prop in world.props.values()] for world in worlds), strict=True):
            assert np.abs(one.centre - twin.centre).max() < 1e-10 and np.abs(one.turn - twin.turn).max() < 1e-9
    assert most >= 4


@pytest.mark.usefixtures("in_either")
def test_a_prop_falls_alike_on_a_soft_body() -> None:
    points, faces = ball(1, 0.05)
    model = build_model(mesh_from_triangles(points, faces), [SOFT], pinned=points[:, 2] < 0)
    start, corners = block((0.03, 0.03, 0.02), (0.01, 0.0, 0.0605), (0.1, 0.0, 0.2))
    worlds = [World([each], [Collider(start.T.copy(), corners)], masses=[0.1]) for each in sessions(model)]
    for world in worlds:
        world.props[0].state.velocity = np.array([0.0, 0.0, -0.2])
    for _ in range(4):
        found = [met(world, 0.005) for world in worlds]
        assert np.abs(found[0].forces - found[1].forces).max() < 1e-7
        assert np.abs(worlds[0].props[0].state.centre - worlds[1].props[0].state.centre).max() < 1e-10
        assert np.abs(worlds[0].sessions[0].body.positions() - worlds[1].sessions[0].body.positions()).max() < 1e-9
    assert found[0].forces[1, 2] > 0.1
