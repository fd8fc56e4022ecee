"""Choose how a body is simulated: on its mesh where that runs live, else on the smallest stand-in that is near enough.

The method is semi-implicit Euler in native code: within live tolerances the error is that of too few vertices, so
other methods only cost more for the same error (studies.work_precision has it in both languages). What is left to
choose is how many vertices move. No law is left out to save time: a body does not know what it will meet.
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
    Outcome,
    Press,
    Pressed,
    choose_presses,
    end_of,
    press_mesh,
    press_variant,
    try_proxy,
)
from .proxy import LARGEST, SMALLEST, Proxy, build_proxy, carry, check, mean_spacing, most_of

BUDGET = 0.6  # [s] of a second for the simulation; the rest is Blender's, to draw
TOLERANCE = 0.5e-3  # [m] between the skins, over the dent
FORCE_TOLERANCE = 0.1  # of the force: about what a fingertip can tell apart
CONTACT = 1.15  # times the work of a body nobody touches
# Error over fingertip radius, and of force, at a spacing as large as the fingertip, and the power of spacing over
# radius they go with: fitted to 75 stand-ins of the 12 bodies in studies.bodies.FITTED, presses of half a radius
ERROR, ERROR_POWER = 0.098, 1.41
FORCE_ERROR, FORCE_POWER = 0.206, 1.32  # on a box about twice that, on what is round about half
TRIES = 5
NEAR_ENOUGH = 0.9  # of a tolerance: what is left saves a fifth of the work, not worth another try
DOUBT = 0.5  # of an error over the root of the number of presses: how much more others may say, than PRESSES do
NEARLY = 1.15  # of a tolerance, where nothing keeps to it: nearer than presses elsewhere would say the same
CLOSE = 1.2  # times the vertices that missed: a third of the work more at most
FAR = 4.0  # times the vertices, from one try to the next
PRESSES = 24  # at most: of four, too few meet edges, and the error of the force scatters by a half
FEW = 6  # where the mesh cannot be pressed so often, a large stand-in of it is
ALLOWANCE = 2.0  # [s] of computing that these presses may take; the tried stand-ins take about as long again
DENSER = 1.25  # where no stand-in can be made, one with so many times the vertices may

_Result = TypeVar("_Result")


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """Hold what was chosen and why.

    proxy: None where the mesh itself moves.  asked: vertices it was built for, 0 for the mesh.  vertices: that move.
    steps: a tick.  cost: [s] a second, expected.
    error [m], force_error: expected against the mesh itself, 0 for the mesh.  reason: a sentence.
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
) -> Plan:
    """Choose, by what stand-ins are measured to be.

    Args:
        tolerance: between the skins over the dent, root of the mean square [m].
        force_tolerance: of the force, as a share.
        radius: of the fingertips [m].
        budget: [s] of computing for a second of motion. A mesh that keeps to it moves itself.
        allowance: [s] of computing for presses; 0: none, and the fit alone chooses.

    Raises:
        DimpleError: the material is too stiff for the mesh, and there is no stand-in either.
    """
    try:
        cost = pace(model)
    except DimpleError as too_stiff:  # for any tick; a stand-in is softer on the clock
        wanted = vertices_for(model, tolerance, force_tolerance, radius)
        because = "The mesh itself is too stiff to move"
        try:
            return stand_in(model, wanted, radius=radius, budget=budget, because=because)
        except DimpleError as none:
            raise too_stiff from none
    if cost <= budget:
        return _mesh_itself(model, cost, f"{_work(model)} run live.")
    slow = f"{_work(model)} would run at {_times(budget / cost)} real time"
    try:
        check(model)
    except DimpleError as error:
        return _mesh_itself(model, cost, f"{slow}, but {error}: the mesh itself moves.")
    wanted, measured, seen_from = vertices_for(model, tolerance, force_tolerance, radius), None, 0
    if allowance and not model.held.all():
        presses = allowance / (cost * (DOWN + HOLD))
        wanted, measured, seen_from = _measured(model, presses, radius, tolerance, force_tolerance, wanted)
    most = most_of(model)
    if wanted > most:
        near = f"{1e3 * tolerance:.3g} mm and {force_tolerance:.0%}"
        return _mesh_itself(
            model, cost, f"{slow}, and no stand-in of up to {most:,} is within {near}: the mesh itself moves."
        )
    try:
        chosen = stand_in(
            model, wanted, radius=radius, budget=budget, because=slow, measured=measured, seen_from=seen_from
        )
    except DimpleError as error:
        return _mesh_itself(model, cost, f"{slow}, but {error}: the mesh itself moves.")
    if chosen.cost >= cost:
        return _mesh_itself(
            model, cost, f"{slow}, and a stand-in that is near enough is no faster: the mesh itself moves."
        )
    return chosen


def mesh_itself(model: Model, *, budget: float = BUDGET) -> Plan:
    """Return the plan of who wants the mesh itself to move."""
    cost = pace(model)
    return _mesh_itself(model, cost, f"As chosen, {_work(model)} run at {_times(budget / cost)} real time.")


