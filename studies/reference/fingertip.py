"""The contact of a fingertip: the measured law at its depth, Eq. (1), and Coulomb friction.

On the surface at rest, as the body carries it, lies a sphere of the fingertip's radius, which the surface keeps out.
Where it would lie straight above the fingertip is its foot: the way there is the depth, and the law gives the force.
Where friction holds it is its anchor. All of it in the space of the shape at rest but for centre and force.
Source: Ruspini and others 1997; Mindlin 1949; Thornton and Yin 1991; Dimitriadis and others 2002.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from core.base import Bools, Floats, Ints
from core.body.shape_matching import Pose
from core.constants import FACTORS
from core.material import law_force
from core.mesh.surface import Mesh
from core.native.motion import FingertipMotion

from .constants import EXACT, HELD, LARGEST_GROWTH, PUSH_TIME, REST_TIME, SEATED, SLACK, STICK, SWEEPS, TRAVEL
from .facets import nearest_on_triangles

FOOT_STEPS = 4
NORMALS = 8  # that hold a sphere: more walls than a fingertip touches at once
FRICTION, DAMPING, LAYER = 4, 5, 6  # of a material's law, behind K1, K2, x0 and the power


@dataclass(frozen=True, slots=True, kw_only=True)
class RestSurface:
    """What is under fingertips: the triangles of a surface at rest, and what is known of the body there.

    order: (t,) of the mesh's triangles, along the curve on which C lays them, so that it meets them in that order.
    corners: (3, t, 3) coordinate, triangle, corner [m].
    normals: (3, t) unit vectors, outward.
    vertices: (t, 3).
    materials: (t,).
    laws: (materials, 7) K1, K2, x0, power, friction, damping ratio, and the radius with which a solid was measured.
    painted: (n, 2) how many times as stiff each vertex is, and as deep its knee.
    size, mass: of the body [m], [kg].
    """

    order: Ints
    corners: Floats
    normals: Floats
    vertices: Ints
    materials: Ints
    laws: Floats
    painted: Floats
    size: float
    mass: float


@dataclass(slots=True)
class Tip:
    """A fingertip; what is said of each is said in body.h."""

    centre: Floats = field(default_factory=lambda: np.zeros(3))
    radius: float = 0.0
    factors: tuple[Floats, float] | None = None
    met: bool = False
    in_contact: bool = False
    slides: float = 0.0
    beside: bool = False
    way: float = 0.0
    deep: float = 0.0
    depth: float = 0.0
    zero: float = 0.0
    height: float = 0.0
    foot: Floats = field(default_factory=lambda: np.zeros(3))
    anchor: Floats = field(default_factory=lambda: np.zeros(3))
    outward: Floats = field(default_factory=lambda: np.zeros(3))
    local: Floats = field(default_factory=lambda: np.zeros(3))
    facet: int = 0
    weight: Floats = field(default_factory=lambda: np.zeros(3))
    stiffer: float = 0.0
    deeper: float = 0.0
    thickness: float = 0.0
    thick_at: Floats = field(default_factory=lambda: np.zeros(3))
    law: float = 0.0
    slope: float = 0.0
    stick: float = 0.0
    force: Floats = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True, slots=True)
class Round:
    """What lies round a sphere.

    facet: the nearest,
    near: as near [m], and
    offset: the way from it (3,) [m].
    normals: that hold the sphere (3,).
    """

    facet: int
    near: float
    offset: Floats
    normals: list[Floats]


@dataclass(frozen=True, slots=True, kw_only=True)
class Around:
    """What a contact asks of its body as it is evaluated.

    surface: at rest.
    pose: where that is now.
    skin: (3, n) where the vertices are [m].
    rest: (3, n) those of a proxy at rest [m], None where the surface is the body's own.
    pushes: the fingertip moves the skin itself.
    others: something else touches the body, or did so short a time ago that its skin still comes back.
    """

    surface: RestSurface
    pose: Pose
    skin: Floats
    rest: Floats | None
    pushes: bool
    others: bool


def rest_surface(
    mesh: Mesh, laws: Sequence[tuple[float, ...]], painted: Floats | None, mass: float, order: Ints | None = None
) -> RestSurface:
    """Prepare a mesh for fingertips. order: of a surface that had another shape before."""
    middles = mesh.rest_positions[mesh.triangles].mean(axis=1)
    order = along_curve(middles) if order is None else order
    corners = mesh.rest_positions[mesh.triangles[order]].transpose(2, 0, 1)
    normals = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0], axis=0)
    return RestSurface(
        order=order, corners=np.ascontiguousarray(corners),
        normals=normals / np.maximum(np.linalg.norm(normals, axis=0), 1e-30),
        vertices=mesh.triangles[order], materials=mesh.triangle_material[order], laws=np.array(laws),
        painted=np.ones((len(mesh.rest_positions), 2)) if painted is None else painted, size=mesh.size, mass=mass,
    )  # fmt: skip


def along_curve(points: Floats) -> Ints:
    """Return the order of points (t, 3) along a Morton curve."""
    low, most = points.min(axis=0), 0x1FFFFF
    span = float((points.max(axis=0) - low).max())
    cells = np.minimum((points - low) * (most / span if span > 0 else 0.0), most).astype(np.int64)
    keys = sum(((cells[:, c] >> bit) & 1) << (3 * bit + c) for bit in range(21) for c in range(3))
    return np.argsort(keys, kind="stable")


def look_round(s: RestSurface, first: int, x: Floats, radius: float) -> Round:
    """Look at the facets round a sphere at x. Of those that are as near, the one that sees x most squarely counts.

    Of normals that count as one the nearest facet's is kept.
    """
    offsets = x[:, None] - (s.corners * nearest_on_triangles(s.corners, x)).sum(axis=2)
    away = np.sqrt((offsets**2).sum(axis=0))
    tied: Ints = np.flatnonzero(away <= away.min() * (1 + EXACT))
    square = np.abs((offsets * s.normals)[:, tied].sum(axis=0))
    facet = first if first in tied[square == square.max()] else int(tied[square.argmax()])
    normals: list[Floats] = []
    gaps: list[float] = []
    holds: Bools = (away < radius * (1 + HELD)) & (away > 0)
    for normal, gap in zip((offsets[:, holds] / away[holds]).T, away[holds].tolist(), strict=True):
        k = next((k for k, other in enumerate(normals) if normal @ other > 1 - HELD), len(normals))
        if k < NORMALS and (k == len(normals) or gap < gaps[k]):
            normals[k : k + 1], gaps[k : k + 1] = [normal], [gap]
    return Round(facet, float(away[facet]), offsets[:, facet], normals)


def along_normals(found: Round, way: Floats) -> tuple[Floats, Floats]:
    """Split a way (3,) into what the normals push along and the rest: the projection on the cone that they span."""
    push, rest, most = np.zeros(len(found.normals)), way.copy(), math.sqrt(way @ way)
    for _ in range(SWEEPS):
        changed = 0.0
        for k, normal in enumerate(found.normals):  # Gauss and Seidel
            more = max(rest @ normal, -push[k])
            push[k] += more
            rest -= more * normal
            changed = max(changed, abs(more))
        if changed <= 1e-12 * most:
            break
    return way - rest, rest


def seat(s: RestSurface, tip: Tip, x: Floats) -> Round:
    """Lay a sphere at x (3,) on the surface, in place, by the shortest way to or from what is nearest."""
    for _ in range(SWEEPS):
        found = look_round(s, tip.facet, x, tip.radius)
        if not found.near > 0 or abs(found.near - tip.radius) <= SEATED / 2 * tip.radius:
            break
        x += (tip.radius / found.near - 1) * found.offset
    return found


def march(s: RestSurface, tip: Tip, x: Floats, way: Floats) -> Round:
    """Lead a sphere at x (3,) over the surface by a way (3,), in place."""
    parts = min(max(math.ceil(math.sqrt(way @ way) / (TRAVEL * tip.radius)), 1), 64)
    for _ in range(parts):
        x += way / parts
        found = seat(s, tip, x)
    return found


def thickness(s: RestSurface, start: Floats, inward: Floats) -> float:
    """Return how thick the body is behind a place of a facet: to where a ray inwards comes out [m]."""
    along = inward @ s.normals
    ways = ((s.corners[:, :, 0] - start[:, None]) * s.normals).sum(axis=0) / np.where(along > 0, along, np.nan)
    for k in np.argsort(ways):
        end = (start + ways[k] * inward)[:, None]
        corners = s.corners[:, [k]]
        offset = end - (corners * nearest_on_triangles(corners, end[:, 0])).sum(axis=2)
        if ways[k] > 0 and (offset**2).sum() <= 1e-18 * s.size**2:
            return float(ways[k])
    return math.inf


def layer(share: float) -> float:
    """Return how many times as stiff a layer is as one without an end. share: the contact's radius over thickness."""
    return 1 + share * (1.133 + share * (1.283 + share * (0.769 + share * 0.0975)))


