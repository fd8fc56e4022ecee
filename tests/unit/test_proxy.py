"""A proxy has the mass, the forces and the shape of its mesh, within what its spacing allows."""

from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from core import native
from core.base import DimpleError, Floats
from core.body.model import Model, build_model
from core.body.shape_matching import fit_pose
from core.mesh.surface import Mesh, base_vertices, mesh_from_triangles
from core.reduction.binding import WHOLE, carry
from core.reduction.cells import grow_cells, spread_seeds, vertex_normals
from core.reduction.proxy import Proxy, build_proxy, mean_spacing, painted
from core.session import Finger, Session
from studies.meshes import bodies
from studies.meshes.simple import box
from studies.paper_objects import PRESETS
from studies.reference import carry as in_numpy
from studies.reference.cells import farthest_first, nearest_seeds, spread_cells
from studies.scenes import BALL, ball, cube
from tests.bodies import REAL, after, hemisphere, joined, real, soup
from tests.bodies import ball as ball_shape

VINYL = PRESETS[1].material


def joined_balls() -> Mesh:
    """Return two balls apart, the second so small that no seed lies on it."""
    return mesh_from_triangles(*joined(ball_shape(3, 0.08), (ball_shape(1, 0.004)[0] + 0.2, ball_shape(1)[1])))


@pytest.fixture(scope="module")
def model() -> Model:
    mesh = ball(5)
    return build_model(mesh, [BALL], pinned=base_vertices(mesh))


@pytest.fixture(scope="module")
def proxy(model: Model) -> Proxy:
    return build_proxy(model, 1000)


def pressed(model: Model, proxy: Proxy | None, depth: float = 0.01, radius: float = 0.02) -> tuple[Session, float]:
    """Press the top down in 0.1 s, hold 0.1 s; return the session and the mean force [N] of the last 50 ms."""
    session = Session(model, proxy=proxy)
    top = model.mesh.rest_positions[model.mesh.rest_positions[:, 2].argmax()] + (0, 0, radius)
    session.set_fingers([Finger(tuple(top), radius)])
    for seconds, down in ((0.1, depth), (0.05, depth), (0.05, depth)):
        session.set_fingers([Finger((top[0], top[1], top[2] - down), radius)])
        frame = session.step(seconds)
    return session, float(frame.finger_forces[0, 2])


def test_at_rest_the_surface_is_the_mesh_bit_for_bit(model: Model, proxy: Proxy) -> None:
    session = Session(model, proxy=proxy)
    assert np.array_equal(session.positions(), model.mesh.rest_positions.astype(np.float32))
    # single precision rounds the liquid's pressure
    np.testing.assert_allclose(after(session, 0.01), model.mesh.rest_positions, atol=1e-7)


@pytest.mark.parametrize("vertices", [700, 4000])
def test_a_proxy_has_no_blunt_edges_so_its_tension_is_that_of_its_area(model: Model, vertices: int) -> None:
    """Stretched alike in all directions a membrane stores T times its area: it was 8 to 16 % more."""
    mesh = build_proxy(model, vertices).model.mesh
    weights = mesh.cotangents
    assert weights @ mesh.rest_lengths**2 == pytest.approx(2 * mesh.triangle_areas.sum(), rel=2e-3)
    assert (weights <= 0).mean() < 0.01 and mesh.closed


@pytest.mark.parametrize(("radius", "around", "vertices"), [(0.02, 0.5, 700), (0.01, 0.0, 1000)])
def test_a_soft_spot_no_larger_than_a_fingertip_answers_as_on_the_mesh(
    model: Model, radius: float, around: float, vertices: int
) -> None:
    """Its force was 16 % off, too high or too low, where cells lay across its border."""
    mesh = model.mesh
    top = mesh.rest_positions[mesh.rest_positions[:, 2].argmax()]
    spot = np.linalg.norm(mesh.rest_positions - top, axis=1) < radius
    softness = np.where(spot, 1.0, around)[mesh.source]
    spotted = build_model(mesh, [BALL], pinned=base_vertices(mesh), softness=softness)
    proxy = build_proxy(spotted, vertices)
    assert pressed(spotted, proxy)[1] == pytest.approx(pressed(spotted, None)[1], rel=0.06)
    assert (spot != spot[proxy.seeds[proxy.cells]]).sum() < 0.2 * spot.sum() and not painted(model).any()


