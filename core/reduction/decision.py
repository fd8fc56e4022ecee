"""Decide how a body is simulated, before anything is made: its full mesh where that runs live, else a proxy.

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
from contextlib import suppress
from dataclasses import dataclass, replace

from ..base import DimpleError
from ..body.model import Model
from . import processor_time
from .active_regions import may_rest, share_awake, slack_of
from .error_model import expected, vertices_for
from .grading import Pressed, share_of
from .processor_time import BUDGET, ESTIMATED, speed_of, work_of
from .proxy import LARGEST, most_of
from .slow_press import MOST, times_faster

TOLERANCE = 0.5e-3  # [m] between the surfaces, over the dent
FORCE_TOLERANCE = 0.1  # of the force: about the just-noticeable difference of a fingertip
# both are to be kept by 49 of 50 presses
MARGIN = 1.2  # bodies and places scatter about the fit: with this 49 of 50 presses keep tolerances of 10 to 30 %
STRETCH = 2.0  # times a tolerance: a proxy that runs live and misses it by no more beats one that does not run live
TOO_SLOW = 4.0  # times what runs live: where a full mesh takes more, the finest proxy that runs live beats it
COARSEST = 0.5  # of the force: the error of a proxy may then be as large
NEARLY_LIVE = 1.8  # times what runs live: a full mesh that takes no more beats a proxy that misses a tolerance


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
        cost = processor_time.cost_of(model)
        because = f"The full mesh would run at {speed_of(cost, budget)} real time ({work_of(model)})"
    except DimpleError:  # for any step; a proxy has longer edges, so it may take longer steps
        cost = math.inf
    decided = Decision(
        model=model, tolerance=tolerance, force_tolerance=force_tolerance, radius=radius, budget=budget, cost=cost,
        keeping=0, least=0, most=0, vertices=0, pressed=None, otherwise=None, because=because, reason="",
        alone=alone,
    )  # fmt: skip
    if cost <= ESTIMATED * budget:
        return replace(decided, reason=f"The full mesh runs live: {work_of(model)}.")
    if pressed and cost <= ESTIMATED * budget * MOST:
        faster, force_error = times_faster(model, pressed, tolerance, force_tolerance)
        if cost <= ESTIMATED * budget * faster:
            reason = (
                f"The presses are slow, so the full mesh runs live with 1/{faster} of its steps, within "
                f"{force_error:.0%} of the force: {work_of(model)}."
            )
            return replace(decided, reason=reason, faster=faster, cost=cost / faster)
    even, graded = _sized(decided, None), None
    rests = resting(decided, cost) if even.keeping > even.most else None
    if rests and rests.cost > NEARLY_LIVE * budget:
        rests = None
    if not (even.most == LARGEST and cost > TOO_SLOW * budget):  # a mesh that is hardly finer is the better one
        return rests or even
    with suppress(DimpleError):
        graded = _sized(decided, pressed.where) if pressed else None
    if graded and graded.vertices and even.keeping > even.most:
        return replace(graded, otherwise=rests or even)
    return rests or replace(even, otherwise=graded if graded and graded.vertices else None)


def resting(decided: Decision, cost: float) -> Decision | None:
    """Decide to step only what moves of a full mesh that costs so much [s]; None where none of it can rest."""
    model, radius = decided.model, decided.radius
    if not (decided.alone and may_rest(model) and cost < math.inf):
        return None
    slack = slack_of(decided.tolerance, radius)
    share = share_awake(model, radius, slack)
    less = share * cost
    live = less <= ESTIMATED * decided.budget
    speed = "which runs live" if live else f"at {speed_of(less, decided.budget)} real time"
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
    if least > most:
        return replace(decided, reason=anyway(decided, too_few(decided)))
    number = min(wanted, most)
    errors = expected(model, number, radius, share)
    reason = proxys_reason(decided.because, number, pressed, "is to be made", *errors)
    return replace(decided, vertices=number, reason=reason)


def anyway(decided: Decision, why: DimpleError) -> str:
    """Return the reason to simulate the full mesh though it is slow.

    Raises:
        DimpleError: it is too stiff.
    """
    processor_time.cost_of(decided.model)
    return f"{decided.because}. It is simulated anyway: {why}."


def proxys_reason(
    because: str, vertices: int, pressed: Pressed | None, speed: str, error: float, force_error: float
) -> str:
    reason = (
        f"{because}. A proxy of {vertices:,} vertices {speed}, within {1e3 * error:.2g} mm and "
        f"{force_error:.0%} of the force."
    )
    return f"{reason} It is fine where it will be pressed." if pressed else reason


def too_few(decided: Decision) -> DimpleError:
    near = f"{1e3 * decided.tolerance:.3g} mm and {decided.force_tolerance:.0%}"
    return DimpleError(f"no proxy of up to {decided.most:,} vertices is within {near}")