def force_at(s: RestSurface, tip: Tip, x: float) -> float:
    """Return the force [N] of the law under a fingertip at a depth [m], with what is painted, and for its own tip."""
    if not x > 0:
        return 0.0
    material = int(s.materials[tip.facet])
    k1, k2, x0, power, _, _, other = s.laws[material].tolist()
    times = tip.stiffer
    if tip.factors:
        rows, end = tip.factors
        times *= float(np.interp(math.sqrt(x / end) * (FACTORS - 1), np.arange(FACTORS), rows[material]))
        if other != 0 and tip.thickness < math.inf:
            measured = math.sqrt(other * x) if other > 0 else -other
            times *= layer(math.sqrt(tip.radius * x) / tip.thickness) / layer(measured / tip.thickness)
    return times * law_force(x, k1, k2, x0 * tip.deeper, power)


def depth_of(s: RestSurface, tip: Tip, force: float) -> float:
    """Return the depth [m] at which the law gives a force [N]."""
    low, high = 0.0, tip.radius
    while force_at(s, tip, high) < force and high < LARGEST_GROWTH * s.size:
        high *= 2
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if force_at(s, tip, middle) < force else (low, middle)
    return high


def take_place(s: RestSurface, tip: Tip, found: Round) -> None:
    """Take the material at the place where a fingertip's foot lies."""
    place = tip.foot - found.offset
    tip.facet = found.facet
    tip.weight = nearest_on_triangles(s.corners[:, [found.facet]], place)[0]
    tip.stiffer, tip.deeper = (tip.weight @ s.painted[s.vertices[found.facet]]).tolist()
    if not tip.factors or s.laws[s.materials[tip.facet], LAYER] == 0:
        return
    gone = place - tip.thick_at
    if not (tip.thickness > 0 and gone @ gone < tip.radius**2):
        tip.thickness, tip.thick_at = thickness(s, place, -tip.outward), place


