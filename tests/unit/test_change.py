"""A session goes on as another model from where it is: constants are tuned while a fingertip rests in the body."""

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from core.base import DimpleError
from core.body.model import Model, build_model
from core.material import PRESETS, Material
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.reduction.proxy import build_proxy, with_constants
from core.session import Finger, Session
from studies.scenes import cube
from tests.bodies import ball

SOFT = Material(K1=600, K2=2000, x0=0.02, k=600, mass=0.5, damping_ratio=0.5, fill="none")
RADIUS, TIP = 0.08, 0.02
STIFF = replace(SOFT, K1=1800, K2=6000, k=1800)
CHANGES = [
    replace(SOFT, K1=1800), replace(SOFT, K2=9000), replace(SOFT, x0=0.004), replace(SOFT, k=3000),
    replace(SOFT, mass=2.0), replace(SOFT, damping_ratio=1.5), replace(SOFT, friction=0.0), replace(SOFT, spread=0.03),
]  # fmt: skip
MAPS = ("softness", "knee", "spread", "thickness")


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
    session.step(0.001)
    assert np.abs(session.positions() - before).max() < 0.015 * 0.01, "of the depth, a tick later"
    session.step(1.0)
    wanted = pressed(on_its_base(mesh, material))
    wanted.step(1.0)
    assert force(session) == pytest.approx(force(wanted), rel=0.02)
    assert session.frame.law_forces[0] == pytest.approx(material.law(0.01), rel=1e-3)


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
    assert force(session) == pytest.approx(force(wanted), rel=0.02)
    if name in ("softness", "spread"):  # the others matter deeper, or while it moves
        assert force(session) != pytest.approx(first, rel=0.01)


FRAME_S, GLIDE_S = 1 / 60, 0.5  # of a frame, and until a change has come in
ASIDE = (0.37, 0.23)  # of an edge: how far beside a vertex is pressed
EDGE = 0.55  # radii of a fingertip: what Make Soft cuts edges to; on longer ones the skin may tremble
COARSE, FINE = 20, 41  # cells along an edge: 2,402 and 10,088 vertices
TUNED: dict[str, dict[str, Any]] = {
    "K1": {"K1": 1220}, "spread": {"spread": 0.03}, "fill": {"fill": "none"}, "mass": {"mass": 0.4},
    "pressure": {"pressure": 1e4},
}  # fmt: skip


@lru_cache
def vinyl_on(cells: int) -> tuple[Mesh, Material]:
    """Return the vinyl cube, and its material."""
    return cube(cells, 0.165), PRESETS[1].material


def pressed_cube(cells: int, material: Material, newtons: float | None) -> Session:
    """Return a vinyl cube under a fingertip, by 10 mm or by a force."""
    mesh, _ = vinyl_on(cells)
    edge = 0.165 / cells
    radius = max(0.01, edge / EDGE)
    session = Session(build_model(mesh, [material], pinned=base_vertices(mesh)))
    for depth in (0.0, 0.0 if newtons else 0.01):
        at = ASIDE[0] * edge, ASIDE[1] * edge, 0.165 / 2 + radius - depth
        session.set_fingers([Finger(at, radius, newtons)])
        session.step(0.5)
    return session


@lru_cache
def pressed_anew(cells: int, name: str, newtons: float | None) -> tuple[Model, float, float]:
    """Return the tuned cube, and how deep and with which force it is pressed from the beginning."""
    session = pressed_cube(cells, tuned(cells, name), newtons)
    deep = float(session.frame.depths[0])
    session.step(0.5)
    return session.model, deep, force(session)


def tuned(cells: int, name: str) -> Material:
    _, material = vinyl_on(cells)
    return replace(material, **TUNED[name])


