"""Cutting a surface finer keeps its shape and its vertices, and leaves no edge too long for the fingertip."""

import numpy as np
import pytest

from core.base import Floats, Ints
from core.mesh.refine import COARSE, FINE, MOST, Refinement, is_coarse, refine
from core.mesh.surface import Mesh, mesh_from_triangles

RADIUS = 0.010
CORNERS = 0.0825 * np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
SIDES = 32


def cube() -> tuple[Floats, Ints]:
    return CORNERS, np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])


def cylinder() -> tuple[Floats, Ints]:
    """Blender's cylinder: its ends are fans of slivers round one of the corners."""
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    rim = 0.0825 * np.stack([np.cos(angle), np.sin(angle), np.ones(SIDES)], axis=1)
    i = np.arange(SIDES)
    j, fan = (i + 1) % SIDES, np.arange(1, SIDES - 1)
    sides = [np.stack([i + SIDES, j + SIDES, j], axis=1), np.stack([i + SIDES, j, i], axis=1)]
    ends = [np.stack([0 * fan, fan, fan + 1], axis=1), SIDES + np.stack([0 * fan, fan + 1, fan], axis=1)]
    return np.concatenate([rim, rim * (1, 1, -1)]), np.concatenate(sides + ends)


def cone() -> tuple[Floats, Ints]:
    """Blender's cone: its flank are strips that narrow to a point, too bent between them for flips."""
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    rim = 0.0825 * np.stack([np.cos(angle), np.sin(angle), -np.ones(SIDES)], axis=1)
    i, fan = np.arange(SIDES), np.arange(1, SIDES - 1)
    flank, lid = np.stack([i, (i + 1) % SIDES, 0 * i + SIDES], axis=1), np.stack([0 * fan, fan + 1, fan], axis=1)
    return np.append(rim, [[0, 0, 0.0825]], axis=0), np.concatenate([flank, lid])


def refined(positions: Floats, triangles: Ints, **how: int) -> tuple[Refinement, Mesh]:
    found = refine(positions, triangles, np.zeros(len(triangles), int), RADIUS, **how)
    return found, mesh_from_triangles(found.at_vertices(positions), found.triangles)


@pytest.mark.parametrize("shape", [cube, cylinder, cone])
def test_a_refined_surface_has_the_same_shape_and_its_own_vertices_first(shape) -> None:
    positions, triangles = shape()
    before = mesh_from_triangles(positions, triangles)
    found, mesh = refined(positions, triangles)
    assert np.array_equal(found.at_vertices(positions)[: len(positions)], positions)
    assert mesh.closed and mesh.volume == pytest.approx(before.volume, rel=1e-12)
    assert mesh.triangle_areas.sum() == pytest.approx(before.triangle_areas.sum(), rel=1e-12)
    assert mesh.rest_lengths.max() <= 1.3 * FINE * RADIUS and len(mesh.rest_positions) <= MOST
    assert is_coarse(positions, triangles, RADIUS) and not is_coarse(mesh.rest_positions, mesh.triangles, RADIUS)


def evenness(mesh: Mesh, which: np.ndarray) -> np.ndarray:
    """Return for some triangles how near they are to having equal sides: 1 where they do."""
    corners = mesh.rest_positions[mesh.triangles[which]]
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    return 4 * np.sqrt(3) * mesh.triangle_areas[which] / (sides**2).sum(axis=1)


def test_flips_make_fans_of_slivers_even() -> None:
    positions, triangles = cylinder()
    _, mesh = refined(positions, triangles)
    end = (mesh.rest_positions[mesh.triangles][:, :, 2] > 0.0825 * (1 - 1e-9)).all(axis=1)
    shape = evenness(mesh, end)
    assert np.median(shape) > 0.8 and np.average(shape > 0.5, weights=mesh.triangle_areas[end]) > 0.9


def test_strips_that_narrow_to_a_point_get_no_more_vertices_than_they_need() -> None:
    _, mesh = refined(*cone())
    every = np.ones(len(mesh.triangles), bool)
    assert len(mesh.rest_positions) < 1.5 * mesh.triangle_areas.sum() / (np.sqrt(3) / 2 * (0.7 * FINE * RADIUS) ** 2)
    assert np.average(evenness(mesh, every) > 0.5, weights=mesh.triangle_areas) > 0.9


def test_what_moves_the_vertices_carries_the_refined_surface_along_and_pins_do_not_spread() -> None:
    positions, triangles = cube()
    found, mesh = refined(positions, triangles)
    pinned = (positions[:, 2] < 0).astype(float)
    held = found.least_at_vertices(pinned) > 0
    assert np.array_equal(held, mesh.rest_positions[:, 2] < -0.0825 * (1 - 1e-9))
    bend = positions @ np.array([[1, 0, 0.2], [0, 1.5, 0], [0, 0, 1]])
    np.testing.assert_allclose(
        found.at_vertices(bend), mesh.rest_positions @ np.array([[1, 0, 0.2], [0, 1.5, 0], [0, 0, 1]]), atol=1e-12
    )


def test_a_surface_far_larger_than_the_fingertip_is_cut_as_finely_as_runs_live() -> None:
    positions, triangles = cube()
    _, mesh = refined(100 * positions, triangles, most=2000)
    assert 500 < len(mesh.rest_positions) <= 2000 and mesh.rest_lengths.max() > COARSE * RADIUS


def test_materials_keep_their_faces() -> None:
    positions, triangles = cube()
    kinds = (np.arange(len(triangles)) >= 6).astype(int)
    found = refine(positions, triangles, kinds, RADIUS)
    areas = mesh_from_triangles(found.at_vertices(positions), found.triangles).triangle_areas
    shares = [areas[kinds[found.origin] == kind].sum() for kind in (0, 1)]
    assert shares == pytest.approx([3 * 0.165**2] * 2, rel=1e-12)
