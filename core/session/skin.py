"""What a session shows: the surface of its body, or what its proxy carries, kept until something moves; and its pins.

Where the skin of a solid has given way under a fingertip, it lies on the fingertip.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import Bools, Floats, Ints, Singles
from ..body.model import Model
from ..constants import ROUNDING
from ..mesh.surface import input_vertices
from ..native import Body
from ..native.motion import PinMotion
from ..reduction.binding import blend, carry
from ..reduction.proxy import Proxy
from .fingertip import Finger
from .rest_shape import Rest


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
        surface[self._still] = self.origin[:, self._still].T

    def _places(self, positions: Floats) -> Floats:
        """Return where the pins (3, p) [m] are among all vertices (3, n)."""
        return np.ascontiguousarray(np.take(positions.T, self._pinned, axis=0).T)


class Skin:
    """The surface of a body; its pins may put vertices of it that nothing carries.

    input_of: the input vertex (n,) that each vertex of the mesh was.
    """

    def __init__(self, model: Model, proxy: Proxy | None, pins: Pins, rest: Rest) -> None:
        self._proxy, self._pins, self._rest, self._source = proxy, pins, rest, model.mesh.source
        self.input_of = input_vertices(model.mesh)
        self._yields = model.compliance > 0
        self._yields_somewhere = bool(self._yields.any())
        self._unwelded = len(self._source) == len(model.mass) and bool((self._source[1:] > self._source[:-1]).all())
        self.laid: Floats | None = None  # (3, n) where the body rests on its shape at rest, and is not stepped
        self.reset()

    def of_mesh(self, values: Floats) -> Floats:
        """Return what the vertices (n, 3) of the mesh have of values (N, 3) of the input vertices."""
        return values if self._unwelded else values[self.input_of]

    def reset(self) -> None:
        """Forget what was shown: something has moved."""
        self._shown: Singles | None = None  # what `positions` returned, until something moves

    def positions(self, body: Body, tips: Sequence[Finger | None]) -> Singles:
        """Return where the input vertices (N, 3) [m] are, to be read."""
        if self._shown is None:
            self._shown = self._of_input(np.asarray(self.on(tips, self.surface(body)), np.float32))
            self._shown.setflags(write=False)
        return self._shown

    def on(self, tips: Sequence[Finger | None], surface: Floats | Singles) -> Floats | Singles:
        """Return a surface (n, 3) [m] that lies on the fingertips where its skin has given way."""
        for tip in tips if self._yields_somewhere else ():
            if tip and len(inside := _inside(tip, surface, self._yields)):
                surface = surface.copy()
                surface[inside] += _way_out(surface[inside] - np.array(tip.position), tip.radius)
        return surface

    def surface(self, body: Body) -> Floats | Singles:
        """Return where the vertices (n, 3) [m] of the mesh are."""
        if self.laid is not None:
            return self.laid.T
        x = body.positions()
        if self._proxy is None:
            return x.T
        surface = carry(self._proxy.binding, x)
        if self._rest.bent:  # it carries what is off the shape at rest alone
            surface += self._rest.whole.T - carry(self._proxy.binding, self._rest.of_body)
        self._pins.put_still(surface)
        return surface

    def velocities(self, body: Body) -> Floats:
        """Return how fast the vertices (n, 3) [m/s] of the mesh move, about."""
        v = body.velocities().T
        return v if self._proxy is None else blend(self._proxy.binding, v)

    def _of_input(self, surface: Singles) -> Singles:
        return surface if self._unwelded else surface[self._source]


def _inside(tip: Finger, surface: Floats | Singles, which: Bools) -> Ints:
    """Return which vertices lie in a fingertip."""
    x, y, z = tip.position
    near = np.flatnonzero(which & (np.abs(surface[:, 2] - z) < tip.radius))
    return near[((surface[near] - np.array((x, y, z))) ** 2).sum(axis=1) < tip.radius**2]


def _way_out(offset: Floats | Singles, radius: float) -> Floats:
    """Return the way (k, 3) [m] onto a sphere from offsets (k, 3) within it.

    It leads away from a point on the sphere behind them, so that a skin is pressed rather than spread.
    """
    apart = np.sqrt((offset**2).sum(axis=1))
    mean = (radius - apart) @ offset
    way = offset + radius / max(float(np.linalg.norm(mean)), ROUNDING * radius**2) * mean
    way /= np.maximum(np.sqrt((way**2).sum(axis=1)), ROUNDING * radius)[:, None]
    along = (offset * way).sum(axis=1)
    return np.asarray((np.sqrt(along**2 + radius**2 - apart**2) - along)[:, None] * way)
