"""Where the servo's process keeps the touched body: takes parcels, runs it beside the servo, posts frames.

Nothing here stalls the servo for long: modules are loaded before the device is greeted; a parcel is read after an
answer has left and its body built after the next, in a few milliseconds each for 5,000 vertices, for which a device
keeps its force. A body that blows up, is too heavy or cannot be read takes all force away, and its report says why.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ..errors import DimpleError
from ..vectors import ZERO, Vector, along, scaled
from .mailbox import Mailbox
from .parcel import Change, frame_size, pack_frame, parcel_path, unpack_changes
from .safety import LEASE
from .servo import Servo
from .servo_messages import BodyState, Order, ServoReport
from .wire import FINGERS

if TYPE_CHECKING:
    from .touched_body import TouchedBody

FRAME_EVERY: Final = 0.015  # [s] between two frames: a little faster than Blender draws
BLEW_UP: Final = (
    "The simulation blew up and was put back to rest. Lower k or K2, or raise the mass, then arm the device again."
)
FAILED: Final = "The body cannot run beside the device ({error}), so a local wall is rendered."
CHANGED: Final = "What is under the fingertips has changed. Lift them and arm the device again."
TOO_FINE: Final = (
    "This body is too fine to run at the device's rate, so a local wall is rendered. Simulate a proxy to feel the "
    "model."
)


class BodyHost:
    """The body in the servo's process.

    Args:
        mailbox: path of the mailbox: parcels lie beside it.

    Attributes:
        state: what became of the body.
        note: why it was refused.
        taken: number of the last parcel.
        touched: the body, None where there is none.
    """

    def __init__(self, mailbox: Path) -> None:
        self.state, self.note, self.taken = BodyState.NONE, "", 0
        self.touched: TouchedBody | None = None
        self._mailbox = mailbox
        self._parcel, self._changes = 0, deque[Change]()  # number of the parcel under way, and what is left of it
        self._frames: Mailbox | None = None
        self._changed = False  # another state, place or body: whatever is inside it now has not pressed it
        self._posted, self._since, self._answered = 0.0, 0, 0
        self._total: list[Vector] = [ZERO] * FINGERS

    def order(self, order: Order, servo: Servo, now: float) -> Order:
        """Return an order of Blender's with the contacts of the body, where one runs; begin to read a new parcel."""
        if order.parcel != self.taken and not self._changes:
            self._parcel = order.parcel
            try:
                self._changes.extend(read_parcel(parcel_path(self._mailbox, order.parcel)))
            except (OSError, DimpleError) as error:
                self._give_up(servo, FAILED.format(error=error))
            if not self._changes:
                self.taken = self._parcel
        if self.state is not BodyState.RUNS:
            return order
        shown = now - order.written <= LEASE
        return replace(order, contacts=servo.order.contacts, held_until=order.held_until if shown else 0.0)

    def joined(self, report: ServoReport) -> ServoReport:
        """Return a report with what became of the body."""
        note = report.note or (self.note if self.state is BodyState.REFUSED else "")
        load = self.touched.load if self.touched else 0.0
        return replace(report, note=note, body=self.state, parcel=self.taken, load=load)

    def _take(self, servo: Servo) -> None:
        """Make the changes of the parcel under way; those after a body wait for the next answer."""
        name = ""
        try:
            while self._changes and name != "body":
                name, *arguments = self._changes.popleft()
                CHANGES[name](self, servo, *arguments)
        except (OSError, DimpleError, AttributeError, LookupError, TypeError, ValueError, RuntimeError) as error:
            self._changes.clear()
            self._give_up(servo, FAILED.format(error=error))
        if not self._changes:
            self.taken = self._parcel

    def advance(self, servo: Servo, now: float) -> None:
        """Run one tick if the servo has answered a STATE, and give it the contacts for the next."""
        if self._changes:
            self._take(servo)
        if self.touched is None or self.state is not BodyState.RUNS or servo.answered == self._answered:
            return
        self._answered, touched = servo.answered, self.touched
        try:
            contacts = touched.advance(servo.places, servo.cap, now)
        except (RuntimeError, ValueError, ArithmeticError) as error:  # the native core refuses what is no number
            self._give_up(servo, FAILED.format(error=error))
            servo.order = replace(servo.order, contacts=())
            return
        if not touched.is_finite:
            servo.end(BLEW_UP)
            self._post(now)  # Blender puts it back to rest
            touched.body.set_state(touched.body.model.matching.rest)
            touched.lift()
            contacts = ()
        elif touched.is_too_heavy:
            self._give_up(servo, TOO_FINE)
            contacts = ()
        if self._changed and touched.is_inside:
            servo.end(CHANGED)
        self._changed = False
        servo.order = replace(servo.order, contacts=contacts)
        self._since += 1
        self._total = [along(total, force, 1.0) for total, force in zip(self._total, touched.forces, strict=True)]
        if self.touched and now - self._posted > FRAME_EVERY:
            self._post(now)

    def close(self) -> None:
        """Let go of the body."""
        if self._frames:
            self._frames.close()
        self.touched = self._frames = None

    # what a parcel may ask for: CHANGES, below

    def _change_body(self, servo: Servo, model: Any, surface: Any, frames: str) -> None:
        """Build a body; its frames go to a file. It runs once it has a state."""
        from .touched_body import TouchedBody

        self.close()
        self._frames = Mailbox(Path(frames), size=frame_size(len(model.mass)), slots=1)
        self.touched, self.state = TouchedBody(model, surface, servo.spec.tick), BodyState.BUILT
        self._since, self._total = 0, [ZERO] * FINGERS

    def _change_constants(self, _servo: Servo, model: Any, surface: Any) -> None:
        """Go on with the numbers of other models of the same meshes."""
        if self.touched:
            # the meshes are those it has: a pickle makes copies of them
            mine, below = self.touched.body.model, self.touched.surface
            self.touched.set_constants(replace(model, mesh=mine.mesh), replace(surface, mesh=below.mesh))

    def _change_state(self, _servo: Servo, positions: Any, velocities: Any) -> None:
        """Put the vertices somewhere, and run from there; no force remains."""
        if self.touched:
            self.touched.body.set_state(positions, velocities)
            self.state = BodyState.RUNS
            self._lift()

    def _change_place(self, _servo: Servo, origin: Vector, scale: float, turn: Any, radius: float) -> None:
        """Place the device in the session [m]."""
        if self.touched:
            self.touched.where = origin, scale, turn, radius
            self._lift()

    def _change_pins(self, _servo: Servo, pins: Any) -> None:
        """Lead pinned vertices (3, pinned) [m] where Blender has them now."""
        if self.touched:
            self.touched.lead(pins)

    def _change_end(self, _servo: Servo) -> None:
        """Let go of the body."""
        self.close()
        self.state = BodyState.NONE

    def _lift(self) -> None:
        """Take the fingertips off; where one comes down inside the body it must not push."""
        assert self.touched
        self.touched.lift()
        self._changed = True

    def _give_up(self, servo: Servo, why: str) -> None:
        servo.end(why)
        self.close()
        self.note = why
        self.state = BodyState.REFUSED

    def _post(self, now: float) -> None:
        """Post a frame for Blender."""
        touched = self.touched
        if touched is None or touched.frame is None or self._frames is None:
            return
        means = [scaled(total, 1 / max(self._since, 1)) for total in self._total]
        positions = touched.body.positions().astype("f4").tobytes()
        self._frames.post(0, pack_frame(touched.frame, means, self.taken, positions))
        self._posted, self._since, self._total = now, 0, [ZERO] * FINGERS


def load() -> None:
    """Load what runs a body, which takes longer than a device waits; Blender has tested the native core."""
    try:
        from .. import native
        from ..solver import backend  # noqa: F401
        from . import touched_body  # noqa: F401

        native.take_tested()
    except (ImportError, OSError, RuntimeError):  # a body is refused when it comes
        return


def read_parcel(path: Path) -> list[Change]:
    """Return the changes in a parcel, none where a newer parcel came.

    Raises:
        DimpleError: it cannot be read.
    """
    try:
        parcel = path.read_bytes()
    except FileNotFoundError:
        return []
    path.unlink(missing_ok=True)
    return unpack_changes(parcel)


CHANGES: dict[str, Callable[..., None]] = {
    "body": BodyHost._change_body,
    "constants": BodyHost._change_constants,
    "state": BodyHost._change_state,
    "place": BodyHost._change_place,
    "pins": BodyHost._change_pins,
    "end": BodyHost._change_end,
}
