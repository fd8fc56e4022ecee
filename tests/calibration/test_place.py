"""Where a body is pressed to find its constants."""

import numpy as np
import pytest

from core.calibration.place import measuring_site, typical_site
from core.material import DEFAULT_MATERIAL, FINGERTIP
from core.mesh.refine import refine
from core.mesh.surface import Mesh, mesh_from_triangles
from studies.primitives import box as box_of
from studies.primitives import joined, moved, sized, stretched
from studies.scenes import ball, cube

DEEPEST = 1.5 * DEFAULT_MATERIAL.x0


@pytest.mark.parametrize("mesh", [cube(20, 0.165), ball(4, 0.0825)], ids=["cube", "ball"])
def test_a_body_with_a_broad_face_is_measured_at_one_place(mesh: Mesh) -> None:
    site = measuring_site(mesh, DEFAULT_MATERIAL, DEEPEST)
    assert site.others == () and np.array_equal(site.point, typical_site(mesh, FINGERTIP).point)


def test_a_body_of_narrow_bars_is_measured_at_several_places_where_the_tip_can_go_deep() -> None:
    """Three bars of 8 mm by 160 mm, 35 mm high: their flanks are the larger part, and too thin to be pressed."""
    bar = stretched(box_of(1), 1, 0.05, 0.22)
    made = sized(*joined(moved(bar, 0, -0.4, 0), bar, moved(bar, 0, 0.4, 0)), 0.16)
    cut = refine(made.rest_positions, made.triangles, np.zeros(len(made.triangles), int), FINGERTIP.radius)
    mesh = mesh_from_triangles(cut.at_vertices(made.rest_positions), cut.triangles)
    assert typical_site(mesh, FINGERTIP).thickness < 0.01
    site = measuring_site(mesh, DEFAULT_MATERIAL, DEEPEST)
    places = [site, *site.others]
    assert len(places) == 5 and len({tuple(each.point) for each in places}) == 5
    assert [each.inward[2] for each in places] == pytest.approx(5 * [-1])
    assert [each.thickness for each in places] == pytest.approx(5 * [0.0352], rel=1e-3)
