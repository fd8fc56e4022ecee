"""A proxy: a coarser body that is simulated in place of a fine mesh, and the binding that moves the fine surface.

Seeds are spread over the surface. Each fine vertex belongs to the cell of one seed, and where three cells meet the
proxy has a triangle. Mass and shape-matching stiffness of a cell go to its seed, so their sums are conserved.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ..base import Bools, DimpleError, Floats, Ints, sums_at
from ..body.model import Model, assemble
from ..body.springs import membrane_stiffness
from ..mesh.cotangents import cotangent_weights
from ..mesh.surface import Mesh, mesh_from_triangles
from .cells import dual, grow_cells, spread_seeds, vertex_normals
from .flips import flip_edges

SMALLEST = 60  # vertices: fewer no longer have the shape of a body
LARGEST = 8000  # more take too long to choose
NORMAL_SHARE = 0.5  # of the spacing: how far apart opposite normals put two points is twice this
NEIGHBOURS = 8  # seeds a fine vertex follows, the last one the distance at which a seed counts no more
VOLUME_SLACK = 0.15  # of the volume: a proxy that loses more is another body


@dataclass(frozen=True, slots=True, kw_only=True)
class Proxy:
    """A coarse model and the binding of a fine mesh to it.

    model: the coarse body that is simulated, m vertices.
    seeds: (m,) the vertex of the fine mesh at which each coarse vertex lies.
    cells: (n,) the coarse vertex whose share of mass and stiffness each vertex of the fine mesh is.
    rest: (n, 3) rest positions of the fine mesh [m].
    still: (n,) pinned or loose in the fine mesh.
    spacing: mean distance between seeds [m].
    fine_spacing: mean distance between vertices of the fine mesh [m].
    followed: (k, n) the seeds that each fine vertex follows.
    weights: (k, n) the weights of their motions.
    lever: (n, 3) the vector that the blended gradient is applied to [m].
    arms: (e, 2) directed edges.
    spread: (e, 3) the rows that turn the motion along an edge into a gradient [1/m].
    upright: (m, 3) the rows that turn the change of a normal into a gradient.
    normals: (m, 3) unit normals at rest.
    """

    model: Model
    seeds: Ints
    cells: Ints
    rest: Floats
    still: Bools
    spacing: float
    fine_spacing: float
    followed: Ints
    weights: npt.NDArray[np.float32]
    lever: Floats
    arms: Ints
    spread: Floats
    upright: Floats
    normals: Floats


def build_proxy(model: Model, vertices: int) -> Proxy:
    """Make a proxy of about the given number of vertices.

    Raises:
        DimpleError: no such proxy can be made; the message says why.
    """
    mesh = model.mesh
    check(model)
    used = np.flatnonzero(~mesh.loose)
    most = most_of(model)
    if not SMALLEST <= vertices <= most:
        raise DimpleError(f"a proxy of this mesh has from {SMALLEST} to {most} vertices, not {vertices}")
    spacing = mean_spacing(mesh, vertices)
    normals = vertex_normals(mesh.triangles, mesh.rest_positions)
    place = np.concatenate([mesh.rest_positions, NORMAL_SHARE * spacing * normals], axis=1)
    seeds = spread_seeds(mesh, place, used, vertices, spacing)
    for _ in range(3):
        cells = grow_cells(mesh, place, seeds)
        triangles = dual(cells[mesh.triangles])
        stands = np.zeros(len(seeds), bool)
        stands[triangles] = True
        if stands.all():
            break
        seeds = seeds[stands]  # a part too small for a triangle follows what is beside it
        if not len(seeds):
            raise DimpleError("its pieces are too small for a proxy")
    else:
        raise DimpleError("its pieces are too small for a proxy")
    coarse = _constants(model, _coarse_mesh(mesh, seeds, triangles), cells)
    followed, weights = _followed(coarse.mesh, place, seeds, cells)
    middle = np.einsum("kn,knc->nc", weights, mesh.rest_positions[seeds][followed])
    arms, spread, upright = _gradient(coarse.mesh)
    return Proxy(
        model=coarse, seeds=seeds, cells=cells, rest=mesh.rest_positions, still=model.held | mesh.loose,
        spacing=spacing, fine_spacing=mean_spacing(mesh, len(used)), followed=followed,
        weights=weights.astype(np.float32), lever=2 * mesh.rest_positions - mesh.rest_positions.mean(axis=0) - middle,
        arms=arms, spread=spread, upright=upright,
        normals=vertex_normals(coarse.mesh.triangles, coarse.mesh.rest_positions),
    )  # fmt: skip


def with_constants(proxy: Proxy, model: Model) -> Proxy:
    """Return a proxy that moves as another model of the same fine mesh, on the same coarse one.

    Raises:
        DimpleError: its laws or pins need another proxy.
    """
    check(model)
    coarse = _constants(model, proxy.model.mesh, proxy.cells)
    return replace(proxy, model=coarse, still=model.held | model.mesh.loose)


def mean_spacing(mesh: Mesh, vertices: int) -> float:
    """Return the distance [m] between vertices when the given number is spread evenly over a surface."""
    return float(np.sqrt(2 / np.sqrt(3) * mesh.triangle_areas.sum() / vertices))


def carry(proxy: Proxy, positions: Floats) -> Floats:
    """Return the fine positions (n, 3) [m] for coarse positions (3, m) [m]; at rest they are exact to the bit.

    F_j is the gradient that fits the ring of seed j best and turns its normal along. Seen from j the surface is at
    x_j + (F_j + F) (X - X_j) / 2, F the gradient at the place itself: exact for every rigid motion, and for a dent
    that is a parabola. A vertex takes the weighted mean over its seeds, F too; the weights come and go smoothly, so
    no facet shows.
    """
    rest, centre = proxy.model.mesh.rest_positions, proxy.rest.mean(axis=0)
    u = positions.T - rest
    turned = vertex_normals(proxy.model.mesh.triangles, positions.T) - proxy.normals
    i, j = proxy.arms.T
    stretched = (u[j] - u[i])[:, :, None] * proxy.spread[:, None, :]
    gradient = turned[:, :, None] * proxy.upright[:, None, :]
    for c in range(9):
        gradient.reshape(-1, 9)[:, c] += sums_at(i, stretched.reshape(-1, 9)[:, c], len(rest))
    shift = 2 * u - np.einsum("mcd,md->mc", gradient, rest - centre)
    motions = (np.concatenate([shift, gradient.reshape(-1, 9)], axis=1) / 2).astype(np.float32)
    mixed = np.zeros((len(proxy.rest), 12), np.float32)
    taken = np.empty_like(mixed)
    for follow, weight in zip(proxy.followed, proxy.weights, strict=True):
        np.take(motions, follow, axis=0, out=taken, mode="clip")
        taken *= weight[:, None]
        mixed += taken
    return proxy.rest + mixed[:, :3] + np.einsum("ncd,nd->nc", mixed[:, 3:].reshape(-1, 3, 3), proxy.lever)


def most_of(model: Model) -> int:
    """Return the largest number of vertices that a proxy may have."""
    return min(int((~model.mesh.loose).sum()) // 2, LARGEST)


def check(model: Model) -> None:
    """Raise where no proxy of any size can be made.

    Raises:
        DimpleError: the laws or springs of the model need its own mesh.
    """
    if model.law_set == "paper":
        raise DimpleError("the paper's equations depend on the mesh, so they need the full mesh")


def _coarse_mesh(fine: Mesh, seeds: Ints, triangles: Ints) -> Mesh:
    points = fine.rest_positions[seeds]
    mesh = mesh_from_triangles(points, flip_edges(points, triangles))
    if len(mesh.rest_positions) != len(seeds) or mesh.loose.any():
        raise DimpleError("its surface is too crumpled for a proxy of this size")
    if mesh.pressurable != fine.pressurable or (fine.closed and not mesh.closed):
        raise DimpleError("a proxy of this size would have holes")
    if fine.pressurable and not abs(mesh.volume / fine.volume - 1) < VOLUME_SLACK:
        raise DimpleError("a proxy of this size would lose too much of the volume")
    return mesh


def _constants(model: Model, mesh: Mesh, cells: Ints) -> Model:
    """Return the model of a proxy on its mesh."""
    fine, m = model.mesh, len(mesh.rest_positions)
    whole = ~fine.loose

    def total(values: Floats) -> Floats:
        return sums_at(cells[whole], values[whole], m)

    area = np.maximum(total(fine.vertex_areas), 1e-30)

    def mean(values: Floats) -> Floats:
        return total(values * fine.vertex_areas) / area

    matching = model.matching
    held = mean(model.held.astype(float)) >= 0.5
    damping = matching.damping / np.maximum(2 * np.sqrt(matching.k1 * model.mass), 1e-30)
    ends = cells[fine.springs].ravel()

    def of_surface(values: Floats, unit: Floats) -> Floats:
        """Return the material's own constant [N/m] on the edges of the proxy, from that of fine edges."""
        weight = np.where(unit > 0, fine.spring_areas, 0.0)
        sums = sums_at(ends, np.repeat(values / np.maximum(unit, 1e-30) * weight, 2), m)
        return (sums / np.maximum(sums_at(ends, np.repeat(weight, 2), m), 1e-30))[mesh.springs].mean(axis=1)

    k = of_surface(model.springs.stiffness, membrane_stiffness(fine, np.ones(len(fine.springs))))
    tension = of_surface(matching.tension, cotangent_weights(fine))
    coarse = assemble(
        mesh, model.materials, law_set=model.law_set, mass=np.maximum(total(model.mass), 1e-30), held=held,
        friction=mean(model.friction), damping=mean(damping),
        stiffness=membrane_stiffness(mesh, k), tension=cotangent_weights(mesh) * tension,
        k1=total(matching.k1), k2=total(matching.k2), d0=mean(matching.d0),
        more=np.reshape([total(k) for k in matching.more], (-1, m)),
        knees=np.reshape([mean(knee) for knee in matching.knees], (-1, m)), fill=model.pressure.fill,
        gravity=model.gravity, ground=model.ground,
    )  # fmt: skip
    if coarse.free != model.free or held.all():
        raise DimpleError("its pins are too few for a proxy of this size")
    return coarse


