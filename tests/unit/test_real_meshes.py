"""Scans and exports as they come. The files are beside the repository; without them these tests skip."""

import numpy as np
import pytest
import trimesh

from core.mesh.surface import Mesh, cap_centres, mesh_from_triangles
from tests.bodies import REAL, real


@pytest.fixture(params=REAL)
def raw(request: pytest.FixtureRequest) -> trimesh.Trimesh:
    return trimesh.Trimesh(*real(request.param), process=False)


@pytest.fixture
def mesh(raw: trimesh.Trimesh) -> Mesh:
    """Return the file as a body of 165 mm."""
    points = np.asarray(raw.vertices, float)
    return mesh_from_triangles(0.165 / np.ptp(points, axis=0).max() * points, np.asarray(raw.faces))


def test_a_real_mesh_keeps_its_surface(raw: trimesh.Trimesh, mesh: Mesh) -> None:
    scale = 0.165 / np.ptp(raw.vertices, axis=0).max()
    assert mesh.triangle_areas.sum() == pytest.approx(raw.area * scale**2, rel=1e-4)
    assert len(mesh.source) == len(raw.vertices)
    np.testing.assert_allclose(mesh.rest_positions[mesh.source], raw.vertices * scale, atol=1e-6 * 0.165)


def test_a_real_mesh_and_its_caps_close_and_have_the_volume_trimesh_finds(raw: trimesh.Trimesh, mesh: Mesh) -> None:
    """Give every border edge a triangle to the middle of its hole, as an artist would fill it."""
    centres = cap_centres(mesh.rest_positions, mesh.cap_edges, mesh.cap_loop)[0]
    caps = np.column_stack([mesh.cap_edges, len(mesh.rest_positions) + mesh.cap_loop])
    points = np.concatenate([mesh.rest_positions, centres])
    whole = trimesh.Trimesh(points, np.concatenate([mesh.triangles, caps]), process=False)
    np.testing.assert_allclose(whole.triangles_cross.sum(axis=0), 0, atol=1e-12 * whole.area)
    assert mesh.volume == pytest.approx(whole.volume, rel=1e-9)
    assert mesh.closed == (len(caps) == 0) and mesh.pressurable == (mesh.volume > 0)
    if mesh.closed:
        assert mesh.volume / 0.165**3 == pytest.approx(abs(raw.volume) / raw.extents.max() ** 3, rel=1e-4)
