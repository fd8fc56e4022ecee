"""A solid by finite elements, measured through one tip: how the dents of that tip and another compare.

A ball and a block have the two slopes K1 and K2 that are fitted to the force of one tip on the solid, with a spread
of 20 and of 25 mm. Their fill is "liquid" or "solid": both keep their volume, but the skin
of a solid gives way under a fingertip.
"""

from __future__ import annotations

import csv
import functools
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from core.base import Floats
from core.calibration.fit import fit_law
from core.material import DEFAULT_MATERIAL, Indenter, Material
from core.mesh.surface import Mesh

from . import dents
from .primitives import box, sized
from .solid_mesh import BALL_RADIUS, BLOCK_EDGE

BODIES, LAWS, FILLS = ("ball", "block"), ("linear", "neo-hookean"), ("liquid", "solid")
TIPS = (10, 20)  # [mm] radii
SPREADS = (0.020, 0.025)  # [m]
DEPTHS, DENTED = (0.001, 0.002, 0.005, 0.010, 0.015, 0.020), (0.005, 0.010, 0.020)  # [m]
STEP = 0.00025  # [m] between the depths of the solid's curve
WITHIN, RINGS = 0.050, 25  # [m] along the skin: how far dents are compared, ring by ring
CELLS = {4: 28, 5: 57}  # of an edge of the block: as fine as the ball, by its subdivisions


def rows(
    subdivisions: int,
    *,
    bodies: Sequence[str] = BODIES,
    laws: Sequence[str] = LAWS,
    tips: Sequence[int] = TIPS,
    spreads: Sequence[float] = SPREADS,
) -> Iterator[dict[str, object]]:
    """Yield how far the dents of either tip, in a body measured through one, are from those of the solid."""
    for body in bodies:
        mesh = dents.ball(subdivisions) if body == "ball" else sized(*box(CELLS[subdivisions]), BLOCK_EDGE)
        for law in laws:
            for tip in tips:
                material = measured(body, law, tip)
                for fill, spread in itertools.product(FILLS, spreads):
                    given = replace(material, fill=fill, spread=spread)
                    for other in TIPS:
                        some = list(dents.settle(mesh, given, 1e-3 * other, DENTED))
                        yield {
                            "body": body, "solid": law, "measured_mm": tip, "fill": fill, "spread_mm": 1e3 * spread,
                            "tip_mm": other,
                            **{f"dent_{1e3 * one.depth:g}_mm_percent":
                               round(100 * _dent_error(mesh, one, body, law, other), 2) for one in some},
                            "volume_percent": round(100 * max(abs(_volume(mesh, one) - 1) for one in some), 4),
                        }  # fmt: skip


def curve(body: str, law: str, tip: int) -> tuple[Floats, Floats]:
    """Return depths [m] and forces [N] of a body by finite elements, from 0 on."""
    some = [row for row in _table("solid_force.csv") if _is(row, body, law, tip)]
    kept = np.array([(row["depth_mm"], row["force_n"]) for row in some], float)
    depths = np.linspace(0.0, DEPTHS[-1], round(DEPTHS[-1] / STEP) + 1)
    through = PchipInterpolator(np.append(0.0, 1e-3 * kept[:, 0]), np.append(0.0, kept[:, 1]))
    return depths, np.asarray(through(depths))


def measured(body: str, law: str, tip: int) -> Material:
    """Return the material whose K1, K2 and x0 a tip measures on the solid."""
    fit = fit_law(*curve(body, law, tip))
    return replace(
        DEFAULT_MATERIAL, K1=fit.K1.value, K2=fit.K2.value, x0=fit.x0.value, density=1000,
        indenter=Indenter(shape="sphere", radius=1e-3 * tip),
    )  # fmt: skip


def _dent_error(mesh: Mesh, one: dents.Settled, body: str, law: str, tip: int) -> float:
    """Return the RMS over the rings of a dent, along the skin, of its error over its depth."""
    way, inward = _along_skin(body, mesh.rest_positions, one.positions)
    some = [row for row in _table("solid_dent.csv") if _is(row, body, law, tip)]
    places = np.array(
        [[row[name] for name in ("depth_mm", "r_mm", "z_mm", "u_r_mm", "u_z_mm")] for row in some], float
    )
    r, z, u_r, u_z = 1e-3 * places[np.isclose(1e-3 * places[:, 0], one.depth), 1:].T
    top = BALL_RADIUS if body == "ball" else BLOCK_EDGE / 2
    rest, none = np.stack([r, 0 * r, z + top], axis=1), 0 * r
    true_way, true_inward = _along_skin(body, rest, rest + np.stack([u_r, none, u_z], axis=1))
    ring = np.floor(way / WITHIN * RINGS).astype(int)
    off = inward - np.interp(way, true_way, true_inward)
    rings = [float(np.mean(off[ring == k] ** 2)) for k in range(RINGS) if (ring == k).any()]
    return float(np.sqrt(np.mean(rings)) / one.depth)


def _along_skin(body: str, rest: Floats, now: Floats) -> tuple[Floats, Floats]:
    """Return the ways (k,) along the skin from where it is touched, and how far it went in along its normals [m]."""
    if body == "block":
        top = rest[:, 2] > rest[:, 2].max() - 1e-6
        return np.hypot(rest[top, 0], rest[top, 1]), (rest - now)[top, 2]
    normals = rest / np.linalg.norm(rest, axis=1)[:, None]
    return BALL_RADIUS * np.arccos(normals[:, 2].clip(-1, 1)), ((rest - now) * normals).sum(axis=1)


def _volume(mesh: Mesh, one: dents.Settled) -> float:
    """Return the volume over that at rest."""
    a, b, c = one.positions[mesh.triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6 / mesh.volume)


def _is(row: dict[str, str], body: str, law: str, tip: int) -> bool:
    return (row["body"], row["law"], row["tip"]) == (body, law, f"ball {tip} mm")


@functools.cache
def _table(name: str) -> list[dict[str, str]]:
    with (dents.KEPT / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))
