"""Carry out what was decided for a body: simulate its full mesh, or make its proxy."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

from ..base import TICK, DimpleError
from ..body.model import Model
from . import processor_time
from .decision import NEARLY_LIVE, Decision, anyway, decide, proxys_reason, resting, too_few
from .error_model import expected
from .grading import Pressed, share_of
from .processor_time import BUDGET, ESTIMATED, speed_of, work_of
from .proxy import Proxy, build_proxy

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


def plan(model: Model, **settings: Any) -> Plan:
    """Choose between the full mesh and its proxies, and make the proxy; see `decide` and `carry_out`."""
    return carry_out(decide(model, **settings))


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
    less = resting(decided, chosen.cost) if not chosen.proxy and not chosen.slack else None
    if not less or chosen.faster > 1 or chosen.cost <= ESTIMATED * decided.budget:
        return chosen
    return replace(chosen, cost=less.cost, slack=less.slack, error=less.slack, reason=less.reason)


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
            raise too_few(decided)
        if chosen.cost >= decided.cost:
            raise DimpleError("no proxy within the tolerances is faster")
        misses = _misses(chosen, decided)
        if misses and decided.cost <= NEARLY_LIVE * budget:
            raise DimpleError("no proxy within the tolerances runs live")
    except DimpleError as error:
        return _full_mesh(model, decided.cost, anyway(decided, error))
    if misses and decided.keeping > decided.most:
        return replace(chosen, reason=f"{chosen.reason} A proxy cannot have the vertices to keep the tolerances.")
    if misses:
        return replace(chosen, reason=f"{chosen.reason} A proxy within the tolerances would not run live.")
    return chosen


def _misses(chosen: Plan, decided: Decision) -> bool:
    return chosen.error > decided.tolerance or chosen.force_error > decided.force_tolerance


def plan_full_mesh(model: Model, *, budget: float = BUDGET, because: str = "") -> Plan:
    """Return the plan that simulates the full mesh, whatever it costs; because: "" where the artist chose."""
    cost, because = processor_time.cost_of(model), because or "As chosen"
    reason = f"{because}, the full mesh: {work_of(model)}, at {speed_of(cost, budget)} real time."
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
    cost, moved = processor_time.cost_of(proxy.model), len(proxy.seeds)
    share = share_of(model.mesh, pressed) if pressed else 1.0
    error, force_error = expected(model, vertices, radius, share)
    speed = "runs live" if cost <= budget else f"runs at {speed_of(cost, budget)} real time"
    reason = proxys_reason(because or "As chosen", moved, pressed, speed, error, force_error)
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


def _full_mesh(model: Model, cost: float, reason: str) -> Plan:
    return Plan(
        proxy=None, asked=0, vertices=len(model.mass), steps=model.substeps(TICK), cost=cost, error=0.0,
        force_error=0.0, reason=reason,
    )  # fmt: skip
