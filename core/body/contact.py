"""Contact of fingertip spheres with vertices and faces, and of vertices with a ground plane.

Velocities first: an impulse stops what moves into the sphere, and Coulomb friction what slides on it. The impulses,
summed, are the reaction on the fingertip (Newton's third law holds to rounding).

Positions second: what is inside is moved out without adding speed, and friction takes back the slip of the step. A
point whose velocity alone is stopped would still creep by dt^2 a in each step, and friction would be viscous.

Normals, and the points of faces that are met, are those at the begin of the step. At its end a point is dt^2 f / m
inside the sphere, and where it slides, to one side: the normal there leans by an angle that grows with the step, and
so would the cone of friction.

Faces keep a fingertip smaller than an edge from slipping through. A facet stands for a surface that bends round the
fingertip: where its corners lie on the sphere, its middle lies inside by the bulge

    s = (|e_12|^2 + |e_23|^2 + |e_31|^2) / 18 R

with edges e at rest. To push there too would be to ask for twice what there is to move, and the surplus would show as
side force and creep. So a facet meets a sphere smaller by 0.16 R: its corners alone keep a small one out, and where
they part under the fingertip, the stretched facet holds it. One too large to bend (s > 0.09 R) meets a sphere smaller
by R / 4 - s, and a vertex the whole sphere. (One sphere for all of a facet, or a contact that slides on it would gain
energy.) Where several faces share a vertex, each moves its share of the vertex's mass (Tonge's mass splitting), so that
the result does not depend on an order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import Bools, Floats, Ints

_TINY = 1e-30
FACE_SWEEPS = 8  # at most, in one step
LEAST_SWEEPS = 2  # where faces are touched: the second stops what slides on after the first, which splits masses
FACE_SLACK = 1e-3  # of the radius: nearer than this needs no further sweep
ROUNDING = 1e-6  # of the radius: what was brought to the surface is on it, whatever its last digits say
TOO_NEAR = 1e-5  # of the radius: a point as near to the centre has no direction of its own
STIFF = 0.25  # of the radius: the bulge of a facet that is met whole
SUNK = 0.16  # of the radius: how far a fingertip may be inside a small facet
NEAR = 0.0625  # of the radius: farther from a fingertip than that, what is at rest stays clear of it for a tick
WEIGHT_FLOOR = 1e-6  # a corner that carries less of a contact than this has no part in it
PINNED_GIVE = 0.1  # of a free vertex: what a face gives at least where pinned vertices carry the rest of it


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """What one fingertip may meet within a tick.

    centre: (3,) [m].
    velocity: (3,) [m/s].
    radius: [m].
    vertices: (c,) near it.
    triangles: (t, 3) near it.
    radii: (t,) of the spheres that they meet [m].
    """

    centre: Floats
    velocity: Floats
    radius: float
    vertices: Ints
    triangles: Ints
    radii: Floats


@dataclass(frozen=True, slots=True)
class Step:
    """A step in time: dt [s], and the farthest that a vertex went in it, however fast it is [m]."""

    dt: float
    travel: float = np.inf

    def slip(self, speed: Floats) -> Floats:
        """Return how long (c,) [s] points of a speed (c,) [m/s] moved with it."""
        return np.minimum(self.dt, self.travel / np.maximum(speed, _TINY))


def candidates(
    x: Floats, rest: Floats, triangles: Ints, inverse_mass: Floats, centre: Floats, radius: float, margin: float
) -> tuple[Ints, Ints, Floats]:
    """Find what a fingertip of a radius [m] may meet that is no farther from it than a margin [m].

    Returns:
        the free vertices, the triangles (t, 3), and the radii (t,) [m] of the spheres that these meet.
    """
    near = ((x - centre[:, None]) ** 2).sum(axis=0) < (radius + margin) ** 2
    within = triangles_near(x, triangles, inverse_mass, centre, radius + margin)
    radii, corners = met_radius(bulge(rest[:, within], radius), radius, SUNK * radius), x[:, within]
    offset = (corners * nearest_on_triangles(corners, centre)).sum(axis=2) - centre[:, None]
    met = np.sqrt((offset**2).sum(axis=0)) < radii + margin
    return np.flatnonzero(near & (inverse_mass > 0)), within[met], radii[met]


def triangles_near(x: Floats, triangles: Ints, inverse_mass: Floats, centre: Floats, reach: float) -> Ints:
    """Return the triangles (t, 3) that can move and whose bounding sphere is within reach [m] of a place (3,)."""
    corners = x[:, triangles.T]
    middle = corners.sum(axis=1) / 3
    extent = np.sqrt(((corners - middle[:, None]) ** 2).sum(axis=0).max(axis=0))
    hit = ((middle - centre[:, None]) ** 2).sum(axis=0) < (reach + extent) ** 2
    return triangles[hit & (inverse_mass[triangles] > 0).any(axis=1)]


def resolve(
    x: Floats, v: Floats, touch: Touch, inverse_mass: Floats, friction: Floats, step: Step, *, faces: bool = True
) -> Floats:
    """Move vertices out of a fingertip, in place.

    Args:
        x, v: (3, n) positions [m] and velocities [m/s].
        inverse_mass: (n,) [1/kg], 0 for pinned vertices.  friction: (n,).
        step: that brought them there.
        faces: also keep the faces out.

    Returns:
        the impulse (3,) [N s] on the fingertip.
    """
    at, begin = touch.vertices, touch.centre - step.dt * touch.velocity
    before = x - v * step.slip(np.sqrt((v**2).sum(axis=0))) - begin[:, None]
    whole = np.full(len(at), touch.radius)
    impulse, _ = _push(x, v, before, touch, whole, at[:, None], np.ones((len(at), 1)), inverse_mass, friction, step)
    sweeps = FACE_SWEEPS if faces and len(touch.triangles) else 0
    weights = nearest_on_triangles(before[:, touch.triangles], np.zeros(3))
    for sweep in range(1, sweeps + 1):
        more, deepest = _push(x, v, before, touch, touch.radii, touch.triangles, weights, inverse_mass, friction, step)
        impulse = impulse + more
        if deepest <= 0 or (sweep >= LEAST_SWEEPS and deepest < FACE_SLACK * touch.radius):
            break
    return impulse


def rest_on_ground(x: Floats, v: Floats, height: float, inverse_mass: Floats, friction: Floats, dt: float) -> None:
    """Keep vertices above the plane z = height [m] after a step dt [s], in place, with friction."""
    low = np.flatnonzero((x[2] < height) & (inverse_mass > 0))
    fall = np.maximum(-v[2, low], 0)
    slide = v[:2, low]
    speed = np.sqrt((slide**2).sum(axis=0))
    stopped = slide * np.minimum(friction[low] * fall / np.maximum(speed, _TINY), 1)
    v[:2, low] = slide - stopped
    x[:2, low] -= dt * stopped
    v[2, low] += fall
    x[2, low] = height


def _push(
    x: Floats,
    v: Floats,
    before: Floats,
    touch: Touch,
    radius: Floats,
    members: Ints,
    weights: Floats,
    inverse_mass: Floats,
    friction: Floats,
    step: Step,
) -> tuple[Floats, float]:
    """Apply contacts at points sum_j weights[:, j] x[members[:, j]], one a row of members (c, j).

    Args:
        before: (3, n) positions at the begin of the step from the centre of the fingertip then. What friction takes
            back is the way since then: a sweep before may have changed velocities that moved nothing.
        radius: (c,) of the sphere that each meets [m].

    Returns:
        the impulse (3,) [N s] on the fingertip and how deep [m] the deepest point was.
    """
    offset = (x[:, members] * weights).sum(axis=2) - touch.centre[:, None]
    distance = np.sqrt((offset**2).sum(axis=0))
    hit = distance < radius * (1 - ROUNDING)
    if not hit.any():
        return np.zeros(3), 0.0
    members, weights, radius, offset = members[hit], weights[hit], radius[hit], offset[:, hit]
    first = (before[:, members] * weights).sum(axis=2)
    distance = np.maximum(np.sqrt((first**2).sum(axis=0)), _TINY)
    normal = first / distance
    at_centre = distance < TOO_NEAR * touch.radius
    if at_centre.any():
        normal[:, at_centre] = _inward(x[:, members[at_centre]])
    count = np.bincount(members[weights > WEIGHT_FLOOR], minlength=x.shape[1])
    # each contact moves its share of a vertex, m / count; the vertex then takes the mean of its shares
    mobility = weights * inverse_mass[members]
    give = np.maximum((mobility * weights * count[members]).sum(axis=1), _TINY)
    # beside pinned vertices: a free one must not be flung away to move a point it hardly carries
    free = inverse_mass[members] > 0
    share = np.maximum((weights * free).sum(axis=1), _TINY)
    give = np.where(free.all(axis=1), give, np.maximum(give, PINNED_GIVE * inverse_mass[members].max(axis=1) / share))

    relative = (v[:, members] * weights).sum(axis=2) - touch.velocity[:, None]
    closing = (relative * normal).sum(axis=0)
    push = np.maximum(-closing, 0) / give
    slide = relative - closing * normal
    speed = np.sqrt((slide**2).sum(axis=0))
    mu = (friction[members] * weights).sum(axis=1)
    drag = np.minimum(mu * push, speed / give) / np.maximum(speed, _TINY)
    impulse = push * normal - drag * slide
    reached = (offset * normal).sum(axis=0)
    way = offset - reached * normal
    held = step.dt * mu * push / np.maximum(np.sqrt((way**2).sum(axis=0)), _TINY)
    back = np.minimum(held, 1 / give) * way
    left = ((way - give * back) ** 2).sum(axis=0)
    depth = np.maximum(np.sqrt(np.maximum(radius**2 - left, 0)) - reached, 0)
    out = depth / give * normal - back
    for c in range(3):
        flat = members.ravel()
        np.add.at(v[c], flat, (impulse[c, :, None] * mobility).ravel())
        np.add.at(x[c], flat, (out[c, :, None] * mobility).ravel())
    return -impulse.sum(axis=1), float(depth.max())


def met_radius(bulge: Floats, radius: float, sunk: Floats | float) -> Floats:
    """Return the radii (c,) [m] of the spheres that facets of a bulge at rest (c,) [m] meet: smaller by sunk [m]."""
    return radius - np.minimum(sunk, np.maximum(STIFF * radius - bulge, 0.0))


def bulge(corners: Floats, radius: float) -> Floats:
    """Return how far (c,) [m] a sphere bulges beyond the middle of facets (3, c, 3) whose corners lie on it."""
    edges = corners - np.roll(corners, 1, axis=2)
    return np.asarray((edges * edges).sum(axis=(0, 2)) / (18 * radius))


def _inward(corners: Floats) -> Floats:
    """Return the inward unit normals (3, c) of faces (3, c, 3): a fingertip came from outside.

    A vertex (3, c, 1) has none and leaves it to its faces.
    """
    if corners.shape[2] == 1:
        return np.zeros(corners.shape[:2])
    a, b, c = corners.transpose(2, 0, 1)
    normal = np.cross(c - a, b - a, axis=0)
    return normal / np.maximum(np.sqrt((normal**2).sum(axis=0)), _TINY)


def nearest_on_triangles(corners: Floats, point: Floats) -> Floats:
    """Return the barycentric weights (t, 3) of the points of triangles (3, t, 3) nearest to a point (3,).

    Source: Ericson, Real-Time Collision Detection, 5.1.5: which of the seven Voronoi regions holds the point.
    """
    a, b, c = corners[:, :, 0], corners[:, :, 1], corners[:, :, 2]
    ab, ac = b - a, c - a
    p = point[:, None]
    d1, d2 = (ab * (p - a)).sum(axis=0), (ac * (p - a)).sum(axis=0)
    d3, d4 = (ab * (p - b)).sum(axis=0), (ac * (p - b)).sum(axis=0)
    d5, d6 = (ab * (p - c)).sum(axis=0), (ac * (p - c)).sum(axis=0)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    on_bc = _ratio(d4 - d3, (d4 - d3) + (d5 - d6))
    v, w = _ratio(vb, va + vb + vc), _ratio(vc, va + vb + vc)
    # the first region that holds wins, so it comes last
    regions: list[tuple[Bools, Floats | float, Floats | float]] = [
        ((va <= 0) & (d4 >= d3) & (d5 >= d6), 1 - on_bc, on_bc),
        ((vb <= 0) & (d2 >= 0) & (d6 <= 0), 0.0, _ratio(d2, d2 - d6)),
        ((vc <= 0) & (d1 >= 0) & (d3 <= 0), _ratio(d1, d1 - d3), 0.0),
        ((d6 >= 0) & (d5 <= d6), 0.0, 1.0),
        ((d3 >= 0) & (d4 <= d3), 1.0, 0.0),
        ((d1 <= 0) & (d2 <= 0), 0.0, 0.0),
    ]
    for holds, at_v, at_w in regions:
        v, w = np.where(holds, at_v, v), np.where(holds, at_w, w)
    return np.stack([1 - v - w, v, w], axis=1)


def _ratio(part: Floats, whole: Floats) -> Floats:
    return part / np.where(np.abs(whole) > _TINY, whole, 1.0)
