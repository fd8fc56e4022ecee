"""The body that runs in the process of the haptic device, one tick each tick of the device, in place of Blender's.

One body at a time does: the one that is nearest to a fingertip. Another takes its place only while none is touched. A
body that is too heavy for the device's rate stays with Blender, and a local wall of its law is rendered.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..core.haptics.contact_rendering import Workspace
    from ..core.haptics.remote_body import RemoteBody
    from ..core.haptics.servo_messages import ServoReport
    from .sessions import LiveBody

HEAVIEST = 0.6  # [s] of processor time for a second of the body: the device's process answers too, and posts frames
TOO_HEAVY = (
    '"{name}" would take {share:.0%} of the time of the device\'s process, so a local wall of its law is rendered. '
    "Simulate a proxy to feel the model itself."
)
NO_CORE = "There is no native core for this machine, so a local wall of the measured law is rendered."


@dataclass(slots=True, eq=False)
class Beside:
    """What runs beside the device.

    body: the body, None where none does.
    remote: it, as its session sees it.
    reason: why none does, for the artist.
    """

    body: LiveBody | None = None
    remote: RemoteBody | None = None
    reason: str = ""
    _costs: dict[LiveBody, tuple[object, float]] = field(default_factory=dict)  # of the model that was measured
    _refused: dict[LiveBody, object] = field(default_factory=dict)
    _left: bytes | None = None

    def choose(self, bodies: Sequence[LiveBody], report: ServoReport) -> LiveBody | None:
        """Return the body that runs beside the device from now on, None where a local wall is to be rendered."""
        from ..core.haptics.remote_body import RemoteBody
        from ..core.haptics.servo_messages import BodyState

        if self.body and (self.body not in bodies or self.body.session.body is not self.remote):
            self._let_go()
        if self.body and report.body is BodyState.REFUSED and self.remote and self.remote.is_known(report):
            self._refused[self.body], self.reason = self.body.session.body.model, report.note
            self.take_back()
        nearest = min(bodies, key=_distance, default=None)
        if nearest is None or (self.body and (nearest is self.body or _distance(self.body) <= 0)):
            return self.body
        if not self._fits(nearest):
            self.take_back()
            return None
        self.take_back()
        session = nearest.session
        session.body = self.remote = RemoteBody(session.body, session.model, after=report.parcel)
        self.body, self.reason = nearest, ""
        return nearest

    def parcel(self, where: Workspace, radius: float, report: ServoReport) -> bytes | None:
        """Return what is to be sent to the body now; the device's place in it, and its fingertips' radius [m]."""
        assert self.body and self.remote
        self._left = None
        self.remote.own = frozenset(range(3)) - self.body.poked
        self.remote.set_place(where, radius)
        return self.remote.parcel(report)

    def last_parcel(self) -> bytes | None:
        """Return what ends the body in the device's process, once."""
        left, self._left = self._left, None
        return left

    def take_back(self) -> None:
        """Let the body run in Blender again, from where it is."""
        if self.body and self.remote and self.body.session.body is self.remote:
            self.body.session.body = self.remote.local
        self._let_go()

    def _let_go(self) -> None:
        if self.remote:
            self._left = self.remote.end()
        self.body = self.remote = None

    def _fits(self, body: LiveBody) -> bool:
        """Tell whether a body is light enough for the device's rate, by its measured cost."""
        from ..core.reduction.planner import measured_cost

        model = body.session.body.model
        if body.session.backend != "native":
            self.reason = NO_CORE
            return False
        if self._refused.get(body) is model:
            return False
        if self._costs.get(body, (None,))[0] is not model:
            self._costs = {body: (model, measured_cost(model))}
        cost = self._costs[body][1]
        if cost > HEAVIEST:
            self.reason = TOO_HEAVY.format(name=body.name, share=cost)
        return cost <= HEAVIEST


def _distance(body: LiveBody) -> float:
    """Return how far the nearest fingertip is from a body's surface [scene units], negative inside it."""
    touches = [touch for touch in body.session.touches() if touch]
    return min((-touch.depth / body.link.scale for touch in touches), default=float("inf"))
