"""Choose how a body is simulated: on its full mesh where that runs live, else on a proxy.

The method is always semi-implicit Euler in native code. Within the tolerances of live work nearly all of the error
comes from having few vertices, so other methods only cost more for the same error (see studies.work_precision). What
is left to choose is the number of vertices: as few as keep the tolerances, or as many as run live. Both come from a
fit, and the cost from counting vertices and steps: nothing is timed, so a plan is the same whatever else the computer
does. No law is left out to save time: what will press a body is not known.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

from .. import native
from ..base import TICK, DimpleError
from ..body.model import Model
from .proxy import SMALLEST, Proxy, build_proxy, check, mean_spacing, most_of

BUDGET = 0.6  # [s] per second for the simulation; Blender needs the rest to draw
TOLERANCE = 0.5e-3  # [m] between the surfaces, over the dent
FORCE_TOLERANCE = 0.1  # of the force: about the just-noticeable difference of a fingertip
# both are to be kept by 49 of 50 presses
NATIVE_COST, NUMPY_COST = 1.4e-8, 6e-7  # [s] a vertex and step: measured once (tests/bench), and kept
# error over fingertip radius, and error of the force, that 49 of 50 presses stay below at a spacing and a spread of a
# dent that equal this radius; with the powers of spacing over radius and spread over radius. Fitted to the proxies of
# the 30 bodies in studies.bodies.FITTED, pressed by half a radius: size, pins, fill and the knee add nothing
ERROR = 0.083, 1.89, -0.42
FORCE_ERROR = 0.56, 2.27, -0.23
NARROWEST = 0.5  # spread over radius: narrower dents have not been fitted
MARGIN = 1.1  # bodies scatter about the fit by a tenth: a proxy is chosen to be so much better than the tolerances
STRETCH = 2.0  # times a tolerance: a proxy that runs live and misses it by no more beats one that does not run live
TRIES = 5
DENSER = 1.25  # where no proxy can be made, the factor of vertices to the next attempt

_Result = TypeVar("_Result")


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How a body is simulated, and why.

    proxy: None where the full mesh is simulated.
    asked: vertices the proxy was requested with, 0 for the full mesh.
    vertices: simulated vertices.
    steps: per tick.
    cost: expected processor time [s] per simulated second.
    error: of the surface against the full mesh that 49 of 50 presses should stay below, root mean square over a
        dent [m].
    force_error: the same of the force, as a share.
    reason: a sentence for the artist.
    """

    proxy: Proxy | None
    asked: int
    vertices: int
    steps: int
    cost: float
    error: float
    force_error: float
    reason: str


def plan(
    model: Model,
    *,
    tolerance: float = TOLERANCE,
    force_tolerance: float = FORCE_TOLERANCE,
    radius: float = 0.01,
    budget: float = BUDGET,
) -> Plan:
    """Choose between the full mesh and its proxies.

    Args:
        tolerance: allowed root-mean-square error of the surface over a dent [m].
        force_tolerance: allowed error of the force, as a share.
        radius: of the fingertips [m].
        budget: processor time [s] for a second of motion; a full mesh within it is simulated as it is.

    Raises:
        DimpleError: the material is too stiff for the mesh, and no proxy can be made.
    """
    wanted = vertices_for(model, tolerance / MARGIN, force_tolerance / MARGIN, radius)
    try:
        cost = cost_of(model)
    except DimpleError as too_stiff:  # for any step; a proxy has longer edges, so it may take longer steps
        because = "The full mesh is too stiff to simulate"
        try:
            return plan_proxy(model, wanted, radius=radius, budget=budget, because=because)
        except DimpleError as none:
            raise too_stiff from none
    if cost <= budget:
        return _full_mesh(model, cost, f"The full mesh runs live: {_work(model)}.")
    slow = f"The full mesh would run at {_times(budget / cost)} real time ({_work(model)})"
    try:
        check(model)
        keeping, least = (vertices_for(model, k * tolerance, k * force_tolerance, radius) for k in (1.0, STRETCH))
        most, near = most_of(model), f"{1e3 * tolerance:.3g} mm and {force_tolerance:.0%}"
        too_few = DimpleError(f"no proxy of up to {most:,} vertices is within {near}")
        if least > most:
            raise too_few
        chosen = plan_proxy(model, min(wanted, most), radius=radius, budget=budget, because=slow)
        fewer = int(chosen.vertices * budget / chosen.cost)  # they take no more steps
        if least <= fewer < chosen.vertices:
            chosen = plan_proxy(model, fewer, radius=radius, budget=budget, because=slow)
        if keeping > most and chosen.cost > budget:
            raise too_few
    except DimpleError as error:
        return _full_mesh(model, cost, f"{slow}. It is simulated anyway: {error}.")
    if chosen.cost >= cost:
        why = "no proxy within the tolerances is faster"
        return _full_mesh(model, cost, f"{slow}. It is simulated anyway: {why}.")
    if chosen.error > tolerance or chosen.force_error > force_tolerance:
        return replace(chosen, reason=f"{chosen.reason} A proxy within the tolerances would not run live.")
    return chosen


