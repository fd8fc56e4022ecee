"""Contact rendering: the measured law of each fingertip in a running session, as a local contact for the servo.

The rendered force is that of the measured law at the depth below the surface at rest, as in the paper, Eq. (1), and not
the force of the simulated contact, for three reasons:

- What the hand is given is then what was measured, whatever the mesh, the step and the fingertip.
- The law is known beyond the frame: its slope gives the servo a stiffness to evaluate 1000 times a second. The
  simulated force is a frame old, and held for a frame it is stable only below 217 N/m.
- As a function of the depth alone it creates no energy: the hand gets back what it put in.

Sideways a spring pulls the fingertip to the place of the body that it sticks to, and slips beyond the friction; the
simulation's own friction would be a force held for a frame. Slopes steeper than the device can render are rendered as
steep as it can, and the panel says so.
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
from ..vectors import Vector
from .contact_model import SIDEWAYS, Contact, wall_slope
from .servo_messages import ServoReport


@dataclass(frozen=True, slots=True)
class Workspace:
    """The place of the device in a session: x_session = origin + scale * turn @ x_device.

    origin: (3,) [m].
    scale: how much larger the session is. Forces are divided by it, so that the rendered stiffness is the material's
        at every scale.
    turn: (3, 3) rotation.
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


def fingers(report: ServoReport, workspace: Workspace, radius: float) -> list[Finger | None]:
    """Return a device's fingertips of a radius [m] in a session; None for one whose sensor is not trusted."""
    return [None if tip.masked else Finger(workspace.to_session(tip.position), radius) for tip in report.tips]


def rendered(material: Material, cap: float) -> Material:
    """Return a material with the slopes that a device can render, no steeper than a cap [N/m]."""
    return replace(material, K1=min(material.K1, cap / material.power**2), K2=min(material.K2, cap))


@dataclass(slots=True)
class ContactRendering:
    """The contacts that a device renders of one session.

    stuck: for each fingertip the place (3,) [m] in the shape at rest where it sticks to the body; none where it
        touches nothing.
    """

    stuck: dict[int, Floats] = field(default_factory=dict)

    def contacts(
        self, session: Session, workspace: Workspace, cap: float, now: float, others: Container[int] = ()
    ) -> tuple[Contact | None, ...]:
        """Return the contact of each fingertip, in the space of the device.

        Args:
            session: what the fingertips press.
            workspace: where the device is in it.
            cap: largest stiffness the device renders [N/m].
            now: [s] of the clock that the servo reads too.
            others: fingertips of the session that are not the device's.
        """
        touches = [None if i in others else touch for i, touch in enumerate(session.touches())]
        self.stuck = {i: place for i, place in self.stuck.items() if i < len(touches) and touches[i]}
        return tuple(
            self._contact(session.model, i, touch, workspace, cap, now) if touch else None
            for i, touch in enumerate(touches)
        )

    def _contact(self, model: Model, i: int, touch: Touching, workspace: Workspace, cap: float, now: float) -> Contact:
        material = rendered(model.materials[int(model.mesh.triangle_material[touch.triangle])], cap)
        slope = wall_slope(material, touch.depth)
        push = material.law(touch.depth)
        grip = self._grip(i, touch, SIDEWAYS * slope, material.friction * push)
        turned, scale = np.array(workspace.turn).T, workspace.scale
        return Contact(
            force=_vector(turned @ (push * touch.outward + grip) / scale),
            at=_vector(workspace.to_device(touch.centre)), normal=_vector(turned @ touch.outward),
            k_n=slope, k_t=SIDEWAYS * slope if touch.depth > 0 else 0.0, gap=max(-touch.depth, 0.0) / scale,
            friction=material.friction, stamp=now,
        )  # fmt: skip

    def _grip(self, i: int, touch: Touching, stiffness: float, limit: float) -> Floats:
        """Return the force (3,) [N] sideways, limited [N]; beyond the limit the place it sticks to is dragged along."""
        if touch.depth <= 0:
            self.stuck.pop(i, None)
            return np.zeros(3)
        rotation, translation = touch.pose
        way = touch.centre - (rotation @ self.stuck.setdefault(i, touch.local) + translation)
        way -= (way @ touch.outward) * touch.outward
        grip = -stiffness * way
        over = float(np.linalg.norm(grip)) / max(limit, 1e-9)
        if over > 1:
            grip, way = grip / over, way / over
        self.stuck[i] = rotation.T @ (touch.centre - way - translation)
        return grip


def _vector(a: Floats) -> Vector:
    x, y, z = (float(c) for c in a)
    return x, y, z
