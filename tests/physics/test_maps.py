"""What is painted on a body multiplies the constants of its material there."""

from dataclasses import replace

import numpy as np
import pytest

from core.base import DimpleError, Floats
from core.body.maps import LEAST
from core.body.model import Model, build_model
from core.calibration.place import typical_site
from core.material import FINGERTIP, PRESETS, Material
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.session import Finger, Session
from studies.scenes import ball
from studies.virtual_press import identify
from tests.bodies import ball as small_ball

VINYL = PRESETS[1].material
RADIUS = 0.0825


@pytest.fixture(scope="module")
def measured() -> tuple[Mesh, Material]:
    """A ball of vinyl whose press with a fingertip, where an artist's is identified, is the measured one."""
    mesh = ball(4, RADIUS)
    return mesh, identify(mesh, VINYL, FINGERTIP, typical_site(mesh, FINGERTIP), 0.023).material


def depth(model: Model, force: float) -> float:
    session = Session(model)
    session.set_fingers([Finger((0.003, 0.002, RADIUS + FINGERTIP.radius), FINGERTIP.radius, force)])
    session.step(1.5)
    return float(session.frame.depths[0])


@pytest.mark.parametrize("painted", [0.5, 0.25])
def test_a_press_stops_where_x0_is_painted(measured: tuple[Mesh, Material], painted: float) -> None:
    mesh, material = measured
    x0, force = 2 * painted * VINYL.x0, 15.0
    model = build_model(mesh, [material], pinned=base_vertices(mesh), knee=np.full(len(mesh.source), painted))
    wanted = x0 + (force - VINYL.K1 * x0) / VINYL.K2
    assert depth(model, force) == pytest.approx(wanted, rel=0.05)


def small(**maps: Floats) -> Model:
    mesh = mesh_from_triangles(*small_ball(2, RADIUS))
    return build_model(mesh, [VINYL], pinned=base_vertices(mesh), **maps)  # type: ignore[arg-type]


def test_each_map_multiplies_its_own_constants_and_half_changes_nothing() -> None:
    plain, n = small(), len(small().mesh.source)
    for name in ("softness", "knee", "spread", "thickness"):
        same, twice = small(**{name: np.full(n, 0.5)}), small(**{name: np.full(n, 1.0)})
        np.testing.assert_array_equal(same.matching.k1, plain.matching.k1)
        np.testing.assert_array_equal(same.mass, plain.mass)
        factors = {
            "k1": twice.matching.k1 / plain.matching.k1, "d0": twice.matching.d0 / plain.matching.d0,
            "tension": twice.matching.tension.sum() / plain.matching.tension.sum(),
            "k": twice.springs.stiffness / plain.springs.stiffness, "mass": twice.mass.sum() / plain.mass.sum(),
        }  # fmt: skip
        wanted = {
            "softness": {"k1": 0.25, "tension": 0.25, "k": 0.25}, "spread": {"tension": 4.0, "k": 4.0},
            "knee": {"d0": 2.0, "k1": factors["k1"], "tension": factors["tension"]},  # those of the next test
            "thickness": {"mass": 2.0},
        }[name]  # fmt: skip
        for constant, factor in factors.items():
            np.testing.assert_allclose(factor, wanted.get(constant, 1.0), rtol=1e-9, err_msg=f"{name}: {constant}")


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_a_body_whose_knee_is_painted_all_over_is_of_the_material_with_that_knee(share: float) -> None:
    material = replace(VINYL, indenter=FINGERTIP)
    mesh = mesh_from_triangles(*small_ball(2, RADIUS))
    painted = build_model(mesh, [material], knee=np.full(len(mesh.source), share / 2)).matching
    deeper = build_model(mesh, [replace(material, x0=share * material.x0)]).matching
    np.testing.assert_allclose(painted.d0, deeper.d0, rtol=0.02)
    for constants in ("k1", "k2", "tension"):
        np.testing.assert_allclose(getattr(painted, constants), getattr(deeper, constants), rtol=0.02, atol=1e-9)


def test_a_place_painted_0_keeps_a_little_of_its_constants_and_runs() -> None:
    n = len(small().mesh.source)
    model = small(knee=np.zeros(n), spread=np.zeros(n), thickness=np.zeros(n))
    assert model.matching.d0.min() == pytest.approx(LEAST * small().matching.d0.min())
    assert depth(model, 3.0) > 0


def test_a_map_of_another_length_or_with_a_nan_is_refused_by_its_name() -> None:
    n = len(small().mesh.source)
    for values, words in ((np.zeros(n - 1), f"one value for each of the {n}"), (np.full(n, np.nan), "not numbers")):
        with pytest.raises(DimpleError, match=f"spread map.*{words}"):
            small(spread=values)
