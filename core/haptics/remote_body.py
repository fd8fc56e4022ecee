"""The body of a session while it runs in the servo's process: what Blender's side of the session sees of it.

It offers what `solver.backend.Body` does, so the session does not know: a step returns what has happened there since
the last look, positions are those of the newest frame. Whatever Blender does, the body runs on at the device's rate.

Without a device the body stays with Blender. At 5 frames a second 2,402 vertices keep real time there, with a fifth of
each frame (6 simulated seconds a second of processor); of 10,088 (1.1) the default share of the processor leaves 0.66
of real time: a second core, without contact and rigs, would win a third, which a larger *Simulation Share* gives too.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ..base import DimpleError, Floats
from ..body.model import Model
from ..solver.motion import Frame, Motion, PinMotion
from .mailbox import Mailbox
from .parcel import Change, frame_size, pack_changes, unpack_frame
from .servo_messages import ServoReport

if TYPE_CHECKING:
    from ..solver.backend import Body
    from .contact_rendering import Workspace

_UNMOVED = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)  # pose of the shape at rest


@dataclass(slots=True, eq=False)
class Parcels:
    """What is to be sent to the servo's process, one parcel after the other.

    changes: not sent yet.
    sent: number of the last parcel.
    body: number of the parcel with the last body, 0 for none.
    """

    changes: list[Change] = field(default_factory=list)
    sent: int = 0
    body: int = 0

    def take(self, report: ServoReport) -> bytes | None:
        """Return what is to be sent, None while the last parcel is on its way or nothing has changed."""
        if not self.changes or report.parcel < self.sent:
            return None
        self.sent += 1
        if any(change[0] == "body" for change in self.changes):
            self.body = self.sent
        parcel = pack_changes(self.changes)
        self.changes.clear()
        return parcel

    def is_known(self, report: ServoReport) -> bool:
        """Tell whether a report is of the last body."""
        return report.parcel >= self.body > 0 and not any(change[0] == "body" for change in self.changes)


@dataclass(slots=True, eq=False)
class RemoteBody:
    """A body in the servo's process. It is built there from now on, and runs there once it has begun.

    local: the body it was, which takes over again when the device goes.
    surface: the model below whose surface at rest fingertips are measured.
    parcels: what goes there.
    model: what moves.
    """

    local: Body
    surface: Model
    parcels: Parcels
    model: Model = field(init=False)
    _frames: Mailbox = field(init=False)
    _seen: int = 0
    _newest: tuple[Frame, bytes] | None = None
    _placed: Floats | None = None  # where it was put
    _since: int = 0  # number of the parcel that put it there: frames of before do not count
    _place: tuple[Workspace, float] | None = None

    def __post_init__(self) -> None:
        self.model = self.local.model
        self._frames = Mailbox(size=frame_size(self.model.mass.size), slots=1)
        self.parcels.changes.append(("body", *_without_notes(self.model, self.surface), str(self._frames.path)))

    def begin(self, surface: Model) -> None:
        """Run from where the local body is, above a surface that may have other numbers by now."""
        if self.local.model is not self.model or surface is not self.surface:
            self.set_constants(self.local.model, surface=surface)
        self.set_state(self.local.positions(), self.local.velocities())

    def end(self) -> None:
        """Let the local body go on from where this one is."""
        if self._placed is not None:  # it has begun
            self.local.set_state(self.positions())
        self._frames.close()
        self.parcels.changes.append(("end",))

    def set_place(self, workspace: Workspace, radius: float) -> None:
        """Place the device and its fingertips of a radius [m] in the session."""
        if self._place != (workspace, radius):
            self._place = workspace, radius
            self.parcels.changes.append(("place", workspace.origin, workspace.scale, workspace.turn, radius))

    def set_constants(self, model: Model, *, surface: Model | None = None) -> None:
        """Give the body the numbers of other models of the same meshes."""
        if model is not self.local.model:
            self.local.set_constants(model, surface=surface)
        self.model, self.surface = model, surface or self.surface
        self.parcels.changes.append(("constants", *_without_notes(model, self.surface)))

    def set_rest(self, rest: Floats, rate: Floats | None = None) -> None:
        """Refuse: what goes to the other process knows no shape at rest that moves."""
        raise DimpleError("A body beside the device keeps its shape at rest.")

    def set_load(self, load: Floats | None) -> None:
        """Do without: beside the device other constants act at once."""

    @property
    def rest_volume(self) -> float:
        """Return the volume at rest [m3]."""
        return self.local.rest_volume

    def set_state(self, positions: Floats, velocities: Floats | None = None) -> None:
        """Put the vertices at positions (3, n) [m] with velocities (3, n) [m/s]."""
        self._placed, self._newest, self._since = np.array(positions, np.float64), None, self.parcels.sent + 1
        self.parcels.changes.append(("state", self._placed, velocities))

    def positions(self) -> Floats:
        """Return where the vertices are, (3, n) [m]."""
        self._look()
        if self._newest is None:
            assert self._placed is not None
            return self._placed.copy()
        return np.frombuffer(self._newest[1], np.float32).reshape(3, -1).astype(np.float64)

    def velocities(self) -> Floats:
        """Return velocities (3, n) [m/s]: none are kept on this side, so the body goes on from rest."""
        return np.zeros_like(self.positions())

    def step(self, motion: Motion) -> Frame:
        """Return what happened since the last look, as that of the motion's ticks: the body runs by itself."""
        if motion.pins:
            self._lead(motion.pins)
        self._look()
        if self._newest is None:
            nothing = (None,) * len(motion.fingertips)
            return Frame(nothing, _UNMOVED, self.model.mesh.volume, 0.0, motion.ticks, True)
        frame, _ = self._newest
        seconds = motion.ticks * motion.tick
        touches = tuple(
            touch._replace(impulse=(touch.impulse[0] * seconds, touch.impulse[1] * seconds, touch.impulse[2] * seconds))
            if touch and tip else None
            for touch, tip in zip(frame.touches[: len(motion.fingertips)], motion.fingertips, strict=True)
        )  # fmt: skip
        return frame._replace(touches=touches, ticks=motion.ticks)

    def _lead(self, pins: PinMotion) -> None:
        """Send where pinned vertices are by now."""
        at = pins.start + pins.last * (pins.end - pins.start)
        changes = self.parcels.changes
        changes[:] = [change for change in changes if change[0] != "pins"]
        changes.append(("pins", at))

    def _look(self) -> None:
        """Read the newest frame."""
        self._seen, message = self._frames.read(0, frame_size(self.model.mass.size), self._seen)
        if message:
            frame, parcel, positions = unpack_frame(message)
            if parcel >= self._since:
                self._newest = frame, positions


def _without_notes(model: Model, surface: Model) -> tuple[Model, Model]:
    """Return two models, or one twice, without their sentences for the artist: those may be of Blender's side."""
    bare = replace(model, notes=())
    return bare, bare if surface is model else replace(surface, notes=())
