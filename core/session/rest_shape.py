"""The shape at rest of a session: its position by object and rig, its sway, and the body that lies on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import Floats
from ..body.model import Model
from ..native import Body
from ..native.motion import Touch
from ..reduction.proxy import Proxy
from .fingertip import Finger
from .sway import STILL, Push, Sway, push_of, sway_of


class Rest:
    """The shape at rest, and its target in the current step.

    sway: None if it moves with its rig alone.
    target: (3, n) positions of all vertices at the end of the step [m], None if it stays.
    bent: it differs from the model's.
    carries: the body lies on it, and is not stepped.
    met: push of other surfaces on a swaying body.
    rate: (3, m) of the simulated vertices in the last motion [m/s].
    """

    target: Floats | None
    bent: bool
    carries: bool = False
    met: Push | None = None
    rate: Floats
    _led: Floats  # (3, n) positions without sway [m]
    _at: Floats | None  # (3, n) positions with sway [m], None until they are needed
    _begin: tuple[Floats, float]  # positions without sway before the last motion, and its duration [s]

    def __init__(self, model: Model, proxy: Proxy | None, before: Rest | None = None) -> None:
        """Begin with the shape of a model, or continue from `before` with other constants."""
        self._model, self._seeds = model, proxy.seeds if proxy else None
        self.sway: Sway | None = sway_of(model, before.sway if before else None)
        if before is None or before._model.mesh is not model.mesh:
            self.reset()
        else:
            self.target, self.bent, self._begin = before.target, before.bent, before._begin
            self._led, self._at = before._led, before._at
            self.rate = self.rate_of_body if self.bent and self.sway else np.zeros_like(self.of_body)

    def reset(self) -> None:
        """Go back to the shape of the model, at rest."""
        self.target = None
        self._led = self._at = self._model.matching.rest
        self._begin = self._led, 1.0
        self.bent, self.carries, self.met, self.rate = False, False, None, np.zeros_like(self.of_body)
        if self.sway:
            self.sway.reset()

    @property
    def moves(self) -> bool:
        """Return whether it is still moving."""
        return self.target is not None or (self.sway is not None and self.sway.moves)

    @property
    def whole(self) -> Floats:
        """Return the positions (3, n) [m] of all vertices."""
        if self._at is None:
            assert self.sway
            self._at = (self._led.T + self.sway.displacement()).T  # stored vertex by vertex in memory
        return self._at

    @property
    def of_body(self) -> Floats:
        """Return the positions (3, m) [m] of the simulated vertices."""
        return self.whole if self._seeds is None else self.whole[:, self._seeds]

    @property
    def rate_of_body(self) -> Floats:
        """Return the velocities (3, m) [m/s] of the simulated vertices in the shape at rest."""
        assert self.sway
        begin, seconds = self._begin
        rate = (self._led - begin) / seconds + self.sway.velocity().T
        return rate if self._seeds is None else rate[:, self._seeds]

    def meet(self, impulses: Floats, seconds: float) -> None:
        """Push a swaying body by the impulses that others gave its vertices (m, 3) in some seconds [N s]."""
        if self.sway:
            self.met = self.sway.met(impulses, seconds, self._seeds)

    def pushes(self, fingers: Sequence[Finger | None], touches: Sequence[Touch | None]) -> list[Push]:
        """Return the pushes of touching fingertips and of other surfaces; none if the body does not sway."""
        if not self.sway:
            return []
        both = [(finger, touch) for finger, touch in zip(fingers, touches, strict=False) if finger and touch]
        pushes = [push_of(touch, finger, self._model.mesh) for finger, touch in both if any(touch.force)]
        return [*pushes, self.met] if self.met and len(self.met.vertices) else pushes

    def bend(self, body: Body, share: float, seconds: float, pushes: Sequence[Push]) -> None:
        """Move by a share of the remaining way to the target, sway for some seconds, and take the body along."""
        before = None if self.carries else self.of_body
        self._advance(share, seconds, pushes)
        if before is not None:
            rate, rate_before = (self.of_body - before) / seconds, self.rate
            self.rate = rate
            self.lay(body, rate, gain=rate - rate_before if self.sway else None)  # the inertia is in the modes

    def lay(self, body: Body, rate: Floats | None = None, *, gain: Floats | None = None) -> None:
        """Give the body its shape at rest, its rate (3, m) in the next motion, and a gain (3, m) in velocity [m/s]."""
        body.set_rest(self.of_body, rate, surface=None if self._seeds is None else self.whole, gain=gain)

    def carry(self, body: Body) -> None:
        """Carry a swaying body, unstepped, if it shows no difference from its shape at rest."""
        if self.sway and not self.carries:
            off = body.positions() - self.of_body
            self.carries = float(np.abs(off).max()) <= STILL * self._model.mesh.size

    def let_go(self, body: Body) -> None:
        """Let a body that is carried be stepped again."""
        if self.carries:
            self.carries, self.rate = False, self.rate_of_body
            self.lay(body)
            body.set_state(self.of_body, self.rate)

    def _advance(self, share: float, seconds: float, pushes: Sequence[Push]) -> None:
        self._begin = self._led, seconds
        if self.target is not None:
            whole = share >= 1
            self._led = self.target if whole else self._led + share * (self.target - self._led)
            self.target = None if whole else self.target
        if self.sway:
            self.sway.advance(self._led.T, seconds, pushes)
        self._at, self.bent = None if self.sway else self._led, True
