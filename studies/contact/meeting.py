"""The contact in a step of a world, summed over the calls in it: what tests and the judge of contact look at."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from core.base import Floats
from core.world import World


class Meeting(NamedTuple):
    """The contact in a step.

    touching: largest number of pairs in contact.
    truncated: number of times that a vertex was stopped from passing through something.
    taken: momentum that these stops changed [N s].
    held_back: largest distance of a collider behind its prescribed motion at the end [m].
    forces: mean force on each surface over the step (k, 3) [N]: bodies, then colliders; sleeping bodies exert none.
    queries: number of proximity queries.
    moments: moments of the forces about the origin (k, 3) [N m].
    """

    touching: int
    truncated: int
    taken: float
    held_back: float
    forces: Floats
    queries: int
    moments: Floats


def met(world: World, seconds: float) -> Meeting:
    """Step a world and return the contact in that step."""
    world.step(seconds)
    return meeting_of(world)


def meeting_of(world: World) -> Meeting:
    """Return the contact in the last step of a world, which had a tick."""
    parts, seconds = world.parts, sum(part.ticks for part in world.parts) * world.sessions[0].clock.tick
    return Meeting(
        max(part.touching for part in parts), sum(part.truncated for part in parts),
        sum(part.taken for part in parts), float(parts[-1].late.max(initial=0.0)),
        np.sum([part.impulses for part in parts], axis=0) / seconds, sum(part.queries for part in parts),
        np.sum([part.moments for part in parts], axis=0) / seconds,
    )  # fmt: skip
