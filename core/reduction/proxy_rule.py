"""How a body is simulated: its full mesh where that runs live, else the even proxy that the budget pays for.

Where no proxy can be made the full mesh runs in slow motion. Costs are counted, not timed, so a plan is the same
whatever else the computer does.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

from ..base import TICK, DimpleError
from ..body.model import Model
from ..messages import Message
from .proxy import SMALLEST, Proxy, most_of, proxy_of

BUDGET = 0.6  # [s] per second for the simulation; Blender needs the rest to draw
COST = 1.4e-8  # [s] a vertex and step: measured once (tests/bench), and kept
ESTIMATED = 1.05  # times the budget may what runs live be expected to cost: no cost is known better than that


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How a body is simulated, and why.

    proxy: None where the full mesh is simulated.
    asked: vertices the proxy was requested with, 0 for the full mesh.
    cost: expected processor time [s] per simulated second.
    error: expected of the surface in a dent, against that of the full mesh [m].
    reason: a sentence for the artist.
    """

    proxy: Proxy | None
    asked: int
    cost: float
    error: float
    reason: str


def plan(model: Model, *, radius: float = 0.01, budget: float = BUDGET) -> Plan:
    """Choose between the full mesh and its proxies, and make the proxy.

    Args:
        radius: of the fingertips [m].
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
    except DimpleError:  # for any step; a proxy has longer edges, so it may take longer steps
        cost = math.inf
    if cost <= ESTIMATED * budget:
        return _full_mesh(cost, Message("The full mesh runs live: {work}.", work=work_of(model)))
    asked = most_of(model)
    if cost < math.inf:  # steps grow no faster than edges shrink, so the work no faster than vertices to 3/2
        asked = min(asked, int(len(model.mass) * (budget / cost) ** (2 / 3)))
    make = partial(plan_proxy, model, radius=radius, budget=budget, because=because)
    try:
        chosen = make(max(asked, SMALLEST))
        fewer = int(chosen.asked * budget / chosen.cost)  # they take no more steps
        return make(max(fewer, SMALLEST)) if chosen.cost > ESTIMATED * budget else chosen
    except DimpleError as error:
        return _full_mesh(
            cost_of(model), Message("{because}. It is simulated anyway: {error}", because=because, error=error)
        )


def plan_full_mesh(model: Model, *, budget: float = BUDGET, because: str = "As chosen") -> Plan:
    """Return the plan that simulates the full mesh, whatever it costs.

    Args:
        because: how the reason of the plan begins.

    Raises:
        DimpleError: the material is too stiff for the mesh.
    """
    cost = cost_of(model)
    return _full_mesh(cost, Message(
        "{because}, the full mesh: {work}, at {speed} real time.",
        because=Message(because), work=work_of(model), speed=speed_of(cost, budget)
    ))  # fmt: skip


def plan_proxy(
    model: Model, vertices: int, *, radius: float, budget: float = BUDGET, because: str = "As chosen"
) -> Plan:
    """Return the plan that simulates a proxy of about the given number of vertices.

    Where no proxy of that size can be made, somewhat larger ones are tried.

    Args:
        radius, budget: as for `plan`.
        because: how the reason of the plan begins.

    Raises:
        DimpleError: no such proxy can be made; the message says why.
    """
    proxy, asked = _first(model, vertices)
    cost, error = cost_of(proxy.model), surface_error(proxy.spacing, radius)
    speed = "runs live" if cost <= ESTIMATED * budget else "runs at {speed} real time"
    reason = Message(
        "{because}. A proxy of {vertices:,} vertices {speed}; its dents are within {error:.2g} mm of the mesh's.",
        because=Message(because), vertices=len(proxy.seeds), speed=Message(speed, speed=speed_of(cost, budget)),
        error=1e3 * error
    )  # fmt: skip
    return Plan(proxy=proxy, asked=asked, cost=cost, error=error, reason=reason)


def surface_error(spacing: float, radius: float) -> float:
    """Return how far [m] dents of a proxy of so long edges [m] are off under a fingertip of a radius [m].

    A dent is curved as the fingertip is, and the middle of a chord of length h is h^2 / (8 R) from its arc of radius R:
    what the proxy cannot show. Of 30 bodies pressed by R / 2, 19 of 20 proxies keep it in 49 of 50 presses, root mean
    square over the dent (tests/studies/charts/proxies.csv).
    """
    return spacing**2 / (8 * radius)


def _first(model: Model, vertices: int) -> tuple[Proxy, int]:
    """Return a proxy of a number of vertices, or of up to twice as many, and that number.

    Raises:
        DimpleError: no number of vertices works; the message is that of the first.
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
    """Return the processor time [s] that a second of motion should take."""
    return COST * len(model.mass) * model.substeps(TICK) / TICK


def work_of(model: Model) -> str:
    return Message(
        "{vertices:,} vertices at {substeps} steps per millisecond",
        vertices=len(model.mass), substeps=model.substeps(TICK)
    )  # fmt: skip


def speed_of(cost: float, budget: float) -> str:
    return f"{budget / cost:.2g}x"