def test_blunt_triangles_are_no_stiffer_than_their_area() -> None:
    """A negative weight is left out, and what is round it is less by as much."""
    points, faces = box(12)
    way = 0.075 * np.random.default_rng(6).uniform(-1, 1, points.shape)  # of a half of the spacing and less
    points = points + np.where(np.abs(points) > 1 - 1e-9, 0.0, way)
    mesh = mesh_from_triangles(points, faces)
    weights = mesh.cotangents
    assert (weights <= 0).mean() > 0.05 and weights.min() >= 0
    assert weights @ mesh.rest_lengths**2 == pytest.approx(2 * mesh.triangle_areas.sum(), rel=0.03)


def test_a_rigid_motion_of_the_proxy_is_one_of_the_surface(proxy: Proxy) -> None:
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    skin = carry(proxy.binding, turn @ proxy.model.matching.rest + 0.3)
    # motions are blended in single precision
    np.testing.assert_allclose(skin, proxy.binding.rest @ turn.T + 0.3, atol=1e-6)


def test_the_native_core_carries_a_surface_as_numpy_does(model: Model, proxy: Proxy) -> None:
    rng = np.random.default_rng(2)
    x = proxy.model.matching.rest + 0.01 * rng.normal(size=(3, len(proxy.seeds)))
    skin, motions = native.carry(native.library(), proxy.binding, x)
    twins = in_numpy.motions_of(proxy.binding, x)
    np.testing.assert_allclose(motions, twins, rtol=1e-6, atol=1e-7 * np.abs(twins).max())
    np.testing.assert_allclose(skin, in_numpy.carry(proxy.binding, twins), atol=4e-7 * model.mesh.size)
    assert not np.array_equal(skin, proxy.binding.rest)


@pytest.mark.parametrize("make", [lambda: ball(4), lambda: bodies.head(20, 0.2), joined_balls])
def test_the_native_core_grows_and_follows_cells_as_numpy_does(make: Callable[[], Mesh]) -> None:
    mesh = make()
    library, spacing = native.library(), mean_spacing(mesh, 150)
    normals = vertex_normals(mesh.triangles, mesh.rest_positions)
    place = np.concatenate([mesh.rest_positions, spacing / 2 * normals], axis=1)
    seeds, rng = spread_seeds(mesh, place, np.flatnonzero(~mesh.loose), 150, spacing), np.random.default_rng(0)
    for taken, least in ((1, 0.0), (40, 0.0), (1, spacing**2)):
        chosen = native.farthest_first(library, place, taken, least, 300)
        assert np.array_equal(chosen, farthest_first(place, taken, least, 300)) and len(chosen)
    found, wanted = native.grow_cells(library, mesh.springs, place, seeds), spread_cells(mesh.springs, place, seeds)
    assert np.array_equal(found[0], wanted[0]) and np.array_equal(found[1], wanted[1])
    cells = np.maximum(wanted[0], 0)
    around = np.array([rng.permutation(len(seeds))[:30] for _ in seeds])
    around[::3, 5:] = -1
    first, followed, weights = native.follow_cells(library, place, seeds, cells, around)
    twins = nearest_seeds(place, seeds, cells, around)
    assert np.array_equal(first, twins[0]) and np.array_equal(followed, twins[1])
    assert np.abs(weights.astype(int) - twins[2]).max() <= 1
    sums = np.add.reduceat(weights, first[:-1], dtype=int).ravel()[: len(place)]
    assert (sums == WHOLE).all()


