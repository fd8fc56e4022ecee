"""The shape of a dent on a ball: its rings about the axis of the press, how far it is from them, how far it reaches.

The press comes from above, along -z, onto the top of a body that is round there. `way` is the distance from there
along the skin at rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from core.base import Bools, Floats
from studies.body.solid_mesh import BALL_RADIUS

WITHIN = 0.050  # [m] of the axis, along the skin: the dent
RINGS = 60  # at least
NARROW = 0.8  # of the spacing: vertices so near in their way make a ring


@dataclass(frozen=True, slots=True)
class Profile:
    """The mean of a dent over its rings.

    way: (k,) along the skin at rest [m].
    r, z: (k,) where that place is now: from the axis and above the top at rest [m].
    """

    way: Floats
    r: Floats
    z: Floats

    def inward(self) -> Floats:
        """Return how far the skin went in along its normal at rest (k,) [m]."""
        sine, cosine = np.sin(self.way / BALL_RADIUS), np.cos(self.way / BALL_RADIUS)
        u_r, u_z = self.r - BALL_RADIUS * sine, self.z - BALL_RADIUS * (cosine - 1)
        return -(u_r * sine + u_z * cosine)

    def reach(self, share: float) -> float:
        """Return how far along the skin the dent falls to a share of its depth [m]."""
        down = self.inward()
        last = int(np.flatnonzero(down < share * down[0])[0])
        return float(np.interp(share * down[0], down[[last, last - 1]], self.way[[last, last - 1]]))


def ways(rest: Floats) -> Floats:
    """Return the ways (n,) [m] of places at rest (n, 3) on the ball whose centre is the origin."""
    return BALL_RADIUS * np.arctan2(np.hypot(rest[:, 0], rest[:, 1]), rest[:, 2])


def profile(rest: Floats, x: Floats, spacing: float, within: float = WITHIN) -> Profile:
    """Return the mean over rings of vertices (n, 3) [m] at rest and now: parabolas through those of about one way.

    Args:
        spacing: of the vertices [m].
        within: how far from the axis [m].
    """
    way = ways(rest)
    reached = within + 2 * spacing
    order = np.argsort(way)
    order = order[: np.searchsorted(way[order], reached)]
    way, r, z = way[order], np.hypot(x[order, 0], x[order, 1]), x[order, 2] - BALL_RADIUS
    at = np.linspace(0, within, max(int(3 * within / spacing), RINGS))
    found = []
    for s in at:
        wide = NARROW * spacing
        while np.count_nonzero(np.abs(way - s) < wide) < 6:
            wide *= 1.2
        near = np.abs(way - s) < wide
        off = way[near] - s
        weight = np.sqrt((1 - (off / wide) ** 2) ** 2)
        # the axis is a line of symmetry: r is odd about it and z even
        base = np.stack([np.ones_like(off), off, off**2], axis=1)
        found.append(
            np.linalg.lstsq(weight[:, None] * base, weight[:, None] * np.stack([r, z], 1)[near], rcond=None)[0][0]
        )
    r_mean, z_mean = np.array(found).T
    r_mean[0] = 0.0
    return Profile(at, r_mean, z_mean)


def off_rings(mean: Profile, way: Floats, r: Floats, z: Floats) -> Floats:
    """Return how far places (k,) are from the mean, square to it [m]."""
    slope = np.stack([np.gradient(mean.r, mean.way), np.gradient(mean.z, mean.way)])
    slope /= np.linalg.norm(slope, axis=0)
    along_r, along_z = (np.interp(way, mean.way, part) for part in slope)
    return (z - np.interp(way, mean.way, mean.z)) * along_r - (r - np.interp(way, mean.way, mean.r)) * along_z


def vertex_roughness(rest: Floats, x: Floats, spacing: float, mean: Profile | None = None) -> float:
    """Return the RMS distance of the vertices of a dent from the mean of their rings [m]."""
    mean = profile(rest, x, spacing) if mean is None else mean
    way = ways(rest)
    some: Bools = way < mean.way[-1]
    return float(np.sqrt(np.mean(off_rings(mean, way[some], *on_axes(x[some])) ** 2)))


def on_axes(x: Floats) -> tuple[Floats, Floats]:
    """Return distances from the axis and heights above the top at rest of places (n, 3) [m]."""
    return np.hypot(x[:, 0], x[:, 1]), x[:, 2] - BALL_RADIUS


def turned_onto(mean: Profile, rest: Floats) -> Floats:
    """Return where places at rest (n, 3) would be, were the dent its mean; beyond it they stay."""
    way, turn = ways(rest), np.arctan2(rest[:, 1], rest[:, 0])
    r, z = np.interp(way, mean.way, mean.r), np.interp(way, mean.way, mean.z) + BALL_RADIUS
    there = np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)
    return np.where((way < mean.way[-1])[:, None], there, rest)
