"""A session goes on as another model from where it is: constants are tuned while a fingertip rests in the body."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from core.base import DimpleError
from core.body.model import Model, build_model
from core.material import Indenter, Material
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.reduction.proxy import build_proxy, with_constants
from core.session import Finger, Session
from studies.paper_objects import PRESETS
from studies.scenes import cube
from tests.bodies import ball

RADIUS, TIP = 0.08, 0.02
BALL_TIP = Indenter(shape="sphere", radius=TIP)
SOFT = Material(K1=600, K2=2000, x0=0.02, k=600, mass=0.5, damping_ratio=0.5, fill="none", indenter=BALL_TIP)
STIFF = replace(SOFT, K1=1800, K2=6000, k=1800)
CHANGES = [
    replace(SOFT, K1=1800), replace(SOFT, K2=9000), replace(SOFT, x0=0.015), replace(SOFT, k=3000),
    replace(SOFT, mass=2.0), replace(SOFT, damping_ratio=1.5), replace(SOFT, friction=0.0), replace(SOFT, spread=0.03),
]  # fmt: skip
MAPS = ("softness", "knee", "spread")


def on_its_base(mesh: Mesh, material: Material = SOFT, **maps: Any) -> Model:
    return build_model(mesh, [material], pinned=base_vertices(mesh), **maps)


def pressed(model: Model, depth: float = 0.01, **options: object) -> Session:
    session = Session(model, **options)  # type: ignore[arg-type]
    for at in (0.0, depth):
        session.set_fingers([Finger((0.0, 0.0, RADIUS + TIP - at), TIP)])
        session.step(0.05)
    session.step(0.5)
    return session


def force(session: Session) -> float:
    return float(np.linalg.norm(session.frame.finger_forces[0]))


@pytest.mark.parametrize("material", CHANGES)
def test_a_changed_constant_acts_at_once_and_nothing_jumps(material: Material) -> None:
    mesh = mesh_from_triangles(*ball(1, RADIUS))
    session = pressed(on_its_base(mesh))
    before = session.positions()
    session.change(on_its_base(mesh, material))
    np.testing.assert_array_equal(session.positions(), before)
    frame = session.step(1 / 60)
    assert np.abs(session.positions() - before).max() < 0.1 * 0.01, "of the depth, a frame later"
    assert frame.pushes[0] == pytest.approx(material.law(frame.depths[0]), rel=1e-6)
    session.step(1.0)
    wanted = pressed(on_its_base(mesh, material))
    wanted.step(1.0)
    assert force(session) == pytest.approx(force(wanted), rel=1e-3)
    assert np.abs(session.positions() - wanted.positions()).max() < 0.1 * 0.01, "of the depth: friction remembers"


@pytest.mark.parametrize("name", MAPS)
def test_a_changed_map_acts_at_once_and_nothing_jumps(name: str) -> None:
    mesh = mesh_from_triangles(*ball(1, RADIUS))
    painted = on_its_base(mesh, **{name: 0.3 + 0.5 * (mesh.rest_positions[mesh.source][:, 2] > 0)})
    session = pressed(on_its_base(mesh))
    before, first = session.positions(), force(session)
    session.change(painted)
    session.step(0.001)
    assert np.abs(session.positions() - before).max() < 0.015 * 0.01, "of the depth, a tick later"
    session.step(1.0)
    wanted = pressed(painted)
    wanted.step(1.0)
    assert force(session) == pytest.approx(force(wanted), rel=1e-3)
    if name == "softness":  # the knee matters deeper, the spread for the shape
        assert force(session) != pytest.approx(first, rel=0.01)


SIZE = 0.165
TUNED: dict[str, dict[str, Any]] = {
    "K1": {"K1": 1220}, "spread": {"spread": 0.03}, "fill": {"fill": "none"}, "mass": {"mass": 0.4},
    "friction": {"friction": 0.2}, "pressure": {"pressure": 2e3},
}  # fmt: skip


@pytest.mark.parametrize("newtons", [None, 8.0], ids=["by depth", "by force"])
@pytest.mark.parametrize("name", TUNED)
def test_what_is_tuned_under_a_resting_fingertip_acts_at_once_and_the_skin_does_not_jump(
    name: str, newtons: float | None
) -> None:
    """From frame to frame it moves by less than a tenth of the depth, and the fingertip feels the new law."""
    mesh, vinyl = cube(20, SIZE), PRESETS[1].material
    tuned, radius, aside = replace(vinyl, **TUNED[name]), vinyl.indenter.radius, (0.003, 0.002)
    session = Session(build_model(mesh, [vinyl], pinned=base_vertices(mesh)))
    for depth in (0.0, 0.0 if newtons else 0.01):
        session.set_fingers([Finger((*aside, SIZE / 2 + radius - depth), radius, newtons)])
        session.step(0.5)
    deep, seen = session.frame.depths[0], [session.positions()]
    session.change(build_model(mesh, [tuned], pinned=base_vertices(mesh)))
    for _ in range(30):
        frame = session.step(1 / 60)
        assert frame.pushes[0] == pytest.approx(tuned.law(frame.depths[0]), rel=1e-6)
        seen.append(session.positions())
    moved = np.linalg.norm(np.diff(seen, axis=0), axis=2).max(axis=1) / deep
    if newtons is None:
        assert moved.max() < 0.1 and frame.depths[0] == pytest.approx(deep, rel=1e-3)
    else:
        assert frame.pushes[0] == pytest.approx(newtons, rel=1e-3)
    assert moved[-1] < 1e-3


def test_a_body_that_is_filled_while_it_is_pressed_takes_its_volume_back() -> None:
    mesh = mesh_from_triangles(*ball(1, RADIUS))
    session = pressed(on_its_base(mesh))
    before = session.positions()
    assert session.frame.volume < 0.993 * session.frame.rest_volume
    session.change(on_its_base(mesh, replace(SOFT, fill="liquid")))
    np.testing.assert_array_equal(session.positions(), before)
    frame = session.step(0.5)
    assert frame.volume == pytest.approx(frame.rest_volume, rel=1e-3) and frame.pressure > 0


@pytest.mark.parametrize("before, after", [(3e5, 0.0), (0.0, 1e5), (1e5, -5e4)])
def test_a_pressure_that_is_let_out_in_one_frame_lets_the_body_go_to_its_rest_and_not_blow_up(
    before: float, after: float
) -> None:
    mesh = cube(8, 0.165)
    models = [build_model(mesh, [replace(PRESETS[1].material, pressure=each)], pinned=base_vertices(mesh))
              for each in (before, after)]  # fmt: skip
    session, anew = map(Session, models)
    for _ in range(4):
        session.step(0.25), anew.step(0.25)
    session.change(models[1])
    for _ in range(60):
        assert not session.step(1 / 60).note
    assert session.frame.volume == pytest.approx(anew.frame.volume, rel=0.01)


def test_a_proxy_takes_other_constants_too() -> None:
    mesh = mesh_from_triangles(*ball(3, RADIUS))
    model = on_its_base(mesh)
    proxy = build_proxy(model, 160)
    session = pressed(model, proxy=proxy)
    before, first = session.positions(), force(session)
    stiff = on_its_base(mesh, STIFF)
    session.change(stiff, proxy=with_constants(proxy, stiff))
    np.testing.assert_array_equal(session.positions(), before)
    session.step(0.5)
    wanted = pressed(stiff, proxy=build_proxy(stiff, 160))
    assert force(session) == pytest.approx(force(wanted), rel=0.02) and force(session) > 2 * first


@pytest.mark.parametrize("forth", [True, False])
def test_a_body_goes_on_as_its_proxy_and_back(forth: bool) -> None:
    mesh = mesh_from_triangles(*ball(3, RADIUS))
    model = build_model(mesh, [replace(SOFT, damping_ratio=0.05)], gravity=(0.0, 0.0, -9.81))
    proxy = build_proxy(model, 300)
    session = Session(model, proxy=None if forth else proxy)
    session.step(0.1)
    before = session.positions()
    session.change(model, proxy=proxy if forth else None)
    assert np.abs(session.positions() - before).max() < 0.001 * RADIUS
    session.step(0.1)
    fallen = (session.positions() - mesh.rest_positions).mean(axis=0)
    assert fallen == pytest.approx([0, 0, -9.81 / 2 * 0.2**2], rel=0.02, abs=1e-4), "it falls on as fast as it was"


def test_a_body_of_another_size_keeps_its_shape_and_its_swing() -> None:
    mesh, twice = (mesh_from_triangles(*ball(1, factor * RADIUS)) for factor in (1, 2))
    session = Session(on_its_base(mesh))
    session.body.set_state(mesh.rest_positions.T, np.where(on_its_base(mesh).pinned, 0.0, 0.1) * np.ones((3, 1)))
    session.step(0.01)
    before, speed = session.positions(), session.body.velocities()
    session.change(on_its_base(twice), scale=2.0)
    np.testing.assert_allclose(session.positions(), 2 * before, atol=1e-7)
    np.testing.assert_allclose(session.body.velocities(), 2 * speed, atol=1e-6)


def test_a_change_that_cannot_be_simulated_is_refused_and_the_body_goes_on() -> None:
    mesh = mesh_from_triangles(*ball(1, RADIUS))
    session = pressed(on_its_base(mesh))
    first = force(session)
    with pytest.raises(DimpleError, match="steps"):
        session.change(on_its_base(mesh, replace(SOFT, mass=1e-10)))
    with pytest.raises(DimpleError, match="vertices of the mesh have changed"):
        session.change(on_its_base(mesh_from_triangles(*ball(0, RADIUS))))
    session.step(0.2)
    assert force(session) == pytest.approx(first, rel=1e-3) and session.model.materials[0] == SOFT
