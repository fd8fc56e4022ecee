"""Ordered one-rings against sums over faces and edges one by one."""

import numpy as np
import pytest

from core.base import Floats
from core.mesh.rings import MAX_RING
from core.mesh.surface import Mesh, mesh_from_triangles
from studies.meshes.simple import cube_triangles
from studies.reference.laws import around
from tests.bodies import TETRAHEDRON, Shape, ball, hemisphere, joined, sheet, soup, walled_box


def cone(sides: int) -> Shape:
    """Return a closed double cone: two fans of `sides` faces."""
    turn = np.arange(sides) * 2 * np.pi / sides
    rim = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    faces = [(s, (s + 1) % sides, sides) for s in range(sides)] + [
        ((s + 1) % sides, s, sides + 1) for s in range(sides)
    ]
    return np.concatenate([rim, [[0, 0, 1], [0, 0, -1.0]]]), np.array(faces)


def touching_tetrahedra() -> Shape:
    """Return two tetrahedra that share one vertex: two fans meet in it."""
    points, faces = TETRAHEDRON
    return soup(joined((points, faces), (-points, faces[:, ::-1])))


SHAPES = {
    "tetrahedron": TETRAHEDRON, "ball": ball(2), "cube": cube_triangles(3, 1.0), "hemisphere": hemisphere(),
    "sheet": sheet(), "wall": walled_box(), "touching": touching_tetrahedra(),
    "one triangle": (np.eye(3), np.array([[0, 1, 2]])),
    "widest fan": cone(MAX_RING), "too wide a fan": cone(MAX_RING + 1), "very wide fan": cone(60),
    "loose": (np.concatenate([ball(1)[0], [[2.0, 2, 2]]]), ball(1)[1]),
}  # fmt: skip


@pytest.fixture(params=SHAPES)
def mesh(request: pytest.FixtureRequest) -> Mesh:
    return mesh_from_triangles(*SHAPES[request.param])


def disturbed(mesh: Mesh) -> Floats:
    noise = np.random.default_rng(1).normal(0, 0.1 * mesh.size, mesh.rest_positions.shape)
    return (mesh.rest_positions + noise).T


def test_the_ring_normal_is_the_sum_of_the_face_normals_round_a_vertex(mesh: Mesh) -> None:
    x = disturbed(mesh)
    wanted = np.zeros_like(x)
    for a, b, c in mesh.triangles:
        normal = np.cross(x[:, b] - x[:, a], x[:, c] - x[:, a])
        for corner in (a, b, c):
            wanted[:, corner] += normal
    arms = around(mesh.rings, x)
    found = np.cross(arms, np.roll(arms, -1, axis=1), axis=0).sum(axis=1)
    regular = mesh.rings.regular
    np.testing.assert_allclose(found[:, regular], wanted[:, regular], atol=1e-12 * mesh.size**2)
    np.testing.assert_array_equal(found[:, ~regular], 0)


def test_every_spring_is_met_at_both_its_ends(mesh: Mesh) -> None:
    rings = mesh.rings
    met = {(int(s), v) for slot in rings.springs for v, s in enumerate(slot) if s >= 0}
    slots = int((rings.springs >= 0).sum())
    irregular = {
        (int(s), int(mesh.springs[s, end]))
        for s, ends in zip(rings.irregular_springs, rings.irregular_ends, strict=True)
        for end in (0, 1)
        if ends[end]
    }
    assert len(met) == slots and not met & irregular
    assert met | irregular == {(s, int(v)) for s, pair in enumerate(mesh.springs) for v in pair}


def test_every_corner_of_every_triangle_is_in_a_ring_or_listed(mesh: Mesh) -> None:
    turned = {tuple(np.roll(f, -k).tolist()) for f in mesh.triangles for k in range(3)}
    assert {tuple(c) for c in mesh.rings.corners.tolist()} == {f for f in turned if not mesh.rings.regular[f[0]]}


@pytest.mark.parametrize(
    ("name", "without"),
    [("ball", 0), ("widest fan", 0), ("too wide a fan", 2), ("touching", 1), ("loose", 1), ("wall", 4)],
)
def test_only_borders_crossings_and_wide_fans_have_no_ring(name: str, without: int) -> None:
    assert (~mesh_from_triangles(*SHAPES[name]).rings.regular).sum() == without
