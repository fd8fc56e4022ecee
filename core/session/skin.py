"""What a session shows: the surface of its body or its proxy, cached until something moves; and its pins.

If the skin of a solid gives way under a fingertip, it is shown lying on the fingertip.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import Bools, DimpleError, Floats, Ints, Singles
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
    """Pinned vertices of a mesh, during a step: they move evenly from its start to its end.

    origin: positions that all vertices (3, n) [m] would have at the start if they were pinned,
    target: and at the end, None if the pins rest.
    """

    def __init__(self, model: Model, proxy: Proxy | None) -> None:
        self._pinned = np.flatnonzero(model.pinned) if proxy is None else proxy.seeds[proxy.model.pinned]
        self._still = proxy.still if proxy else self._pinned[:0]
        self.rest_at(model.matching.rest)

    def rest_at(self, positions: Floats) -> None:
        """Put the pins at their positions among those of all vertices (3, n) [m], and let them stay there."""
        self.origin: Floats = positions
        self.target: Floats | None = None
        self._arrives = False  # whether they reach the target in the current motion

    def lead(self, first: float, last: float) -> PinMotion | None:
        """Return the motion from the shares of the way that are covered at the end of its first and its last tick."""
        self._arrives = False
        if self.target is None:
            return None
        if self.origin is self.target:  # the previous step ended between two ticks
            first = last = 1.0
        self._arrives = last >= 1
        return PinMotion(self._places(self.origin), self._places(self.target), first, last)

    def take(self) -> None:
        """Rest at the target if the current motion has reached it."""
        if self._arrives and self.target is not None:
            self.rest_at(self.target)

    def move(self, share: float) -> bool:
        """Begin the next step after a share of this one; return whether the pins move."""
        if self.target is None:
            return False
        self.origin = self.target if share >= 1 else self.origin + share * (self.target - self.origin)
        return True

    def put_still(self, surface: Singles) -> None:
        """Put those vertices of a proxy's skin (n, 3) [m] that nothing carries at their pinned positions."""
        surface[self._still] = self.origin[:, self._still].T

    def _places(self, positions: Floats) -> Floats:
        """Return the positions (3, p) [m] of the pins among those of all vertices (3, n)."""
        return np.ascontiguousarray(np.take(positions.T, self._pinned, axis=0).T)


class Skin:
    """The surface of a body; vertices that nothing carries follow the pins."""

    def __init__(self, model: Model, proxy: Proxy | None, pins: Pins, rest: Rest) -> None:
        self._proxy, self._pins, self._rest, self._source = proxy, pins, rest, model.mesh.source
        self._input_of = input_vertices(model.mesh)
        self._yields = model.compliance > 0
        self._yields_somewhere = bool(self._yields.any())
        self._unwelded = len(self._source) == len(model.mass) and bool((self._source[1:] > self._source[:-1]).all())
        self.reset()

    def of_mesh(self, positions: Floats) -> Floats:
        """Return the positions of the mesh's vertices (n, 3) from those of the input vertices (N, 3).

        Raises:
            DimpleError: another number of vertices, or positions that are not numbers.
        """
        positions = np.asarray(positions, np.float64)
        if positions.shape != (len(self._source), 3):
            raise DimpleError("The mesh has {vertices} vertices: give a position for each.", vertices=len(self._source))
        if not np.isfinite(positions).all():
            raise DimpleError("A vertex has a position that is not a number.")
        return positions if self._unwelded else positions[self._input_of]

    def reset(self) -> None:
        """Clear the cached positions, because something has moved."""
        self._shown: Singles | None = None  # what `positions` returned, until something moves

    def positions(self, body: Body, tips: Sequence[Finger | None]) -> Singles:
        """Return the positions of the input vertices (N, 3) [m], read-only."""
        if self._shown is None:
            self._shown = self._of_input(np.asarray(self.on(tips, self.surface(body)), np.float32))
            self._shown.setflags(write=False)
        return self._shown

    def on(self, tips: Sequence[Finger | None], surface: Floats | Singles) -> Floats | Singles:
        """Return a surface (n, 3) [m] with the skin that gave way lying on the fingertips."""
        for tip in tips if self._yields_somewhere else ():
            if tip and len(inside := _inside(tip, surface, self._yields)):
                surface = surface.copy()
                surface[inside] += _way_out(surface[inside] - np.array(tip.position), tip.radius)
        return surface

    def surface(self, body: Body) -> Floats | Singles:
        """Return the positions of the vertices (n, 3) [m] of the mesh."""
        if self._rest.carries:
            return self._rest.whole.T
        x = body.positions()
        if self._proxy is None:
            return x.T
        surface = carry(self._proxy.binding, x)
        if self._rest.bent:  # the proxy carries only the displacement from the shape at rest
            surface += self._rest.whole.T - carry(self._proxy.binding, self._rest.of_body)
        self._pins.put_still(surface)
        return surface

    def velocities(self, body: Body) -> Floats:
        """Return the velocities of the vertices (n, 3) [m/s] of the mesh, approximate with a proxy."""
        v = body.velocities().T
        return v if self._proxy is None else blend(self._proxy.binding, v)

    def _of_input(self, surface: Singles) -> Singles:
        return surface if self._unwelded else surface[self._source]


def _inside(tip: Finger, surface: Floats | Singles, which: Bools) -> Ints:
    """Return which of the vertices in `which` lie inside a fingertip."""
    x, y, z = tip.position
    near = np.flatnonzero(which & (np.abs(surface[:, 2] - z) < tip.radius))
    return near[((surface[near] - np.array((x, y, z))) ** 2).sum(axis=1) < tip.radius**2]


def _way_out(offset: Floats | Singles, radius: float) -> Floats:
    """Return displacements (k, 3) [m] that move offsets (k, 3) inside a sphere onto it.

    They point away from a point on the far side of the sphere, so that the skin is pressed rather than spread.
    """
    apart = np.sqrt((offset**2).sum(axis=1))
    mean = (radius - apart) @ offset
    way = offset + radius / max(float(np.linalg.norm(mean)), ROUNDING * radius**2) * mean
    way /= np.maximum(np.sqrt((way**2).sum(axis=1)), ROUNDING * radius)[:, None]
    along = (offset * way).sum(axis=1)
    return np.asarray((np.sqrt(along**2 + radius**2 - apart**2) - along)[:, None] * way)
