"""Contact of fingertip spheres with vertices and faces, and of vertices with a ground plane.

Speeds first: a point whose gap to the sphere is g when a step begins may close in at g / dt, one that touches it not at
all. Sweeps over all contacts of a fingertip change each impulse by what stops its point: an impulse may shrink again
where others do its part, though never below nothing, and friction stays within Coulomb's cone. A step begins with the
impulses of the one before. Otherwise, under a deep press, dt^2 f / m would carry a held vertex farther than its
neighbours are away, and contacts would be resolved that are none. The impulses, summed, are the reaction on the
fingertip (Newton's third law holds to rounding).
Source: Catto, Iterative Dynamics with Temporal Coherence, 2005.

The skin of a solid gives way under a fingertip, in proportion to the pressure at first: its vertices go so deep into
the sphere, and what shows lies on it (`skin`). So an impulse stops its point where it is as deep as that says.

Places then follow from speeds, so that what is held does not creep. What is inside all the same, as where a fingertip
appears, is moved out without adding speed.

Normals, and the points of faces that are met, are those at the begin of the step: where forces would have carried a
point depends on how long the step is, and neither the way out nor friction may.

A face is met at its point nearest to the fingertip (`facets`). Where several share a vertex, each moves its share of
the vertex's mass (Tonge's mass splitting), so that the result does not depend on an order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core.base import Bools, Floats, Ints

from .constants import (
    BACK,
    EXACT,
    HARDEST,
    MOST_GIVEN,
    PINNED_GIVE,
    ROUNDING,
    SLACK,
    SUNK,
    SWEEPS,
    TOO_NEAR,
    TRAVEL,
)
from .facets import bulge, faces_near, inward_normals, met_radius, nearest_on_triangles

_TINY = 1e-30


@dataclass(frozen=True, slots=True, kw_only=True)
class Touch:
    """What one fingertip may meet within a tick.

    centre: (3,) [m].
    velocity: (3,) [m/s].
    radius: [m].
    vertices: (c,) near it.
    triangles: (t, 3) near it.
    radii: (t,) of the spheres that they meet [m].
    faces: (t,) which of the mesh they are.
    kept: (3, vertices and faces of the mesh) the impulses of the last step [N s], None where there was none; replaced
        by those of the next.
    slides: share of the friction that the fingertip uses up on the surface: of the skin's, so much does not hold.
    """

    centre: Floats
    velocity: Floats
    radius: float
    vertices: Ints
    triangles: Ints
    radii: Floats
    faces: Ints | None = None
    kept: Floats | None = None
    slides: float = 0.0


@dataclass(frozen=True, slots=True)
class Skin:
    """What the surface of a body is under a fingertip: friction (n,), and compliance (n,) [m/N], 0 where it is hard."""

    friction: Floats
    compliance: Floats


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
        the free vertices, which faces (t,), and the radii (t,) [m] of the spheres that these meet.
    """
    near = ((x - centre[:, None]) ** 2).sum(axis=0) < (radius + margin) ** 2
    faces = faces_near(x, triangles, inverse_mass, centre, radius + margin)
    within = triangles[faces]
    radii, corners = met_radius(bulge(rest[:, within], radius), radius, SUNK * radius), x[:, within]
    offset = (corners * nearest_on_triangles(corners, centre)).sum(axis=2) - centre[:, None]
    met = np.sqrt((offset**2).sum(axis=0)) < radii + margin
    return np.flatnonzero(near & (inverse_mass > 0)), faces[met], radii[met]


def resolve(x: Floats, v: Floats, touch: Touch, inverse_mass: Floats, skin: Skin, step: Step) -> Floats:
    """Keep vertices and faces out of a fingertip after a step, in place.

    Args:
        x, v: (3, n) positions [m] and velocities [m/s].
        inverse_mass: (n,) [1/kg], 0 for pinned vertices.
        step: that brought them there.

    Returns:
        the impulse on the fingertip [N s], and its moment about the origin [N m s], (2, 3).
    """
    before = x - v * step.slip(np.sqrt((v**2).sum(axis=0)))
    met = _find(before, v, touch, inverse_mass, skin, step.dt)
    push = (met.held * met.normal).sum(axis=0)
    met.held[:, push <= 0] = 0
    met.move(v, met.held)
    for _ in range(SWEEPS):
        if _sweep_speeds(v, touch, met, inverse_mass, step.dt) < ROUNDING * touch.radius:
            break
    moved = np.unique(met.members)
    moved = moved[inverse_mass[moved] > 0]
    x[:, moved] = before[:, moved] + v[:, moved] * step.slip(np.sqrt((v[:, moved] ** 2).sum(axis=0)))
    for sweep in range(SWEEPS):
        if _sweep_places(x, touch, met, inverse_mass, first=sweep == 0) < SLACK * touch.radius:
            break
    if touch.kept is not None:
        touch.kept[:] = 0
        moving = (inverse_mass[met.members] > 0).all(axis=1)  # what cannot give way would add up
        touch.kept[:, met.numbers[moving]] = met.held[:, moving]
    return -np.stack([met.held.sum(axis=1), np.cross(met.points(before), met.held, axis=0).sum(axis=1)])


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


