"""A solid by finite elements, fitted through one tip: what the body then answers another, and how its dents compare.

The body answers in proportion and is full of liquid. Its stiffness is that with which the force of one tip comes
nearest to the solid's. Its spread is the one with which that comes nearest still, or that and the dents under it; or,
without the solid, the one with which a tip twice as large meets a force as much larger as from an elastic half space.

A solid's force goes with the root of the tip's radius at any depth. A body of one spread answers larger tips with too
little more while the contact is narrower than the spread, with too much more where it is wider. And its force begins
nearly in proportion to the depth where a solid's begins with its power of 1.5. So by the spread of a half space the
other tip is met within 10 % from 5 mm on, but at 1 and 2 mm the force is 7 to 41 % off, under the fitted tip too; and
the dents, whose tails want a larger spread the deeper they are, are 5 to 9 % of their depth off.

Some of that is the straight bed's and some the constant spread's: `other_tip_identified` gives the bed all freedom that
an identification has, `following_spread` lets the spread grow with the contact.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from core.base import Floats
from core.material import DEFAULT_MATERIAL
from core.mesh.surface import Mesh
from core.reduction.proxy import mean_spacing

from . import dents
from .dent_shape import Profile, profile
from .solid_mesh import BALL_RADIUS

LAWS, TIPS = ("linear", "neo-hookean"), (10, 20)  # of the solid; radii of the tips [mm]
SPREADS = (14, 16, 18, 20, 22, 24, 26)  # [mm] that are tried
DEPTHS, DENTED = (0.001, 0.002, 0.005, 0.010, 0.015, 0.020), (0.005, 0.010, 0.020)  # [m]
WITHIN = 0.050  # [m] along the skin: how far dents are compared


@dataclass(frozen=True, slots=True)
class Pressed:
    """A body of one spread under one tip.

    force: (k,) at each depth [N], of a stiffness that is still to be fitted.
    dents: (m,) RMS error of each dent over its depth.
    volume: largest change, as a share.
    """

    force: Floats
    dents: Floats
    volume: float


def tables(subdivisions: int) -> Iterator[tuple[str, Iterator[dict[str, object]]]]:
    """Yield the name of each file of this part, and its rows."""
    from . import following_spread, other_tip_identified

    yield "other_tip.csv", rows(subdivisions)
    yield "other_tip_identified.csv", other_tip_identified.rows(subdivisions)
    yield "following_spread.csv", following_spread.rows()


def rows(subdivisions: int) -> Iterator[dict[str, object]]:
    """Yield what a body that was fitted through one tip answers either tip, for each law of the solid."""
    mesh = dents.ball(subdivisions)
    settled = {(spread, tip): _settled(mesh, spread, tip) for spread in SPREADS for tip in TIPS}
    for law in LAWS:
        solid, shapes = {tip: _solid_force(law, tip) for tip in TIPS}, dents.profiles(law)
        made = {
            (spread, tip): Pressed(
                np.array([one.force[2] for one in some]),
                np.array([dent_error(mesh, one, shapes[f"ball {tip} mm", one.depth]) for one in some
                          if one.depth in DENTED]),
                max(abs(_volume(mesh, one.positions) / _volume(mesh, mesh.rest_positions) - 1) for one in some),
            )
            for (spread, tip), some in settled.items()
        }  # fmt: skip
        for fitted in TIPS:
            for by in ("force", "force and dents", "half space"):
                yield from _best(law, fitted, by, made, solid)


def _best(
    law: str, fitted: int, by: str, made: dict[tuple[int, int], Pressed], solid: dict[int, Floats]
) -> Iterator[dict[str, object]]:
    """Yield a row for each tip, of the spread that one tip's force, or that and its dents, are met best with."""
    ratio = half_space(1e-3 * TIPS[1]) / half_space(1e-3 * TIPS[0])

    def missed(spread: int) -> float:
        one = made[spread, fitted]
        if by == "half space":
            off = np.log(made[spread, TIPS[1]].force / made[spread, TIPS[0]].force / ratio)
            return float((off**2).mean())
        off = (_stiffness(one, solid[fitted]) * one.force - solid[fitted]) / solid[fitted].max()
        return float((off**2).mean() + ((one.dents**2).mean() if by != "force" else 0.0))

    spread = min(SPREADS, key=missed)
    stiffness = _stiffness(made[spread, fitted], solid[fitted])
    for tip in TIPS:
        one = made[spread, tip]
        off = stiffness * one.force / solid[tip] - 1
        yield {
            "solid": law, "fitted_mm": fitted, "by": by, "spread_mm": spread, "tip_mm": tip,
            **{f"force_{1e3 * depth:g}_mm_percent": round(100 * each, 1)
               for depth, each in zip(DEPTHS, off.tolist(), strict=True)},
            **{f"dent_{1e3 * depth:g}_mm_percent": round(100 * each, 2)
               for depth, each in zip(DENTED, one.dents.tolist(), strict=True)},
            "volume_percent": round(100 * one.volume, 4),
        }  # fmt: skip


def half_space(radius: float) -> Floats:
    """Return what an elastic half space, as curved as the ball, answers a tip of a radius [m] at DEPTHS, over E* (k,).

    Source: Sneddon 1965; curvatures are added as Hertz does.
    """
    radius = 1 / (1 / radius + 1 / BALL_RADIUS)

    def depth(a: float) -> float:  # at which the contact is as wide as a
        return float(a / 2 * np.log((radius + a) / (radius - a)))

    widest = radius * (1 - 1e-12)
    contacts = np.array([brentq(lambda a, x=x: depth(a) - x, 0.0, widest) for x in DEPTHS])
    return np.array([(1 + (radius / a) ** 2) * a * depth(a) - radius * a for a in contacts])


def _settled(mesh: Mesh, spread: int, tip: int) -> list[dents.Settled]:
    even = replace(DEFAULT_MATERIAL, K2=DEFAULT_MATERIAL.K1, fill="liquid", density=1000, spread=1e-3 * spread)
    return list(dents.settle(mesh, even, 1e-3 * tip, DEPTHS))


def _stiffness(one: Pressed, solid: Floats) -> float:
    """Return the factor by which forces come nearest to a solid's."""
    return float(one.force @ solid / (one.force @ one.force))


def _solid_force(law: str, tip: int) -> Floats:
    """Return the forces (k,) [N] of the ball by finite elements, at the depths."""
    with (dents.KEPT / "solid_force.csv").open(newline="", encoding="utf-8") as file:
        some = [row for row in csv.DictReader(file) if (row["body"], row["law"]) == ("ball", law)]
    curve = np.array([(row["depth_mm"], row["force_n"]) for row in some if row["tip"] == f"ball {tip} mm"], float)
    return np.asarray(np.interp(DEPTHS, 1e-3 * curve[:, 0], curve[:, 1]))


def dent_error(mesh: Mesh, one: dents.Settled, true: Profile) -> float:
    """Return the RMS error of a dent along the skin over its depth."""
    spacing = mean_spacing(mesh, len(mesh.rest_positions))
    shape = profile(mesh.rest_positions, one.positions, spacing, within=2.2 * BALL_RADIUS)
    way = np.linspace(0, WITHIN, 200)
    off = np.interp(way, shape.way, shape.inward()) - np.interp(way, true.way, true.inward())
    return float(np.sqrt((off**2).mean()) / one.depth)


def _volume(mesh: Mesh, positions: Floats) -> float:
    a, b, c = positions[mesh.triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)