def stand_in(
    model: Model,
    vertices: int,
    *,
    radius: float,
    budget: float = BUDGET,
    because: str = "",
    measured: Outcome | None = None,
    seen_from: int = 0,
) -> Plan:
    """Return the plan for a stand-in of about so many vertices, or somewhat more where the mesh asks for them.

    Args:
        measured: what it came to where it was tried.  seen_from: vertices of the stand-in that was pressed in place of
            a mesh too heavy for it, 0 for the mesh.

    Raises:
        DimpleError: none can be made, and why.
    """
    proxy, vertices = _first(vertices, lambda n: build_proxy(model, n))
    cost, moved = pace(proxy.model), len(proxy.seeds)
    error, force_error = (measured.error, measured.force_error) if measured else expected(proxy, radius)
    speed = "runs live" if cost <= budget else f"runs at {_times(budget / cost)}"
    known = "kept within" if measured else "should keep within about"
    how = f" (seen from {seen_from:,})" if seen_from else "" if measured else " (not tried)"
    reason = (
        f"{because or 'As chosen'}; a stand-in of {moved:,} vertices {known} {1e3 * error:.2g} mm and "
        f"{force_error:.0%} of the force{how} and {speed}."
    )
    return Plan(
        proxy=proxy, asked=vertices, vertices=moved, steps=proxy.model.substeps(TICK), cost=cost, error=error,
        force_error=force_error, reason=reason,
    )  # fmt: skip


def _first(vertices: int, make: Callable[[int], _Result]) -> tuple[_Result, int]:
    """Return what is made with so many vertices, or with the next larger number that it can be made with; and that.

    Raises:
        DimpleError: none can be made, and why.
    """
    why = DimpleError()
    for asked in (math.ceil(vertices * DENSER**k) for k in range(TRIES)):
        try:
            return make(asked), asked
        except DimpleError as error:
            why = why if why.args else error
    raise why


def _goal(model: Model, radius: float, paid: float) -> tuple[list[Press], list[Pressed], int]:
    """Return presses, what they come to, and the vertices of the stand-in that was pressed; 0 where the mesh was.

    Args:
        paid: presses of the mesh itself that are paid for.

    Raises:
        DimpleError: no such stand-in can be made.
    """
    if paid >= FEW:
        presses = choose_presses(model, radius, int(min(paid, PRESSES)))
        return presses, end_of(press_mesh(model, presses))[0], 0
    n = len(model.mass)
    size = n * (paid / FEW) ** (2 / 3)  # steps go with the root of the vertices
    size = min(max(size, FAR * SMALLEST), most_of(model), LARGEST // 2)
    presses = choose_presses(model, radius, int(min(max(paid * (n / size) ** 1.5, FEW), PRESSES)))
    (proxy, _, ends), _ = _first(round(size), lambda n: end_of(press_variant(model, presses, n)))
    assert proxy  # of a way with vertices
    return presses, [replace(end, positions=carry(proxy, end.positions).T) for end in ends], len(proxy.seeds)


def _measured(
    model: Model, paid: float, radius: float, tolerance: float, force_tolerance: float, wanted: int
) -> tuple[int, Outcome | None, int]:
    """Return the fewest vertices tried that met the tolerances, what they came to, and from how many that was seen.

    Where none did: those that nearly did; or how many should, by how the errors fall, and None.

    Args:
        paid: presses of the mesh itself that are paid for.
        wanted: vertices to begin with.
    """
    try:
        presses, goal, seen_from = _goal(model, radius, paid)
    except DimpleError:
        return wanted, None, 0
    most, doubt = seen_from // 2 if seen_from else most_of(model), 1 + DOUBT * (len(presses) ** -0.5 - PRESSES**-0.5)
    best, nearly, missed, vertices = None, None, 0, wanted
    for _ in range(TRIES):
        tried = min(vertices, most)
        found = end_of(try_proxy(model, presses, goal, tried))
        # what the goal is off by itself: by the fit, and the squares of errors add up
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
    """Return how many vertices a stand-in needs to meet the tolerances under a fingertip of a radius [m]."""
    by_skin = (tolerance / (ERROR * radius)) ** (1 / ERROR_POWER)
    by_force = (force_tolerance / FORCE_ERROR) ** (1 / FORCE_POWER)
    spacing = radius * max(min(by_skin, by_force), 1e-6)
    return max(math.ceil((mean_spacing(model.mesh, 1) / spacing) ** 2), SMALLEST)


def expected(proxy: Proxy, radius: float) -> tuple[float, float]:
    """Return the error [m] and of the force that a stand-in is expected to have, by the fit."""
    share = proxy.spacing / radius
    return ERROR * radius * share**ERROR_POWER, min(FORCE_ERROR * share**FORCE_POWER, 1.0)


def pace(model: Model) -> float:
    """Time this machine: [s] of computing for a second of motion, from a tick or three that nobody touches."""
    body, steps = create(model), model.substeps(TICK)
    best, spent = math.inf, 0.0
    while best == math.inf or spent < min(3 * best, 0.05):
        started = time.perf_counter()  # some systems count processor time in steps of many ticks
        body.step(Motion(1, steps, TICK))
        took = time.perf_counter() - started
        best, spent = min(best, took), spent + took
    return CONTACT * best / TICK


def _mesh_itself(model: Model, cost: float, reason: str) -> Plan:
    return Plan(
        proxy=None, asked=0, vertices=len(model.mass), steps=model.substeps(TICK), cost=cost, error=0.0,
        force_error=0.0, reason=reason,
    )  # fmt: skip


def _work(model: Model) -> str:
    return f"{len(model.mass):,} vertices at {model.substeps(TICK)} steps a millisecond"


def _times(speed: float) -> str:
    return f"{speed:.2g}x"
