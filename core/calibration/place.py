"""Where a body is pressed to find its constants: where most presses are alike, on a broad face away from pins.

A body of thin parts, such as text, has no such face. There some places are taken together: those where the tip can go
deep, facing the way of the most of them, from soft to stiff. So it is where that place is unlike most.
"""

from __future__ import annotations

import contextlib
from dataclasses import replace

import numpy as np

from ..base import Bools, DimpleError, Floats, Ints, sums_at
from ..material import Indenter, Material
from ..mesh.ray import ray_hit
from ..mesh.surface import Mesh, base_vertices
from .indent import CLEAR, Site, find_site, go_down, put_back, set_up

ASIDE = (0.37, 0.23, 0.0)  # of an edge: how far beside the middle a sphere presses
PLACES = 300  # that are looked at, evenly over the surface
AROUND = 2.0  # radii of the tip: how far the surface counts
MANY = 200_000  # pairs of a place and a vertex that are looked at at once
EDGE = 0.15  # by which a place may be less even than the best, where it lies in the middle of the top
DOWN = (0.0, 0.0, -1.0)
UNEVEN = 0.7  # a surface that is nowhere more even is one of thin parts: forces differ from place to place
COMPARED = 15  # places of such a surface that are pressed
BESIDES, HALFWAY = 8, 0.5  # places of an even surface that are pressed beside the first, to this share of the knee, and
USUAL = 0.05  # by which the first may differ from the median of them: the pole of a globe answers a tenth less
ROOM = 0.9  # of the depth that the tip can reach at most: so much it must at a place that counts, by the same quantile
BARE = 0.5  # of the median evenness: less is an end or a border
SHARES = (0.5, 0.1, 0.3, 0.7, 0.9)  # of places that answer less: those are identified together,
SHARES_EVEN = (0.5, 0.25, 0.75)  # and those of an even surface
ALIKE = 0.9  # cosine between the normals of places that face the same way
LITTLE = 0.45  # of what a flat place has under a tip: the corner of a cube has 0.42, and answers half of the law
MOST = 2.5  # times that share of the law: what points and corners answer at most


def typical_site(mesh: Mesh, indenter: Indenter, *, pinned: Bools | None = None) -> Site:
    """Find where a tip meets a body as it does in most places.

    That is the middle of the top, unless there is a hole, a point, an edge or a pin: then where the surface is the most
    even. A sphere is put a little beside it, for few presses are right on a vertex.

    Args:
        pinned: (N,) input vertices; none is the base.

    Raises:
        DimpleError: as `find_site`, where it can be pressed nowhere.
    """
    if pinned is None or not np.any(pinned):
        pinned = base_vertices(mesh)
    top = _evenness_at_top(mesh, indenter, pinned)
    if top >= 1 - EDGE:  # nowhere is it more even by so much
        with contextlib.suppress(DimpleError):
            return _beside(mesh, indenter, pinned, None, np.array(DOWN))
    points, normals, evenness = _candidates(mesh, indenter, pinned)
    best = int((evenness + 1e-3 * normals[:, 2]).argmax())
    if top >= evenness[best] - EDGE:
        with contextlib.suppress(DimpleError):
            return _beside(mesh, indenter, pinned, None, np.array(DOWN))
    return _beside(mesh, indenter, pinned, points[best], -normals[best])


def measuring_site(mesh: Mesh, material: Material, deepest: float, *, pinned: Bools | None = None) -> Site:
    """Find where the tip of a material meets a body as it does in most places: on thin parts several places together.

    On an even surface it is the place of `typical_site`, unless that is unlike most, as the pole of a globe is, whose
    triangles are slender: then three places.

    Args:
        material: its constants are ignored.
        deepest: depth [m] to be pressed to.
        pinned: as for `typical_site`.

    Raises:
        DimpleError: as `typical_site`.
    """
    tip = material.indenter
    site = typical_site(mesh, tip, pinned=pinned)
    if pinned is None or not np.any(pinned):
        pinned = base_vertices(mesh)
    coarse = float(np.median(mesh.rest_lengths)) > tip.radius  # then evenness says little
    even = _evenness(mesh, tip, pinned, site.point[None], -site.inward[None])[0] >= UNEVEN
    if tip.shape != "sphere" or coarse:
        return site
    points, normals, evenness = _candidates(mesh, tip, pinned)
    which = _even_places(evenness) if even else _alike(mesh, points, normals, evenness, deepest)
    sites = [site] if even else []
    for index in which:
        with contextlib.suppress(DimpleError):  # a pin is near
            place, inward = points[index].tolist(), (-normals[index]).tolist()
            sites.append(find_site(mesh, tip, pinned=pinned, above=place, inward=inward))
    if not sites:
        return site
    depth = min(material.x0, deepest) * (HALFWAY if even else 1.0)
    forces = _forces(mesh, replace(material, constants=None), sites, depth)
    order = np.argsort(forces)
    if even and abs(forces[0] / np.median(forces) - 1) <= USUAL:
        return site
    few = [sites[order[round(share * (len(order) - 1))]] for share in (SHARES_EVEN if even else SHARES)]
    thinnest = min(each.thickness for each in few)
    return replace(few[0], thickness=thinnest, others=tuple(few[1:]))


def _even_places(evenness: Floats) -> Ints:
    """Return a few places, of those given (m,), all over the even surface."""
    kept = np.flatnonzero(evenness >= min(UNEVEN, evenness.max()))
    return kept[np.unique(np.linspace(0, len(kept) - 1, BESIDES).astype(np.int64))]


