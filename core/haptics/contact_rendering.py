"""Contact rendering: the touch of a fingertip in a frame, as a local contact for the servo.

The force is that of the touch: the measured law at the depth of the fingertip, Eq. (1), and friction. A force held for
a frame would be stable only below 217 N/m; the slope of the law lets the servo evaluate it 1000 times a second. What
is steeper than the device can render is rendered as steep as it can, and the panel says so.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..material import law_force, law_slope
from ..native.motion import Touch
from ..session import Finger
from ..vectors import ZERO, Vector, along, dot, scaled
from .contact_model import Contact
from .servo_messages import ServoReport

Law = tuple[float, float, float, float]  # of a touch: K1, K2 [N/m], x0 [m] and the power
# of force over depth: a contact of a soft body yields sideways by 2 (1 - nu) / (2 - nu), nu = 1/2. Mindlin 1949
SIDEWAYS = 2 / 3


@dataclass(frozen=True, slots=True)
class Workspace:
    """The place of the device in a session: x_session = origin + scale * turn @ x_device.

    origin: (3,) [m].
    scale: how much larger the session is. Forces are divided by it, so that the rendered stiffness is the material's
        at every scale.
    turn: (3, 3) rotation.
    """

    origin: Vector = ZERO
    scale: float = 1.0
    turn: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

    def to_session(self, at: Vector) -> Vector:
        """Return where a point of the device [m] is in the session [m]."""
        a, b, c = self.turn
        return along(self.origin, (dot(a, at), dot(b, at), dot(c, at)), self.scale)

    def to_device(self, at: Vector) -> Vector:
        """Return where a point of the session [m] is on the device [m]."""
        return scaled(self.turned(along(at, self.origin, -1.0)), 1 / self.scale)

    def turned(self, way: Vector) -> Vector:
        """Return a direction of the session in the space of the device."""
        (a, b, c), (x, y, z) = self.turn, way
        return along(along(scaled(a, x), b, y), c, z)


def fingers(report: ServoReport, workspace: Workspace, radius: float) -> list[Finger | None]:
    """Return a device's fingertips of a radius [m] in a session; None for one whose sensor is not trusted."""
    return [None if tip.masked else Finger(workspace.to_session(tip.position), radius) for tip in report.tips]


def rendered(law: Law, cap: float) -> Law:
    """Return a law with the slopes that a device can render, no steeper than a cap [N/m]."""
    K1, K2, x0, power = law
    return min(K1, cap / power**2), min(K2, cap), x0, power


def wall_slope(law: Law, depth: float) -> float:
    """Return the stiffness [N/m] of a contact at a depth [m]: of a law that begins without any, K1 at the least.

    Until the next frame the fingertip may be deeper, and a contact that is too soft there gives more than it took.
    """
    return max(law_slope(depth, *law), min(law[:2]))


def contact_of(touch: Touch | None, workspace: Workspace, cap: float, now: float) -> Contact | None:
    """Return the contact of a fingertip in the space of the device, None where it meets no surface.

    Args:
        touch: how it meets a body.
        workspace: where the device is in the session.
        cap: largest stiffness the device renders [N/m].
        now: [s] of the clock that the servo reads too.
    """
    if touch is None or touch.triangle < 0:
        return None
    law, outward, scale = rendered(touch.law, cap), touch.outward, workspace.scale
    slope, push, pressed = wall_slope(law, touch.depth), law_force(touch.depth, *law), dot(touch.force, touch.outward)
    grip = along(touch.force, outward, -pressed)
    force = along(scaled(outward, push), grip, push / pressed if pressed > 0 else 0.0)  # as much friction as of the law
    return Contact(
        force=scaled(workspace.turned(force), 1 / scale), at=workspace.to_device(touch.centre),
        normal=workspace.turned(outward), k_n=slope, k_t=SIDEWAYS * push / touch.depth if push > 0 else 0.0,
        gap=max(-touch.depth, 0.0) / scale, friction=touch.friction, stamp=now,
    )  # fmt: skip
