"""The body under the device's fingertips, in the servo's process: one tick of the model each tick of the device.

The answer to a STATE is given before the body moves, from the contact of the tick before evaluated where the fingertip
is now: so the device never waits for the model, and the model has the rest of the tick.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from ..vectors import ZERO, Vector, along, dot, scaled
from .contact_model import SIDEWAYS, Contact, wall_slope
from .coupling import STIFFER, Coupling, Slopes
from .safety import QUIET_FORCE
from .wire import FINGERS

if TYPE_CHECKING:
    from ..base import Floats
    from ..body.model import Model
    from ..solver.backend import Body
    from ..solver.motion import FingertipMotion, Frame, PinMotion, Touch

Where = tuple[Vector, float, tuple[Vector, Vector, Vector], float]
HEAVIEST: Final = 0.8  # of a tick: a body that takes more leaves the device no time
BORROWED: Final = 500  # ticks that it may take beyond that, less what it takes below: a busy second of others is none
LONGEST: Final = 2.0  # ticks that one counts at most: on a virtual machine time that was stolen counts as taken
LEAD: Final = 16  # ticks: about a frame of Blender's
PATIENCE: Final = 250  # ticks of an average
SOFT_SLOPE: Final = 1.5  # times its law a body may stiffen between two ticks: too stiff is viscous, too soft active
GRIP: Final = 1e3  # a friction beyond every force: the model has slipped already where it slips


class TouchedBody:
    """A body and what its fingertips do.

    Args:
        model: what moves.
        surface: the model below whose surface at rest fingertips are measured.
        tick: of the device [s].

    Attributes:
        where: the device in the session: origin [m], scale, turn (see `Workspace`), and its fingertips' radius [m].
        frame: what the last tick came to, None before the first.
        load: its cost over a tick, mean of PATIENCE ticks.
        forces: on the fingertips by the model [N].
        places: where the spheres are [m].

    Raises:
        DimpleError: no native core runs here, or the body cannot be simulated at this tick.
    """

    def __init__(self, model: Model, surface: Model, tick: float) -> None:
        from ..solver.backend import create

        self.body: Body = create(model, surface=surface)
        self.frame: Frame | None = None
        self.load, self._ticks, self._borrowed = 0.0, 0, 0.0
        self.where: Where = (ZERO, 1.0, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), 0.0)
        self._pins: tuple[Floats, Floats, int] | None = None  # from, to, ticks gone
        self.tick = tick
        self.forces: list[Vector] = [ZERO] * FINGERS
        self.places: list[Vector | None] = [None] * FINGERS
        self._couplings = [Coupling() for _ in range(FINGERS)]
        self._touched: list[Touch | None] = [None] * FINGERS
        self.set_constants(model, surface)

    def set_constants(self, model: Model, surface: Model) -> None:
        """Go on with the numbers of other models of the same meshes."""
        self.substeps = model.substeps(self.tick)
        if model is not self.body.model:
            self.body.set_constants(model, surface=surface)
        self.surface, self._materials = surface, surface.materials
        self._slopes = [
            Slopes(k1=STIFFER * m.slope(m.x0), k2=STIFFER * m.K2, knee=m.law(m.x0)) for m in surface.materials
        ]
        self._material_of = surface.mesh.triangle_material.tolist()

    def lift(self) -> None:
        """Take all fingertips off."""
        self.places = [None] * FINGERS
        self._touched = [None] * FINGERS
        self.forces = [ZERO] * FINGERS
        self._couplings = [Coupling() for _ in range(FINGERS)]

    def advance(self, places: Sequence[Vector | None], cap: float, now: float) -> tuple[Contact | None, ...]:
        """Run one tick; return the contact of each fingertip in the space of the device.

        Args:
            places: of the device's fingertips [m], None where a sensor is not trusted.
            cap: largest stiffness that the device renders [N/m].
            now: [s].
        """
        from ..solver.motion import Motion

        began = time.thread_time()  # other processes do not make a body heavy
        cap = max(cap, 1e-3)
        tips = [self._tip(i, place, cap) for i, place in enumerate(places)]
        self.frame = frame = self.body.step(Motion(1, self.substeps, self.tick, tuple(tips), self._led()))
        self._touched = [*frame.touches]
        contacts = tuple([self._contact(i, touch, cap, now) for i, touch in enumerate(frame.touches)])
        self._ticks += 1
        took = min((time.thread_time() - began) / self.tick, LONGEST)
        self.load += (took - self.load) / min(self._ticks, PATIENCE)
        self._borrowed = max(self._borrowed + took - HEAVIEST, 0.0)
        return contacts

    def lead(self, at: Floats) -> None:
        """Lead the pinned vertices to places (3, pinned) [m], evenly over LEAD ticks."""
        self._pins = self.body.positions()[:, self.body.model.pinned], at, 0

    def _led(self) -> PinMotion | None:
        from ..solver.motion import PinMotion

        if self._pins is None:
            return None
        start, end, gone = self._pins
        share = (gone + 1) / LEAD
        self._pins = (start, end, gone + 1) if gone + 1 < LEAD else None
        return PinMotion(start, end, share, share)

    @property
    def is_inside(self) -> bool:
        """Tell whether a fingertip of the device is so deep that it would push as soon as it met the skin."""
        touches = self.frame.touches if self.frame else ()
        return any(touch and touch.law_force >= QUIET_FORCE for touch in touches)

    @property
    def is_finite(self) -> bool:
        """Tell whether the last tick did not blow up."""
        return self.frame is None or self.frame.finite

    @property
    def is_too_heavy(self) -> bool:
        """Tell whether the body leaves the device no time: within half a second of 2 ticks a tick, 5 s of 0.9."""
        return self._borrowed > BORROWED

    def _tip(self, i: int, place: Vector | None, cap: float) -> FingertipMotion | None:
        """Return the way of a sphere in this tick, None where there is none."""
        from ..solver.motion import FingertipMotion

        before, radius, coupling = self.places[i], self.where[3], self._couplings[i]
        if place is None or radius <= 0:
            self.places[i], self._couplings[i] = None, Coupling()
            return None
        coupling.follow(self._to_session(place), self.tick)
        self.places[i] = at = coupling.place(self._slopes_at(i), cap)
        return FingertipMotion(before or at, at, at, radius, before is None)

    def _slopes_at(self, i: int) -> Slopes:
        touch = self._touched[i]
        return self._slopes[self._material_of[touch.triangle] if touch and touch.triangle >= 0 else 0]

    def _contact(self, i: int, touch: Touch | None, cap: float, now: float) -> Contact | None:
        """Return the contact of a fingertip: the force of the coupling, and how it changes until the next tick."""
        if touch is None:
            self.forces[i] = ZERO
            return None
        self.forces[i] = scaled(touch.impulse, 1 / self.tick)
        if touch.triangle < 0:
            return None
        coupling, slopes = self._couplings[i], self._slopes_at(i)
        assert coupling.near
        force = coupling.take(self.forces[i], slopes, cap)
        material = self._materials[self._material_of[touch.triangle]]
        scale = self.where[1]
        slope = min(SOFT_SLOPE * wall_slope(material, touch.depth), cap)
        return Contact(
            force=scaled(self._turned(force), 1 / scale), at=self._to_device(coupling.near),
            normal=self._turned(touch.outward), k_n=slope, k_t=SIDEWAYS * slope if any(force) else 0.0,
            gap=max(-touch.depth, 0.0) / scale, friction=GRIP, stamp=now,
        )  # fmt: skip

    def _to_session(self, at: Vector) -> Vector:
        origin, scale, (a, b, c), _ = self.where
        return along(origin, (dot(a, at), dot(b, at), dot(c, at)), scale)

    def _to_device(self, at: Vector) -> Vector:
        origin, scale, _, _ = self.where
        return scaled(self._turned(along(at, origin, -1.0)), 1 / scale)

    def _turned(self, v: Vector) -> Vector:
        """Return a direction of the session in the device."""
        (a, b, c), (x, y, z) = self.where[2], v
        return (
            a[0] * x + b[0] * y + c[0] * z,
            a[1] * x + b[1] * y + c[1] * z,
            a[2] * x + b[2] * y + c[2] * z,
        )
