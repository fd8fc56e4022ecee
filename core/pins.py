"""The pins of a session, and what follows them without being simulated: where they are led, and their way there."""

from __future__ import annotations

import numpy as np

from .base import Floats, Singles
from .body.model import Model
from .reduction.proxy import Proxy
from .solver.motion import PinMotion

ROW = "V12"  # bytes of a place in single precision


class Pins:
    """Pinned vertices of a mesh, during a step: they move evenly from its begin to its end.

    followed: the vertices of the mesh whose places are prescribed.
    origin: where all vertices (3, n) [m] would be at the begin if they were pinned,
    target: and at the end, None where pins rest.
    """

    def __init__(self, model: Model, proxy: Proxy | None) -> None:
        self._pinned = np.flatnonzero(model.pinned) if proxy is None else proxy.seeds[proxy.model.pinned]
        self._still = proxy.still if proxy else self._pinned[:0]
        self.followed = np.union1d(self._pinned, self._still) if proxy else self._pinned
        self._places_of: list[tuple[Floats, Floats]] = []  # of all vertices, and of the pins among them
        self._still_of: tuple[Floats, Singles] | None = None  # the same for still vertices
        self.rest_at(model.matching.rest)

    def rest_at(self, positions: Floats) -> None:
        """Let the pins be where they are among all vertices (3, n) [m], and stay there."""
        self.origin: Floats = positions
        self.target: Floats | None = None
        self._arrives = False  # at the end of the motion under way

    def lead(self, first: float, last: float) -> PinMotion | None:
        """Return the motion of some ticks, as shares of the way that are over at the end of the first and the last."""
        self._arrives = False
        if self.target is None:
            return None
        if self.origin is self.target:  # the step before ended between two ticks
            first = last = 1.0
        self._arrives = last >= 1
        return PinMotion(self._places(self.origin), self._places(self.target), first, last)

    def take(self) -> None:
        """Go where they are at the end of the motion under way."""
        if self._arrives and self.target is not None:
            self.rest_at(self.target)

    def move(self, share: float) -> bool:
        """Begin the next step after a share of this one; tell whether anything is led."""
        if self.target is None:
            return False
        self.origin = self.target if share >= 1 else self.origin + share * (self.target - self.origin)
        return True

    def put_still(self, surface: Singles) -> None:
        """Put those vertices of a proxy's skin (n, 3) [m] that nothing carries where the pins are."""
        if self._still_of is None or self._still_of[0] is not self.origin:
            self._still_of = self.origin, np.ascontiguousarray(self.origin[:, self._still].T, np.float32)
        np.put(surface.view(ROW), self._still, self._still_of[1].view(ROW))  # a quarter of the time of surface[still]

    def _places(self, positions: Floats) -> Floats:
        """Return where the pins (3, p) [m] are among all vertices (3, n): the same array for the same ones."""
        found = next((places for of, places in self._places_of if of is positions), None)
        if found is None:
            found = np.ascontiguousarray(np.take(positions.T, self._pinned, axis=0).T)
            self._places_of = self._places_of[-1:] + [(positions, found)]
        return found
