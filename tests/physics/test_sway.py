"""A body sways as solids do: modes against closed forms, exact in time, and nothing grows."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh

from core.body.lattice import fill, weight
from core.body.model import build_model
from core.body.modes import MODES, modes_of
from core.material import FINGERTIP, Material
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.recording.basis import reduce
from core.reduction.cells import vertex_normals
from core.reduction.proxy import build_proxy
from core.session import Finger, Session
from core.session.sway import Sway
from core.world import Collider, World
from studies.contact.meeting import meeting_of

JELLY = Material(K1=300, K2=675, x0=0.01, k=500, density=1040, fill="solid", indenter=FINGERTIP)


def ball(radius: float = 0.0825, subdivisions: int = 4) -> Mesh:
    made = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return mesh_from_triangles(made.vertices, made.faces)


def box(*sides: float, cells: int = 12) -> Mesh:
    made = trimesh.creation.box(sides).subdivide_to_size(max(sides) / cells)
    return mesh_from_triangles(made.vertices, made.faces)


def swaying(mesh: Mesh, held: Any, **options: Any) -> Sway:
    modes = modes_of(mesh, held)
    return Sway(mesh, held, modes, **{"frequency": 3.0, "density": 1040.0, "damping": 0.1, **options})


@pytest.mark.parametrize(("parts", "sways"), [(3, True), (5, False)])
def test_parts_that_nothing_holds_do_not_sway(parts: int, sways: bool) -> None:
    """Their rigid motions take the places of modes; where they take all, the body does not sway."""
    balls = [trimesh.creation.icosphere(2, 0.03).apply_translation((0.1 * k, 0, 0)) for k in range(parts)]
    made = trimesh.util.concatenate(balls)
    modes = modes_of(mesh_from_triangles(made.vertices, made.faces), (made.vertices[:, 0] < 0.03).astype(float))
    assert (modes is not None) == sways
    assert modes is None or modes.rates[0] == pytest.approx(modes.rates[1], rel=0.01), "of the held ball alone"



def energy(sway: Sway) -> float:
    """Return kinetic and elastic energy of the modes, over the density."""
    return float((sway._v**2 + (sway._rates * sway._q) ** 2).sum() / 2)


def session(**options: Any) -> Session:
    mesh = ball(subdivisions=3)
    return Session(
        build_model(
            mesh, [JELLY], pinned=base_vertices(mesh), **{"sway": (1.0, 3.0, 0.1, (0, 0, -9.81)), **options}
        )
    )


@pytest.mark.parametrize("mesh", [ball(), box(0.12, 0.08, 0.06), trimesh.creation.torus(0.08, 0.03)])
def test_a_lattice_weighs_what_the_body_weighs(mesh: Any) -> None:
    mesh = mesh if isinstance(mesh, Mesh) else mesh_from_triangles(mesh.vertices, mesh.faces)
    assert weight(fill(mesh)).sum() == pytest.approx(mesh.volume, rel=0.08)


def test_a_bar_that_is_pinned_at_its_end_swings_as_a_beam_does() -> None:
    """f = 1.875^2 / (2 pi L^2) sqrt(E I / (rho A)): Euler and Bernoulli; shear takes some 2 %."""
    mesh, side, length = box(0.03, 0.03, 0.2, cells=40), 0.03, 0.2
    held = (mesh.rest_positions[:, 2] < mesh.rest_positions[:, 2].min() + 1e-6).astype(float)
    rate = modes_of(mesh, held).rates[:2]
    beam = 1.8751**2 / length**2 * math.sqrt(side**2 / 12)
    assert rate == pytest.approx([beam, beam], rel=0.05)


def test_a_bone_holds_the_flesh_about_it() -> None:
    mesh = box(0.08, 0.08, 0.3, cells=24)
    at, none = mesh.rest_positions, np.zeros(len(mesh.rest_positions))
    bone = np.array([[at.min(axis=0), at.max(axis=0)]]) * (0, 0, 1)
    outside = np.array([[(0.5, 0, -1), (0.5, 0, 1)]])
    free, held, apart = (modes_of(mesh, none, bones=each) for each in (None, bone, outside))
    assert np.array_equal(apart.rates, free.rates), "it does not pass through the body"
    nodes = held.lattice.nodes - held.lattice.nodes.mean(axis=0)
    far, moved = np.abs(nodes[:, :2]).max(axis=1), np.linalg.norm(held.shapes[0], axis=1)
    assert moved[far < 0.02].max() < 0.3 * moved[far > 0.035].max()


def test_pins_hold_as_firmly_as_they_weigh() -> None:
    mesh = box(0.08, 0.08, 0.16, cells=16)
    high = (mesh.rest_positions[:, 2] > 0).astype(float)
    base = (mesh.rest_positions[:, 2] < mesh.rest_positions[:, 2].min() + 1e-6).astype(float)
    swung = []
    for weight_of_pin in (0.0, 0.3, 0.7, 1.0):
        sway = swaying(mesh, np.maximum(base, weight_of_pin * high))
        sway.advance(mesh.rest_positions, 0.01)
        for step in range(1, 5):
            sway.advance(mesh.rest_positions + (0.01 * step, 0, 0), 0.01)
        swung.append(np.linalg.norm(sway.displacement()[high > 0], axis=1).max())
    assert swung[0] > 1.2 * swung[1] > 1.2**2 * swung[2] > 0 and swung[3] < 1e-9


def test_a_free_body_has_no_mode_that_only_moves_it() -> None:
    mesh = ball()
    modes = modes_of(mesh, np.zeros(len(mesh.rest_positions)))
    assert modes.rates[0] > 0.1 * modes.rates[-1]
    momentum = np.einsum("m,kmc->kc", modes.volume, modes.shapes)
    assert np.abs(momentum).max() < 1e-6 * math.sqrt(mesh.volume)


@pytest.mark.parametrize("rate", [24, 60, 7])
def test_undamped_modes_keep_their_energy_at_any_rate(rate: int) -> None:
    mesh = ball(subdivisions=3)
    sway = swaying(mesh, base_vertices(mesh).astype(float), damping=0.0)
    still = mesh.rest_positions
    sway.advance(still, 0.1)
    sway.advance(still + [0.01, 0.02, 0.03], 0.1)
    sway.advance(still + [0.02, 0.04, 0.06], 0.1)
    sway.advance(still + [0.02, 0.04, 0.06], 0.1)
    sway.advance(still + [0.02, 0.04, 0.06], 0.1)
    before = energy(sway)
    assert before > 1e-9
    for _ in range(10 * rate):
        sway.advance(still + [0.02, 0.04, 0.06], 1 / rate)
    assert energy(sway) == pytest.approx(before, rel=1e-6)


def test_a_body_that_is_turned_on_its_side_sags_and_turned_back_is_as_it_was() -> None:
    mesh = box(0.05, 0.05, 0.1, cells=16)
    held = (mesh.rest_positions[:, 2] < mesh.rest_positions[:, 2].min() + 1e-6).astype(float)
    sway = swaying(mesh, held, damping=1.0, gravity=(0, 0, -9.81), frequency=6.0)
    turn, at = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0.0]]), mesh.rest_positions
    for _ in range(120):
        sway.advance(at @ turn.T, 1 / 30)
    tip = np.abs(at[:, 2] - at[:, 2].max()) < 1e-6
    sag = sway.displacement()[tip].mean(axis=0)
    assert sag[2] == pytest.approx(-1.57 * 9.81 / (12 * math.pi) ** 2, rel=0.15)  # 1.57 for a beam's first mode alone
    for _ in range(200):
        sway.advance(at, 1 / 30)
    assert np.abs(sway.displacement()).max() < 1e-4


def test_a_rotation_is_followed_and_moves_nothing_by_itself() -> None:
    mesh = ball(subdivisions=3)
    sway = swaying(mesh, base_vertices(mesh).astype(float), damping=1.0)
    for degree in range(0, 180, 3):
        c, s = math.cos(math.radians(degree)), math.sin(math.radians(degree))
        turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        sway.advance(mesh.rest_positions @ turn.T, 1 / 60)
    assert np.abs(sway._turn - turn).max() < 0.01


def test_large_sways_keep_the_volume() -> None:
    mesh = ball()
    sway = swaying(mesh, base_vertices(mesh).astype(float))

    def volume(at: Any) -> float:
        a, b, c = at[mesh.triangles].transpose(1, 0, 2)
        return float((a * np.cross(b, c)).sum() / 6)

    for frame in range(8):
        sway.advance(mesh.rest_positions + [0.04 * min(frame / 4, 1), 0, 0], 1 / 24)
    moved = sway.displacement()
    assert np.abs(moved).max() > 0.01
    assert volume(mesh.rest_positions + moved) == pytest.approx(volume(mesh.rest_positions), rel=0.005)


def test_a_body_that_nothing_touches_is_not_stepped() -> None:
    body = session()
    at = body.model.mesh.rest_positions[body.model.mesh.source]
    for frame in range(30):
        led = at + [0.02 * min(frame / 4, 1), 0, 0]
        body.set_pins(led)
        body.set_rest(led)
        body.step(1 / 60)
    assert np.abs(body.positions() - led).max() > 0.002
    assert np.allclose(body.body.positions().T, body.model.mesh.rest_positions, atol=1e-8), "the native body rests"


def test_a_body_that_is_touched_in_motion_goes_on_at_its_speed_however_firmly_it_is_held() -> None:
    mesh = ball(subdivisions=3)
    body = Session(build_model(mesh, [JELLY], pinned=0.5 * base_vertices(mesh), sway=(1.0, 30.0, 1.0, (0, 0, 0))))
    at = mesh.rest_positions[mesh.source]
    for frame in range(30):
        led = at + [0.5 * (frame + 1) / 100, 0, 0]
        body.set_pins(led)
        body.set_rest(led)
        body.step(0.01)
    assert body.rides
    body.wake()
    assert np.abs(body.body.velocities() - [[0.5], [0], [0]]).max() < 0.02


def test_a_fingertip_pushes_the_body_aside_and_feels_the_law_at_the_depth_below_where_it_is() -> None:
    body, still = session(), session(sway=None)
    for frame in range(60):
        tip = Finger((0.0825 + 0.01 - 0.015 * min(frame / 20, 1), 0, 0), 0.010)
        for each in (body, still):
            each.set_fingers([tip])
            each.step(1 / 60)
    depth, force = body.frame.depths[0], body.frame.pushes[0]
    assert depth < 0.9 * still.frame.depths[0], "it gives way as a whole"
    assert force == pytest.approx(JELLY.law(float(depth)), rel=0.01)
    for _ in range(300):
        body.set_fingers([None])
        body.step(1 / 60)
    assert np.abs(body.positions() - body.model.mesh.rest_positions[body.model.mesh.source]).max() < 1e-4


@pytest.mark.parametrize("seconds", [1 / 24, 1 / 60, 1 / 120, 0.001])
def test_pushed_by_a_fingertip_nothing_grows(seconds: float) -> None:
    body, largest = session(sway=(1.0, 3.0, 0.0, (0, 0, -9.81))), []
    for _ in range(min(int(2 / seconds), 240)):
        body.set_fingers([Finger((0.0, 0.0, 0.0825 + 0.004), 0.010)])
        body.step(seconds)
        largest.append(body.frame.depths[0])
    assert max(largest[len(largest) // 2 :]) <= 1.05 * max(largest[: len(largest) // 2])


@pytest.mark.parametrize("damping", [0.1, 0.0])
def test_a_body_leans_away_from_a_collider_nothing_grows_and_it_comes_back(damping: float) -> None:
    body, still = session(sway=(1.0, 3.0, damping, (0, 0, -9.81))), session(sway=None)
    made = trimesh.creation.icosphere(subdivisions=3, radius=0.03)
    worlds, forces, leans = [], [], []
    for each in (body, still):
        worlds.append(World([each], [Collider(np.ascontiguousarray((made.vertices + [0.116, 0, 0.02]).T), made.faces)]))
    for frame in range(96):
        place = made.vertices + [0.1125 - 0.02 * min(frame / 5, 1), 0, 0.02]
        for world in worlds:
            world.set_colliders([place])
            world.step(1 / 24)
        forces.append([float(np.linalg.norm(meeting_of(world).forces[0])) for world in worlds])
        leans.append(float(body.rest_shape.whole[0].mean()))
    assert forces[-1][0] < 0.5 * forces[-1][1], "it gives way as a whole"
    assert np.mean(leans[-24:]) < -0.003
    assert np.std(leans[-24:]) < np.std(leans[12:36])
    if damping:
        for frame in range(120):
            worlds[0].set_colliders([made.vertices + [0.1125 + 0.02 * min(frame / 5, 1), 0, 0.02]])
            worlds[0].step(1 / 24)
        assert np.abs(body.positions() - body.model.mesh.rest_positions[body.model.mesh.source]).max() < 1e-3


def test_skin_that_nothing_touches_lies_on_the_swaying_shape_whether_it_is_stepped_or_not() -> None:
    stepped, rides = session(), session()
    at = stepped.model.mesh.rest_positions[stepped.model.mesh.source]
    for frame in range(30):
        led = at + [0.04 * min(frame / 4, 1), 0, 0]
        stepped.set_fingers([Finger((1.0, 1.0, 1.0), 0.010)])
        for body in (stepped, rides):
            body.set_pins(led)
            body.set_rest(led)
            body.step(1 / 24)
        assert np.abs(stepped.positions() - rides.positions()).max() < 2e-4
    assert rides.rides and not stepped.rides


def test_a_proxy_that_sways_differs_from_its_mesh_by_no_more_than_one_that_does_not() -> None:
    mesh, apart = ball(subdivisions=5), []
    for sway in (None, (1.0, 3.0, 0.2, (0, 0, -9.81))):
        model = build_model(mesh, [replace(JELLY, friction=0.0)], pinned=base_vertices(mesh), sway=sway)
        full, proxied = Session(model), Session(model, proxy=build_proxy(model, 2500))
        for frame in range(24):
            for body in (full, proxied):
                body.set_fingers([Finger((0.0825 + 0.01 - 0.015 * min(frame / 10, 1), 0, 0), 0.010)])
                body.step(1 / 24)
        assert proxied.frame.pushes[0] == pytest.approx(full.frame.pushes[0], rel=0.04)
        apart.append(float(np.abs(proxied.positions() - full.positions()).max()))
    assert apart[1] < 1.2 * apart[0], apart


def test_a_sway_ships_as_fewer_shape_keys_than_it_has_modes() -> None:
    body = session()
    at, away, normals = body.model.mesh.rest_positions[body.model.mesh.source], [], []
    for frame in range(72):
        led = at + [0.04 * min(frame / 4, 1), 0, 0]
        body.set_rest(led)
        body.step(1 / 24)
        away.append(body.positions() - led)
        normals.append(vertex_normals(body.model.mesh.triangles, body.positions()))
    assert np.abs(away).max() > 0.01
    assert len(reduce(np.array(away, np.float32), np.array(normals, np.float32), 1e-4).chosen) < MODES