@dataclass(slots=True, kw_only=True)
class _Contacts:
    """Points sum_j weights[:, j] x[members[:, j]] that a fingertip may meet in a step.

    numbers: (c,) of the vertex or, behind the vertices, of the face.
    members, weights, mobility: (c, 3); mobility: what an impulse adds to the velocity of each member.
    radius: (c,) of the sphere that each meets [m].
    normal: (3, c).
    part: (c,) of its gap or depth that each may lose in the step.
    closing: (c,) speed along the normal at which it does [m/s]; above 0 where the skin yields.
    friction: (c,).
    yields: (c,) what the skin does under an impulse, over the step [1/kg].
    held: (3, c) impulses so far [N s].
    """

    numbers: Ints
    members: Ints
    weights: Floats
    mobility: Floats
    radius: Floats
    normal: Floats
    part: Floats
    closing: Floats
    friction: Floats
    yields: Floats
    held: Floats

    def points(self, of: Floats) -> Floats:
        """Return what (3, n) is at the points (3, c)."""
        return np.asarray((of[:, self.members] * self.weights).sum(axis=2))

    def move(self, what: Floats, by: Floats) -> None:
        """Add to what (3, n) is at the members what impulses or ways by (3, c) give each, in place."""
        for c in range(3):
            np.add.at(what[c], self.members.ravel(), (by[c, :, None] * self.mobility).ravel())

    def compliance(self, inverse_mass: Floats, at_work: Bools) -> Floats:
        """Return what each contact gives (c,), 1 / mass: it moves its share m / count of a vertex.

        The vertex then takes the mean of what its contacts at work do.
        """
        counted = self.members[at_work][self.weights[at_work] > ROUNDING]
        count = np.bincount(counted, minlength=len(inverse_mass))
        give = np.maximum((self.mobility * self.weights * count[self.members]).sum(axis=1), _TINY)
        # beside pinned vertices: a free one must not be flung away to move a point it hardly carries
        free = inverse_mass[self.members] > 0
        share = np.maximum((self.weights * free).sum(axis=1), _TINY)
        least = PINNED_GIVE * inverse_mass[self.members].max(axis=1) / share
        return np.asarray(np.where(free.all(axis=1), give, np.maximum(give, least)))


def _find(before: Floats, v: Floats, touch: Touch, inverse_mass: Floats, skin: Skin, dt: float) -> _Contacts:
    """Return the contacts that may work in a step that began before (3, n) [m]: near enough, or held until then."""
    n, triangles = len(inverse_mass), touch.triangles
    number = np.arange(len(triangles)) if touch.faces is None else touch.faces
    offset = before - (touch.centre - dt * touch.velocity)[:, None]
    alone = np.repeat(touch.vertices[:, None], 3, axis=1)
    members = np.concatenate([alone, triangles])
    weights = np.concatenate(
        [np.tile([1.0, 0.0, 0.0], (len(alone), 1)), nearest_on_triangles(offset[:, triangles], np.zeros(3))]
    )
    radius = np.concatenate([np.full(len(alone), touch.radius), touch.radii])
    numbers = np.concatenate([touch.vertices, n + number])
    held = np.zeros((3, len(members))) if touch.kept is None else touch.kept[:, numbers]
    was_held = (held != 0).any(axis=0)
    first = (offset[:, members] * weights).sum(axis=2)
    apart = np.sqrt((first**2).sum(axis=0))
    noted = v[:, np.concatenate([touch.vertices, touch.triangles.ravel()])]
    fastest = np.sqrt((noted**2).sum(axis=0).max(initial=0))
    margin = dt * (2 * fastest + np.sqrt((touch.velocity**2).sum()))
    at_centre = apart < TOO_NEAR * touch.radius
    is_face = np.arange(len(members)) >= len(alone)
    met = ((apart < radius + margin) | was_held) & (is_face | ~at_centre)  # a vertex has no direction
    normal = first / np.maximum(apart, _TINY)
    inward = met & at_centre
    normal[:, inward] = inward_normals(before[:, members[inward]])
    here, share = members[met], weights[met]
    compliance, friction = ((each[here] * share).sum(axis=1) for each in (skin.compliance, skin.friction))
    yields = np.where(is_face[met], 4.0, 2.0) * compliance / dt**2
    friction = (1 - touch.slides) * friction
    part = np.where(was_held[met] & (yields == 0), BACK, 1.0)  # what yields comes out by its impulse alone
    gap, normal = (apart - radius)[met], normal[:, met]
    gives = (yields > 0) & (gap < 0)
    if gives.any():
        inside = np.where(skin.compliance[touch.vertices] > 0, touch.radius - apart[: len(alone)], 0)
        pushed = first[:, : len(alone)] @ np.maximum(inside, 0)
        deep, normal[:, gives] = _given(touch, pushed, first[:, met][:, gives], radius[met][gives], normal[:, gives])
        # p = deep / (c (1 - s^2)) with s = deep / most, along its tangent there
        most = MOST_GIVEN * touch.radius
        s = np.minimum(deep / most, HARDEST)
        tangent = (1 - s**2) / (1 + s**2)
        yields[gives] *= (1 - s**2) * tangent
        gap[gives] = -(deep - most * s + most * s * tangent)
    gap = np.where(yields > 0, gap, np.maximum(gap, 0))
    return _Contacts(
        numbers=numbers[met], members=members[met], weights=weights[met], radius=radius[met], held=held[:, met],
        normal=normal, part=part, closing=-part * gap / dt, friction=friction, yields=yields,
        mobility=weights[met] * inverse_mass[members[met]],
    )  # fmt: skip


