"""One material on any mesh: identified with its tip, as the product does it, it answers the same force straight back.

The tip's radius is twice the edges or more; where edges are longer, studies/README.md says what is lost.
"""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
import pytest

from core.base import Floats
from core.body.model import build_model
from core.calibration.identify import identification
from core.calibration.indent import Site, find_site
from core.calibration.place import measuring_site, typical_site
from core.material import DEFAULT_MATERIAL, Indenter, Material
from core.mesh.refine import is_coarse, refine
from core.mesh.surface import Mesh, mesh_from_triangles
from core.session import Finger, Session
from core.steps import result_of
from studies.dents import jittered
from studies.primitives import SIZE, box, icosphere, remeshed, rotated, sized, uv_sphere

TIP, FINGERTIP = Indenter(shape="sphere", radius=0.020), Indenter(shape="sphere", radius=0.010)
DEPTH, SPEED, PLACES = 0.010, 0.05, 3  # [m], [m/s]
DEEPEST = 1.5 * DEFAULT_MATERIAL.x0
CLOSE = 0.03  # of the force: what it may differ from the law, and be sideways
NEAR = 0.1  # of the law, which a round tip meets more softly at first and rounds at its knee


def turned_ball(subdivisions: int, seed: int) -> Mesh:
    points, faces = rotated(icosphere(subdivisions), seed=seed)
    return mesh_from_triangles(points * SIZE / 2 / np.linalg.norm(points, axis=1).max(), faces)


MESHES: dict[str, Callable[[], Mesh]] = {
    "ball of 2,562": lambda: sized(*icosphere(4)),
    "ball of 2,562, turned": partial(turned_ball, 4, 0),
    "cube of 2,402": lambda: sized(*box(20)),
}
FINER: dict[str, Callable[[], Mesh]] = {
    "ball of 2,562, turned again": partial(turned_ball, 4, 1),
    "uneven ball of 2,562": lambda: sized(*remeshed(4)),
    "ball of 10,242": lambda: sized(*icosphere(5)),
    "ball of 10,242, turned": partial(turned_ball, 5, 0),
    "uneven ball of 10,242": lambda: sized(*remeshed(5)),
    "ball of 40,962": lambda: sized(*icosphere(6)),
    "cube of 10,088": lambda: sized(*box(41)),
    "uneven cube of 10,088": lambda: sized(*jittered(41)),
}


def cut_finer(mesh: Mesh) -> Mesh:
    """Return a mesh as a session cuts it for the usual fingertip."""
    points, triangles = mesh.rest_positions, mesh.triangles
    assert is_coarse(points, triangles, FINGERTIP.radius)
    found = refine(points, triangles, np.zeros(len(triangles), int), FINGERTIP.radius)
    return mesh_from_triangles(found.at_vertices(points), found.triangles)


def identified(mesh: Mesh, tip: Indenter, site: Site | None = None) -> Material:
    """Return the material with the constants that the product finds for a mesh."""
    site = site or typical_site(mesh, tip)
    return result_of(identification(mesh, DEFAULT_MATERIAL, tip, site, DEEPEST)).material


def places(mesh: Mesh, tip: Indenter, *, cube: bool) -> Iterator[Site]:
    """Yield places on the upper side, away from edges and pins."""
    rng = np.random.default_rng(1)
    for _ in range(PLACES):
        x, y = rng.uniform(-0.03, 0.03, 2).tolist()
        outward = np.array([0.0, 0.0, 1.0] if cube else [x, y, SIZE / 2])
        outward /= np.linalg.norm(outward)
        above = np.array([x, y, 0.0]) if cube else SIZE / 2 * outward
        yield find_site(mesh, tip, above=above.tolist(), inward=(-outward).tolist())


def pressed(mesh: Mesh, material: Material, site: Site, deepest: float = DEPTH) -> Floats:
    """Return the force (3,) [N] on a fingertip as large as the tip, that goes in at an even speed, on the way."""
    tip = material.indenter.radius
    session = Session(build_model(mesh, [material], pinned=site.pinned[mesh.source]))
    for depth, seconds in ((0.0, 0.001), (deepest, deepest / SPEED)):
        x, y, z = (site.point + (depth - tip) * site.inward).tolist()
        session.set_fingers([Finger((x, y, z), tip)])
        session.step(seconds - 0.004 if depth else seconds)
    return np.asarray(session.step(0.004).finger_forces[0])


def forces(mesh: Mesh, tip: Indenter, *, cube: bool) -> Iterator[tuple[float, float]]:
    """Yield the force over the law, and its part across the press over it, at several places of a mesh."""
    material = identified(mesh, tip)
    for site in places(mesh, tip, cube=cube):
        force = pressed(mesh, material, site)
        along = float(-force @ site.inward)
        across = float(np.linalg.norm(force + along * site.inward))
        yield along / material.law(DEPTH), across / along


def judge(name: str, mesh: Mesh, tip: Indenter, close: float = CLOSE) -> None:
    for force, across in forces(mesh, tip, cube="cube" in name):
        print(f"{name}: {force:.3f} of the law, {100 * across:.1f} % across")
        assert force == pytest.approx(1.0, abs=close) and across < close


@pytest.mark.parametrize("name", [*MESHES, *(pytest.param(name, marks=pytest.mark.slow) for name in FINER)])
def test_an_identified_body_answers_the_law_on_any_mesh_and_hardly_sideways(name: str) -> None:
    judge(name, {**MESHES, **FINER}[name](), TIP)


@pytest.mark.parametrize("seed", [4, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (5, 10))])
def test_a_ball_with_long_edges_here_and_there_answers_the_law_everywhere(seed: int) -> None:
    """As it comes it answers by up to 12 % too much, and sideways by a fifth. Of seeds 4 to 11 these are 3.4 % off."""
    judge(f"uneven ball of 2,562 ({seed}), cut finer", cut_finer(sized(*remeshed(4, seed=seed))), FINGERTIP, 0.035)


def test_a_mesh_too_coarse_for_the_fingertip_is_cut_finer_and_answers_as_well() -> None:
    """As it comes it answers sideways, by a quarter of the force."""
    judge("cube of 2,402, cut finer", cut_finer(sized(*box(20))), FINGERTIP)


@pytest.mark.parametrize(("segments", "rings"), [(32, 16), pytest.param(64, 32, marks=pytest.mark.slow)])
def test_the_pole_of_a_uv_sphere_answers_the_law_as_the_rest_of_it_does(segments: int, rings: int) -> None:
    """Cut finer by its edges alone its pole had no neighbour nearer than 8 mm, and answered 0.72 of the law at 5 mm."""
    mesh = cut_finer(sized(*uv_sphere(segments, rings)))
    material = identified(mesh, FINGERTIP, measuring_site(mesh, DEFAULT_MATERIAL, DEEPEST))
    for angle in (0.0, 0.4, 0.8, 1.2):
        inward = -np.array([np.sin(angle), 0.1 * np.sin(angle), np.cos(angle)])
        site = find_site(mesh, FINGERTIP, above=(0.0, 0.0, 0.0), inward=inward.tolist())
        for depth in (0.005, 0.010, DEFAULT_MATERIAL.x0):
            force = -float(pressed(mesh, material, site, depth) @ site.inward) / material.law(depth)
            print(f"{segments} x {rings}, {angle:g} rad from the pole: {force:.3f} of the law at {1e3 * depth:g} mm")
            assert force == pytest.approx(1.0, abs=NEAR)
