"""The shape at rest of a session: its position by object and rig, and its sway."""

from __future__ import annotations

from collections.abc import Sequence

from ..base import Floats
from ..body.model import Model
from ..reduction.proxy import Proxy
from .sway import Push, Sway, sway_of


class Rest:
    """The shape at rest, and its target in the current step.

    sway: None if it moves with its rig alone.
    target: (3, n) positions of all vertices at the end of the step [m], None if it stays.
    bent: it differs from the model's.
    carries: the body lies on it, and is not stepped.
    """

    target: Floats | None
    bent: bool
    carries: bool = False
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

    def reset(self) -> None:
        """Go back to the shape of the model, at rest."""
        self.target = None
        self._led = self._at = self._model.matching.rest
        self._begin = self._led, 1.0
        self.bent = self.carries = False
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

    def advance(self, share: float, seconds: float, pushes: Sequence[Push]) -> None:
        """Move by a share of the remaining way to the target, and sway for some seconds."""
        self._begin = self._led, seconds
        if self.target is not None:
            whole = share >= 1
            self._led = self.target if whole else self._led + share * (self.target - self._led)
            self.target = None if whole else self.target
        if self.sway:
            self.sway.advance(self._led.T, seconds, pushes)
        self._at, self.bent = None if self.sway else self._led, True
