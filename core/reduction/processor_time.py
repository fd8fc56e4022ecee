"""What a body costs to simulate: counted, not timed, so that it is the same whatever else the computer does."""

from __future__ import annotations

from ..base import TICK
from ..body.model import Model
from ..messages import Message

BUDGET = 0.6  # [s] per second for the simulation; Blender needs the rest to draw
COST = 1.4e-8  # [s] a vertex and step: measured once (tests/bench), and kept
ESTIMATED = 1.05  # times the budget may what runs live be expected to cost: no cost is known better than that


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