@pytest.mark.parametrize("rate", [60, pytest.param(24, marks=pytest.mark.slow), 10])
@pytest.mark.parametrize("newtons", [None, 8.0], ids=["by depth", "by force"])
@pytest.mark.parametrize("name", TUNED)
@pytest.mark.parametrize("cells", [COARSE, pytest.param(FINE, marks=pytest.mark.slow)])
def test_a_resting_pressed_body_glides_to_its_new_rest(
    cells: int, name: str, newtons: float | None, rate: float
) -> None:
    """It moves in the first frame after the change, by less than 1 % of the depth, and ends as one pressed anew."""
    mesh, material = vinyl_on(cells)
    model, deep_anew, force_anew = pressed_anew(cells, name, newtons)
    session = pressed_cube(cells, material, newtons)
    deep = float(session.frame.depths[0])
    session.change(model, glide=True)
    seen = [session.positions()]
    for _ in range(round(GLIDE_S * rate)):
        session.step(1 / rate)
        seen.append(session.positions())
    moved = np.linalg.norm(np.diff(seen, axis=0), axis=2).max(axis=1) / deep
    print(f"{len(mesh.rest_positions)} {name} at {rate}: {moved[0]:.5f} of the depth at first, up to {moved.max():.4f}")
    assert 0 < moved[0] < 0.01
    session.step(0.5)
    if newtons:
        assert session.frame.depths[0] == pytest.approx(deep_anew, rel=0.05)
    else:
        assert force(session) == pytest.approx(force_anew, rel=0.05)


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
    x = session.positions()
    session.change(models[1], glide=True)
    session.step(FRAME_S)
    moved = np.linalg.norm(session.positions() - x, axis=1).max()
    for _ in range(60):
        assert not session.step(FRAME_S).note
    way = np.linalg.norm(session.positions() - x, axis=1).max()
    assert 0 < moved < 0.02 * way
    assert session.frame.volume == pytest.approx(anew.frame.volume, rel=0.01)


def test_a_constant_that_is_changed_back_gives_the_force_back() -> None:
    mesh = mesh_from_triangles(*ball(1, RADIUS))
    session = pressed(on_its_base(mesh))
    first = force(session)
    session.change(on_its_base(mesh, STIFF))
    session.step(0.3)
    assert force(session) > 2 * first
    session.change(on_its_base(mesh))
    session.step(1.0)
    assert force(session) == pytest.approx(first, rel=0.01)


def test_a_body_that_hardens_under_a_force_is_pressed_as_deep_as_one_that_was_hard_before() -> None:
    """Friction would hold the wider dent of the softer material open: a tenth of the depth and more."""
    mesh = mesh_from_triangles(*ball(4, RADIUS))
    tip = Finger((0.0, 0.0, 1.2 * RADIUS), 0.2 * RADIUS, 3.0)
    depths = []
    for materials in ([SOFT, STIFF], [STIFF]):
        session = Session(on_its_base(mesh, materials[0]))
        session.set_fingers([tip])
        session.step(1.0)
        for material in materials[1:]:
            session.change(on_its_base(mesh, material), glide=True)
            for _ in range(18):
                session.step(FRAME_S)
            assert session.body.model.friction.max() < 0.1 * material.friction
        for _ in range(10):
            session.step(0.1)
        assert (session.body.model.friction == STIFF.friction).all()
        depths.append(float(session.frame.depths[0]))
    assert depths[0] == pytest.approx(depths[1], rel=0.03)


def hardened(factor: float, changes: int, frames: int) -> tuple[list[float], float]:
    """Harden a body under a force so often, with frames between; return its depths, and that of one pressed anew."""
    mesh = mesh_from_triangles(*ball(4, RADIUS))
    tip = Finger((0.0, 0.0, 1.2 * RADIUS), 0.2 * RADIUS, 3.0)
    soft, *harder = [
        on_its_base(mesh, replace(SOFT, K1=K1, K2=3 * K1, k=K1)) for K1 in 600 * factor ** np.arange(changes + 1)
    ]
    session, anew = Session(soft), Session(harder[-1])
    for each in (session, anew):
        each.set_fingers([tip])
        each.step(1.0)
    depths = [float(session.frame.depths[0])]
    for model in harder:
        session.change(model, glide=True)
        depths += [float(session.step(FRAME_S).depths[0]) for _ in range(frames)]
    depths += [float(session.step(FRAME_S).depths[0]) for _ in range(60)]
    return depths, float(anew.step(1.0).depths[0])