def test_a_bent_proxy_bends_the_surface_without_facets(model: Model, proxy: Proxy) -> None:
    """Bent into a parabola the error is under a fifth of that of flat facets: spacing^2 curvature / 8."""
    curvature = 5.0

    def bent(x: Floats) -> Floats:
        return np.stack([x[0], x[1], x[2] + curvature * x[0] ** 2 / 2])

    off = carry(proxy.binding, bent(proxy.model.matching.rest)) - bent(model.matching.rest).T
    facets = proxy.spacing**2 * curvature / 8
    assert np.sqrt((off**2).mean()) < 0.2 * facets
    assert np.abs(bent(model.matching.rest) - model.matching.rest).max() > 20 * facets, "the bend itself is large"


def test_mass_shape_matching_and_pins_are_conserved(model: Model, proxy: Proxy) -> None:
    coarse = proxy.model
    assert coarse.mass.sum() == pytest.approx(model.mass.sum(), rel=1e-12)
    assert coarse.matching.k1.sum() == pytest.approx(model.matching.k1.sum(), rel=1e-12)
    # the pinned area, within a row of cells along its rim
    rim = 2 * np.pi * 0.08 * proxy.spacing
    areas = [float(m.mesh.vertex_areas[m.pinned].sum()) for m in (model, coarse)]
    assert abs(areas[0] - areas[1]) < rim < areas[0]
    assert coarse.mesh.closed and abs(coarse.mesh.volume / model.mesh.volume - 1) < 0.03


def test_a_press_of_the_proxy_is_that_of_the_mesh(model: Model, proxy: Proxy) -> None:
    """Force within 15 %, the surface of a 10 mm dent within 1 mm (root mean square), for a tenth of the work.

    The error is nowhere larger than twice the sagitta of a facet, h^2 / 6 R.
    """
    (fine, force), (coarse, coarse_force) = pressed(model, None), pressed(model, proxy)
    assert coarse_force == pytest.approx(force, rel=0.15)
    off = np.linalg.norm(fine.positions() - coarse.positions(), axis=1)
    moved = np.linalg.norm(fine.positions() - model.mesh.rest_positions, axis=1)
    assert np.sqrt((off[moved > 1e-3] ** 2).mean()) < 1e-3
    assert off.max() < 2 * proxy.spacing**2 / (6 * 0.020)
    assert coarse.frame.volume == pytest.approx(fine.frame.volume, rel=2e-3)
    assert coarse.frame.depths == pytest.approx(fine.frame.depths, abs=2e-4)
    steps = [session.substeps * len(m.mass) for session, m in ((fine, model), (coarse, proxy.model))]
    assert steps[1] < steps[0] / 10


def test_finer_proxies_have_smaller_errors(model: Model) -> None:
    fine = pressed(model, None)[0].positions()
    errors = []
    for vertices in (150, 1350):
        shown = pressed(model, build_proxy(model, vertices))[0].positions()
        errors.append(np.sqrt(((shown - fine) ** 2).sum(axis=1).mean()))
    assert 1e-6 < errors[1] < errors[0] / 2  # the spacing falls to a third


def test_pinned_vertices_stay_and_follow_their_object(model: Model, proxy: Proxy) -> None:
    session, _ = pressed(model, proxy)
    pinned = model.pinned
    assert 0 < pinned.sum() < len(pinned) / 2
    assert np.array_equal(session.positions()[pinned], model.mesh.rest_positions[pinned].astype(np.float32))
    moved = model.mesh.rest_positions + (0.02, 0.0, 0.0)
    session.set_fingers([])
    session.set_pins(moved)
    for _ in range(10):
        session.step(0.1)
        session.set_pins(moved)
    np.testing.assert_allclose(session.positions()[pinned], moved[pinned], atol=1e-7)
    np.testing.assert_allclose(session.positions(), moved, atol=1e-4)


