"""The body that runs in the process of the haptic device, one tick each tick of the device, in place of Blender's.

One body at a time does: the one that is nearest to a fingertip. It is built there while Blender's goes on, and takes
over when it is built and no fingertip is near; another takes its place in the same way. Where a body is too fine for
the device's rate, or too coarse for a fingertip, Blender steps it and a local wall of its law is rendered.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..core.haptics.contact_rendering import Workspace
    from ..core.haptics.remote_body import Parcels, RemoteBody
    from ..core.haptics.servo_messages import ServoReport
    from .sessions import LiveBody

HEAVIEST = 0.7  # [s] of processor time for a second of the body: the device's process answers too, and posts frames
CLEAR_MM = 5.0  # of every fingertip from the body that takes over: none is inside before it has begun
TOO_COARSE = (
    "The mesh is too coarse for this fingertip, so a local wall is rendered. Set Simulate to Automatic, or use a "
    "larger fingertip."
)
RIGGED = "A rig moves this body, so a local wall of the measured law is rendered."


def _parcels() -> Parcels:
    from ..core.haptics.remote_body import Parcels

    return Parcels()


@dataclass(slots=True, eq=False)
class Beside:
    """What is built or runs beside the device.

    body: the body, None where there is none.
    remote: it, as its session sees it.
    reason: why none runs, for the artist.
    parcels: what goes to the device's process.
    """

    body: LiveBody | None = None
    remote: RemoteBody | None = None
    reason: str = ""
    parcels: Parcels = field(default_factory=_parcels)
    _looked: tuple[object, float] = (None, 0.0)  # what the reason is of: a model, and the fingertips' radius [m]

    @property
    def runs(self) -> bool:
        """Tell whether the session's body is the one beside the device."""
        return self.body is not None and self.body.session.body is self.remote

    def choose(self, bodies: Sequence[LiveBody], report: ServoReport, radius: float) -> None:
        """Bring up to date which body runs beside the device, or is built there, for fingertips of a radius [m]."""
        from ..core.haptics.servo_messages import BodyState

        known = self.parcels.is_known(report)
        if self.body and (self.body not in bodies or self._is_replaced(self.body)):
            self.take_back()
        if self.body and known and report.body is BodyState.REFUSED:
            self._looked, self.reason = (self.body.session.body.model, radius), report.note
            self.take_back()
        nearest = min(bodies, key=_distance_mm, default=None)
        if nearest is None or (self.runs and self.body is not nearest and _distance_mm(self.body) < CLEAR_MM):
            return
        fits = self._fits(nearest, radius)
        if nearest is not self.body or not fits:
            self.take_back()
            if fits:
                self._build(nearest)
        elif not self.runs and known and report.body is BodyState.BUILT and _distance_mm(nearest) > CLEAR_MM:
            session = nearest.session
            self.remote.begin(session.model)
            session.body = self.remote

    def parcel(self, report: ServoReport, where: Workspace | None = None, radius: float = 0.0) -> bytes | None:
        """Return what is to be sent now; where the device is in the body, and its fingertips' radius [m]."""
        if self.remote and where:
            self.remote.set_place(where, radius)
        return self.parcels.take(report)

    def take_back(self) -> None:
        """Let the body run in Blender again, from where it is."""
        if self.remote:
            self.remote.end()
            if self.runs:
                self.body.session.body = self.remote.local
        self.body = self.remote = None

    def _build(self, body: LiveBody) -> None:
        from ..core.haptics.remote_body import RemoteBody

        self.body = body
        self.remote = RemoteBody(body.session.body, body.session.model, self.parcels)

    def _is_replaced(self, body: LiveBody) -> bool:
        """Tell whether the session has another body by now: its mesh has changed."""
        return body.session.body not in (self.remote, self.remote.local)

    def _fits(self, body: LiveBody, radius: float) -> bool:
        """Tell whether a body can run there; its vertices and steps decide, so that it is the same every time."""
        from ..core.haptics.body_host import TOO_FINE
        from ..core.mesh.refine import is_coarse
        from ..core.reduction.processor_time import cost_of

        model = body.session.body.model
        if self._looked[0] is not model or self._looked[1] != radius:
            self._looked, self.reason = (model, radius), ""
            if model.rigged:
                self.reason = RIGGED
            elif cost_of(model) > HEAVIEST:
                self.reason = TOO_FINE
            elif is_coarse(model.mesh.rest_positions, model.mesh.triangles, radius):
                self.reason = TOO_COARSE
        return not self.reason


def _distance_mm(body: LiveBody) -> float:
    """Return how far the nearest fingertip is from a body's surface [mm], negative inside it."""
    return min((-1e3 * touch.depth for touch in body.session.touches() if touch), default=float("inf"))
