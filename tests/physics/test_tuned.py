"""Softness by eye: a fingertip that a force pushes rests where the law says, wherever on the mesh, and however it came.

On a mesh as coarse as Make Soft leaves it the depth differs from place to place, and friction remembers the way.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from core.body.model import Model, build_model
from core.calibration.identify import identification
from core.calibration.place import typical_site
from core.material import PRESETS, Material
from core.mesh.surface import Mesh, base_vertices
from core.session import Finger, Session
from core.steps import result_of
from studies.scenes import cube

SIZE, CELLS, TIP = 0.165, 30, 0.010  # edges of 0.55 radii of the fingertip
FORCE, FRAME_S = 15.0, 1 / 60
SOFT, HARD = (replace(PRESETS[1].material, K1=K1) for K1 in (300, 3000))
DEPTH = FORCE / HARD.K1
PAINTED = 0.375  # three quarters of x0
PLACES = {"edge": (0.5, 0.0), "vertex": (0.0, 0.0), "face": (0.5, 0.5)}  # [edges] from the middle of the top
CLOSE = 0.05
everywhere = pytest.mark.parametrize(
    "place", [pytest.param(name, marks=pytest.mark.slow if name != "edge" else ()) for name in PLACES]
)


@lru_cache
def models(material: Material) -> tuple[Model, Model]:
    """Return a body with the constants of the closed form, and with those identified."""
    mesh = on()
    site, deepest = typical_site(mesh, material.indenter), 1.5 * material.x0
    found = result_of(identification(mesh, material, material.indenter, site, deepest)).material
    estimated, identified = (build_model(mesh, [each], pinned=base_vertices(mesh)) for each in (material, found))
    return estimated, identified


@lru_cache
def on() -> Mesh:
    return cube(CELLS, SIZE)


def pressed(model: Model, place: str) -> Session:
    """Press within a quarter of a second, and rest."""
    session, edge = Session(model), SIZE / CELLS
    at = (PLACES[place][0] * edge, PLACES[place][1] * edge, SIZE / 2 + TIP)
    for share in range(16):
        session.set_fingers([Finger(at, TIP, FORCE * share / 15)])
        session.step(FRAME_S)
    session.step(0.75)
    return session


@everywhere
def test_a_force_presses_as_deep_as_the_law_says_on_a_vertex_an_edge_and_a_face(place: str) -> None:
    session = pressed(models(HARD)[1], place)
    assert session.frame.depths[0] == pytest.approx(DEPTH, rel=CLOSE)


@everywhere
def test_k1_that_is_dragged_to_ten_times_ends_where_the_law_says_though_it_was_an_estimate_first(place: str) -> None:
    session = pressed(models(SOFT)[1], place)
    for model in models(HARD):
        session.change(model, glide=True)
        for _ in range(75):
            frame = session.step(FRAME_S)
    assert -float(frame.finger_forces[0] @ (0.0, 0.0, -1.0)) == pytest.approx(FORCE, rel=0.01)
    assert frame.depths[0] == pytest.approx(DEPTH, rel=CLOSE)


@everywhere
def test_a_knee_that_is_painted_under_a_resting_force_lets_the_fingertip_out_to_where_a_new_press_ends(
    place: str,
) -> None:
    material = models(PRESETS[1].material)[1].materials[0]
    plain, painted = (
        build_model(on(), [material], pinned=base_vertices(on()), knee=np.full(len(on().source), weight))
        for weight in (0.5, PAINTED)
    )
    session, anew = pressed(plain, place), pressed(painted, place)
    session.change(painted, glide=True)
    for _ in range(75):
        session.step(FRAME_S)
    ratio = float(session.frame.depths[0] / anew.frame.depths[0])
    print(f"a knee painted under a force, on the {place}: {ratio - 1:+.1%} of the depth of a new press")
    assert ratio == pytest.approx(1, rel=0.03)