def test_a_free_proxy_conserves_momentum() -> None:
    model = build_model(ball(4), [BALL])
    proxy = build_proxy(model, 300)
    session = Session(model, proxy=proxy, backend="native64")
    rest = proxy.model.matching.rest
    session.body.set_state(rest, np.zeros_like(rest) + [[0.1], [0.0], [0.05]])
    session.step(0.1)
    velocity = proxy.model.mass @ session.body.velocities().T / proxy.model.mass.sum()
    np.testing.assert_allclose(velocity, (0.1, 0.0, 0.05), atol=1e-9)
    x = session.positions().T.astype(float)
    rotation, shift = fit_pose(model.matching.rest, x, np.ones(x.shape[1]))
    np.testing.assert_allclose(shift, np.array([0.1, 0.0, 0.05]) * 0.1, atol=1e-5)


@pytest.mark.parametrize("vertices", [283, 800, 1600])
def test_cells_are_in_one_piece_so_a_closed_mesh_has_a_closed_proxy(vertices: int) -> None:
    """On a bent body cells cut one another in two while they grow; two pieces of a cell would leave a hole."""
    bent = bodies.build(bodies.BODIES[29])
    mesh, spacing = bent.mesh, mean_spacing(bent.mesh, vertices)
    normals = vertex_normals(mesh.triangles, mesh.rest_positions)
    place = np.concatenate([mesh.rest_positions, spacing / 2 * normals], axis=1)
    seeds = spread_seeds(mesh, place, np.arange(len(place)), vertices, spacing)
    cells = grow_cells(mesh, place, seeds)
    own = mesh.springs[cells[mesh.springs[:, 0]] == cells[mesh.springs[:, 1]]]
    pieces = trimesh.graph.connected_component_labels(own, node_count=len(place)).max() + 1
    assert pieces == len(seeds)
    assert build_proxy(bent, vertices).model.mesh.closed


def test_separate_parts_and_open_meshes_have_proxies() -> None:
    two = joined(ball_shape(4, 0.05), (ball_shape(3, 0.02)[0] + (0.2, 0, 0), ball_shape(3, 0.02)[1]))
    # a speck beside them is too small for a triangle: it follows
    three = joined(two, (ball_shape(1, 0.002)[0] + (0.0, 0, 0.06), ball_shape(1, 0.002)[1]))
    for points, faces in (two, three, hemisphere(64, 32, 0.1), soup(ball_shape(4, 0.05))):
        model = build_model(mesh_from_triangles(points, faces), [VINYL])
        proxy = build_proxy(model, 300)
        assert not proxy.model.mesh.loose.any() and proxy.model.mesh.pressurable
        assert np.array_equal(carry(proxy.binding, proxy.model.matching.rest), proxy.binding.rest)


@pytest.mark.parametrize("name", REAL)
def test_scans_have_a_proxy_or_a_reason(name: str) -> None:
    points, faces = real(name)
    mesh = mesh_from_triangles(0.165 / np.ptp(points, axis=0).max() * points, faces)
    model = build_model(mesh, [VINYL], pinned=base_vertices(mesh))
    for vertices in (150, 600):
        try:
            proxy = build_proxy(model, vertices)
        except DimpleError as error:
            assert str(error)
            continue
        assert np.array_equal(carry(proxy.binding, proxy.model.matching.rest), proxy.binding.rest)
        session = Session(model, proxy=proxy)
        assert session.step(0.02).finite
    if name == "bunny.ply":
        assert session.proxy is not None


def test_a_mesh_too_coarse_or_pins_too_few_have_no_proxy() -> None:
    mesh: Mesh = cube(12, 0.1)
    with pytest.raises(DimpleError, match="from 60"):
        build_proxy(build_model(mesh, [VINYL]), 800)
    pin = np.zeros(len(mesh.source), bool)
    pin[[16, 17, 30]] = True  # a corner of a cell inside a side
    assert not build_model(mesh, [VINYL], pinned=pin).free
    with pytest.raises(DimpleError, match="pins"):
        build_proxy(build_model(mesh, [VINYL], pinned=pin), 60)