def _given(
    touch: Touch, pushed: Floats, offset: Floats, radius: Floats, normal: Floats
) -> tuple[Floats, Floats]:
    """Return how deep [m] a skin has given way at offsets (3, c) from the centre, and which way it springs back (3, c).

    That is not straight away from the centre, but from a point behind it, so that it is pressed down and not aside.

    Args:
        pushed: (3,) the mean way to what gives way, by its depth; friction has no part in it.
    """
    way = offset + touch.radius * (pushed / max(np.sqrt((pushed**2).sum()), _TINY))[:, None]
    length = np.sqrt((way**2).sum(axis=0))
    normal = np.where(length > TRAVEL * touch.radius, way / np.maximum(length, _TINY), normal)
    along = (offset * normal).sum(axis=0)
    return np.sqrt(along**2 + radius**2 - (offset**2).sum(axis=0)) - along, normal


def _sweep_speeds(v: Floats, touch: Touch, met: _Contacts, inverse_mass: Floats, dt: float) -> float:
    """Change the impulses by what stops their points, all from the same speeds.

    Returns:
        how far [m] the change moves what it moves farthest.
    """
    relative = met.points(v) - touch.velocity[:, None]
    speed, was = (relative * met.normal).sum(axis=0), (met.held * met.normal).sum(axis=0)
    at_work = (speed < met.closing - met.yields * was) | (was > 0)
    if not at_work.any():
        return 0.0
    give = met.compliance(inverse_mass, at_work)
    push = was + (met.closing - speed - met.yields * was) / (give + met.yields)
    push[push * give * dt < EXACT * touch.radius] = 0
    drag = met.held - was * met.normal - (relative - speed * met.normal) / give
    size = np.sqrt((drag**2).sum(axis=0))
    held = push * met.normal + np.minimum(1, met.friction * push / np.maximum(size, _TINY)) * drag
    change = np.where(at_work, held - met.held, 0)
    met.held += change
    met.move(v, change)
    return float((np.sqrt((change**2).sum(axis=0)) * give).max()) * dt


def _sweep_places(x: Floats, touch: Touch, met: _Contacts, inverse_mass: Floats, *, first: bool) -> float:
    """Move out what is inside, and first let what slides past its normal follow the sphere, all from the same places.

    Returns:
        how deep [m] the deepest was.
    """
    offset, held = met.points(x) - touch.centre[:, None], (met.held != 0).any(axis=0)
    apart = np.sqrt((offset**2).sum(axis=0))
    at_work = (apart < met.radius * (1 - ROUNDING)) | (first & held & (apart > met.radius))
    at_work &= met.yields == 0
    if not at_work.any():
        return 0.0
    along = (offset * met.normal).sum(axis=0)
    level = np.sqrt(np.maximum(met.radius**2 - ((offset - along * met.normal) ** 2).sum(axis=0), 0))
    depth = level - along
    left = np.minimum((1 - met.part) * depth, SLACK / 2 * touch.radius)
    out = np.where(
        depth > 0, depth - left, np.maximum(depth, level - met.radius)
    )
    met.move(x, np.where(at_work, out, 0) / met.compliance(inverse_mass, at_work) * met.normal)
    return float(depth[at_work].max())
