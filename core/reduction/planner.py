"""Choose how a body is simulated: on its full mesh where that runs live, else on a proxy.

The method is always semi-implicit Euler in native code. Within the tolerances of live work nearly all of the error
comes from having few vertices, so other methods only cost more for the same error (see studies.work_precision). What
is left to choose is the number of vertices: as few as keep the tolerances, or as many as run live. Both come from a
fit, and the cost from counting vertices and steps: nothing is timed, so a plan is the same whatever else the computer
does. No law is left out to save time: what will press a body is not known. Where it is known, and no proxy that is even
keeps the tolerances live, a proxy is fine there and coarse elsewhere. Where it is slow, and the full mesh runs live in
fewer steps, that is simulated faster than its fingertips go. Where neither it nor a proxy within the tolerances runs
live, what of it does not move rests.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

from .. import native
from ..base import TICK, DimpleError
from ..body.model import Model
from .active_regions import may_rest, share_awake, slack_of
from .error_model import expected, vertices_for
from .grading import Pressed, share_of
from .proxy import LARGEST, Proxy, build_proxy, check, most_of
from .slow_press import MOST, times_faster

BUDGET = 0.6  # [s] per second for the simulation; Blender needs the rest to draw
TOLERANCE = 0.5e-3  # [m] between the surfaces, over the dent
FORCE_TOLERANCE = 0.1  # of the force: about the just-noticeable difference of a fingertip
# both are to be kept by 49 of 50 presses
NATIVE_COST, NUMPY_COST = 1.4e-8, 6e-7  # [s] a vertex and step: measured once (tests/bench), and kept
MARGIN = 1.2  # bodies and places scatter about the fit: with this 49 of 50 presses keep tolerances of 10 to 30 %
ESTIMATED = 1.05  # times the budget may what runs live be expected to cost: no cost is known better than that
STRETCH = 2.0  # times a tolerance: a proxy that runs live and misses it by no more beats one that does not run live
TOO_SLOW = 4.0  # times what runs live: where a full mesh takes more, the finest proxy that runs live beats it
COARSEST = 0.5  # of the force: the error of a proxy may then be as large
NEARLY_LIVE = 1.8  # times what runs live: a full mesh that takes no more beats a proxy that misses a tolerance
TRIES = 5
DENSER = 1.25  # where no proxy can be made, the factor of vertices to the next attempt

_Result = TypeVar("_Result")
Maker = Callable[[Model, int, Pressed | None], Proxy]  # of a proxy


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
    faster: times that the body is simulated as fast as slow fingertips go.
    slack: [m] regions that go no farther rest, 0 where all is stepped.
    """

    proxy: Proxy | None
    asked: int
    vertices: int
    steps: int
    cost: float
    error: float
    force_error: float
    reason: str
    faster: int = 1
    slack: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """What is to be simulated, before it is made.

    model, tolerance, force_tolerance, radius, budget: what was to be decided, see `decide`.
    cost: of the full mesh, infinite where it is too stiff for any step.
    keeping, least: vertices of a proxy that stays within the tolerances, and of one that misses them by no more than
        it may.
    most: vertices that a proxy may have at most.
    vertices: of the proxy to be made, 0 for the full mesh.
    pressed: where it is fine, None where everywhere.
    otherwise: what is to be done where this is not enough or cannot be made, None where nothing else can.
    because: how the reason begins where the full mesh does not run live.
    reason: a sentence for the artist.
    alone: it meets nothing but fingertips.
    faster, slack: as in a plan.
    """

    model: Model
    tolerance: float
    force_tolerance: float
    radius: float
    budget: float
    cost: float
    keeping: int
    least: int
    most: int
    vertices: int
    pressed: Pressed | None
    otherwise: Decision | None
    because: str
    reason: str
    alone: bool
    faster: int = 1
    slack: float = 0.0


def plan(model: Model, **settings: Any) -> Plan:
    """Choose between the full mesh and its proxies, and make the proxy; see `decide` and `carry_out`."""
    return carry_out(decide(model, **settings))


