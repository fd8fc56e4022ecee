"""What a device lets feel of a running session: the measured law of each fingertip, as a local contact.

The force is Eq. (1), K(x) with the depth below the surface at rest, as in the paper: what is felt is what was
measured, whatever fingertip presses. Sideways it is the friction of the simulation. Slopes steeper than the device
can render are rendered as steep as it can, and `renderings` says so.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..base import Floats
from ..depth import Touching
from ..material import Material
from ..session import Session
from .contact_model import Contact
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


@dataclass(frozen=True, slots=True)
class Rendering:
    """Hold what a device makes of a slope of the law: asked and rendered [N/m]."""

    asked: float
    rendered: float

    @property
    def whole(self) -> bool:
        """Tell whether the device can render it."""
        return self.rendered >= self.asked


def renderings(material: Material, cap: float) -> tuple[Rendering, Rendering]:
    """Return what a device with a largest stiffness [N/m] makes of K1 and K2."""
    first, second = (Rendering(slope, min(slope, cap)) for slope in (material.K1, material.K2))
    return first, second


def rendered(material: Material, cap: float) -> Material:
    """Return a material with the slopes a device can render."""
    return replace(material, K1=min(material.K1, cap), K2=min(material.K2, cap))


def contacts(session: Session, place: Workspace, cap: float, now: float) -> tuple[Contact | None, ...]:
    """Return what each fingertip of a session feels, in the space of the device.

    Args:
        cap: largest stiffness the device renders [N/m].  now: [s] of the clock that the servo reads too.
    """
    forces = session.frame.finger_forces
    return tuple(
        _contact(session, touch, forces[i] if i < len(forces) else np.zeros(3), place, cap, now) if touch else None
        for i, touch in enumerate(session.touches())
    )


def _contact(session: Session, touch: Touching, force: Floats, place: Workspace, cap: float, now: float) -> Contact:
    model = session.model
    material = rendered(model.materials[int(model.mesh.triangle_material[touch.triangle])], cap)
    slope = material.K1 if touch.depth <= material.x0 else material.K2
    out = touch.outward
    grip = force - (force @ out) * out
    felt = material.law(touch.depth) * out + (grip if touch.depth > 0 else 0.0)
    turned = np.array(place.turn).T
    return Contact(
        force=_vector(turned @ felt / place.scale), at=_vector(place.to_device(touch.centre)),
        normal=_vector(turned @ out), k_n=slope, k_t=SIDEWAYS * slope if touch.depth > 0 else 0.0,
        gap=max(-touch.depth, 0.0) / place.scale, friction=material.friction, stamp=now,
    )  # fmt: skip


def _vector(a: Floats) -> Vector:
    x, y, z = (float(c) for c in a)
    return x, y, z
