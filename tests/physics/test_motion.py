"""Bodies in motion: the clock, gravity, momentum, energy, the stability bound, shape matching."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from core.base import Floats
from core.body import shape_matching
from core.body.model import Model, build_model
from core.fills import FILLS
from core.material import Material
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.session import Finger, Session
from studies import scenes
from studies.methods import native as native_method
from studies.reference import semi_implicit
from studies.reference.energy import stored
from studies.reference.laws import State, forces, initial_state
from studies.reference.path import FingerPath
from tests.bodies import TETRAHEDRON, ball, hemisphere, sheet

RATES = (24.0, 30.0, 60.0, 120.0)
EVERY = ["native64", "native"]
AT_RATES = [(rate, kind) for kind in EVERY for rate in RATES]


def run(model: Model, state: State, seconds: float, substeps: int = 0) -> State:
    """Move a body that nothing touches, without a session."""
    ticks = round(seconds / 1e-3)
    nobody = FingerPath(centres=np.zeros((0, ticks + 1, 3)), radii=np.zeros(0))
    native_method.run(model, state, nobody, tick=1e-3, substeps=substeps or model.substeps(1e-3))
    return state


@cache
def poked(frame_rate: float, backend: str) -> list[Floats]:
    """Press a ball 20 mm, sideways too, hold, let go; return where it is after each of these."""
    mesh, each = scenes.ball(1), 1 / 6
    model = build_model(mesh, [scenes.BALL], pinned=base_vertices(mesh))
    session = Session(model, backend=backend)
    start = np.array([0.0, 0.0, scenes.BALL_RADIUS + 0.02])
    session.set_fingers([Finger(tuple(start), 0.02)])
    seen = []
    for i in range(1, round(3 * each * frame_rate) + 1):
        way = np.interp(i / frame_rate, each * np.arange(4), [0, 1, 1, 0.2])
        session.set_fingers([Finger(tuple(start + way * np.array([0.005, 0, -0.02])), 0.02)])
        session.step(1 / frame_rate)
        if i % round(each * frame_rate) == 0:
            seen.append(session.positions())
    return seen


def test_an_undamped_ball_pressed_flat_and_let_go_keeps_its_energy() -> None:
    """Its skin folds and stiffens under the press; the step was chosen for the shape at rest."""
    material = replace(scenes.BALL, damping_ratio=0.0)
    mesh = scenes.ball(4)
    model = build_model(mesh, [material], pinned=base_vertices(mesh))
    grown = []
    for depth in (0.06, 0.07, 0.075, 0.08, 0.085):  # of 160 mm: how it folds differs from one to the next
        energies = energies_after(Session(model), depth)
        assert energies[0] > 1.0
        grown.append(max(energies) / energies[0])
    least = sorted(grown)  # one fold in twenty gains more; in steps half as long it does not
    assert least[2] < 1.05 and least[3] < 1.1 and least[4] < 1.15


def energies_after(session: Session, depth: float) -> list[float]:
    """Press a ball so deep [m], let go, and return its energy [J] ten times in a second."""
    model, top = session.model, scenes.BALL_RADIUS + 0.02
    session.set_fingers([Finger((0.0, 0.0, top), 0.02)])
    session.step(0.001)
    session.set_fingers([Finger((0.0, 0.0, top - depth), 0.02)])
    session.step(0.35)
    session.set_fingers([])
    energies = []
    for _ in range(10):
        assert session.step(0.1).note == ""
        kept = stored(model, session.body.positions(), (np.eye(3), np.zeros(3)))
        energies.append(kept + float((model.mass * session.body.velocities() ** 2).sum()) / 2)
    return energies


@pytest.mark.parametrize(("rate", "backend"), AT_RATES)
def test_the_same_press_gives_the_same_motion_at_any_frame_rate(rate: float, backend: str) -> None:
    wanted = poked(RATES[0], backend)
    moved = np.abs(wanted[0] - wanted[2]).max()
    assert moved > 0.003
    for here, there in zip(poked(rate, backend), wanted, strict=True):
        np.testing.assert_allclose(here, there, atol=1e-7 if backend != "native" else 2e-3 * moved)


@pytest.mark.parametrize(("rate", "backend"), AT_RATES)
def test_a_body_falls_4_9_metres_in_a_second_at_any_frame_rate(rate: float, backend: str) -> None:
    light = Material(K1=10, K2=10, x0=0.1, k=1, mass=1, fill="none")
    model = build_model(mesh_from_triangles(*TETRAHEDRON), [light], gravity=(0, 0, -9.81))
    session = Session(model, backend=backend)
    for _ in range(round(rate)):
        session.step(1 / rate)
    fall = session.positions() - TETRAHEDRON[0]
    assert fall[:, 2] == pytest.approx(-9.81 / 2, rel=2e-3)
    np.testing.assert_allclose(fall[:, :2], 0, atol=1e-5)


def momentum(model: Model, state: State) -> tuple[Floats, Floats]:
    """Return linear [N s] and angular momentum about the centre of mass [N m s]."""
    per_vertex, arms = (model.mass * state.velocities).T, state.positions.T - centre(model, state)
    return per_vertex.sum(axis=0), np.cross(arms, per_vertex).sum(axis=0)


def centre(model: Model, state: State) -> Floats:
    return np.asarray(state.positions @ model.mass / model.mass.sum())


def thrown() -> tuple[Model, State]:
    """Return a free body that is deformed, spins, flies and shakes."""
    model = build_model(scenes.ball(0), [replace(scenes.BALL, fill="liquid")])
    rng, state = np.random.default_rng(0), initial_state(model)
    state.positions *= 1 + 0.2 * rng.normal(size=state.positions.shape)
    spin = np.cross([3.0, 1.0, 2.0], state.positions.T).T
    state.velocities[:] = spin + np.array([[1.0], [2.0], [-1.0]]) + rng.normal(0, 0.5, spin.shape)
    return model, state


def change(model: Model, state: State, before: tuple[Floats, Floats]) -> float:
    return max(
        float(np.linalg.norm(now - then) / np.linalg.norm(then))
        for now, then in zip(momentum(model, state), before, strict=True)
    )


@pytest.mark.parametrize("backend", ["native64", "native"])
def test_momentum_is_kept_over_ten_thousand_steps(backend: str) -> None:
    model, state = thrown()
    rounding, off = (1e-4, 1e-5) if backend == "native" else (1e-11, 1e-11)  # single precision and double
    session = Session(model, backend=backend)
    session.body.set_state(state.positions, state.velocities)
    before = momentum(model, state)
    session.step(10_000 / session.substeps * 1e-3)
    assert session.frame.total_steps >= 9_990
    after = State(positions=session.body.positions(), velocities=session.body.velocities(), pose=None)
    assert change(model, after, before) < rounding
    way = before[0] / model.mass.sum() * session.frame.time
    assert np.linalg.norm(centre(model, after) - centre(model, state) - way) < off * np.linalg.norm(way), "straight on"


def energy(model: Model, state: State) -> float:
    return stored(model, state.positions) + float((model.mass * state.velocities**2).sum()) / 2


@pytest.mark.parametrize("amount", [0.3, 2.0], ids=["short of the knee", "beyond the knee"])
def test_without_damping_energy_swings_but_neither_grows_nor_fades(amount: float) -> None:
    model, state = scenes.twisted_ball(0, amount=amount, damping_ratio=0.0)
    start = energy(model, state)
    seen = [energy(model, run(model, state, 0.02, substeps=8)) for _ in range(12)]
    assert 0.9 * start < np.mean(seen) < 1.1 * start


def test_damping_takes_energy_and_puts_a_free_body_to_rest_in_its_own_shape() -> None:
    model, state = scenes.twisted_ball(0, damping_ratio=0.5)
    start = energy(model, state)
    run(model, state, 0.5)
    assert energy(model, state) < 1e-4 * start
    distance = np.linalg.norm(state.positions[:, :, None] - state.positions[:, None], axis=0)
    rest = model.matching.rest
    np.testing.assert_allclose(distance, np.linalg.norm(rest[:, :, None] - rest[:, None], axis=0), atol=1e-5)


def test_a_spun_body_keeps_spinning_and_its_rest_shape_follows() -> None:
    model = build_model(scenes.ball(0), [replace(scenes.BALL, damping_ratio=1.0)])
    state, spin = initial_state(model), np.array([0.0, 3.0, 6.0])
    state.velocities[:] = np.cross(spin, state.positions.T).T
    _, before = momentum(model, state)
    energy_before = energy(model, state)
    run(model, state, 0.3)
    assert momentum(model, state)[1] == pytest.approx(before, rel=1e-9)
    assert energy(model, state) == pytest.approx(energy_before, rel=0.02)
    turn, _ = shape_matching.fit_pose(model.matching.rest, state.positions, model.matching.k1)
    angle = np.arccos((np.trace(turn) - 1) / 2)
    assert angle == pytest.approx(np.linalg.norm(spin) * 0.3, rel=0.02)


BODIES: dict[str, Mesh] = {
    "ball": scenes.ball(1), "cube": scenes.cube(2, 0.165), "capped": mesh_from_triangles(*hemisphere(6, 2, 0.08)),
    "sheet": mesh_from_triangles(*sheet(3, 0.1)), "uneven": mesh_from_triangles(ball(1)[0] ** 3 / 10, ball(1)[1]),
}  # fmt: skip


def highest_frequency(model: Model) -> float:
    """Return the highest angular frequency [1/s] at rest, by power iteration on differences of the forces."""
    state, h = initial_state(replace(model, gravity=np.zeros(3))), 1e-7 * model.mesh.size
    rest, root = model.matching.rest, np.sqrt(model.inverse_mass)
    u = np.random.default_rng(0).normal(size=rest.shape)
    for _ in range(100):
        ahead, behind = (
            forces(
                model,
                replace(
                    state,
                    positions=rest + sign * h * root * u / np.abs(root * u).max(),
                    pose=None if state.pose is None else state.pose,
                ),
            )
            for sign in (1, -1)
        )
        u = -root * (ahead - behind) / (2 * h) * np.abs(root * u).max()
        square = float(np.linalg.norm(u))
        u /= square
    return float(np.sqrt(square))


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("fill", ["air", "none"])
def test_the_bound_is_never_below_the_highest_frequency(body: str, fill: str, monkeypatch: pytest.MonkeyPatch) -> None:
    # what is kept in reserve for a body pressed flat does not count at rest
    monkeypatch.setitem(FILLS, fill, FILLS[fill]._replace(reserve=1.0))
    mesh = BODIES[body]
    for pinned in (None, base_vertices(mesh)):
        model = build_model(mesh, [replace(scenes.BALL, fill=fill, K2=610.0, damping_ratio=0.0)], pinned=pinned)
        assert highest_frequency(model) <= np.sqrt(model.omega_squared) * (1 + 1e-6)
        assert np.sqrt(model.omega_squared) < 1.6 * highest_frequency(model)


@pytest.mark.parametrize("pressure", [-1e5, 1e5, 1e6])
@pytest.mark.parametrize("body", BODIES)
def test_the_bound_holds_under_a_pressure_too(body: str, pressure: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FILLS, "air", FILLS["air"]._replace(reserve=1.0))
    material = replace(scenes.BALL, fill="air", pressure=pressure, K1=1.0, K2=1.0, k=1.0, damping_ratio=0.0)
    for pinned in (None, base_vertices(BODIES[body])):
        model = build_model(BODIES[body], [material], pinned=pinned)
        assert highest_frequency(model) <= np.sqrt(model.omega_squared) * (1 + 1e-6)


@pytest.mark.parametrize("damping", [0.0, 0.2, 1.0])
@pytest.mark.parametrize(("share", "stays"), [(0.95, True), (3.0, False)])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_step_under_the_bound_stays_and_one_well_over_it_blows_up(damping: float, share: float, stays: bool) -> None:
    model = build_model(scenes.ball(0), [replace(scenes.BALL, damping_ratio=damping, K2=610.0)])
    omega = np.sqrt(model.omega_squared)
    z = model.decay / (2 * omega)
    step = share * 2 / omega * (np.sqrt(1 + z * z) - z)
    state = initial_state(model)
    state.velocities[:] = 1e-6 * np.random.default_rng(1).normal(size=state.velocities.shape)
    nobody = FingerPath(centres=np.zeros((0, 2, 3)), radii=np.zeros(0))
    semi_implicit.run(model, state, nobody, tick=600 * step, substeps=600)
    bent = np.abs(state.positions - state.positions.mean(axis=1, keepdims=True) - model.matching.rest).max()
    assert (bent < 1e-5) == stays
