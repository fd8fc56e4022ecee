"""The surface at rest: what is accepted, what is repaired with a note, and what is refused."""

import numpy as np
import pytest

from core.base import DimpleError
from core.mesh.repair import SLANTED, weld
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from studies.meshes.simple import cube_triangles
from tests.bodies import TETRAHEDRON, Shape, ball, hemisphere, joined, sheet, signed_volume, soup, walled_box


def notes_say(mesh: Mesh, words: str) -> bool:
    return any(words in note for note in mesh.notes)


def test_a_closed_mesh_is_taken_as_it_is() -> None:
    mesh = mesh_from_triangles(*TETRAHEDRON)
    assert mesh.closed and mesh.pressurable and not mesh.notes
    assert mesh.volume == pytest.approx(1 / 6)
    assert mesh.triangle_areas.sum() == pytest.approx(1.5 + np.sqrt(3) / 2)
    assert mesh.vertex_areas.sum() == pytest.approx(mesh.triangle_areas.sum())
    assert sorted(map(tuple, mesh.springs.tolist())) == [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    assert mesh.rest_lengths == pytest.approx([1, 1, 1, *[np.sqrt(2)] * 3])
    np.testing.assert_array_equal(mesh.source, range(4))


def test_soup_is_welded_into_a_closed_mesh() -> None:
    shape = ball(1)
    mesh = mesh_from_triangles(*soup(shape))
    assert mesh.closed and notes_say(mesh, "198 vertices coincide with others") and len(mesh.rest_positions) == 42
    assert mesh.volume == pytest.approx(signed_volume(*shape))
    np.testing.assert_allclose(mesh.rest_positions[mesh.source], soup(shape)[0], atol=1e-12)


@pytest.mark.parametrize("jitter", [1e-9, 1e-8, 1e-7])
def test_soup_is_welded_although_its_corners_are_rounded_apart(jitter: float) -> None:
    points, faces = soup(ball(1))
    noise = np.random.default_rng(0).uniform(-jitter, jitter, points.shape)
    mesh = mesh_from_triangles(points + noise, faces)
    assert mesh.closed and len(mesh.rest_positions) == 42


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("level", [False, True])
def test_one_pair_of_near_vertices_is_found_among_thousands(level: bool, seed: int) -> None:
    """Also where all lie in a plane on which the quick look says nothing."""
    points, off = (np.random.default_rng(seed).uniform(-1, 1, shape) for shape in ((3000, 3), 3))
    if level:
        points -= np.outer(points @ SLANTED, SLANTED) / (SLANTED @ SLANTED)
    points[2000] = points[700] + 0.49e-6 * off / np.abs(off).max()
    kept, source = weld(points, 1e-6)
    assert len(kept) == 2999 and source[2000] == source[700] == 700
    np.testing.assert_array_equal(kept, np.delete(np.arange(3000), 2000))
    assert len(weld(np.delete(points, 2000, axis=0), 1e-6)[0]) == 2999


def test_vertices_a_little_apart_stay_apart() -> None:
    points, faces = joined(TETRAHEDRON, (TETRAHEDRON[0] + [1 + 1e-4, 0, 0], TETRAHEDRON[1]))
    assert len(mesh_from_triangles(points, faces).rest_positions) == 8


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("shape", [ball(1), cube_triangles(2, 1.0), TETRAHEDRON], ids=["ball", "cube", "tetrahedron"])
def test_faces_flipped_at_random_are_flipped_back(shape: Shape, seed: int) -> None:
    points, faces = shape
    flipped = np.random.default_rng(seed).random(len(faces)) < 0.5
    mesh = mesh_from_triangles(points, np.where(flipped[:, None], faces[:, ::-1], faces))
    assert mesh.closed and mesh.volume == pytest.approx(signed_volume(*shape))
    assert signed_volume(mesh.rest_positions, mesh.triangles) == pytest.approx(mesh.volume)


def test_one_flipped_face_is_flipped_back_alone() -> None:
    points, faces = ball(1)
    faces[3] = faces[3, ::-1]
    mesh = mesh_from_triangles(points, faces)
    assert mesh.notes == ("1 faces were flipped to match the normals of their neighbors.",)


def test_a_mesh_facing_inward_is_turned_outward() -> None:
    points, faces = ball(1)
    mesh = mesh_from_triangles(points, faces[:, ::-1])
    assert mesh.volume == pytest.approx(signed_volume(points, faces)) and notes_say(mesh, "normals pointed inward")


def test_of_two_balls_the_one_facing_inward_is_turned() -> None:
    points, faces = ball(1)
    mesh = mesh_from_triangles(*joined((points, faces), (0.9 * points + [3, 0, 0], faces[:, ::-1])))
    assert mesh.volume == pytest.approx((1 + 0.9**3) * signed_volume(points, faces))
    assert notes_say(mesh, "80 faces of separate parts")


@pytest.mark.parametrize("flipped", [0, 1], ids=["whole", "one face flipped"])
def test_a_hollow_ball_keeps_its_cavity(flipped: int) -> None:
    points, faces = ball(1)
    outer = faces.copy()
    outer[:flipped] = outer[:flipped, ::-1]
    mesh = mesh_from_triangles(*joined((points, outer), (0.5 * points, faces[:, ::-1])))
    assert mesh.volume == pytest.approx((1 - 0.5**3) * signed_volume(points, faces))


@pytest.mark.parametrize("flipped", [0, 1], ids=["whole", "one face flipped"])
def test_an_open_part_facing_inward_is_turned_only_where_its_normals_disagree(flipped: int) -> None:
    (points, faces), bowl = ball(1), hemisphere()
    inward = bowl[1][:, ::-1].copy()
    inward[:flipped] = inward[:flipped, ::-1]
    mesh = mesh_from_triangles(*joined((points, faces), (bowl[0] + [5, 0, 0], inward)))
    bowl_volume = mesh_from_triangles(*bowl).volume
    assert mesh.volume == pytest.approx(signed_volume(points, faces) + (1 if flipped else -1) * bowl_volume)


@pytest.mark.parametrize("segments", [3, 16, 40])
def test_the_cap_of_a_hemisphere_makes_its_volume_that_of_the_closed_one(segments: int) -> None:
    points, faces = hemisphere(segments)
    floor = np.array([(0, s + 1, s) for s in range(1, segments - 1)])  # a fan over the open end
    mesh = mesh_from_triangles(points, faces)
    assert not mesh.closed and mesh.pressurable and notes_say(mesh, "Holes closed for the pressure only: 1.")
    assert mesh.volume == pytest.approx(signed_volume(points, np.concatenate([faces, floor])))
    assert len(mesh.cap_edges) == segments and set(mesh.cap_loop) == {0}


def test_a_tube_has_two_holes() -> None:
    points, faces = cube_triangles(3, 1.0)
    sides = faces[~np.isclose(np.abs(points[faces][:, :, 2]).min(axis=1), 0.5)]
    mesh = mesh_from_triangles(points, sides)
    assert notes_say(mesh, "only: 2.") and mesh.volume == pytest.approx(1.0)


@pytest.mark.parametrize("bend", [0.0, 1e-4, 1e-2, 0.1])
def test_a_crumpled_sheet_encloses_no_volume(bend: float) -> None:
    points, faces = sheet(8)
    points[:, 2] = np.random.default_rng(0).normal(0, bend, len(points)) if bend else 0
    mesh = mesh_from_triangles(points, faces)
    assert not mesh.pressurable and not mesh.closed
    assert mesh.notes == ("The mesh is an open sheet without a volume, so its fill has no effect.",)


def test_one_triangle_is_a_sheet_that_stands_on_its_rim() -> None:
    mesh = mesh_from_triangles(np.eye(3), np.array([[0, 1, 2]]))
    assert not mesh.pressurable and len(mesh.springs) == 3 and base_vertices(mesh).all()


def test_zero_area_faces_are_noted_and_harmless() -> None:
    points, faces = TETRAHEDRON
    middle = len(points)
    points = np.concatenate([points, [[0.5, 0, 0]]])  # on the edge 0-1: a face of no area, and one shrunk to a line
    mesh = mesh_from_triangles(points, np.concatenate([faces, [[0, middle, 1], [2, 2, 3]]]))
    assert notes_say(mesh, "2 faces have no area") and mesh.volume == pytest.approx(1 / 6)
    assert len(mesh.triangles) == 5 and np.isfinite(mesh.rest_lengths).all()


def test_loose_vertices_are_noted_and_kept() -> None:
    points, faces = TETRAHEDRON
    mesh = mesh_from_triangles(np.concatenate([[[5.0, 5, 5]], points]), faces + 1)
    np.testing.assert_array_equal(mesh.loose, [True, False, False, False, False])
    assert notes_say(mesh, "1 loose vertices") and mesh.size == 1.0 and len(mesh.source) == 5


def test_a_wall_inside_is_noted_and_does_not_count_as_volume() -> None:
    mesh = mesh_from_triangles(*walled_box())
    assert notes_say(mesh, "4 edges are non-manifold") and mesh.volume == pytest.approx(2.0)


def test_the_base_is_the_lowest_tenth_and_of_a_sheet_the_rim() -> None:
    points, faces = cube_triangles(10, 1.0)
    held = base_vertices(mesh_from_triangles(points, faces))
    np.testing.assert_array_equal(held, points[:, 2] <= -0.4 + 1e-12)
    points, faces = sheet(4)
    np.testing.assert_array_equal(
        base_vertices(mesh_from_triangles(points, faces)), np.abs(points[:, :2]).max(axis=1) == 0.5
    )


@pytest.mark.parametrize("position", [np.nan, np.inf, 1e30])
def test_a_vertex_with_a_nan_infinite_or_huge_coordinate_is_named(position: float) -> None:
    points, faces = ball(0)
    points[7, 1] = position
    with pytest.raises(DimpleError, match="Vertex 7 has a NaN or infinite coordinate"):
        mesh_from_triangles(points, faces)


@pytest.mark.parametrize(
    ("points", "faces", "words"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int), "no faces"),
        (np.eye(3), np.zeros((0, 3), int), "no faces"),
        (np.eye(3), np.array([[0, 1, 3]]), "does not exist"),
        (np.eye(3), np.array([[0, 1, -1]]), "does not exist"),
        (np.ones((3, 3)), np.array([[0, 1, 2]]), "at the same point"),
        (np.arange(3.0)[:, None] * np.ones(3), np.array([[0, 1, 2]]), "no area"),
        (np.eye(3), np.array([[0, 1, 1]]), "line or a point"),
    ],
)
def test_a_mesh_that_cannot_be_pressed_is_refused_with_the_reason(
    points: np.ndarray, faces: np.ndarray, words: str
) -> None:
    with pytest.raises(DimpleError, match=words):
        mesh_from_triangles(points, faces)


def test_a_material_for_each_triangle_or_none() -> None:
    with pytest.raises(DimpleError, match="material index"):
        mesh_from_triangles(*TETRAHEDRON, triangle_material=np.zeros(3, int))