def test_a_body_that_hardens_a_little_lets_the_fingertip_go_back_a_little() -> None:
    depths, anew = hardened(1.02, 1, 1)
    assert min(depths) > 0.97 * anew and depths[-1] == pytest.approx(anew, rel=0.01)


@pytest.mark.parametrize("factor, changes, frames", [(1.08, 20, 1), (1.26, 5, 6)], ids=["each frame", "now and then"])
def test_a_number_that_is_dragged_ends_where_one_that_is_typed_does(factor: float, changes: int, frames: int) -> None:
    depths, anew = hardened(factor, changes, frames)
    assert depths[-1] == pytest.approx(anew, rel=0.02)


@pytest.mark.parametrize("frames", [8, pytest.param(12, marks=pytest.mark.slow)])
def test_a_small_change_while_a_body_still_hardens_does_not_keep_its_wider_dent(frames: int) -> None:
    mesh = mesh_from_triangles(*ball(4, RADIUS))
    tip = Finger((0.0, 0.0, 1.2 * RADIUS), 0.2 * RADIUS, 3.0)
    depths = []
    for materials in ([SOFT, replace(STIFF, K1=1.05 * STIFF.K1, K2=1.05 * STIFF.K2), STIFF], [STIFF]):
        session = Session(on_its_base(mesh, materials[0]))
        session.set_fingers([tip])
        session.step(1.0)
        for material in materials[1:]:
            session.change(on_its_base(mesh, material), glide=True)
            for _ in range(frames):
                session.step(FRAME_S)
        for _ in range(12):
            session.step(0.1)
        depths.append(float(session.frame.depths[0]))
    assert depths[0] == pytest.approx(depths[1], rel=0.005)


def test_a_fingertip_gives_way_only_once_though_the_constants_are_given_anew_in_every_frame() -> None:
    """As while a map is painted, of which the fingertip's own place has its share already."""
    mesh = mesh_from_triangles(*ball(4, RADIUS))
    session = Session(on_its_base(mesh, SOFT))
    session.set_fingers([Finger((0.0, 0.0, 1.2 * RADIUS), 0.2 * RADIUS, 3.0)])
    session.step(1.0)
    for _ in range(90):
        session.change(on_its_base(mesh, STIFF), glide=True)
        session.step(FRAME_S)
    assert float(session.frame.finger_forces[0][2]) == pytest.approx(3.0, rel=0.02)


def test_the_force_returns_gently_after_a_change() -> None:
    depths, anew = hardened(3.0, 1, 1)
    assert np.diff(depths).max() < 0.1 * anew and depths[-1] == pytest.approx(anew, rel=0.02)


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


def test_pins_that_come_while_the_body_is_away_hold_it_where_it_is() -> None:
    mesh = mesh_from_triangles(*ball(1, RADIUS))
    session = Session(build_model(mesh, [SOFT], gravity=(0.0, 0.0, -9.81)))
    session.step(0.1)
    before, base = session.positions(), base_vertices(mesh)[mesh.source]
    assert before[:, 2].mean() < -0.04
    session.change(build_model(mesh, [SOFT], pinned=base_vertices(mesh)))
    session.step(0.5)
    np.testing.assert_allclose(session.positions()[base], before[base], atol=1e-7)
    assert np.abs(session.positions() - before).max() < 0.01 * RADIUS, "it hangs from them without a start"


def test_a_change_that_cannot_be_simulated_is_refused_and_the_body_goes_on() -> None:
    mesh = mesh_from_triangles(*ball(1, RADIUS))
    session = pressed(on_its_base(mesh))
    first = force(session)
    with pytest.raises(DimpleError, match="steps"):
        session.change(on_its_base(mesh, replace(SOFT, mass=1e-10)))
    with pytest.raises(DimpleError, match="other vertices"):
        session.change(on_its_base(mesh_from_triangles(*ball(0, RADIUS))))
    session.step(0.2)
    assert force(session) == pytest.approx(first, rel=1e-3) and session.model.materials[0] == SOFT
