"""The stability map: time step against stiffness, one panel for each method."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from studies import stability
from studies.methods.registry import METHODS
from studies.stability import Bound, Cell

from .drawing import edges, save, table, write_csv

CELLS = ("stable", "inaccurate", "blown up")
COLOURS = ("#b7dcc3", "#f2b134", "#a4303f")  # they differ in lightness, for color-blind readers


def draw_stability(out: Path, quick: bool) -> None:
    stiffness = np.logspace(0.8, 4.8, 3 if quick else 9).tolist()
    steps = np.logspace(-4, -1, 4 if quick else 13).tolist()
    sought = stiffness[-1:] if quick else stiffness[::2]
    found = list(stability.stability_map(list(METHODS), stiffness, steps, sought=sought))
    cells = {(c.method, c.k, c.dt): c for c in found if isinstance(c, stability.Cell)}
    bounds = [b for b in found if isinstance(b, stability.Bound)]
    write_csv(
        out / "stability.csv",
        ("method", "k_n_per_m", "dt_s", "label", "error"),
        ((c.method, c.k, c.dt, c.label, c.error) for c in cells.values()),
    )
    write_csv(
        out / "stability_bounds.csv", ("method", "k_n_per_m", "bound_dt_s", "measured_dt_s", "product_dt_s"),
        ((b.method, b.k, b.theory, b.measured, b.product) for b in bounds),
    )  # fmt: skip
    print_stability(list(cells.values()), bounds)
    figure, panels = plt.subplots(3, 3, figsize=(10, 8.8), sharex=True, sharey=True)
    for (name, method), axes in zip(METHODS.items(), panels.flat, strict=True):
        codes = [[CELLS.index(cells[name, k, dt].label) for k in stiffness] for dt in steps]
        draw_map(axes, stiffness, steps, codes)
        draw_bounds(axes, [b for b in bounds if b.method == name])
        axes.set_title(method.label, fontsize=9)
    for axes in panels[-1]:
        axes.set_xlabel("surface spring constant k [N/m]")
    for axes in panels[:, 0]:
        axes.set_ylabel("time step [s]")
    keys: list[Patch | Line2D] = [Patch(color=c, label=label) for c, label in zip(COLOURS, CELLS, strict=True)]
    keys.append(Line2D([], [], color="black", lw=1.8, label="limit in theory"))
    keys.append(Line2D([], [], color="black", ls="", marker="o", mfc="white", ms=5, label="limit measured"))
    keys.append(Line2D([], [], color="black", ls=":", lw=1.6, label="step Dimple takes"))
    figure.legend(handles=keys, loc="lower center", ncols=6, frameon=False)
    figure.suptitle(
        f"Where methods blow up: a shaken ball of 12 vertices. Blown up: deformed over {stability.BLOWN:.0f} times as "
        f"much as at the start; inaccurate: an error over {100 * stability.INACCURATE:.0f} % of that.\n"
        "Green at the top right: the step is longer than the whole motion, after which a damped body is at rest",
        fontsize=9,
    )
    save(figure, out / "stability", bottom=0.03)


def draw_map(axes: Axes, stiffness: Sequence[float], steps: Sequence[float], codes: Sequence[Sequence[int]]) -> None:
    axes.grid(False)
    axes.pcolormesh(
        edges(np.array(stiffness)), edges(np.array(steps)), codes, cmap=ListedColormap(COLOURS), vmin=-0.5, vmax=2.5,
        edgecolors="white", lw=0.3,
    )  # fmt: skip
    axes.set(xscale="log", yscale="log")
    axes.minorticks_off()


def draw_bounds(axes: Axes, bounds: Sequence[Bound]) -> None:
    if not bounds:
        return
    k = [b.k for b in bounds]
    axes.plot(k, [b.theory for b in bounds], "k-", lw=1.8)
    axes.plot(k, [b.measured for b in bounds], "o", mfc="white", mec="black", ms=5)
    if bounds[0].method == "semi_implicit":
        axes.plot(k, [b.product for b in bounds], "k:", lw=1.6)


def print_stability(cells: list[Cell], bounds: list[Bound]) -> None:
    lines = [("method", *(f"{label} cells" for label in CELLS), "limit measured / theory")]
    for name in METHODS:
        counts = [str(sum(c.method == name and c.label == label for c in cells)) for label in CELLS]
        shares = [b.measured / b.theory for b in bounds if b.method == name and math.isfinite(b.measured)]
        lines.append((name, *counts, f"{min(shares):.3f} to {max(shares):.3f}" if shares else "none"))
    print("\nWhere methods blow up\n" + table(lines), flush=True)
