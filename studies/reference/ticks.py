"""The loop every method shares: ticks of a path, equal substeps in a tick, contact after each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from core.base import Floats
from core.body.model import Model

from . import contact
from .constants import NEAR, TRAVEL
from .contact import Step, Touch
from .laws import State, forces
from .path import FingerPath

# advance(model, state, dt, acceleration): move a state in place by dt [s], contact apart. The acceleration (3, n)
# [m/s2] at the start is given where the step before left it, and returned where the next one may have it.
Advance = Callable[[Model, State, float, "Floats | None"], "Floats | None"]


def run_ticks(advance: Advance, model: Model, state: State, path: FingerPath, *, tick: float, substeps: int) -> Floats:
    """Advance a state in place by the ticks [s] of a path, each in equal substeps.

    Returns:
        the impulses (k, 3) [N s] on the fingertips.
    """
    total = np.zeros((len(path.radii), 3))
    acceleration = None
    for touches in each_tick(model, state, path, tick):
        near = [h for h in touches if len(h.vertices) or len(h.triangles)]
        alone, limit = model.ground is None and not near, min((h.radius for h in near), default=np.inf) * 2 * TRAVEL
        for i in range(substeps):
            before = state.positions.copy() if near else state.positions
            try:
                acceleration = advance(model, state, tick / substeps, acceleration if alone else None)
            except np.linalg.LinAlgError:  # no rigid motion fits a body that has blown up
                state.positions[:] = np.nan
                return total
            if near:
                slow_down(before, state.positions, limit)
            now = moved_back(touches, (substeps - 1 - i) * tick / substeps)
            total += meet(model, state, now, Step(tick / substeps, limit))[:, 0]
    return total


def slow_down(before: Floats, x: Floats, limit: float) -> None:
    """Let no vertex of x (3, n) move farther than a limit [m] from where it was before, in place.

    A deep press holds the skin with forces that would carry it past a fingertip within one substep. Velocities are
    left alone, so that the fingertip gets the whole impulse.
    """
    way = x - before
    length = np.sqrt((way * way).sum(axis=0))
    far = length > limit
    if far.any():
        x[:, far] = before[:, far] + way[:, far] * (limit / length[far])


def moved_back(touches: Sequence[Touch], seconds: float) -> list[Touch]:
    """Return where the fingertips were some seconds before."""
    return [replace(touch, centre=touch.centre - seconds * touch.velocity) for touch in touches]


def each_tick(model: Model, state: State, path: FingerPath, tick: float) -> Iterator[list[Touch]]:
    """Yield, for each tick [s] of a path, what the fingertips may touch in it."""
    for t in range(path.centres.shape[1] - 1):
        speed = float(np.sqrt((state.velocities**2).sum(axis=0).max(initial=0)))
        yield [
            reach(model, state, finger, start, end, radius, speed, tick)
            for finger, start, end, radius in zip(
                path.fingers, path.centres[:, t], path.centres[:, t + 1], path.radii, strict=False
            )
        ]


def acceleration_of(model: Model, state: State) -> Floats:
    """Return (3, n) [m/s2]; 0 where pinned: pinned vertices keep the velocity the session gave them."""
    return forces(model, state) * model.inverse_mass


def reach(
    model: Model, state: State, finger: int, start: Floats, end: Floats, radius: float, speed: float, tick: float
) -> Touch:
    """Find what a fingertip going from start to end (3,) may touch in a tick [s], vertices moving at speed [m/s]."""
    # what a body at rest touches is near too, though nothing moves
    margin = 2 * float(np.linalg.norm(end - start)) + 2 * speed * tick + NEAR * radius
    corners = model.mesh.triangles
    vertices, faces, radii = contact.candidates(
        state.positions, model.matching.rest, corners, model.inverse_mass, end, radius, margin
    )
    kept = state.kept.setdefault(finger, np.zeros((3, len(model.mass) + len(corners))))
    return Touch(
        centre=end, velocity=(end - start) / tick, radius=radius, vertices=vertices, triangles=corners[faces],
        radii=radii, faces=faces, kept=kept,
    )  # fmt: skip


def meet(model: Model, state: State, touches: Sequence[Touch], step: Step) -> Floats:
    """Resolve the contacts of a step in place.

    Returns:
        the impulses on the fingertips [N s] and their moments about the origin [N m s], (k, 2, 3).
    """
    x, v = state.positions, state.velocities
    skin = contact.Skin(model.friction, model.compliance)
    impulses = [contact.resolve(x, v, touch, model.inverse_mass, skin, step) for touch in touches]
    if model.ground is not None:
        contact.rest_on_ground(x, v, model.ground, model.inverse_mass, model.friction, step.dt)
    return np.array(impulses).reshape(-1, 2, 3)
