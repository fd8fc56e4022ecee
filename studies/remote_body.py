"""The body of a session while it runs in the servo's process: what Blender's side of the session sees of it.

It offers what `solver.backend.Body` does, so the session does not know: a step returns what has happened there since
the last look, positions are those of the newest frame. Whatever Blender does, the body runs on at the device's rate.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from core.base import DimpleError, Floats
from core.body.model import Model
from core.haptics.mailbox import Mailbox
from core.haptics.parcel import Change, frame_size, pack_changes, unpack_frame
from core.haptics.servo_messages import ServoReport
from core.solver.motion import Frame, Motion, PinMotion

if TYPE_CHECKING:
    from core.haptics.contact_rendering import Workspace
    from core.solver.backend import Body

Place = tuple["Workspace", float]


@dataclass(slots=True, eq=False)
class RemoteBody:
    """A body that runs in the servo's process.

    local: the body it was, which takes over again when the device goes.
    model: what moves.
    surface: the model below whose surface at rest fingertips are measured.
    after: number of the last parcel before its own.
    own: which fingertips of the session are the device's; the others are sent there.
    """

    local: Body
    surface: Model
    model: Model = field(init=False)
    after: int = 0
    own: frozenset[int] = frozenset((0, 1, 2))
    _changes: list[Change] = field(default_factory=list)
    _frames: Mailbox | None = None
    _seen: int = 0
    _newest: tuple[Frame, int, bytes] | None = None
    _placed: Floats | None = None
    _place: Place | None = None
    _pressed: tuple[object, ...] = ()

    def __post_init__(self) -> None:
        self.model = self.local.model
        positions, velocities = self.local.positions(), self.local.velocities()
        self._frames = Mailbox(size=frame_size(positions.shape[1]), slots=1)
        self._placed = positions
        self._changes.append(("body", self.model, self.surface, positions, velocities, str(self._frames.path)))

    def parcel(self, report: ServoReport) -> bytes | None:
        """Return what is to be sent, None while the last parcel is on its way or nothing has changed."""
        if not self._changes or report.parcel < self.after:
            return None
        changes, self._changes, self.after = self._changes, [], report.parcel + 1
        return pack_changes(changes)

    def is_known(self, report: ServoReport) -> bool:
        """Tell whether a report is of this body."""
        return report.parcel >= self.after > 0 and not any(change[0] == "body" for change in self._changes)

    def set_place(self, workspace: Workspace, radius: float) -> None:
        """Place the device and its fingertips of a radius [m] in the session."""
        if self._place != (workspace, radius):
            self._place = workspace, radius
            self._changes.append(("place", workspace.origin, workspace.scale, workspace.turn, radius))

    def set_constants(self, model: Model, *, surface: Model | None = None) -> None:
        """Give the body the numbers of other models of the same meshes."""
        self.local.set_constants(model, surface=surface)
        self.model = model
        self.surface = surface or self.surface
        self._changes.append(("constants", model, self.surface))

    def set_rest(self, rest: Floats, rate: Floats | None = None) -> None:
        """Refuse: what goes to the other process knows no shape at rest that moves."""
        raise DimpleError("A body in another process keeps its shape at rest.")

    @property
    def rest_volume(self) -> float:
        """Return the volume at rest [m3]."""
        return self.local.rest_volume

    def set_state(self, positions: Floats, velocities: Floats | None = None) -> None:
        """Put the vertices at positions (3, n) [m] with velocities (3, n) [m/s]."""
        self._placed, self._newest = np.array(positions, np.float64), None  # a frame of before does not count
        self._changes.append(("state", self._placed, velocities))

    def positions(self) -> Floats:
        """Return where the vertices are, (3, n) [m]."""
        self._look()
        if self._newest is None or self._placed is not None:
            assert self._placed is not None
            return self._placed.copy()
        return np.frombuffer(self._newest[2], np.float32).reshape(3, -1).astype(np.float64)

    def velocities(self) -> Floats:
        """Return velocities (3, n) [m/s]: none are kept on this side, so the body goes on from rest."""
        return np.zeros_like(self.positions())

    def step(self, motion: Motion) -> Frame:
        """Return what happened since the last look, as that of the motion's ticks: the body runs by itself."""
        pressed = tuple(
            (tip.last, tip.radius) if tip and i not in self.own else None for i, tip in enumerate(motion.fingertips)
        )
        if pressed != self._pressed and any((*pressed, *self._pressed)):
            self._changes.append(("pressed", pressed))
        self._pressed = pressed
        if motion.pins:
            self._lead(motion.pins)
        self._look()
        count = len(motion.fingertips)
        if self._newest is None:
            rest = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
            return Frame((None,) * count, rest, self.model.mesh.volume, 0.0, motion.ticks, True)
        frame, _, _ = self._newest
        seconds = motion.ticks * motion.tick
        touches = tuple(
            touch._replace(impulse=(touch.impulse[0] * seconds, touch.impulse[1] * seconds, touch.impulse[2] * seconds))
            if touch and tip else None
            for touch, tip in zip(frame.touches[:count], motion.fingertips, strict=True)
        )  # fmt: skip
        return frame._replace(touches=touches, ticks=motion.ticks)

    def end(self) -> bytes:
        """Let the body go on from where it is on this side; return the parcel that ends it on the other."""
        self.local.set_state(self.positions())
        if self._frames:
            self._frames.close()
        self._frames = None
        return pack_changes([("end",)])

    def _lead(self, pins: PinMotion) -> None:
        """Send where pinned vertices are by now."""
        at = pins.start + pins.last * (pins.end - pins.start)
        self._changes = [change for change in self._changes if change[0] != "pins"]
        self._changes.append(("pins", at))

    def _look(self) -> None:
        """Read the newest frame."""
        if self._frames is None:
            return
        self._seen, message = self._frames.read(0, frame_size(self.model.mass.size), self._seen)
        if message:
            self._newest = unpack_frame(message)
            if not any(change[0] == "state" for change in self._changes):
                self._placed = None
