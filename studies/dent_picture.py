"""Pictures of dents: seen from above in a low light, beside those by finite elements; and their profiles."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from core.base import Floats, Ints
from core.mesh.surface import Mesh
from core.reduction.cells import vertex_normals

from .dent_shape import Profile, ways
from .solid_mesh import BALL_RADIUS

SHOWN = (0.010, 0.015, 0.020, 0.025)  # [m] depths
HALF = 0.045  # [m] half the width of a picture
LIGHT = np.array([-0.75, 0.35, 0.56])  # where it comes from
TIP = "ball 10 mm"

Dent = tuple[str, str, float, Mesh, Floats]  # material, label, depth [m], mesh, positions (n, 3) [m]


def draw_dents(dents: Sequence[Dent], solids: dict[tuple[str, float], Profile], out: Path) -> None:
    """Draw a picture for each material: a row for each depth, a column for each mesh, the finite elements last."""
    from matplotlib.figure import Figure

    for name in dict.fromkeys(dent[0] for dent in dents):
        labels = list(dict.fromkeys(dent[1] for dent in dents if dent[0] == name))
        figure = Figure(figsize=(2.6 * (len(labels) + 1), 2.7 * len(SHOWN)), layout="constrained")
        grid = figure.subplots(len(SHOWN), len(labels) + 1, squeeze=False)
        for row, depth in zip(grid, SHOWN, strict=True):
            for axes, label in zip(row, labels, strict=False):
                _, _, _, mesh, x = next(d for d in dents if d[:2] == (name, label) and abs(d[2] - depth) < 1e-6)
                shade(axes, mesh.rest_positions, mesh.triangles, x)
                axes.set_title(f"{label}: {1e3 * depth:g} mm", fontsize=8)
            last = row[-1]
            last.axis("off")
            solid = solids.get((TIP, round(depth, 6)))
            if solid is not None:
                shade(last, *turned(solid))
                last.set_title(f"finite elements: {1e3 * depth:g} mm", fontsize=8)
        figure.savefig(out / f"dents_{name}.png", dpi=100)


def turned(solid: Profile, sections: int = 180) -> tuple[Floats, Ints, Floats]:
    """Return the surface of revolution of a profile: places at rest, triangles and places now."""
    turn = np.arange(sections) * 2 * np.pi / sections
    some = solid.way < 1.2
    way, r, z = (part[some, None] for part in (solid.way, solid.r, solid.z))
    angle = way / BALL_RADIUS
    rest = [BALL_RADIUS * np.sin(angle) * np.cos(turn), BALL_RADIUS * np.sin(angle) * np.sin(turn),
            BALL_RADIUS * np.cos(angle) + 0 * turn]  # fmt: skip
    now = [r * np.cos(turn), r * np.sin(turn), z + BALL_RADIUS + 0 * turn]
    corner = np.arange(len(way) * sections).reshape(len(way), sections)
    a, b, c, d = corner[:-1], corner[1:], np.roll(corner[1:], -1, axis=1), np.roll(corner[:-1], -1, axis=1)
    faces = np.concatenate([np.stack(three, -1).reshape(-1, 3) for three in ((a, b, c), (a, c, d))])
    return np.stack(rest, -1).reshape(-1, 3), faces, np.stack(now, -1).reshape(-1, 3)


def shade(axes: Any, rest: Floats, triangles: Ints, x: Floats) -> None:
    """Draw a surface as smooth shading shows it, from above."""
    some = triangles[(ways(rest)[triangles] < 2 * HALF).all(axis=1)]
    normals = vertex_normals(triangles, x)
    grey = np.clip(normals @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1)
    axes.tripcolor(1e3 * x[:, 0], 1e3 * x[:, 1], some, grey, shading="gouraud", cmap="gray", vmin=0, vmax=1)
    axes.set(xlim=(-1e3 * HALF, 1e3 * HALF), ylim=(-1e3 * HALF, 1e3 * HALF), aspect="equal")
    axes.axis("off")


def draw_profiles(shapes: dict[tuple[str, str, float], Profile], path: Path) -> None:
    """Draw the skin pressed by each tip to 10 and 20 mm, with and without a spread, over that by finite elements."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 9), layout="constrained")
    tips = list(dict.fromkeys(tip for _, tip, _ in shapes))
    tips = [tip for tip in tips if ("spread 0 mm", tip, 0.010) in shapes]
    for axes, (tip, depth) in zip(
        figure.subplots(2, 2).ravel(), [(tip, depth) for tip in tips for depth in (0.010, 0.020)], strict=True
    ):
        for name in dict.fromkeys(name for name, _, _ in shapes):
            shape = shapes[name, tip, depth]
            style: dict[str, Any] = {"color": "k", "lw": 2.5} if name == "finite elements" else {"lw": 1.2}
            axes.plot(1e3 * shape.r, 1e3 * shape.z, label=name, **style)
        axes.set(title=f"{tip}, {1e3 * depth:g} mm", xlabel="r [mm]", ylabel="z [mm]", xlim=(0, 85), ylim=(-70, 5))
        axes.set_aspect("equal")
        axes.legend(fontsize="small")
    figure.savefig(path, dpi=100)
