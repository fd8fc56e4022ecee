"""What a session shows: the surface of its body, or what its proxy carries, kept until something moves.

Where the skin of a solid has given way under a fingertip, it lies on the fingertip.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .base import Bools, Floats, Ints, Singles
from .body.model import Model
from .constants import ROUNDING
from .fingertip import Finger
from .mesh.surface import input_vertices
from .native import Body
from .pins import Pins
from .reduction.binding import blend, carry
from .reduction.proxy import Proxy


class Skin:
    """The surface of a body; its pins may put vertices of it that nothing carries.

    input_of: the input vertex (n,) that each vertex of the mesh was.
    """

    def __init__(self, model: Model, proxy: Proxy | None, pins: Pins) -> None:
        self._proxy, self._pins, self._source = proxy, pins, model.mesh.source
        self.input_of = input_vertices(model.mesh)
        self._yields = model.compliance > 0
        self._yields_somewhere = bool(self._yields.any())
        self._unwelded = len(self._source) == len(model.mass) and bool((self._source[1:] > self._source[:-1]).all())
        self.reset()

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
        x = body.positions()
        if self._proxy is None:
            return x.T
        surface = carry(self._proxy.binding, x)
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