def _alike(mesh: Mesh, points: Floats, normals: Floats, evenness: Floats, deepest: float) -> Ints:
    """Return the places, of those given (m, 3), that face the way of the most where a tip can go deep."""
    deep = np.array([_thickness(mesh, *place) for place in zip(points, normals, strict=True)])
    room = np.minimum(CLEAR * deep, deepest)
    kept = np.flatnonzero(room >= ROOM * np.quantile(room, ROOM))
    kept = kept[evenness[kept] >= BARE * np.median(evenness[kept])]
    alike = normals[kept] @ normals[kept].T > ALIKE
    kept = kept[alike[alike.sum(axis=1).argmax()]]
    return kept[np.unique(np.linspace(0, len(kept) - 1, COMPARED).astype(np.int64))]


def _thickness(mesh: Mesh, point: Floats, normal: Floats) -> float:
    """Return how far [m] it is from a point of the surface to the far side."""
    within = point - 1e-6 * mesh.size * normal
    hit = ray_hit(tuple(within), tuple(-normal), mesh.rest_positions, mesh.triangles)
    return hit[0] if hit else np.inf


def _forces(mesh: Mesh, material: Material, sites: list[Site], depth: float) -> Floats:
    """Return the force [N] on the tip at each site at a depth [m], by the closed form; inf where there is no rest."""
    session, forces = set_up(mesh, material, material.indenter, sites[0]), []
    for site in sites:
        put_back(session, material.indenter, site)
        station = go_down(session, material.indenter, site, 0.0, depth)
        forces.append(station.force if station.found else np.inf)
    return np.array(forces)


def _beside(mesh: Mesh, indenter: Indenter, pinned: Bools, above: Floats | None, inward: Floats) -> Site:
    """Return the site at a place, for a sphere a little beside it."""
    def at(point: Floats | None) -> Site:
        return find_site(
            mesh, indenter, pinned=pinned, above=None if point is None else point.tolist(), inward=inward.tolist()
        )  # fmt: skip

    site = at(above)
    if indenter.shape != "sphere":
        return site
    aside = float(np.median(mesh.rest_lengths)) * np.array(ASIDE)
    if above is not None:  # along the surface
        aside = aside - (aside @ inward) * inward
    try:
        return at(site.point + aside)
    except DimpleError:  # the middle is all there is
        return site


def bare_message(mesh: Mesh, point: Floats, outward: Floats, radius: float) -> str:
    """Return a message where a fingertip presses a point or a corner, "" where there is enough surface under it.

    It counts the surface within two radii as it is seen along the press: 1 on a plane, 0.5 at an edge that is pressed
    like a face, where the law holds; on points and corners the force is from once to two and a half times that share
    of the law at the way that the fingertip went in.

    Args:
        point: (3,) on the surface at rest [m].
        outward: (3,) unit vector against the press.
        radius: of the fingertip [m].
    """
    a, b, c = mesh.rest_positions[mesh.triangles].transpose(1, 0, 2)
    seen = np.maximum(np.cross(b - a, c - a) @ outward / 2, 0.0)
    near = ((mesh.rest_positions - point) ** 2).sum(axis=1) <= (AROUND * radius) ** 2
    share = float(near[mesh.triangles].mean(axis=1) @ seen) / (np.pi * (AROUND * radius) ** 2)
    if share >= LITTLE or not near.any():
        return ""
    return (
        f"The fingertip presses a point or a corner: it has {share:.0%} of the surface that the measured law stands "
        f"for, so the force will be some {share:.0%} to {MOST * share:.0%} of the law."
    )


def _candidates(mesh: Mesh, indenter: Indenter, pinned: Bools) -> tuple[Floats, Floats, Floats]:
    """Return places (m, 3) [m] all over the surface, the normals (m, 3) there, and how even it is round them (m,)."""
    areas = np.cumsum(mesh.triangle_areas)
    which = np.unique(np.searchsorted(areas, areas[-1] * (np.arange(PLACES) + 0.5) / PLACES))
    corners = mesh.rest_positions[mesh.triangles[which]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    points = corners.mean(axis=1)
    return points, normals, _evenness(mesh, indenter, pinned, points, normals)


def _evenness_at_top(mesh: Mesh, indenter: Indenter, pinned: Bools) -> float:
    """Return how even the surface is at the middle of the top, below 0 where the tip misses it."""
    try:
        site = find_site(mesh, indenter, pinned=pinned)
    except DimpleError:
        return -1.0
    return float(_evenness(mesh, indenter, pinned, site.point[None], -site.inward[None])[0])


def _evenness(mesh: Mesh, indenter: Indenter, pinned: Bools, points: Floats, normals: Floats) -> Floats:
    """Return how even a surface is round places (m, 3) with normals (m, 3): 1 is a plane, with no pin or border near.

    It is the mean cosine between the normal and those within some radii of the tip, of what area there should be.
    """
    x, radius = mesh.rest_positions, AROUND * indenter.radius
    a, b, c = x[mesh.triangles].transpose(1, 0, 2)
    corners, across = mesh.triangles.ravel(), np.cross(b - a, c - a) / 6
    lying = np.stack([sums_at(corners, np.repeat(axis, 3), len(x)) for axis in across.T], axis=1)
    free = np.ones(len(x))
    free[mesh.source[np.asarray(pinned, bool)]] = 0.0
    found = np.empty(len(points))
    for part in np.array_split(np.arange(len(points)), len(x) * len(points) // MANY + 1):
        # |x - p|^2 as a product: fast, and exact enough for what is counted
        middle = points[part].mean(axis=0)
        away, to = x - middle, points[part] - middle
        square = (away**2).sum(axis=1)[:, None] - 2 * away @ to.T + (to**2).sum(axis=1)
        near = square <= radius**2
        cosines = np.maximum(lying @ normals[part].T, 0.0) * near
        whole = np.maximum(mesh.vertex_areas @ near, 0.8 * np.pi * radius**2)
        found[part] = free @ cosines / whole
    return found
