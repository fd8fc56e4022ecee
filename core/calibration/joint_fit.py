"""What a tip answers on a bed of springs under a membrane, in closed form, and the best fit of it to several curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..base import DimpleError, Floats
from ..body.estimate import BEYOND, falloff, reach
from ..material import Indenter

BINS = 40  # of the depth, whose means are fitted
TRUSTED = 0.01  # of full scale: no curve counts as more exact than this
SPREADS = 32  # that are tried
CLOSER = 5  # times the way between them is halved
AFRESH = 8  # spreads from one fit that begins anew to the next
STEPS, ENOUGH = 25, 1e-5  # of the fit at each spread, and the gain of the last one
CONTACTS = 80  # radii of contact that a round tip's curve is drawn through
SHIFT = 0.03  # of the depth: how far a touch that is an estimate may be off
FEWEST = 6  # bins of a curve
LEAST_KNEE, MOST_KNEE = 0.05, 0.95  # of the depth that the deepest curve reaches: where a knee can be found


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """A loading curve.

    name: of its file.
    tip: what measured it.
    depth: (n,) from the first touch [m].
    force: (n,) [N].
    noise: standard deviation of the force [N].
    shifts: whether the first touch is an estimate.
    """

    name: str
    tip: Indenter
    depth: Floats
    force: Floats
    noise: float
    shifts: bool = False


@dataclass(frozen=True, slots=True)
class Means:
    """The means of one curve that are fitted: depth [m], force and its error [N] (m,), and the tip's reach [m]."""

    depth: Floats
    force: Floats
    error: Floats
    radius: float
    curve: Curve


@dataclass(frozen=True, slots=True)
class Shape:
    """What a bed of stiffness 1 answers at one spread: depth [m], force [m3] and radius of contact [m], (c,)."""

    depth: Floats
    force: Floats
    contact: Floats


@dataclass(frozen=True, slots=True)
class Found:
    """A fit at one spread [m]: logarithms of kappa1, and of x0 and the root of kappa2 over kappa1 less 1; shifts."""

    spread: float
    values: Floats
    shapes: tuple[Shape, ...]
    cost: float


def means_of(curve: Curve, size: float) -> Means:
    """Return the means of a curve over equal parts of its depth."""
    pressed = curve.depth > 0
    x, f = curve.depth[pressed], curve.force[pressed]
    if not len(x) or not f.max() > 0:
        raise DimpleError("{name}: no force was measured in contact.", name=curve.name)
    part = np.minimum((x / x.max() * BINS).astype(np.int64), BINS - 1)
    counts = np.bincount(part, minlength=BINS)
    full = counts > 0
    if full.sum() < FEWEST:
        raise DimpleError(
            "{name}: only {full} depths in contact. Measure at more depths.", name=curve.name, full=int(full.sum())
        )
    depth, force = (np.bincount(part, weights=each, minlength=BINS)[full] / counts[full] for each in (x, f))
    error = np.full(len(depth), max(curve.noise, TRUSTED * float(f.max())))
    return Means(depth, force, error, reach(curve.tip, size), curve)


def _shape(means: Means, spread: float) -> Shape:
    """Return how a bed with a spread [m] answers a tip: the closed form by its radius of contact."""
    radius, deepest = means.radius, float(means.depth.max()) * (1 + 2 * SHIFT)
    if means.curve.tip.shape != "sphere":
        area = math.pi * radius**2 + 2 * math.pi * radius * falloff(radius, spread)
        depth = np.array([0.0, deepest])
        return Shape(depth, area * depth, np.full(2, radius))
    left = 1 - np.linspace(0, 1, CONTACTS + 1)[1:-1]  # closer and closer to the whole face
    a, rise = radius * np.cos(math.pi / 2 * left**3), radius * np.sin(math.pi / 2 * left**3)
    s = np.array([falloff(each, spread) for each in a.tolist()])
    depth = radius - rise + spread**2 * a / (s * rise)
    edge = depth - radius + rise
    force = math.pi * a**2 * (depth - radius) + 2 * math.pi / 3 * (radius**3 - rise**3) + 2 * math.pi * a * s * edge
    last = min(int(np.searchsorted(depth, deepest)) + 1, len(a))
    zero = np.zeros(1)
    return Shape(*(np.concatenate([zero, each[:last]]) for each in (depth, force, a)))


