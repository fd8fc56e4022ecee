"""A fingertip that is pushed by a force: a rigid sphere which moves along the direction of its press.

    m a = F - R - c v

F is what it is pushed with, R what the body gave it at the end of the last tick (the mean over a tick is that of its
middle, and would take half a tick times the slope of R from c), c so large that it comes to rest without bouncing.
Damping is taken at the end of the tick and the reaction at its begin, so it is stable while m is larger than K dt^2 (K
the slope of the contact, several times the law's where a body is stiff under a fingertip) and than the skin it moves
with it; m is chosen so, and changes the way to the rest but not the rest itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..base import FINGER_TRAVEL
from ..body.model import Model

LEAST_MASS = 0.05  # [kg] that of a fingertip with its bones
SAFETY = 4.0  # times the skin's mass at which it would be unstable
FACE_SAFETY = 2.0  # times that of the heaviest face at its middle: a coarse skin moves whole faces
SLOPE_SAFETY = 16.0  # times that of the law's slope
SKIN_REACH = 2.0  # radii: so far the skin moves with a fingertip


@dataclass(frozen=True, slots=True, kw_only=True)
class Pushed:
    """Where such a fingertip is: its way along the press [m] and its speed on it [m/s]."""

    way: float
    speed: float = 0.0


def mass_and_damping(model: Model, radius: float, tick: float) -> tuple[float, float]:
    """Return the effective mass [kg] and the damping [N s/m] of a fingertip of a radius [m] on a body."""
    softest = min(min(material.K1, material.K2) for material in model.materials)
    stiffest = max(max(material.K1, material.K2) for material in model.materials)
    skin = float(model.mass.sum() / model.mesh.triangle_areas.sum()) * math.pi * (SKIN_REACH * radius) ** 2
    mass = max(LEAST_MASS, SAFETY * skin, FACE_SAFETY * model.face_mass, SLOPE_SAFETY * stiffest * tick**2)
    return mass, 2 * math.sqrt(math.sqrt(softest * stiffest) * mass)


def advance(
    pushed: Pushed, force: float, reaction: float, *, model: Model, radius: float, tick: float
) -> Pushed:
    """Return where a fingertip is a tick [s] later.

    Args:
        force: along the press, that pushes it [N].
        reaction: along the press, that the body gave it last [N]; negative where it pushes it out.
    """
    mass, damping = mass_and_damping(model, radius, tick)
    speed = (mass * pushed.speed + tick * (force + reaction)) / (mass + tick * damping)
    most = FINGER_TRAVEL * radius / tick  # faster, it would skip over the skin
    speed = min(max(speed, -most), most)
    return Pushed(way=pushed.way + tick * speed, speed=speed)
