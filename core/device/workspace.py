"""The place of a device in a session: converts fingertips into the session, and the surface under each back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from ..constants import FACTORS
from ..material import Indenter, law_force
from ..native.motion import Touch
from ..other_tip import FARTHEST
from ..session import Finger, Session
from ..vectors import ZERO, Vector, along, dot, scaled
from .limits import SIDEWAYS
from .orders import ServoReport
from .rendered_surface import Law, Surface

LawAt = Callable[[Sequence[float]], Sequence[float]]
OtherTip = tuple[float, LawAt]  # its radius [m], and its forces [N] as a function of depths [m] at its place


@dataclass(frozen=True, slots=True)
class Workspace:
    """The place of the device in a session: x_session = origin + scale * turn @ x_device.

    origin: (3,) [m].
    scale: size of the session relative to the device's space. Forces are divided by it, so that the rendered stiffness
        is the material's at every scale.
    turn: (3, 3) rotation.
    """

    origin: Vector = ZERO
    scale: float = 1.0
    turn: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

    def to_session(self, at: Vector) -> Vector:
        """Return the position in the session [m] of a point of the device [m]."""
        a, b, c = self.turn
        return along(self.origin, (dot(a, at), dot(b, at), dot(c, at)), self.scale)

    def to_device(self, at: Vector) -> Vector:
        """Return the position in the device's space [m] of a point of the session [m]."""
        return scaled(self.turned(along(at, self.origin, -1.0)), 1 / self.scale)

    def turned(self, way: Vector) -> Vector:
        """Return a direction of the session in the space of the device."""
        (a, b, c), (x, y, z) = self.turn, way
        return along(along(scaled(a, x), b, y), c, z)


def fingers(report: ServoReport, workspace: Workspace, radius: float) -> list[Finger | None]:
    """Return a device's fingertips as those of a session, of a radius [m]; None for one with an untrusted sensor."""
    return [None if tip.masked else Finger(workspace.to_session(tip.position), radius) for tip in report.tips]


def surfaces_of(
    session: Session, touches: Sequence[Touch | None], workspace: Workspace, now: float
) -> list[Surface | None]:
    """Return the surface under each fingertip of a session, see `surface_of`."""
    return [surface_of(touch, workspace, now, other_tip(session, i)) for i, touch in enumerate(touches)]


def other_tip(session: Session, index: int) -> OtherTip | None:
    """Return the radius and law of a session's fingertip, None if it is lifted or is the tip that measured them all."""
    finger = session.fingers[index] if index < len(session.fingers) else None
    if finger is None:
        return None
    ball = Indenter(shape="sphere", radius=finger.radius)
    if all(material.indenter == ball for material in session.model.materials):
        return None
    return finger.radius, partial(session.law, index)


def surface_of(
    touch: Touch | None, workspace: Workspace, now: float, other: OtherTip | None = None
) -> Surface | None:
    """Return the surface under a fingertip in the space of the device, None if there is none.

    Args:
        touch: its contact with a body.
        workspace: the place of the device in the session.
        now: time of the clock that the servo also reads [s].
        other: the tip, if it is not the one that measured.
    """
    if touch is None or touch.triangle < 0:
        return None
    K1, K2, x0, power = touch.law
    factors, deepest = _factors(touch.law, *other) if other else ((), 0.0)
    law = Law(K1, K2, x0 / workspace.scale, power, factors, deepest / workspace.scale)
    anchor = workspace.to_device(anchor_of(touch)) if touch.depth > 0 else None
    return Surface(
        place=workspace.to_device(along(touch.centre, touch.outward, touch.depth)),
        normal=workspace.turned(touch.outward), anchor=anchor, law=law, friction=touch.friction, stamp=now,
    )  # fmt: skip


def anchor_of(touch: Touch) -> Vector:
    """Return the anchor [m] to which friction, as a spring, holds the centre of a touching fingertip."""
    pressed, push = dot(touch.force, touch.outward), law_force(touch.depth, *touch.law)
    if not (pressed > 0 and push > 0):
        return touch.centre
    return along(touch.centre, along(touch.force, touch.outward, -pressed), touch.depth / (SIDEWAYS * push))


def _factors(law: tuple[float, float, float, float], radius: float, law_at: LawAt) -> tuple[tuple[float, ...], float]:
    """Return the factors of a tip on the force of a law, and the deepest of their depths [m]."""
    deepest = FARTHEST * max(radius, law[2])
    depths = [deepest * (max(k, 0.25) / (FACTORS - 1)) ** 2 for k in range(FACTORS)]
    pairs = [(force, law_force(x, *law)) for force, x in zip(law_at(depths), depths, strict=True)]
    return tuple([force / plain if plain > 0 else 0.0 for force, plain in pairs]), deepest