def skin_height(a: Around, tip: Tip, place: Floats) -> float:
    """Return how far the skin stands above the surface at rest at a place of a facet [m].

    Of a proxy, the vertex counts that is the nearest at rest.
    """
    if a.rest is None:
        here = a.skin[:, a.surface.vertices[tip.facet]] @ tip.weight
    else:
        nearest = int(((a.rest - place[:, None]) ** 2).sum(axis=0).argmin())
        place, here = a.rest[:, nearest], a.skin[:, nearest]
    rotation, translation = a.pose
    return float(tip.outward @ (rotation.T @ (here - rotation @ place - translation)))


def straighten(
    s: RestSurface, tip: Tip, x: Floats, touched: Floats, most: float, found: Round
) -> tuple[bool, Round]:
    """Lead a foot on until it lies straight above x, touching no farther than the most from what the anchor touches.

    Returns:
        whether it does.
    """
    if not np.array_equal(tip.foot, tip.anchor):
        found = look_round(s, tip.facet, tip.foot, tip.radius)
    for step in range(FOOT_STEPS + 1):
        if np.linalg.norm(tip.foot - found.offset - touched) > most:
            break
        _, aside = along_normals(found, tip.foot - x)
        far = math.sqrt(aside @ aside)
        if far <= SLACK * tip.radius or step == FOOT_STEPS:
            return True, found
        found = march(s, tip, tip.foot, -(1 if far < most else most / far) * aside)
    return False, found