def decide(
    model: Model,
    *,
    tolerance: float = TOLERANCE,
    force_tolerance: float = FORCE_TOLERANCE,
    radius: float = 0.01,
    budget: float = BUDGET,
    pressed: Pressed | None = None,
    alone: bool = True,
) -> Decision:
    """Choose between the full mesh and its proxies, without making one.

    Args:
        tolerance: allowed root-mean-square error of the surface over a dent [m].
        force_tolerance: allowed error of the force, as a share.
        radius: of the fingertips [m].
        budget: processor time [s] for a second of motion; a full mesh within it is simulated as it is.
        pressed: where the fingertips will press, if that is known.
        alone: it meets nothing but fingertips.

    Raises:
        DimpleError: the material is too stiff for the mesh, and no proxy can be made.
    """
    because = "The full mesh is too stiff to simulate"
    try:
        cost = cost_of(model)
        because = f"The full mesh would run at {_times(budget / cost)} real time ({_work(model)})"
    except DimpleError:  # for any step; a proxy has longer edges, so it may take longer steps
        cost = math.inf
    decided = Decision(
        model=model, tolerance=tolerance, force_tolerance=force_tolerance, radius=radius, budget=budget, cost=cost,
        keeping=0, least=0, most=0, vertices=0, pressed=None, otherwise=None, because=because, reason="",
        alone=alone,
    )  # fmt: skip
    if cost <= ESTIMATED * budget:
        return replace(decided, reason=f"The full mesh runs live: {_work(model)}.")
    if pressed and cost <= ESTIMATED * budget * MOST:
        faster, force_error = times_faster(model, pressed, tolerance, force_tolerance)
        if cost <= ESTIMATED * budget * faster:
            reason = (
                f"The presses are slow, so the full mesh runs live with 1/{faster} of its steps, within "
                f"{force_error:.0%} of the force: {_work(model)}."
            )
            return replace(decided, reason=reason, faster=faster, cost=cost / faster)
    even, graded = _sized(decided, None), None
    resting = _resting(decided, cost) if even.keeping > even.most else None
    if resting and resting.cost > NEARLY_LIVE * budget:
        resting = None
    if not (even.most == LARGEST and cost > TOO_SLOW * budget):  # a mesh that is hardly finer is the better one
        return resting or even
    with suppress(DimpleError):
        graded = _sized(decided, pressed.where) if pressed else None
    if graded and graded.vertices and even.keeping > even.most:
        return replace(graded, otherwise=resting or even)
    return resting or replace(even, otherwise=graded if graded and graded.vertices else None)


def _resting(decided: Decision, cost: float) -> Decision | None:
    """Decide to step only what moves of a full mesh that costs so much [s]; None where none of it can rest."""
    model, radius = decided.model, decided.radius
    if not (decided.alone and may_rest(model) and cost < math.inf):
        return None
    slack = slack_of(decided.tolerance, radius)
    share = share_awake(model, radius, slack)
    less = share * cost
    speed = "which runs live" if less <= ESTIMATED * decided.budget else f"at {_times(decided.budget / less)} real time"
    reason = (
        f"{decided.because}. What moves by less than {1e3 * slack:.2g} mm rests; a fingertip moves about {share:.0%} "
        f"of it, {speed}."
    )
    return replace(decided, vertices=0, cost=less, slack=slack, reason=reason)


def _sized(decided: Decision, pressed: Pressed | None) -> Decision:
    """Decide how many vertices a proxy is to have that is fine everywhere, or where it is pressed."""
    model, radius = decided.model, decided.radius
    share = share_of(model.mesh, pressed) if pressed else 1.0
    wanted, keeping, least = (
        vertices_for(model, k * decided.tolerance, k * decided.force_tolerance, radius, share)
        for k in (1 / MARGIN, 1.0, STRETCH)
    )
    most = most_of(model, share)
    if least > most and decided.cost > TOO_SLOW * decided.budget:
        least = vertices_for(model, radius, COARSEST, radius, share)
    decided = replace(decided, keeping=keeping, least=least, most=most, pressed=pressed)
    try:
        check(model)
        if least > most:
            raise _too_few(decided)
    except DimpleError as error:
        return replace(decided, reason=_anyway(decided, error))
    number = min(wanted, most)
    errors = expected(model, number, radius, share)
    reason = _proxys_reason(decided.because, number, pressed, "is to be made", *errors)
    return replace(decided, vertices=number, reason=reason)


def carry_out(decided: Decision, build: Maker = build_proxy) -> Plan:
    """Make the proxy that was decided on.

    Its steps are known then, so one that does not run live may give way to one of fewer vertices; where none can be
    made, the full mesh is simulated.

    Args:
        build: makes a proxy of a model and a number of vertices.

    Raises:
        DimpleError: the material is too stiff for the mesh, and no proxy can be made.
    """
    chosen = _best_of(decided, build)
    resting = _resting(decided, chosen.cost) if not chosen.proxy and not chosen.slack else None
    if not resting or chosen.faster > 1 or chosen.cost <= ESTIMATED * decided.budget:
        return chosen
    return replace(chosen, cost=resting.cost, slack=resting.slack, error=resting.slack, reason=resting.reason)


