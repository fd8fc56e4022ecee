"""Choose how a body is simulated: on its full mesh where that runs live, else on the smallest accurate proxy.

The method is always semi-implicit Euler in native code. Within the tolerances of live work nearly all of the error
comes from having few vertices, so other methods only cost more for the same error (see studies.work_precision). What
is left to choose is the number of vertices. No law is left out to save time: what will press a body is not known.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

from ..base import TICK, DimpleError
from ..body.model import Model
from ..solver.backend import create
from ..solver.motion import Motion
from .benchmark import (
    DOWN,
    HOLD,
    BenchmarkPress,
    Outcome,
    PressResult,
    choose_presses,
    press_mesh,
    press_variant,
    result_of,
    try_proxy,
    unwatched,
)
from .proxy import LARGEST, SMALLEST, Proxy, build_proxy, carry, check, mean_spacing, most_of

BUDGET = 0.6  # [s] per second for the simulation; Blender needs the rest to draw
TOLERANCE = 0.5e-3  # [m] between the surfaces, over the dent
FORCE_TOLERANCE = 0.1  # of the force: about the just-noticeable difference of a fingertip
CONTACT = 1.15  # the cost of a body that is pressed over that of one that is not
# error over fingertip radius, and error of the force, at a spacing equal to that radius, each with the power of
# spacing over radius that it grows with: fitted to 75 proxies of the 12 bodies in studies.bodies.FITTED, pressed by
# half a radius
ERROR, ERROR_POWER = 0.098, 1.41
FORCE_ERROR, FORCE_POWER = 0.206, 1.32  # about twice that on a box, half of it on round bodies
TRIES = 5
NEAR_ENOUGH = 0.9  # of a tolerance: the rest would save a fifth of the work, not worth another try
DOUBT = 0.5  # of the error, over the root of the number of presses: the margin for pressing fewer times than PRESSES
NEARLY = 1.15  # of a tolerance, where no proxy meets it: presses at other places scatter by more than this
CLOSE = 1.2  # times the vertices that missed: at most a third more work
FAR = 4.0  # times the vertices, from one try to the next
PRESSES = 24  # at most; of four presses too few meet edges, and the error of the force scatters by a half
FEW = 6  # presses: where the mesh is too slow for so many, a large proxy is pressed in its place
ALLOWANCE = 2.0  # [s] of processor time for these presses; those of the proxies take about as long again
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
    error: expected error of the surface against the full mesh, root mean square over a dent [m].
    force_error: expected error of the force, as a share.
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
    allowance: float = ALLOWANCE,
    watch: Callable[[], None] = unwatched,
) -> Plan:
    """Choose between the full mesh and its proxies, by pressing them.

    Args:
        tolerance: allowed root-mean-square error of the surface over a dent [m].
        force_tolerance: allowed error of the force, as a share.
        radius: of the fingertips [m].
        budget: processor time [s] for a second of motion; a full mesh within it is simulated as it is.
        allowance: processor time [s] for presses; 0 presses nothing, and the fit alone chooses.
        watch: called all the time meanwhile, to show that work goes on.

    Raises:
        DimpleError: the material is too stiff for the mesh, and no proxy can be made.
    """
    try:
        cost = measured_cost(model)
    except DimpleError as too_stiff:  # for any step; a proxy has longer edges, so it may take longer steps
        wanted = vertices_for(model, tolerance, force_tolerance, radius)
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
    except DimpleError as error:
        return _full_mesh(model, cost, f"{slow}. It is simulated all the same: {error}.")
    wanted, measured, seen_from = vertices_for(model, tolerance, force_tolerance, radius), None, 0
    if allowance and not model.held.all():
        presses = allowance / (cost * (DOWN + HOLD))
        wanted, measured, seen_from = _measured(
            model, presses, radius, tolerance, force_tolerance, wanted, watch
        )  # fmt: skip
    most = most_of(model)
    if wanted > most:
        near = f"{1e3 * tolerance:.3g} mm and {force_tolerance:.0%}"
        why = f"no proxy of up to {most:,} vertices is within {near}"
        return _full_mesh(model, cost, f"{slow}. It is simulated all the same: {why}.")
    try:
        chosen = plan_proxy(
            model, wanted, radius=radius, budget=budget, because=slow, measured=measured, seen_from=seen_from
        )
    except DimpleError as error:
        return _full_mesh(model, cost, f"{slow}. It is simulated all the same: {error}.")
    if chosen.cost >= cost:
        return _full_mesh(
            model, cost, f"{slow}. It is simulated all the same: no proxy within the tolerances is faster."
        )
    return chosen


def plan_full_mesh(model: Model, *, budget: float = BUDGET) -> Plan:
    """Return the plan that simulates the full mesh, whatever it costs."""
    cost = measured_cost(model)
    return _full_mesh(model, cost, f"As chosen, the full mesh: {_work(model)}, at {_times(budget / cost)} real time.")


def plan_proxy(
    model: Model,
    vertices: int,
    *,
    radius: float,
    budget: float = BUDGET,
    because: str = "",
    measured: Outcome | None = None,
    seen_from: int = 0,
) -> Plan:
    """Return the plan that simulates a proxy of about the given number of vertices.

    Where no proxy of that size can be made, somewhat larger ones are tried.

    Args:
        radius: of the fingertips [m].
        budget: processor time [s] for a second of motion.
        because: how the reason of the plan begins; "" where the artist chose.
        measured: the outcome of pressing the proxy, None where it was not pressed.
        seen_from: vertices of the larger proxy that it was compared with, 0 where that was the full mesh.

    Raises:
        DimpleError: no such proxy can be made; the message says why.
    """
    proxy, vertices = _first(vertices, lambda n: build_proxy(model, n))
    cost, moved = measured_cost(proxy.model), len(proxy.seeds)
    error, force_error = (measured.error, measured.force_error) if measured else expected(proxy, radius)
    speed = "runs live" if cost <= budget else f"runs at {_times(budget / cost)} real time"
    known = "measured" if measured else "expected, not measured"
    how = f"{known} against a proxy of {seen_from:,} vertices" if seen_from else known
    reason = (
        f"{because or 'As chosen'}. A proxy of {moved:,} vertices {speed}. Its errors: {1e3 * error:.2g} mm and "
        f"{force_error:.0%} of the force ({how})."
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


def _reference(
    model: Model, radius: float, paid: float, watch: Callable[[], None]
) -> tuple[list[BenchmarkPress], list[PressResult], int]:
    """Return presses, the results to compare with, and the vertices of the proxy they are of, 0 for the full mesh.

    Args:
        paid: presses of the full mesh that the allowance pays for.

    Raises:
        DimpleError: no such proxy can be made.
    """
    if paid >= FEW:
        presses = choose_presses(model, radius, int(min(paid, PRESSES)))
        return presses, result_of(press_mesh(model, presses), watch)[0], 0
    n = len(model.mass)
    size = n * (paid / FEW) ** (2 / 3)  # steps grow with the root of the vertices
    size = min(max(size, FAR * SMALLEST), most_of(model), LARGEST // 2)
    presses = choose_presses(model, radius, int(min(max(paid * (n / size) ** 1.5, FEW), PRESSES)))
    (proxy, _, ends), _ = _first(round(size), lambda n: result_of(press_variant(model, presses, n), watch))
    assert proxy  # of a variant with vertices
    return presses, [replace(end, positions=carry(proxy, end.positions).T) for end in ends], len(proxy.seeds)


def _measured(
    model: Model, paid: float, radius: float, tolerance: float, force_tolerance: float, wanted: int,
    watch: Callable[[], None],
) -> tuple[int, Outcome | None, int]:
    """Try proxies of several sizes and find the smallest one within the tolerances.

    Args:
        paid: presses of the full mesh that the allowance pays for.
        wanted: vertices to begin with.

    Returns:
        Its vertices, its outcome, and the vertices of the proxy it was compared with (0 for the full mesh). Where
        none is within the tolerances: the one that nearly is, else the vertices that should be enough, and None.
    """
    try:
        presses, goal, seen_from = _reference(model, radius, paid, watch)
    except DimpleError:
        return wanted, None, 0
    most, doubt = seen_from // 2 if seen_from else most_of(model), 1 + DOUBT * (len(presses) ** -0.5 - PRESSES**-0.5)
    best, nearly, missed, vertices = None, None, 0, wanted
    for _ in range(TRIES):
        tried = min(vertices, most)
        found = result_of(try_proxy(model, presses, goal, tried), watch)
        # the error of the reference itself, by the fit; squares of errors add up
        share = tried / seen_from if seen_from else 0.0
        skin = doubt * found.error / tolerance / math.sqrt(1 - share**ERROR_POWER)
        force = doubt * found.force_error / force_tolerance / math.sqrt(1 - share**FORCE_POWER)
        off, known = max(skin, force), replace(found, error=skin * tolerance, force_error=force * force_tolerance)
        if off <= 1:
            best = known
        else:
            missed = tried
        if nearly is None and off <= NEARLY:
            nearly = known
        if best and (NEAR_ENOUGH < off <= 1 or best.asked <= CLOSE * missed):
            break
        # the errors fall with the spacing, which is as one over the root of the vertices
        factor = max(skin ** (2 / ERROR_POWER), force ** (2 / FORCE_POWER)) if not found.note else DENSER
        vertices = max(math.ceil(tried * min(max(factor, 1 / FAR), FAR)), SMALLEST)
        if best:  # between what missed and what met
            vertices = min(max(vertices, math.ceil(missed * math.sqrt(CLOSE))), best.asked - 1)
        elif missed == most:
            break
    chosen = best or nearly
    return (chosen.asked, chosen, seen_from) if chosen else (vertices, None, 0)


def vertices_for(model: Model, tolerance: float, force_tolerance: float, radius: float) -> int:
    """Return how many vertices a proxy needs, by the fit, to meet tolerances under a fingertip of a radius [m]."""
    by_skin = (tolerance / (ERROR * radius)) ** (1 / ERROR_POWER)
    by_force = (force_tolerance / FORCE_ERROR) ** (1 / FORCE_POWER)
    spacing = radius * max(min(by_skin, by_force), 1e-6)
    return max(math.ceil((mean_spacing(model.mesh, 1) / spacing) ** 2), SMALLEST)


def expected(proxy: Proxy, radius: float) -> tuple[float, float]:
    """Return the errors of the surface [m] and of the force (a share) that a proxy should have, by the fit."""
    share = proxy.spacing / radius
    return ERROR * radius * share**ERROR_POWER, min(FORCE_ERROR * share**FORCE_POWER, 1.0)


def measured_cost(model: Model) -> float:
    """Measure the processor time [s] for a second of motion on this machine, from a few ticks without contact."""
    body, steps = create(model), model.substeps(TICK)
    best, spent = math.inf, 0.0
    while best == math.inf or spent < min(3 * best, 0.05):
        started = time.perf_counter()  # some systems count processor time in steps longer than a tick
        body.step(Motion(1, steps, TICK))
        took = time.perf_counter() - started
        best, spent = min(best, took), spent + took
    return CONTACT * best / TICK


def _full_mesh(model: Model, cost: float, reason: str) -> Plan:
    return Plan(
        proxy=None, asked=0, vertices=len(model.mass), steps=model.substeps(TICK), cost=cost, error=0.0,
        force_error=0.0, reason=reason,
    )  # fmt: skip


def _work(model: Model) -> str:
    return f"{len(model.mass):,} vertices at {model.substeps(TICK)} steps per millisecond"


def _times(speed: float) -> str:
    return f"{speed:.2g}x"