def find_foot(s: RestSurface, tip: Tip, x: Floats) -> tuple[float, Round]:
    """Find the foot of a fingertip that lies on the surface at rest, from where it was, or from its anchor.

    Returns:
        how far it is from x [m], 0 where no normal that holds it keeps them apart.
    """
    at_anchor = look_round(s, tip.facet, tip.anchor, tip.radius)
    _, aside = along_normals(at_anchor, tip.anchor - x)
    most = 2 * math.sqrt(aside @ aside) + SLACK * tip.radius
    touched = tip.anchor - at_anchor.offset
    above, found = straighten(s, tip, x, touched, most, at_anchor)
    if not above:
        tip.foot = tip.anchor.copy()
        above, found = straighten(s, tip, x, touched, most, at_anchor)
    if not above:
        tip.foot = tip.anchor.copy()
        found = march(s, tip, tip.foot, -aside)
    way = tip.foot - x
    along, aside = along_normals(found, way)
    # what a foot that is straight above is still aside would tilt the force of a shallow press
    up = along if math.sqrt(aside @ aside) <= SLACK * tip.radius else way
    deep = math.sqrt(up @ up)
    if not along @ along > 0 or not deep > EXACT * tip.radius:  # it has no direction
        return 0.0, found
    tip.outward = up / deep
    return deep, found


def find_gap(s: RestSurface, tip: Tip, x: Floats) -> tuple[float, Round]:
    """Find the foot of one that is clear of the surface, or comes to it. Return how deep it is: its gap, negative."""
    found = look_round(s, tip.facet, x, tip.radius)
    tip.outward = found.offset / found.near if found.near > EXACT * tip.radius else s.normals[:, found.facet].copy()
    tip.foot = x + (tip.radius - found.near) * tip.outward
    return tip.radius - found.near, seat(s, tip, tip.foot)


def place_tip(a: Around, tip: Tip, before: Floats, x: Floats) -> Floats:
    """Find where a fingertip is, at x in the space of the shape at rest, that was elsewhere before.

    It gets no deeper than it goes: in a crease another foot may be farther, which would give energy.

    Returns:
        the way from its foot to its anchor.
    """
    deep, found = find_foot(a.surface, tip, x) if tip.met else (0.0, None)
    tip.met, deep = deep > 0, min(deep, tip.deep + float(np.linalg.norm(x - before)))
    if not tip.met or found is None:
        deep, found = find_gap(a.surface, tip, x)
        tip.met = deep > 0
    take_place(a.surface, tip, found)
    if not tip.in_contact:
        tip.zero, tip.beside, tip.stick = -tip.height, a.others, 0.0
    tip.deep, tip.depth = deep, deep - tip.zero
    if not tip.in_contact:
        tip.anchor = tip.foot.copy()
    tip.in_contact = tip.depth > 0
    aside = along_normals(found, tip.anchor - x)[1] if tip.met else tip.anchor - tip.foot
    aside = aside - (aside @ tip.outward) * tip.outward
    if not tip.in_contact and not a.pushes:  # while it moves the skin itself, that says nothing
        tip.height = skin_height(a, tip, tip.foot - tip.radius * tip.outward) if deep > -tip.radius else 0.0
    return aside


def press(a: Around, tip: Tip, centre: Floats, seconds: float = 0.0) -> None:
    """Evaluate the contact of a fingertip at a centre (3,).

    Args:
        seconds: since the last time, where the body is free: what holds a body between springs would ring undamped.
    """
    s, rotation, was = a.surface, a.pose[0], tip.in_contact
    before, x = tip.local, rotation.T @ (centre - a.pose[1])
    tip.local, tip.force, tip.law, tip.slope, tip.slides = x, np.zeros(3), 0.0, 0.0, 0.0
    if not np.isfinite(x).all():  # of a body that has blown up
        tip.met = tip.in_contact = False
        return
    aside = place_tip(a, tip, before, x)
    if not tip.in_contact:
        return
    law, step = force_at(s, tip, tip.depth), 1e-4 * tip.depth + EXACT * tip.radius
    tip.law, tip.slope = law, max((law - force_at(s, tip, tip.depth - step)) / step, 0.0)
    of_material = s.laws[s.materials[tip.facet]]
    stick, friction = STICK * law / tip.depth, float(of_material[FRICTION])
    far = left = math.sqrt(aside @ aside)
    most = friction * law / stick if stick > 0 else 0.0
    if was and stick > tip.stick > 0:  # it keeps its force and gives up its way
        left *= tip.stick / stick
    left, tip.stick = min(left, most), stick
    tip.slides = left / most if most > 0 else 1.0
    if left < (1 - EXACT) * far:  # the anchor comes nearer
        aside *= left / far
        tip.anchor = tip.foot.copy()
        march(s, tip, tip.anchor, aside)
    force, push = stick * aside, law
    if seconds > 0 and was:
        drag = 2 * float(of_material[DAMPING]) * math.sqrt(tip.slope * s.mass) / seconds * (x - before)
        up = float(drag @ tip.outward)
        # no more than the law: a touch begins without a jump
        force, push = force - drag + up * tip.outward, push - min(max(up, -law), law)
        size = math.sqrt(force @ force)
        force *= friction * push / size if size > friction * push else 1.0
    force = force + push * tip.outward
    if math.sqrt(force @ force) + tip.slope < math.inf:
        tip.force = rotation @ force
    else:  # what is beyond all measure is no force
        tip.law, tip.slope, tip.slides, tip.in_contact = 0.0, 0.0, 0.0, False


