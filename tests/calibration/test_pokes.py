"""Pokes all over an object give a map of softness that predicts places it has not seen, or none where it cannot."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from core.base import DimpleError, Floats
from core.calibration.pokes import Pokes, map_pokes, read_pokes
from core.material import DEFAULT_MATERIAL
from core.mesh.surface import Mesh, mesh_from_triangles

HARD = Path(__file__).parents[3] / "shared" / "data" / "calibration" / "hard"
RADIUS, NOISE, PLACES = 0.0825, 0.05, 100


@pytest.fixture(scope="module")
def ball() -> Mesh:
    made = trimesh.creation.icosphere(3, radius=RADIUS)
    return mesh_from_triangles(np.array(made.vertices), np.array(made.faces))


def stiffness(places: Floats) -> Floats:
    """Return a lump: three times as stiff at one side, half as stiff at the other."""
    return np.asarray(np.exp(0.8 * np.sin(places[:, 0] / 0.05) + 0.4 * np.cos(places[:, 2] / 0.06)), np.float64)


def poked(seed: int, places: int = PLACES, uneven: bool = True) -> Pokes:
    random = np.random.default_rng(seed)
    towards = random.normal(size=(places, 3))
    points = RADIUS * towards / np.linalg.norm(towards, axis=1, keepdims=True)
    depths = random.uniform(0.004, 0.02, places)
    law = np.array([DEFAULT_MATERIAL.law(depth) for depth in depths.tolist()])
    true = stiffness(points) if uneven else np.ones(places)
    return Pokes(places=points, depths=depths, forces=true * law * np.exp(random.normal(0, NOISE, places)))


def test_the_map_is_the_softness_that_made_the_pokes(ball: Mesh) -> None:
    shares: list[float] = []
    found, true = map_pokes(ball, DEFAULT_MATERIAL, poked(0), shares.append), stiffness(ball.rest_positions)
    assert shares == sorted(shares) and 0 <= min(shares) <= max(shares) < 1, "its progress"
    painted, inside = 4.0 ** (1 - 2 * found.weights), (true > 0.26) & (true < 3.9)
    assert np.sqrt(((painted / true - 1)[inside] ** 2).mean()) < 0.15
    assert found.error < 0.2 and found.without > 0.5


def test_one_softness_all_over_needs_no_map(ball: Mesh) -> None:
    with pytest.raises(DimpleError, match="One softness is as good as a map"):
        map_pokes(ball, DEFAULT_MATERIAL, poked(1, uneven=False))


def test_each_place_is_predicted_by_its_four_nearest_and_not_by_itself(ball: Mesh) -> None:
    pokes = poked(2)
    law = np.array([DEFAULT_MATERIAL.law(depth) for depth in pokes.depths.tolist()])
    logs, errors = np.log(pokes.forces / law), []
    for i, place in enumerate(pokes.places):
        near = np.argsort(((pokes.places - place) ** 2).sum(axis=1))[1:5]
        errors.append(np.expm1(logs[near].mean() - logs[i]))
    assert map_pokes(ball, DEFAULT_MATERIAL, pokes).error == pytest.approx(np.sqrt(np.mean(np.square(errors))))


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


COLUMNS = "x,y,z,depth,force\n"


@pytest.mark.parametrize(
    ("text", "place", "depth", "force"),
    [
        (COLUMNS + "1,2,3,4,5\n" * 8, (1e-3, 2e-3, 3e-3), 4e-3, 5.0),
        ("x;y;z;depth;force\n" + "1,5;2;3;4,5;5,5\n" * 8, (1.5e-3, 2e-3, 3e-3), 4.5e-3, 5.5),
        (COLUMNS + "m,m,m,um,mN\n" + "0.1,0.2,0.3,4000,5000\n" * 8, (0.1, 0.2, 0.3), 4e-3, 5.0),
        ("t;X (m);Y (m);Z (m);Force [gf];Depth (um)\n" + "0;.1;.2;.3;-100;4000\n" * 8, (0.1, 0.2, 0.3), 4e-3, 0.980665),
        ("force_mN\tx_cm\ty_cm\tz_cm\tindentation_mm\n" + "2000\t1\t2\t3\t-4\n" * 8, (0.01, 0.02, 0.03), 4e-3, 2.0),
    ],
    ids=["bare", "decimal commas", "row of units", "force turned round", "depth turned round"],
)
def test_tables_of_robots_are_read_in_their_units(
    text: str, place: tuple[float, ...], depth: float, force: float, tmp_path: Path
) -> None:
    path = tmp_path / "pokes.csv"
    path.write_text(text, encoding="utf-8")
    pokes = read_pokes(path)
    assert pokes.places.tolist() == [pytest.approx(place)] * 8
    assert (pokes.depths[0], pokes.forces[0]) == (pytest.approx(depth), pytest.approx(force))


def test_rows_in_the_air_are_no_pokes(tmp_path: Path) -> None:
    path = tmp_path / "pokes.csv"
    approach = [f"0,0,2,{depth / 4},{max(depth, 0) / 4 + 0.01 * (-1) ** depth}" for depth in range(-20, 15)]
    path.write_text(COLUMNS + "\n".join(approach) + "\n")
    pokes = read_pokes(path)
    assert len(pokes.depths) == 14 and pokes.depths.min() == pytest.approx(0.25e-3)


@pytest.mark.skipif(not HARD.is_dir(), reason="the shared data is not here")
@pytest.mark.parametrize("name", ["decimal_comma", "unit_row"])
def test_the_same_pokes_written_in_two_ways_are_the_same(name: str) -> None:
    pokes = read_pokes(HARD / f"pokes_{name}.csv")
    assert len(pokes.depths) == 70
    assert (pokes.depths.min(), pokes.depths.max()) == pytest.approx((0.5e-3, 3.5e-3))
    assert (pokes.forces.min(), pokes.forces.max()) == pytest.approx((0.5, 3.5))


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("x,y,depth,force\n" + "1,2,3,4\n" * 8, "no column z"), (COLUMNS, "no table"),
        (COLUMNS + "1,2,3,4,0\n" * 8, "No poke has"),
    ],
    ids=["no z", "no rows", "no force"],
)  # fmt: skip
def test_a_table_that_is_none_is_said(text: str, what: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(DimpleError, match=what):
        read_pokes(path)
