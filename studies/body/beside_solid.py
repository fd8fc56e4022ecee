"""A solid that one tip measured, beside finite elements: its force and dents under that tip and under another.

A ball and a block have the two slopes K1 and K2 that are fitted to the force of one tip on the solid. Their fill is
"liquid" or "solid": both keep their volume, but the skin of a solid gives way under a fingertip.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from core.base import Floats
from core.calibration.fit import fit_law
from core.material import DEFAULT_MATERIAL, Indenter, Material
from core.mesh.surface import Mesh
from studies.body import dents
from studies.body.solid_mesh import BALL_RADIUS, BLOCK_EDGE
from studies.files import new_figure, read_csv, save_picture, write_csv
from studies.meshes.simple import box, sized

KEPT = Path(__file__).parents[2] / "tests" / "studies" / "solid"  # the finite elements' force and dents
BODIES, LAWS, FILLS = ("ball", "block"), ("linear", "neo-hookean"), ("liquid", "solid")
TIPS = (10, 20)  # [mm] radii
SPREAD = 0.025  # [m]
DEPTHS, DENTED = (0.001, 0.002, 0.005, 0.010, 0.015, 0.020), (0.005, 0.010, 0.020)  # [m]
STEP = 0.00025  # [m] between the depths of the solid's curve
WITHIN, RINGS = 0.050, 25  # [m] along the skin: how far dents are compared, ring by ring
CELLS = {4: 28, 5: 57}  # of an edge of the block: as fine as the ball, by its subdivisions
HEAD = ("body", "solid", "measured_mm", "fill", "tip_mm", *(f"dent_{1e3 * depth:g}_mm_percent" for depth in DENTED),
        "volume_percent")  # fmt: skip


def rows(
    subdivisions: int, *, bodies: Sequence[str] = BODIES, laws: Sequence[str] = LAWS, tips: Sequence[int] = TIPS
) -> Iterator[tuple[object, ...]]:
    """Yield how far the dents of either tip, in a body measured through one, are from those of the solid; see HEAD."""
    for body, law, tip, fill, other in itertools.product(bodies, laws, tips, FILLS, TIPS):
        mesh, some = settled(subdivisions, body, law, tip, fill, other, DENTED)
        errors = (round(100 * dent_error(mesh, one, body, law, other), 2) for one in some)
        volume = max(abs(_volume(mesh, one) - 1) for one in some)
        yield body, law, tip, fill, other, *errors, round(100 * volume, 4)


def settled(
    subdivisions: int, body: str, law: str, tip: int, fill: str, other: int, depths: Sequence[float]
) -> tuple[Mesh, list[dents.Settled]]:
    """Return a body measured through a tip [mm], and how it rests under another at each depth [m]."""
    mesh = dents.ball(subdivisions) if body == "ball" else sized(*box(CELLS[subdivisions]), BLOCK_EDGE)
    material = replace(measured(body, law, tip), fill=fill, spread=SPREAD)
    return mesh, list(dents.settle(mesh, material, 1e-3 * other, depths))


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


def solid_skin(body: str, law: str, tip: int, depth: float) -> tuple[Floats, Floats]:
    """Return places (k, 3) on the skin of the finite elements, from the axis outwards, at rest and pressed [m]."""
    some = [row for row in _table("solid_dent.csv") if _is(row, body, law, tip)]
    names = ("depth_mm", "r_mm", "z_mm", "u_r_mm", "u_z_mm")
    places = 1e-3 * np.array([[row[name] for name in names] for row in some], float)
    r, z, u_r, u_z = places[np.isclose(places[:, 0], depth), 1:].T
    top, none = BALL_RADIUS if body == "ball" else BLOCK_EDGE / 2, 0 * r
    rest = np.stack([r, none, z + top], axis=1)
    return rest, rest + np.stack([u_r, none, u_z], axis=1)


def dent_error(mesh: Mesh, one: dents.Settled, body: str, law: str, tip: int) -> float:
    """Return the RMS over the rings of a dent, along the skin, of its error over its depth."""
    way, inward = _along_skin(body, mesh.rest_positions, one.positions)
    true_way, true_inward = _along_skin(body, *solid_skin(body, law, tip, one.depth))
    ring = np.floor(way / WITHIN * RINGS).astype(int)
    off = inward - np.interp(way, true_way, true_inward)
    rings = [float(np.mean(off[ring == k] ** 2)) for k in range(RINGS) if (ring == k).any()]
    return float(np.sqrt(np.mean(rings)) / one.depth)


def draw(out: Path, subdivisions: int) -> None:
    """Draw force and dents of the block that the smaller tip measured, over those by finite elements."""
    body, law, (small, _) = "block", "linear", TIPS
    figure = new_figure(11, 3.9)
    force, *sections = figure.subplots(1, 3, width_ratios=(1, 1.1, 1.1))
    table: list[tuple[object, ...]] = []
    for axes, tip, color in zip(sections, TIPS, ("tab:blue", "tab:orange"), strict=True):
        mesh, some = settled(subdivisions, body, law, small, "solid", tip, DEPTHS)
        true_depths, true_forces = curve(body, law, tip)
        force.plot(1e3 * true_depths, true_forces, "k", lw=1)
        what = "measured with it" if tip == small else "predicted"
        forces = [one.force for one in some]
        force.plot([1e3 * one.depth for one in some], forces, "o", color=color, label=f"{tip} mm tip, {what}")
        table += [("force_n", tip, 1e3 * one.depth, "", one.force) for one in some]
        rest, top = mesh.rest_positions, float(mesh.rest_positions[:, 2].max())
        row = BLOCK_EDGE / CELLS[subdivisions] * 0.51  # the row beside the axis, where none lies on it
        section = (rest[:, 0] > -1e-6) & (rest[:, 1] > -1e-6) & (rest[:, 1] < row) & (rest[:, 2] > top - 1e-6)
        for one in (one for one in some if one.depth in DENTED):
            pressed = solid_skin(body, law, tip, one.depth)[1]
            pressed = pressed[pressed[:, 2] > pressed[0, 2] - 1e-9]
            axes.plot(1e3 * pressed[:, 0], 1e3 * (pressed[:, 2] - BLOCK_EDGE / 2), "k", lw=1)
            now = one.positions[section]
            x = 1e3 * np.stack([np.hypot(now[:, 0], now[:, 1]), now[:, 2] - top], axis=1)
            axes.plot(x[:, 0], x[:, 1], ".", ms=4, color=color)
            table += [("height_mm", tip, 1e3 * one.depth, f"{r:.3f}", f"{z:.3f}") for r, z in x]
        axes.set(
            title=f"dents of the {tip} mm tip", xlabel="distance from the axis [mm]", ylabel="height of the skin [mm]",
            xlim=(0, 60), ylim=(-21, 1), yticks=range(-20, 1, 5),
        )  # fmt: skip
    force.plot([], [], "k", lw=1, label="finite elements")
    force.set(title="force", xlabel="depth [mm]", ylabel="force on the fingertip [N]")
    force.legend(frameon=False, fontsize=8)
    figure.suptitle("A solid block, measured with a tip of 10 mm: Dimple (dots) beside finite elements (lines)")
    save_picture(figure, out / "finite_elements.png")
    write_csv(out / "finite_elements.csv", ("what", "tip_mm", "depth_mm", "from_axis_mm", "value"), table)


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
    return read_csv(KEPT / name)