def _best_of(decided: Decision, build: Maker) -> Plan:
    first, other = _carried_out(decided, build), decided.otherwise
    live = first.cost <= decided.budget and not _misses(first, decided)
    if other is None or (first.proxy and (decided.pressed or live)):
        return first
    second = _carried_out(other, build)
    return second if second.proxy or decided.pressed else first


def _carried_out(decided: Decision, build: Maker) -> Plan:
    model, budget = decided.model, decided.budget
    if not decided.vertices:
        whole = _full_mesh(model, decided.cost, decided.reason)
        return replace(whole, faster=decided.faster, slack=decided.slack, error=decided.slack)
    make = partial(
        plan_proxy, model, radius=decided.radius, budget=budget, pressed=decided.pressed, because=decided.because,
        build=build,
    )  # fmt: skip
    try:
        chosen = make(decided.vertices)
        fewer = int(chosen.vertices * budget / chosen.cost)  # they take no more steps
        if decided.least <= fewer < chosen.vertices:
            chosen = make(fewer)
        if chosen.cost > budget and decided.keeping > decided.most:
            raise _too_few(decided)
        if chosen.cost >= decided.cost:
            raise DimpleError("no proxy within the tolerances is faster")
        misses = _misses(chosen, decided)
        if misses and decided.cost <= NEARLY_LIVE * budget:
            raise DimpleError("no proxy within the tolerances runs live")
    except DimpleError as error:
        return _full_mesh(model, decided.cost, _anyway(decided, error))
    if misses and decided.keeping > decided.most:
        return replace(chosen, reason=f"{chosen.reason} A proxy cannot have the vertices to keep the tolerances.")
    if misses:
        return replace(chosen, reason=f"{chosen.reason} A proxy within the tolerances would not run live.")
    return chosen


def _misses(chosen: Plan, decided: Decision) -> bool:
    return chosen.error > decided.tolerance or chosen.force_error > decided.force_tolerance


def plan_full_mesh(model: Model, *, budget: float = BUDGET, because: str = "") -> Plan:
    """Return the plan that simulates the full mesh, whatever it costs; because: "" where the artist chose."""
    cost, because = cost_of(model), because or "As chosen"
    reason = f"{because}, the full mesh: {_work(model)}, at {_times(budget / cost)} real time."
    return _full_mesh(model, cost, reason)


def plan_proxy(
    model: Model,
    vertices: int,
    *,
    radius: float,
    budget: float = BUDGET,
    pressed: Pressed | None = None,
    because: str = "",
    build: Maker = build_proxy,
) -> Plan:
    """Return the plan that simulates a proxy of about the given number of vertices.

    Where no proxy of that size can be made, somewhat larger ones are tried.

    Args:
        radius: of the fingertips [m].
        budget: processor time [s] for a second of motion.
        pressed: where the proxy is to be fine, None for everywhere.
        because: how the reason of the plan begins; "" where the artist chose.
        build: makes a proxy of a model and a number of vertices.

    Raises:
        DimpleError: no such proxy can be made; the message says why.
    """
    proxy, vertices = _first(vertices, lambda n: build(model, n, pressed))
    cost, moved = cost_of(proxy.model), len(proxy.seeds)
    share = share_of(model.mesh, pressed) if pressed else 1.0
    error, force_error = expected(model, vertices, radius, share)
    speed = "runs live" if cost <= budget else f"runs at {_times(budget / cost)} real time"
    reason = _proxys_reason(because or "As chosen", moved, pressed, speed, error, force_error)
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


def _proxys_reason(
    because: str, vertices: int, pressed: Pressed | None, speed: str, error: float, force_error: float
) -> str:
    reason = (
        f"{because}. A proxy of {vertices:,} vertices {speed}, within {1e3 * error:.2g} mm and "
        f"{force_error:.0%} of the force."
    )
    return f"{reason} It is fine where it will be pressed." if pressed else reason


def _too_few(decided: Decision) -> DimpleError:
    near = f"{1e3 * decided.tolerance:.3g} mm and {decided.force_tolerance:.0%}"
    return DimpleError(f"no proxy of up to {decided.most:,} vertices is within {near}")


def _anyway(decided: Decision, why: DimpleError) -> str:
    """Return the reason to simulate the full mesh though it is slow.

    Raises:
        DimpleError: it is too stiff.
    """
    cost_of(decided.model)
    return f"{decided.because}. It is simulated anyway: {why}."


def _times(speed: float) -> str:
    return f"{speed:.2g}x"
