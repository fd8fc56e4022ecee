"""The shape at rest of a session: its place by object and rig, and its sway there."""

from __future__ import annotations

from collections.abc import Sequence

from ..base import Floats
from ..body.model import Model
from ..reduction.proxy import Proxy
from .sway import Push, Sway, sway_of


class Rest:
    """Where the shape at rest is, and where it goes in the step under way.

    sway: None where it moves with its rig alone.
    target: (3, n) of all vertices at the end of the step [m], None where it stays.
    bent: it is another than the model's.
    """

    target: Floats | None
    bent: bool
    _led: Floats  # without sway
    _at: Floats | None  # with it, None until it is asked for
    _begin: tuple[Floats, float]  # where it was before the last motion, without sway, and how long that took [s]

    def __init__(self, model: Model, proxy: Proxy | None, before: Rest | None = None) -> None:
        """Begin with the shape of a model, or go on as it was `before` with other constants."""
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
        self.bent = False
        if self.sway:
            self.sway.reset()

    @property
    def moves(self) -> bool:
        """Tell whether it goes on moving."""
        return self.target is not None or (self.sway is not None and self.sway.moves)

    @property
    def whole(self) -> Floats:
        """Return where it is (3, n) [m], of all vertices."""
        if self._at is None:
            assert self.sway
            self._at = (self._led.T + self.sway.displacement()).T  # by vertex, as they lie in memory
        return self._at

    @property
    def of_body(self) -> Floats:
        """Return where it is (3, m) [m], of the vertices that move."""
        return self.whole if self._seeds is None else self.whole[:, self._seeds]

    @property
    def rate_of_body(self) -> Floats:
        """Return how fast the vertices that move are carried (3, m) [m/s]."""
        assert self.sway
        begin, seconds = self._begin
        rate = (self._led - begin) / seconds + self.sway.velocity().T
        return rate if self._seeds is None else rate[:, self._seeds]

    def advance(self, share: float, seconds: float, pushes: Sequence[Push]) -> None:
        """Go a share of what is left of the way, and sway for some seconds."""
        self._begin = self._led, seconds
        if self.target is not None:
            whole = share >= 1
            self._led = self.target if whole else self._led + share * (self.target - self._led)
            self.target = None if whole else self.target
        if self.sway:
            self.sway.advance(self._led.T, seconds, pushes)
        self._at, self.bent = None if self.sway else self._led, True
