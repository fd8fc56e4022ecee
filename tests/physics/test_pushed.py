"""A fingertip that is pushed by a force sinks in until the body pushes back as much, and comes to rest there."""

from dataclasses import replace

import numpy as np
import pytest

from core.body import pressure, shape_matching, springs
from core.body.model import Model, build_model
from core.material import PRESETS, Material
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.reduction.proxy import build_proxy
from core.session import Finger, Session
from core.solver.pushed import mass_and_damping
from studies.scenes import cube
from tests.bodies import ball

RADIUS, TIP = 0.08, 0.02
VINYL = PRESETS[1].material
SOFT = Material(K1=600, K2=2000, x0=0.02, k=600, mass=0.5, damping_ratio=0.5, fill="none")


def pinned(material: Material = SOFT, subdivisions: int = 2) -> Model:
    mesh = mesh_from_triangles(*ball(subdivisions, RADIUS))
    return build_model(mesh, [material], pinned=base_vertices(mesh))


def tip(force: float | None = None, depth: float = 0.0) -> Finger:
    return Finger((0.0, 0.0, RADIUS + TIP - depth), TIP, force)


def pushed(model: Model, force: float, seconds: float = 1.5, **options: object) -> Session:
    session = Session(model, **options)  # type: ignore[arg-type]
    session.set_fingers([tip(force)])
    session.step(seconds)
    return session


def static_force(model: Model, depth: float, **options: object) -> float:
    session = Session(model, **options)  # type: ignore[arg-type]
    for at in (0.0, depth):
        session.set_fingers([tip(depth=at)])
        session.step(0.3)
    session.step(1.0)
    return float(session.step(0.1).finger_forces[0, 2])


@pytest.mark.parametrize("force", [0.5, 3.0, 12.0])
@pytest.mark.parametrize("material", [SOFT, VINYL, PRESETS[2].material], ids=["soft", "air", "water"])
def test_it_rests_at_the_depth_whose_static_force_is_its_own(material: Material, force: float) -> None:
    model = pinned(material)
    session = pushed(model, force)
    depth = float(session.frame.depths[0])
    assert session.step(0.1).finger_forces[0, 2] == pytest.approx(force, rel=0.01)
    low, high = (static_force(model, share * depth) for share in (0.98, 1.02))
    assert low < force < high, "the depth of that static force is within 2 %"


def test_a_softer_material_sinks_deeper() -> None:
    materials = [replace(SOFT, K1=factor * 600, K2=factor * 2000, k=factor * 600) for factor in (4, 2, 1)]
    depths = [pushed(pinned(each, 1), 5.0, 0.3).frame.depths[0] for each in materials]
    assert depths[0] < 0.7 * depths[1] < 0.7 * 0.9 * depths[2]


def test_the_force_may_change_while_it_rests() -> None:
    model = pinned()
    session = pushed(model, 4.0)
    deep = session.frame.depths[0]
    session.set_fingers([tip(1.0)])
    session.step(1.0)
    assert session.frame.depths[0] < 0.6 * deep
    assert session.frame.depths[0] == pytest.approx(pushed(model, 1.0).frame.depths[0], rel=0.01)
    session.set_fingers([tip(0.0)])
    session.step(1.0)
    assert session.frame.depths[0] < 0.1 * deep, "without a force the body pushes it out"


@pytest.mark.parametrize("force", [6.0, 9.0])
@pytest.mark.parametrize("material", [replace(SOFT, damping_ratio=0.0), VINYL, replace(SOFT, K2=40_000, x0=0.003)])
def test_energy_does_not_grow(material: Material, force: float) -> None:
    """The force gives F times its way; what is left of it with fingertip and body only falls."""
    model = pinned(material, 1)
    session = Session(model, backend="native64")
    session.set_fingers([tip(force)])
    mass, _ = mass_and_damping(model, TIP, session.clock.tick)
    left, here = [0.0], RADIUS + TIP
    for _ in range(1500):
        session.step(0.001)
        before, here = here, session.placed[0].position[2]  # type: ignore[union-attr]
        speed = (here - before) / session.clock.tick
        left.append(held_by(session, model) + 0.5 * mass * speed**2 - force * (RADIUS + TIP - here))
    lowest = np.minimum.accumulate(left)
    assert lowest[-1] < -0.3 * force * 0.003, "it has come to rest lower than it began"
    assert (left - lowest).max() < 0.01 * -lowest[-1], "nothing comes back"


def held_by(session: Session, model: Model) -> float:
    """Return the energy of a body's motion and shape [J]."""
    x, v, pose = session.body.positions(), session.body.velocities(), (np.eye(3), np.zeros(3))
    moving = 0.5 * float((model.mass * (v * v).sum(axis=0)).sum())
    shape = springs.energy(model.springs, x) + shape_matching.energy(model.matching, x, pose)
    return moving + shape + (pressure.energy(model.pressure, x) if model.pressure.fill != "none" else 0.0)


@pytest.mark.parametrize("backend", ["native", "native64"])
@pytest.mark.parametrize("where", [(0.31, 0.18), (0.1, 0.02)], ids=["aside", "near the middle"])
@pytest.mark.parametrize("cells", [1, 2, 3])
def test_it_stands_still_on_faces_heavier_than_itself(cells: int, where: tuple[float, float], backend: str) -> None:
    """Of a coarse mesh a fingertip moves whole faces, not the skin that is as large as itself."""
    water, size, force = PRESETS[2].material, 0.165, 3.0
    mesh = cube(cells, size)
    session = Session(build_model(mesh, [water], pinned=base_vertices(mesh)), backend=backend)
    session.set_fingers([Finger((where[0] * size, where[1] * size, size / 2 + 0.0101), 0.01, force)])
    session.step(1.0)
    forces = [session.step(0.001).finger_forces[0, 2] for _ in range(100)]
    np.testing.assert_allclose(forces, force, rtol=0.01)


def test_it_stands_still_on_a_stiff_body_that_a_prescribed_one_could_not_enter() -> None:
    session = pushed(pinned(replace(SOFT, K1=50_000, K2=900_000, x0=0.001, k=50_000), 1), 20.0, 1.0)
    places = []
    for _ in range(20):
        session.step(0.001)
        places.append(session.placed[0].position[2])  # type: ignore[union-attr]
    assert np.ptp(places) < 1e-6 and session.frame.finite


def test_a_proxy_is_pushed_as_deep_as_its_mesh() -> None:
    model = pinned(SOFT, 4)
    whole = pushed(model, 5.0).frame.depths[0]
    assert pushed(model, 5.0, proxy=build_proxy(model, 1000)).frame.depths[0] == pytest.approx(whole, rel=0.03)


def test_it_is_the_same_at_any_frame_rate() -> None:
    model = pinned(SOFT, 1)
    fine, coarse = Session(model), Session(model)
    for session, steps in ((fine, 120), (coarse, 12)):
        for _ in range(steps):
            session.set_fingers([tip(3.0)])
            session.step(1.2 / steps / 4)
    assert fine.frame.depths[0] == pytest.approx(coarse.frame.depths[0], abs=1e-6)
