"""Where the servo's process keeps the touched body: takes parcels, runs it beside the servo, posts frames.

A body that blows up, is too heavy or cannot be read takes all force away, and its report says why.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from ..errors import DimpleError
from .mailbox import Mailbox
from .parcel import frame_size, pack_frame, parcel_path, unpack_changes
from .safety import LEASE, QUIET_FORCE
from .servo import Servo
from .servo_messages import BodyState, Order, ServoReport
from .vectors import ZERO, Vector, along, length, scaled
from .wire import FINGERS

if TYPE_CHECKING:
    from .touched_body import TouchedBody

WATCH: Final = 20  # ticks after a change in which a force means that a fingertip came down inside the body
FRAME_EVERY: Final = 0.015  # [s] between two frames: a little faster than Blender draws
BLEW_UP: Final = "The simulation blew up and was put back to rest: soften the material, then arm the device again."
FAILED: Final = "The body cannot run beside the device ({error}), so a local wall is rendered."
CHANGED: Final = "What is under the fingertips has changed. Lift them and arm the device again."
TOO_HEAVY: Final = "The body is too heavy to be simulated at the device's rate, so a local wall is rendered."


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
        self._mailbox, self._watch = mailbox, 0
        _load()
        self._frames: Mailbox | None = None
        self._posted, self._ticks, self._since, self._answered = 0.0, 0, 0, 0
        self._total: list[Vector] = [ZERO] * FINGERS

    def order(self, order: Order, servo: Servo, now: float) -> Order:
        """Return an order of Blender's with the contacts of the body, where there is one; take a new parcel."""
        if order.parcel != self.taken:
            self._take(order.parcel, servo)
        if self.state is not BodyState.RUNS:
            return order
        shown = now - order.written <= LEASE
        return replace(order, contacts=servo.order.contacts, held_until=order.held_until if shown else 0.0)

    def joined(self, report: ServoReport) -> ServoReport:
        """Return a report with what became of the body."""
        note = report.note or (self.note if self.state is BodyState.REFUSED else "")
        load = self.touched.load if self.touched else 0.0
        return replace(report, note=note, body=self.state, parcel=self.taken, load=load)

    def _take(self, number: int, servo: Servo) -> None:
        self.taken, path = number, parcel_path(self._mailbox, number)
        try:
            parcel = path.read_bytes()
            path.unlink(missing_ok=True)
            for name, *arguments in unpack_changes(parcel):
                getattr(self, f"change_{name}")(servo, *arguments)
        except FileNotFoundError:
            return  # a newer one took its place
        except (OSError, DimpleError, AttributeError, TypeError, ValueError, RuntimeError) as error:
            self._give_up(servo, FAILED.format(error=error))

    def advance(self, servo: Servo, now: float) -> None:
        """Run one tick if the servo has answered a STATE, and give it the contacts for the next."""
        if self.touched is None or servo.answered == self._answered:
            return
        self._answered, touched = servo.answered, self.touched
        try:
            contacts = touched.advance(servo.places, servo.stored, servo.cap, now)
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
            self._give_up(servo, TOO_HEAVY)
            contacts = ()
        if self._watch:
            self._watch -= 1
            if any(contact and length(contact.force) >= QUIET_FORCE for contact in contacts) or touched.is_inside:
                servo.end(CHANGED)
                self._watch = 0
        servo.order = replace(servo.order, contacts=contacts)
        self._ticks += 1
        self._since += 1
        self._total = [along(total, force, 1.0) for total, force in zip(self._total, touched.forces, strict=True)]
        if self.touched and now - self._posted > FRAME_EVERY:
            self._post(now)

    def close(self) -> None:
        """Let go of the body."""
        if self._frames:
            self._frames.close()
        self.touched = self._frames = None

    # the changes: what a parcel may ask for

    def change_body(self, servo: Servo, model: Any, surface: Any, positions: Any, velocities: Any, frames: str) -> None:
        """Begin with a body as it is, and post its frames to a file; what is under a fingertip changes: no force."""
        from .touched_body import TouchedBody

        self.close()
        self._watch = WATCH
        self._frames = Mailbox(Path(frames), size=frame_size(len(model.mass)), slots=1)
        self.touched = TouchedBody(model, surface, servo.spec.tick)
        self.touched.body.set_state(positions, velocities)
        self.state, self._ticks, self._since, self._total = BodyState.RUNS, 0, 0, [ZERO] * FINGERS

    def change_constants(self, _servo: Servo, model: Any, surface: Any) -> None:
        """Go on with the numbers of other models of the same meshes."""
        if self.touched:
            # the meshes are those it has: a pickle makes copies of them
            mine, below = self.touched.body.model, self.touched.surface
            self.touched.set_constants(replace(model, mesh=mine.mesh), replace(surface, mesh=below.mesh))

    def change_state(self, _servo: Servo, positions: Any, velocities: Any) -> None:
        """Put the vertices elsewhere; no force remains."""
        if self.touched:
            self.touched.body.set_state(positions, velocities)
            self._lift()

    def change_place(self, _servo: Servo, origin: Vector, scale: float, turn: Any, radius: float) -> None:
        """Place the device in the session [m]."""
        if self.touched:
            self.touched.where = origin, scale, turn, radius
            self._lift()

    def change_pressed(self, _servo: Servo, pressed: Any) -> None:
        """Press with fingertips of a poke, in place of the device's: place and radius [m]."""
        if self.touched:
            self.touched.pressed = pressed
            self._watch = WATCH

    def change_pins(self, _servo: Servo, pins: Any) -> None:
        """Lead pinned vertices (3, pinned) [m] where Blender has them now."""
        if self.touched:
            self.touched.lead(pins)

    def change_end(self, _servo: Servo) -> None:
        """Let go of the body."""
        self.close()
        self.state = BodyState.NONE

    def _lift(self) -> None:
        """Take the fingertips off; where one comes down inside the body it must not push."""
        assert self.touched
        self.touched.lift()
        self._watch = WATCH

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
        self._frames.post(0, pack_frame(touched.frame, means, self._ticks, positions))
        self._posted, self._since, self._total = now, 0, [ZERO] * FINGERS


def _load() -> None:
    """Load and test the native core now: between two answers there is no time for it."""
    try:
        from ..native import why_not
        from . import touched_body  # noqa: F401
    except ImportError:  # no numpy: a body is refused when it comes
        return
    why_not()
