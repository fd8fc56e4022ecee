"""The solid's ball as the product identifies it: by the two slopes that are calibrated, and by the curve itself.

Both bodies have the spread that materials have by default. What a body that was identified by the solid's own curve
misses under another tip is missed by the tension; what one identified by two slopes misses beyond that, by those.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from core.base import Floats
from core.calibration.fit import fit_law
from core.calibration.indent import find_site
from core.material import DEFAULT_MATERIAL, Indenter, Material

from . import dents
from .other_tip import DENTED, DEPTHS, LAWS, TIPS, dent_error
from .virtual_press import identify

STEP = 0.00025  # [m] between the depths of the solid's curve


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve(Material):
    """A material whose law is a measured curve in place of two slopes.

    curve: (k,) depths [m] and (k,) forces [N].
    """

    curve: tuple[tuple[float, ...], tuple[float, ...]]

    def law(self, depth: float) -> float:
        """Return the measured force [N] at a depth [m]."""
        return float(np.interp(depth, *self.curve))


def rows(subdivisions: int) -> Iterator[dict[str, object]]:
    """Yield what a body that was identified through one tip answers either tip, for each law of the solid."""
    mesh = dents.ball(subdivisions)
    for law in LAWS:
        shapes = dents.profiles(law)
        for tip in TIPS:
            for by, material in _measured(law, tip):
                indenter = material.indenter
                found = identify(mesh, material, indenter, find_site(mesh, indenter), DEPTHS[-1])
                for other in TIPS:
                    wanted = np.interp(DEPTHS, *_curve(law, other))
                    some = list(dents.settle(mesh, found.material, 1e-3 * other, DEPTHS))
                    yield {
                        "solid": law, "identified_mm": tip, "by": by, "tip_mm": other,
                        **{f"force_{1e3 * one.depth:g}_mm_percent": round(100 * (float(one.force[2]) / force - 1), 1)
                           for one, force in zip(some, wanted.tolist(), strict=True)},
                        **{f"dent_{1e3 * one.depth:g}_mm_percent":
                           round(100 * dent_error(mesh, one, shapes[f"ball {other} mm", one.depth]), 2)
                           for one in some if one.depth in DENTED},
                    }  # fmt: skip


def _measured(law: str, tip: int) -> Iterator[tuple[str, Material]]:
    """Yield the material that a tip measures on the solid, by two slopes and by the curve itself."""
    depths, forces = _curve(law, tip)
    fit = fit_law(depths, forces)
    slopes = replace(
        DEFAULT_MATERIAL, K1=fit.K1.value, K2=fit.K2.value, x0=fit.x0.value, fill="liquid", density=1000,
        indenter=Indenter(shape="sphere", radius=1e-3 * tip),
    )  # fmt: skip
    yield "two slopes", slopes
    curve = tuple(depths.tolist()), tuple(forces.tolist())
    yield "curve", Curve(**{each.name: getattr(slopes, each.name) for each in fields(Material)}, curve=curve)


def _curve(law: str, tip: int) -> tuple[Floats, Floats]:
    """Return depths [m] and forces [N] of the ball by finite elements, from 0 on."""
    with (dents.KEPT / "solid_force.csv").open(newline="", encoding="utf-8") as file:
        some = [row for row in csv.DictReader(file) if (row["body"], row["law"]) == ("ball", law)]
    kept = np.array([(row["depth_mm"], row["force_n"]) for row in some if row["tip"] == f"ball {tip} mm"], float)
    depths = np.linspace(0.0, DEPTHS[-1], round(DEPTHS[-1] / STEP) + 1)
    through = PchipInterpolator(np.append(0.0, 1e-3 * kept[:, 0]), np.append(0.0, kept[:, 1]))
    return depths, np.asarray(through(depths))
