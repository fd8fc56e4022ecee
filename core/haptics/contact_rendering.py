"""What a device lets feel of a running session: the measured law of each fingertip, as a local contact.

The force is Eq. (1), K(x) with the depth below the surface at rest, as in the paper: what is felt is what was
measured, whatever fingertip presses. Sideways a spring holds it to the place of the body that it stuck to, and
slips beyond the friction. (The simulation's own friction, a frame old, would shake the hand: it is a force held for
a frame.) Slopes steeper than the device can render are rendered as steep as it can; the panel says so.
"""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, field, replace

import numpy as np

from ..base import Floats
from ..body.model import Model
from ..material import Material
from ..mesh.depth import Touching
from ..session import Finger, Session
from .contact_model import Contact
from .messages import Report
from .vectors import Vector

# of the normal stiffness: a contact of a soft body gives way sideways by 2 (1 - nu) / (2 - nu), nu = 1/2. Mindlin 1949
SIDEWAYS = 2 / 3


@dataclass(frozen=True, slots=True)
class Workspace:
    """Place the device in a session: x_session = origin + scale * turn @ x_device.

    origin: (3,) [m].  scale: how much larger the session is.  turn: (3, 3) rotation.  Forces are divided by the scale,
    so that the stiffness felt is the material's at every scale.
    """

    origin: Vector = (0.0, 0.0, 0.0)
    scale: float = 1.0
    turn: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

    def to_session(self, at: Vector) -> Vector:
        """Return where a point of the device [m] is in the session [m]."""
        return _vector(np.array(self.origin) + self.scale * np.array(self.turn) @ np.array(at))

    def to_device(self, at: Floats) -> Floats:
        """Return where a point (3,) of the session [m] is on the device [m]."""
        return np.array(self.turn).T @ (at - np.array(self.origin)) / self.scale


def fingers(report: Report, place: Workspace, radius: float) -> list[Finger | None]:
    """Return the fingertips of a device, as large as a radius [m]; one whose sensor is not believed is lifted off."""
    return [None if tip.masked else Finger(place.to_session(tip.position), radius) for tip in report.tips]


def rendered(material: Material, cap: float) -> Material:
    """Return a material with the slopes a device can render."""
    return replace(material, K1=min(material.K1, cap), K2=min(material.K2, cap))


@dataclass(slots=True)
class Felt:
    """Follow what the fingertips of a session feel.

    stuck: for each, the place (3,) [m] in the shape at rest where it sticks to the body, None where it touches nothing.
    """

    stuck: dict[int, Floats] = field(default_factory=dict)

    def contacts(
        self, session: Session, place: Workspace, cap: float, now: float, others: Container[int] = ()
    ) -> tuple[Contact | None, ...]:
        """Return what each fingertip feels, in the space of the device.

        Args:
            cap: largest stiffness the device renders [N/m].  now: [s] of the clock that the servo reads too.
            others: fingertips of the session that are not the device's.
        """
        touches = [None if i in others else touch for i, touch in enumerate(session.touches())]
        self.stuck = {i: place for i, place in self.stuck.items() if i < len(touches) and touches[i]}
        return tuple(
            self._contact(session.model, i, touch, place, cap, now) if touch else None
            for i, touch in enumerate(touches)
        )

    def _contact(self, model: Model, i: int, touch: Touching, place: Workspace, cap: float, now: float) -> Contact:
        material = rendered(model.materials[int(model.mesh.triangle_material[touch.triangle])], cap)
        slope = material.K1 if touch.depth <= material.x0 else material.K2
        push = material.law(touch.depth)
        grip = self._grip(i, touch, SIDEWAYS * slope, material.friction * push)
        turned = np.array(place.turn).T
        return Contact(
            force=_vector(turned @ (push * touch.outward + grip) / place.scale),
            at=_vector(place.to_device(touch.centre)), normal=_vector(turned @ touch.outward),
            k_n=slope, k_t=SIDEWAYS * slope if touch.depth > 0 else 0.0, gap=max(-touch.depth, 0.0) / place.scale,
            friction=material.friction, stamp=now,
        )  # fmt: skip

    def _grip(self, i: int, touch: Touching, stiffness: float, most: float) -> Floats:
        """Return the force (3,) [N] sideways, at most so large [N]; beyond, the place it sticks to is dragged along."""
        if touch.depth <= 0:
            self.stuck.pop(i, None)
            return np.zeros(3)
        rotation, translation = touch.pose
        way = touch.centre - (rotation @ self.stuck.setdefault(i, touch.local) + translation)
        way -= (way @ touch.outward) * touch.outward
        grip = -stiffness * way
        over = float(np.linalg.norm(grip)) / max(most, 1e-9)
        if over > 1:
            grip, way = grip / over, way / over
        self.stuck[i] = rotation.T @ (touch.centre - way - translation)
        return grip


def _vector(a: Floats) -> Vector:
    x, y, z = (float(c) for c in a)
    return x, y, z
