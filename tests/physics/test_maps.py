"""What is painted on a body multiplies the constants of its material there."""

import numpy as np
import pytest

from core.base import DimpleError, Floats
from core.body.model import Model, build_model
from core.material import FINGERTIP
from core.mesh.surface import base_vertices, mesh_from_triangles
from core.session import Finger, Session
from studies.paper_objects import PRESETS
from tests.bodies import ball as small_ball

VINYL = PRESETS[1].material
RADIUS = 0.0825


def depth(model: Model, force: float) -> float:
    session = Session(model)
    session.set_fingers([Finger((0.003, 0.002, RADIUS + FINGERTIP.radius), FINGERTIP.radius, force)])
    session.step(1.5)
    return float(session.frame.depths[0])


def small(**maps: Floats) -> Model:
    mesh = mesh_from_triangles(*small_ball(2, RADIUS))
    return build_model(mesh, [VINYL], pinned=base_vertices(mesh), **maps)  # type: ignore[arg-type]


def test_each_map_multiplies_its_own_constants_and_half_changes_nothing() -> None:
    plain, n = small(), len(small().mesh.source)
    for name in ("softness", "knee", "spread"):
        same, twice = small(**{name: np.full(n, 0.5)}), small(**{name: np.full(n, 1.0)})
        np.testing.assert_array_equal(same.matching.k1, plain.matching.k1)
        np.testing.assert_array_equal(same.mass, plain.mass)
        factors = {
            "k1": twice.matching.k1 / plain.matching.k1, "d0": twice.matching.d0 / plain.matching.d0,
            "tension": twice.matching.tension.sum() / plain.matching.tension.sum(),
            "k": twice.springs.stiffness / plain.springs.stiffness,
        }  # fmt: skip
        wanted = {
            "softness": {"k1": 0.25, "tension": 0.25, "k": 0.25}, "spread": {"tension": 4.0, "k": 4.0},
            "knee": {"d0": 2.0},
        }[name]  # fmt: skip
        for constant, factor in factors.items():
            np.testing.assert_allclose(factor, wanted.get(constant, 1.0), rtol=1e-9, err_msg=f"{name}: {constant}")


def test_where_the_knee_is_painted_0_the_skin_is_hard_from_the_start() -> None:
    n = len(small().mesh.source)
    model = small(knee=np.zeros(n), spread=np.zeros(n))
    assert depth(model, 3.0) == pytest.approx(3.0 / VINYL.K2, rel=0.02)


def test_a_map_of_another_length_or_with_a_nan_is_refused_by_its_name() -> None:
    n = len(small().mesh.source)
    for values, words in ((np.zeros(n - 1), f"one value for each of the {n}"), (np.full(n, np.nan), "not numbers")):
        with pytest.raises(DimpleError, match=f"spread map.*{words}"):
            small(spread=values)