def force_of(shape: Shape, spread: float, values: Floats, knee: bool, depth: Floats) -> Floats:
    """Return the force (m,) [N] of one tip at depths [m]; a round tip goes on evenly where its whole face touches."""
    kappa = math.exp(values[0])
    x = np.maximum(depth, 0.0)
    force = np.interp(x, shape.depth, shape.force)
    force = force + np.maximum(x - shape.depth[-1], 0) * shape.force[-1] / max(shape.depth[-1], 1e-30)
    if not knee:
        return kappa * force
    x0, root = math.exp(values[1]), math.exp(values[2])
    a = np.interp(x, shape.depth, shape.contact)
    more = math.pi * a**2 * root**2 + BEYOND * 2 * math.pi * a * spread * root
    return kappa * (force + more * np.maximum(x - x0, 0))


def residuals(means: Sequence[Means], found: Found, knee: bool) -> Floats:
    """Return the errors (n,) over what is allowed, and the shifts of touches over theirs."""
    count, parts, at = 3 if knee else 1, [], 0
    for each, shape in zip(means, found.shapes, strict=True):
        shift = 0.0
        if each.curve.shifts:
            shift = found.values[count + at]
            at += 1
            parts.append(np.array([shift / (SHIFT * float(each.depth.max()))]))
        parts.append((force_of(shape, found.spread, found.values, knee, each.depth - shift) - each.force) / each.error)
    return np.concatenate(parts)


def profile(means: Sequence[Means], spreads: Floats, knee: bool) -> list[Found]:
    """Return the best fit at each spread (s,) [m], each from where the one before ended."""
    fits = [at_spread(means, float(spreads[0]), knee)]
    for i, spread in enumerate(spreads[1:].tolist()):
        fits.append(at_spread(means, spread, knee, start=None if i % AFRESH == 0 else fits[-1]))
    return fits


def closer(means: Sequence[Means], fits: Sequence[Found], knee: bool) -> Found:
    """Return the best fit of all, between the spreads that were tried too."""
    best, way = min(fits, key=cost_of), fits[1].spread / fits[0].spread
    for _ in range(CLOSER):
        way **= 0.5
        beside = [at_spread(means, best.spread * by, knee, start=best) for by in (1 / way, way)]
        best = min((best, *beside), key=cost_of)
    return best


def at_spread(means: Sequence[Means], spread: float, knee: bool, *, start: Found | None = None) -> Found:
    """Return the best fit at a spread [m], by damped Gauss-Newton steps from another fit, if there is one near."""
    shapes = tuple(_shape(each, spread) for each in means)
    deepest = max(float(each.depth.max()) for each in means)
    if start:
        return _descend(means, replace(start, spread=spread, shapes=shapes), knee, deepest)
    pairs = zip(means, shapes, strict=True)
    stiff = math.log(np.median([each.force[-1] / np.interp(each.depth[-1], s.depth, s.force) for each, s in pairs]))
    shifts = [0.0] * sum(each.curve.shifts for each in means)
    starts = [[stiff, math.log(share * deepest), 0.5] for share in (0.3, 0.6)] if knee else [[stiff]]
    begins = [Found(spread, np.array(start + shifts), shapes, math.inf) for start in starts]
    return min((_descend(means, begin, knee, deepest) for begin in begins), key=cost_of)


def cost_of(found: Found) -> float:
    """Return the sum of the squared residuals of a fit, by which fits are sorted."""
    return found.cost


def _descend(means: Sequence[Means], found: Found, knee: bool, deepest: float) -> Found:
    damping, r = 1e-2, residuals(means, found, knee)
    found = replace(found, cost=float(r @ r))
    for _ in range(STEPS):
        slopes = slopes_of(means, found, knee, r)
        normal, down = slopes.T @ slopes, slopes.T @ r
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), -down)
        values = found.values + np.clip(step, -1.0, 1.0)
        if knee:
            values[1] = np.clip(values[1], math.log(LEAST_KNEE * deepest), math.log(MOST_KNEE * deepest))
            values[2] = np.clip(values[2], -6.0, 6.0)
        tried = replace(found, values=values)
        left = residuals(means, tried, knee)
        cost = float(left @ left)
        if cost < found.cost:
            enough = found.cost - cost < ENOUGH * found.cost
            found, r, damping = replace(tried, cost=cost), left, damping / 4
            if enough:
                break
        else:
            damping *= 8
            if damping > 1e8:
                break
    return found


def slopes_of(means: Sequence[Means], found: Found, knee: bool, r: Floats) -> Floats:
    """Return the slopes (n, p) of the residuals in the values."""
    columns, count = [], 3 if knee else 1
    for i in range(len(found.values)):
        by = 1e-5 if i < count else 1e-8
        values = found.values.copy()
        values[i] += by
        columns.append((residuals(means, replace(found, values=values), knee) - r) / by)
    return np.stack(columns, axis=1)