def plan_full_mesh(model: Model, *, budget: float = BUDGET) -> Plan:
    """Return the plan that simulates the full mesh, whatever it costs."""
    cost = cost_of(model)
    return _full_mesh(model, cost, f"As chosen, the full mesh: {_work(model)}, at {_times(budget / cost)} real time.")


def plan_proxy(
    model: Model,
    vertices: int,
    *,
    radius: float,
    budget: float = BUDGET,
    because: str = "",
) -> Plan:
    """Return the plan that simulates a proxy of about the given number of vertices.

    Where no proxy of that size can be made, somewhat larger ones are tried.

    Args:
        radius: of the fingertips [m].
        budget: processor time [s] for a second of motion.
        because: how the reason of the plan begins; "" where the artist chose.

    Raises:
        DimpleError: no such proxy can be made; the message says why.
    """
    proxy, vertices = _first(vertices, lambda n: build_proxy(model, n))
    cost, moved = cost_of(proxy.model), len(proxy.seeds)
    error, force_error = expected(proxy, radius)
    speed = "runs live" if cost <= budget else f"runs at {_times(budget / cost)} real time"
    reason = (
        f"{because or 'As chosen'}. A proxy of {moved:,} vertices {speed}, within {1e3 * error:.2g} mm and "
        f"{force_error:.0%} of the force."
    )
    return Plan(
        proxy=proxy, asked=vertices, vertices=moved, steps=proxy.model.substeps(TICK), cost=cost, error=error,
        force_error=force_error, reason=reason,
    )  # fmt: skip


def _first(vertices: int, make: Callable[[int], _Result]) -> tuple[_Result, int]:
    """Return what `make` returns for a number of vertices or the next larger one that works, and that number.

    Raises:
        DimpleError: no number of vertices works; the message is that of the first.
    """
    why = DimpleError()
    for asked in (math.ceil(vertices * DENSER**k) for k in range(TRIES)):
        try:
            return make(asked), asked
        except DimpleError as error:
            why = why if why.args else error
    raise why


def vertices_for(model: Model, tolerance: float, force_tolerance: float, radius: float) -> int:
    """Return how many vertices a proxy needs, by the fit, to meet tolerances under a fingertip of a radius [m]."""
    wide, (_, power, _), (_, force_power, _) = spread_of(model) / radius, ERROR, FORCE_ERROR
    by_skin = (tolerance / (radius * _fitted(ERROR, 1.0, wide))) ** (1 / power)
    by_force = (force_tolerance / _fitted(FORCE_ERROR, 1.0, wide)) ** (1 / force_power)
    spacing = radius * max(min(by_skin, by_force), 1e-6)
    return max(math.ceil((mean_spacing(model.mesh, 1) / spacing) ** 2), SMALLEST)


def expected(proxy: Proxy, radius: float) -> tuple[float, float]:
    """Return the errors of the surface [m] and of the force (a share) that a proxy should keep, by the fit."""
    share, wide = proxy.spacing / radius, spread_of(proxy.model) / radius
    return radius * _fitted(ERROR, share, wide), min(_fitted(FORCE_ERROR, share, wide), 1.0)


def spread_of(model: Model) -> float:
    """Return how far a dent reaches beyond a fingertip [m]: the root of tension over stiffness, in the mean."""
    # the sum of w l^2 over edges is twice the area, as the surface's own coordinates have the gradient 1
    tension = float((model.matching.tension * model.mesh.rest_lengths**2).sum()) / 2
    return math.sqrt(max(tension, 0.0) / max(float(model.matching.k1.sum()), 1e-30))


def _fitted(fit: tuple[float, float, float], share: float, wide: float) -> float:
    """Return an error by its fit, for spacing and spread over the fingertip's radius."""
    factor, power, spread_power = fit
    return factor * share**power * max(wide, NARROWEST) ** spread_power


def cost_of(model: Model) -> float:
    """Return the processor time [s] that a second of motion should take."""
    each = NUMPY_COST if native.why_not() else NATIVE_COST
    return each * len(model.mass) * model.substeps(TICK) / TICK


def _full_mesh(model: Model, cost: float, reason: str) -> Plan:
    return Plan(
        proxy=None, asked=0, vertices=len(model.mass), steps=model.substeps(TICK), cost=cost, error=0.0,
        force_error=0.0, reason=reason,
    )  # fmt: skip


def _work(model: Model) -> str:
    return f"{len(model.mass):,} vertices at {model.substeps(TICK)} steps per millisecond"


def _times(speed: float) -> str:
    return f"{speed:.2g}x"