def _followed(mesh: Mesh, place: Floats, seeds: Ints, cells: Ints) -> tuple[Ints, Floats]:
    """Return the seeds (k, n) each fine vertex follows and their weights (k, n), sums 1.

    The nearest ones of two rings round its own, weighted by (1 - (d / D)^2)^2, D the distance of the first that
    is left out: a seed's weight is 0, and so is its slope, where it comes and goes.
    """
    m = len(seeds)
    itself = np.arange(m)[:, None].repeat(2, axis=1)
    links = np.unique(np.concatenate([mesh.springs, mesh.springs[:, ::-1], itself]), axis=0)
    first = np.split(links[:, 1], np.searchsorted(links[:, 0], np.arange(1, m)))
    rings = [np.unique(np.concatenate([first[k] for k in ring])) for ring in first]
    width = max(len(ring) for ring in rings)
    around = np.full((m, width), -1)
    for row, ring in zip(around, rings, strict=True):
        row[: len(ring)] = ring
    take = min(NEIGHBOURS + 1, width)
    n = len(place)
    followed, weights = np.empty((take - 1, n), np.int64), np.empty((take - 1, n))
    for part in np.array_split(np.arange(n), n * width // 1_000_000 + 1):
        ring = around[cells[part]]
        distance = ((place[part, None] - place[seeds[ring]]) ** 2).sum(axis=2)
        distance[ring < 0] = np.inf
        order = np.argsort(distance, axis=1)[:, :take]
        near = np.take_along_axis(distance, order, axis=1)
        bound = np.where(np.isfinite(near), near, -np.inf).max(axis=1, keepdims=True) * (1 + 1e-9)
        weight = np.where(np.isfinite(near), np.maximum(1 - near / np.maximum(bound, 1e-30), 0) ** 2, 0.0)[:, :-1]
        weight[:, 0] += 1e-30
        followed[:, part] = np.maximum(np.take_along_axis(ring, order, axis=1)[:, :-1], 0).T
        weights[:, part] = (weight / weight.sum(axis=1, keepdims=True)).T
    return followed, weights


def _gradient(mesh: Mesh) -> tuple[Ints, Floats, Floats]:
    """Return directed edges (e, 2), and rows (e, 3) and (m, 3) so that F - 1 is

        sum over edges of (u_j - u_i) row_ij^T + (change of the normal) row_i^T.

    F minimises sum |F e - e'|^2 / |e|^2 + s |F n - n'|^2: rows are e / |e|^2 and s n times the inverse of
    sum e e^T / |e|^2 + s n n^T. s is half the number of edges, as much as they say of each direction in the skin.
    """
    x, m = mesh.rest_positions, len(mesh.rest_positions)
    arms = np.concatenate([mesh.springs, mesh.springs[:, ::-1]])
    i, j = arms.T
    edge = x[j] - x[i]
    row = edge / (edge**2).sum(axis=1)[:, None]
    normals = vertex_normals(mesh.triangles, x)
    s = np.bincount(i, minlength=m) / 2
    moment = s[:, None, None] * normals[:, :, None] * normals[:, None, :]
    outer = (edge[:, :, None] * row[:, None, :]).reshape(-1, 9)
    for c in range(9):
        moment.reshape(-1, 9)[:, c] += sums_at(i, outer[:, c], m)
    inverse = np.linalg.pinv(moment, rcond=1e-3, hermitian=True)
    return arms, np.einsum("ec,ecd->ed", row, inverse[i]), s[:, None] * np.einsum("mc,mcd->md", normals, inverse)