def count_anew(tip: Tip, tick: float, *, others: bool) -> None:
    """Let the depth be counted from the surface at rest again, where what had moved the skin has gone."""
    if tip.in_contact and tip.beside and not others:
        tip.zero *= math.exp(-tick / REST_TIME)


def push_on(s: RestSurface, pose: Pose, tip: Tip, to: FingertipMotion, tick: float) -> None:
    """Let a force push a fingertip on for a tick [s], towards the depth at which the law answers it."""
    if not tip.depth > -tip.radius:  # nothing is under it
        return
    straight = max(-float(np.array(to.inward) @ pose[0] @ tip.outward), 0.5)
    way = (depth_of(s, tip, to.force) - tip.depth) * (1 - math.exp(-tick / PUSH_TIME)) / straight
    tip.way += min(max(way, -TRAVEL * tip.radius), TRAVEL * tip.radius)


def lift(tip: Tip) -> None:
    """Take a fingertip away."""
    tip.met = tip.in_contact = False
    tip.way = tip.slides = tip.zero = tip.height = tip.law = tip.slope = tip.stick = tip.thickness = 0.0
    tip.force = np.zeros(3)


def is_inside(s: RestSurface, x: Floats) -> bool:
    """Tell whether a place (3,) is inside the body. Source: generalised winding number, Jacobson and others 2013."""
    a, b, c = (s.corners - x[:, None, None]).transpose(2, 0, 1)
    p, q, r = (np.sqrt((each**2).sum(axis=0)) for each in (a, b, c))
    beside = p * q * r + (a * b).sum(axis=0) * r + (b * c).sum(axis=0) * p + (c * a).sum(axis=0) * q
    seen = np.arctan2((a * np.cross(b, c, axis=0)).sum(axis=0), beside).sum()
    return bool(seen > 1.5 * math.pi)


def put_down(a: Around, tip: Tip) -> None:
    """Put a fingertip down where a motion begins. Where its centre is inside the body it comes from outside."""
    s, (rotation, translation) = a.surface, a.pose
    x = rotation.T @ (tip.centre - translation)
    found = look_round(s, 0, x, tip.radius)
    if found.near > 0 and is_inside(s, x):
        x = x - (1 + tip.radius / found.near) * found.offset
        tip.centre = rotation @ x + translation
    tip.local, tip.facet = x, found.facet
    tip.depth, found = find_gap(s, tip, x)
    tip.deep, tip.met, tip.anchor = tip.depth, tip.depth > 0, tip.foot.copy()
    take_place(s, tip, found)
    tip.height = skin_height(a, tip, tip.foot - tip.radius * tip.outward)


def take(a: Around, tip: Tip, to: FingertipMotion | None) -> None:
    """Take what a motion says of a fingertip."""
    if to is None or to.fresh:
        lift(tip)
    if to is None:
        return
    if tip.met or tip.in_contact:  # another radius lies on the same place
        more = (to.radius - tip.radius) * tip.outward
        tip.anchor, tip.foot = tip.anchor + more, tip.foot + more
    tip.deep += to.radius - tip.radius
    tip.radius, tip.factors, tip.centre = to.radius, to.factors, np.array(to.start, np.float64)
    if to.fresh:
        put_down(a, tip)


def go_along(tip: Tip, before: RestSurface, now: RestSurface) -> None:
    """Let a fingertip that lies on the surface go with it where it changes."""
    if tip.met:
        way = (now.corners - before.corners)[:, tip.facet] @ tip.weight
        tip.anchor, tip.foot, tip.local = tip.anchor + way, tip.foot + way, tip.local + way
    tip.thickness = 0.0
