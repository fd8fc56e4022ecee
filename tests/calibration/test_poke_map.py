"""Pokes all over an object give a map of softness that predicts places it has not seen, with an interval that holds."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from core.base import DimpleError, Floats
from core.calibration.poke_map import Pokes, map_pokes
from core.calibration.poke_table import read_pokes
from core.material import DEFAULT_MATERIAL
from core.mesh.surface import Mesh, mesh_from_triangles

RADIUS, NOISE, PLACES = 0.0825, 0.05, 100


@pytest.fixture(scope="module")
def ball() -> Mesh:
    made = trimesh.creation.icosphere(3, radius=RADIUS)
    return mesh_from_triangles(np.array(made.vertices), np.array(made.faces))


def stiffness(places: Floats) -> Floats:
    """Return a lump: three times as stiff at one side, half as stiff at the other."""
    return np.asarray(np.exp(0.8 * np.sin(places[:, 0] / 0.03) + 0.4 * np.cos(places[:, 2] / 0.04)), np.float64)


def poked(seed: int, places: int = PLACES, uneven: bool = True) -> Pokes:
    random = np.random.default_rng(seed)
    towards = random.normal(size=(places, 3))
    points = RADIUS * towards / np.linalg.norm(towards, axis=1, keepdims=True)
    depths = random.uniform(0.004, 0.02, places)
    law = np.array([DEFAULT_MATERIAL.law(depth) for depth in depths.tolist()])
    true = stiffness(points) if uneven else np.ones(places)
    return Pokes(places=points, depths=depths, forces=true * law * np.exp(random.normal(0, NOISE, places)))


def test_the_map_is_the_softness_that_made_the_pokes(ball: Mesh) -> None:
    found, true = map_pokes(ball, DEFAULT_MATERIAL, poked(0)), stiffness(ball.rest_positions)
    assert np.sqrt(((found.stiffness / true - 1) ** 2).mean()) < 0.08 and found.without > 0.5
    assert found.error < 2 * NOISE, "a place that is predicted is hardly worse than one that is measured"
    painted = 4.0 ** (1 - 2 * found.weights)
    inside = (found.stiffness > 0.26) & (found.stiffness < 3.9)
    np.testing.assert_allclose(painted[inside], found.stiffness[inside], rtol=1e-9)


def test_the_interval_holds_the_truth_and_the_places_left_out(ball: Mesh) -> None:
    held, predicted = [], []
    for seed in range(4):
        found, true = map_pokes(ball, DEFAULT_MATERIAL, poked(seed, 70)), stiffness(ball.rest_positions)
        held.append((np.abs(np.log(found.stiffness / true)) <= np.log(found.interval)).mean())
        predicted.append(found.coverage)
    assert 0.88 <= np.mean(held) and 0.89 <= np.mean(predicted) <= 1.0
    assert np.median(found.interval) < 1.3


def test_one_softness_all_over_is_found_to_be_one(ball: Mesh) -> None:
    found = map_pokes(ball, DEFAULT_MATERIAL, poked(1, uneven=False))
    assert np.abs(found.stiffness - 1).max() < 0.1 and found.error <= 1.1 * found.without
    assert np.abs(found.weights - 0.5).max() < 0.05


def test_where_nobody_poked_the_interval_is_wide(ball: Mesh) -> None:
    pokes = poked(2, 200)
    upper = pokes.places[:, 2] > 0
    half = Pokes(places=pokes.places[upper], depths=pokes.depths[upper], forces=pokes.forces[upper])
    found, height = map_pokes(ball, DEFAULT_MATERIAL, half), ball.rest_positions[:, 2]
    far, near = (np.log(found.interval[side]) for side in (height < -0.9 * RADIUS, height > 0.2 * RADIUS))
    assert np.median(far) > 3 * np.median(near)


def test_several_pokes_at_one_place_are_one_measurement(ball: Mesh) -> None:
    once = poked(3)
    thrice = Pokes(**{name: np.repeat(getattr(once, name), 3, axis=0) for name in ("places", "depths", "forces")})
    found = map_pokes(ball, DEFAULT_MATERIAL, thrice)
    assert (found.places, found.pokes) == (PLACES, 3 * PLACES)


def test_what_is_no_map_is_said(ball: Mesh) -> None:
    with pytest.raises(DimpleError, match="A map needs pokes"):
        map_pokes(ball, DEFAULT_MATERIAL, poked(0, 5))
    pokes = poked(0)
    with pytest.raises(DimpleError, match="from the surface"):
        map_pokes(ball, DEFAULT_MATERIAL, Pokes(places=1e3 * pokes.places, depths=pokes.depths, forces=pokes.forces))
    with pytest.raises(DimpleError, match="No poke has"):
        map_pokes(ball, DEFAULT_MATERIAL, Pokes(places=pokes.places, depths=pokes.depths, forces=0 * pokes.forces))


@pytest.mark.parametrize(
    ("text", "place", "depth", "force"),
    [
        ("x,y,z,depth,force\n1,2,3,4,5\n", (1e-3, 2e-3, 3e-3), 4e-3, 5.0),
        ("# robot\nt;X (m);Y (m);Z (m);Force [gf];Depth (um)\n0;.1;.2;.3;-100;4000\n", (0.1, 0.2, 0.3), 4e-3, 0.980665),
        ("force_mn\tx_cm\ty_cm\tz_cm\tindentation_mm\n,,,,\n2000\t1\t2\t3\t4\nend\n", (0.01, 0.02, 0.03), 4e-3, 2.0),
    ],
)
def test_tables_of_robots_are_read_in_their_units(
    tmp_path: Path, text: str, place: tuple[float, ...], depth: float, force: float
) -> None:
    path = tmp_path / "pokes.csv"
    path.write_text(text, encoding="utf-8")
    pokes = read_pokes(path)
    assert pokes.places.tolist() == [pytest.approx(place)]
    assert (pokes.depths[0], pokes.forces[0]) == (pytest.approx(depth), pytest.approx(force))


@pytest.mark.parametrize(
    ("text", "what"), [("x,y,depth,force\n1,2,3,4\n", "no column z"), ("x,y,z,depth,force\n", "no pokes")]
)
def test_a_table_that_is_none_is_said(tmp_path: Path, text: str, what: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(DimpleError, match=what):
        read_pokes(path)
