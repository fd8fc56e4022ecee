"""The choice of what is simulated: the full mesh if it runs live, else an evenly spaced proxy within the budget.

If no proxy can be made, the full mesh runs in slow motion. Costs are estimated from counts, not timed, so a plan does
not depend on what else the computer does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

from ..base import TICK, DimpleError
from ..body.model import Model
from ..message import Message
from .proxy import SMALLEST, Proxy, most_of, proxy_of

COST = 1.4e-8  # [s] for a vertex and substep: measured once (tests/bench), then fixed


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """The choice of what is simulated, and the reason.

    proxy: None if the full mesh is simulated.
    asked: requested number of vertices of the proxy, 0 for the full mesh.
    cost: expected processor time [s] per simulated second.
    error: expected error of the surface in a dent, relative to the full mesh [m].
    reason: a sentence for the artist.
    """

    proxy: Proxy | None
    asked: int
    cost: float
    error: float
    reason: str


def plan(model: Model, *, radius: float, budget: float) -> Plan:
    """Choose between the full mesh and its proxies, and make the proxy.

    Args:
        radius: radius of the fingertips [m].
        budget: processor time [s] for a second of motion.

    Raises:
        DimpleError: the material is too stiff for the mesh, and no proxy can be made.
    """
    because = Message("The full mesh is too stiff to simulate")
    try:
        cost = cost_of(model)
        because = Message(
            "The full mesh would run at {speed} real time ({work})", speed=speed_of(cost, budget), work=work_of(model)
        )
    except DimpleError:  # no step is short enough; a proxy has longer edges, so it may take longer steps
        cost = math.inf
    if runs_live(cost, budget):
        return _full_mesh(cost, Message("The full mesh runs live: {work}.", work=work_of(model)))
    asked = min(most_of(model), int(budget * TICK / COST))  # those that the budget pays for at one step per tick
    if cost < math.inf:  # substeps grow at most as 1 / edge, so the work as vertices^1.5
        asked = min(asked, int(len(model.mass) * (budget / cost) ** (2 / 3)))
    make = partial(plan_proxy, model, radius=radius, budget=budget, because=because)
    try:
        chosen = make(max(asked, SMALLEST))
        fewer = int(chosen.asked * budget / chosen.cost)  # a smaller proxy needs no more substeps
        return chosen if runs_live(chosen.cost, budget) else make(max(fewer, SMALLEST))
    except DimpleError as error:
        return _full_mesh(
            cost_of(model), Message("{because}. It is simulated anyway: {error}", because=because, error=error)
        )


def plan_full_mesh(model: Model, *, budget: float, because: str = "As chosen") -> Plan:
    """Return the plan that simulates the full mesh at any cost.

    Args:
        because: beginning of the reason of the plan.

    Raises:
        DimpleError: the material is too stiff for the mesh.
    """
    cost = cost_of(model)
    return _full_mesh(cost, Message(
        "{because}, the full mesh: {work}, at {speed} real time.",
        because=Message(because), work=work_of(model), speed=speed_of(cost, budget)
    ))  # fmt: skip


def plan_proxy(model: Model, vertices: int, *, radius: float, budget: float, because: str = "As chosen") -> Plan:
    """Return the plan that simulates a proxy of about the given number of vertices.

    If no proxy of that size can be made, somewhat larger ones are tried.

    Args:
        radius, budget: as for `plan`.
        because: beginning of the reason of the plan.

    Raises:
        DimpleError: no such proxy can be made; the message says why.
    """
    proxy, asked = _first(model, vertices)
    cost, error = cost_of(proxy.model), surface_error(proxy.spacing, radius)
    speed = "runs live" if runs_live(cost, budget) else "runs at {speed} real time"
    reason = Message(
        "{because}. A proxy of {vertices:,} vertices {speed}; its dents are within {error:.2g} mm of the mesh's.",
        because=Message(because), vertices=len(proxy.seeds), speed=Message(speed, speed=speed_of(cost, budget)),
        error=1e3 * error
    )  # fmt: skip
    return Plan(proxy=proxy, asked=asked, cost=cost, error=error, reason=reason)


def surface_error(spacing: float, radius: float) -> float:
    """Return the expected error [m] of dents of a proxy with edges of length `spacing` [m] under a fingertip.

    A dent has the curvature 1 / R of the fingertip. The middle of a chord of length h is h^2 / (8 R) from its arc: the
    proxy cannot show this much. Of the proxies of 30 bodies pressed by R / 2, 95 % have an RMS error over the dent
    within this value in 98 % of the presses (tests/studies/charts/proxies.csv).
    """
    return spacing**2 / (8 * radius)


def _first(model: Model, vertices: int) -> tuple[Proxy, int]:
    """Return a proxy with the given number of vertices, or up to twice as many, and the number requested.

    Raises:
        DimpleError: none of these numbers works; the message is that of the first.
    """
    why: DimpleError | None = None
    for asked in (vertices * quarters // 4 for quarters in (4, 5, 6, 8)):
        try:
            return proxy_of(model, asked), asked
        except DimpleError as error:
            why = why or error
    assert why is not None
    raise why


def _full_mesh(cost: float, reason: str) -> Plan:
    return Plan(proxy=None, asked=0, cost=cost, error=0.0, reason=reason)


def cost_of(model: Model) -> float:
    """Return the expected processor time [s] for a second of motion."""
    return COST * len(model.mass) * model.substeps(TICK) / TICK


def work_of(model: Model) -> str:
    return Message(
        "{vertices:,} vertices at {substeps} steps per millisecond",
        vertices=len(model.mass), substeps=model.substeps(TICK)
    )  # fmt: skip


def runs_live(cost: float, budget: float) -> bool:
    """Return whether the speed is that of real time to one decimal: estimates of cost are no more accurate."""
    return round(budget / cost, 1) >= 1


def speed_of(cost: float, budget: float) -> str:
    return f"{budget / cost:.2g}x"
