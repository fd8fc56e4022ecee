"""Draw the charts of the studies: `python -m tools.charts --out DIR [--quick]`, each as PNG, SVG and CSV.

The numbers come from core.study; drawing and the independent solver are development only.
"""

from __future__ import annotations

import argparse
import math
import shutil
import time
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.integrate import solve_ivp

from core.base import Floats
from core.integrators.methods import FRONTS, METHODS
from core.model import Model, State
from core.study import stability, work_precision
from core.study.motion import right_hand_side

from .charts_model import draw_cost, draw_energy, draw_literal, draw_space, draw_stiff_nylon
from .drawing import LABELS, MARKERS, STYLES, edges, save, table, write_csv
from .environment import ROOT

CELLS = ("stable", "inaccurate", "blown up")
KEPT = ROOT / "tests" / "study" / "charts"  # what the README shows
COLOURS = ("#4c9f70", "#f2c14e", "#d1495b")


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("build/charts"), metavar="DIR")
    parser.add_argument("--quick", action="store_true", help="smaller bodies, fewer points: under 50 seconds")
    parser.add_argument("--keep", action="store_true", help="keep the main charts and the fronts")
    options = parser.parse_args(words)
    options.out.mkdir(parents=True, exist_ok=True)
    for draw in (
        draw_work_precision, draw_stability, draw_energy, draw_literal, draw_cost, draw_space, draw_stiff_nylon
    ):  # fmt: skip
        started = time.perf_counter()
        draw(options.out, options.quick)
        print(f"{draw.__name__.removeprefix('draw_')}: {time.perf_counter() - started:.1f} s", flush=True)
    if options.keep:
        keep(options.out)
    print("\nWhere each method fails, and why\n" + where_methods_fail(), flush=True)
    return 0


def dop853(model: Model, start: State, seconds: float) -> Floats:
    """Return the positions (3, n) after a time by SciPy's DOP853, rtol 1e-10."""
    y = np.concatenate([start.positions.ravel(), start.velocities.ravel()])
    answer = solve_ivp(right_hand_side(model), (0, seconds), y, method="DOP853", rtol=1e-10, atol=1e-13)
    return np.asarray(answer.y[: start.positions.size, -1]).reshape(3, -1)


def draw_work_precision(out: Path, quick: bool) -> None:
    cases = work_precision.cases(quick=quick)
    points = {}
    for case in cases:
        started = time.perf_counter()
        points[case.name] = list(work_precision.measure(case, reference=dop853, quick=quick))
        print(f"  {case.name}: {time.perf_counter() - started:.1f} s", flush=True)
    rows = [point for case in cases for point in points[case.name]]
    write_csv(
        out / "work_precision.csv",
        ("scene", "method", "steps", "relative_error", "finger_force_n", "cpu_s", "unsolved_steps"),
        ((p.case, p.method, p.steps, p.error, p.force, p.cost, p.unsolved) for p in rows),
    )
    figure, grid = plt.subplots(2, 3, figsize=(13.5, 9), sharey=False)
    panels = list(grid.flat)
    for case, axes in zip(cases, panels, strict=False):
        for name, label in LABELS.items():
            good = [p for p in points[case.name] if p.method == name and math.isfinite(p.error)]
            axes.loglog(
                [max(p.error, 1e-9) for p in good], [p.cost for p in good], color=STYLES[name], marker=MARKERS[name],
                ms=5, lw=1.2, label=label,
            )  # fmt: skip
            odd = [p for p in good if p.unsolved]
            axes.loglog([p.error for p in odd], [p.cost for p in odd], "x", color="black", ms=7)
        how = f"fingertip down {1e3 * case.depth:.0f} mm" if case.depth else "no contact"
        axes.set_title(f"{case.label}\n{case.model.mass.size} vertices, {1e3 * case.seconds:.0f} ms, {how}")
        axes.set_xlabel("error of the positions over the motion")
        axes.invert_xaxis()
    for axes in grid[:, 0]:
        axes.set_ylabel("processor time [s], lower is better")
    for axes in panels[len(cases) :]:
        axes.set_axis_off()
    grid[-1, -1].legend(*grid[0, 0].get_legend_handles_labels(), loc="center", frameon=False, fontsize=10)
    figure.suptitle(
        "Work against precision. Right and low is good; runs that blew up are left out; x: steps without a solution"
    )
    save(figure, out / "work_precision")
    best = {case.name: work_precision.front(points[case.name]) for case in cases}
    write_csv(
        out / "fronts.csv", ("scene", "error_at_most", "method", "steps", "relative_error", "cpu_ms"),
        ((scene, bound, p.method, p.steps, f"{p.error:.3g}", f"{1e3 * p.cost:.3g}")
         for scene, found in best.items() for bound, p in found.items() if p),
    )  # fmt: skip
    lines = [("scene", *(f"<= {bound:.0e}" for bound in work_precision.DECADES))]
    for scene, found in best.items():
        lines.append((scene, *(f"{p.method} {1e3 * p.cost:.0f} ms" if p else "-" for p in found.values())))
    print("\nThe cheapest method in numpy for an error of at most\n" + table(lines), flush=True)
    chosen = {p.method for found in best.values() for p in found.values() if p}
    print("Not offered, on no front: " + ", ".join(n for n in METHODS if n not in chosen) + "\n", flush=True)


def draw_stability(out: Path, quick: bool) -> None:
    stiffness = np.logspace(0.8, 4.8, 4 if quick else 13)
    steps = np.logspace(-4, -1, 6 if quick else 19)
    found = list(stability.stability_map(list(METHODS), stiffness.tolist(), steps.tolist()))
    cells = {(c.method, c.k, c.dt): c for c in found if isinstance(c, stability.Cell)}
    bounds = [b for b in found if not isinstance(b, stability.Cell)]
    write_csv(
        out / "stability.csv",
        ("method", "k_n_per_m", "dt_s", "label", "error"),
        ((c.method, c.k, c.dt, c.label, c.error) for c in cells.values()),
    )
    write_csv(out / "stability_bounds.csv", ("method", "k_n_per_m", "bound_dt_s", "product_dt_s"), bounds)
    columns = math.ceil(len(METHODS) / 3)
    figure, panels = plt.subplots(3, columns, figsize=(3.6 * columns, 9.6), sharex=True, sharey=True)
    for axes in panels.flat[len(METHODS) :]:
        axes.set_axis_off()
    for (name, method), axes in zip(METHODS.items(), panels.flat, strict=False):
        codes = [[CELLS.index(cells[name, k, dt].label) for k in stiffness] for dt in steps]
        axes.grid(False)
        axes.pcolormesh(
            edges(stiffness),
            edges(steps),
            codes,
            cmap=ListedColormap(COLOURS),
            vmin=-0.5,
            vmax=2.5,
            edgecolors="white",
            lw=0.3,
        )
        mine = [b for b in bounds if b[0] == name]
        if mine:
            axes.plot([b[1] for b in mine], [b[2] for b in mine], "k-", lw=1.8)
            axes.plot([b[1] for b in mine], [b[3] for b in mine], "k:", lw=1.2)
        axes.set(xscale="log", yscale="log", title=method.label)
    for axes in panels[-1]:
        axes.set_xlabel("surface spring constant k [N/m]")
    for axes in panels[:, 0]:
        axes.set_ylabel("time step [s]")
    keys: list[Patch | Line2D] = [Patch(color=c, label=label) for c, label in zip(COLOURS, CELLS, strict=True)]
    keys.append(Line2D([], [], color="black", lw=1.8, label="bound in theory"))
    keys.append(Line2D([], [], color="black", ls=":", label="step the product takes (semi-implicit)"))
    figure.legend(handles=keys, loc="lower center", ncols=5, frameon=False)
    figure.suptitle(
        f"Where methods blow up: ball of 12 vertices. Blown up: deformed over {stability.BLOWN:.0f} times the start; "
        f"inaccurate: off by more than {100 * stability.INACCURATE:.0f} % of it.\n"
        "Where a step is longer than the motion lasts, a damped body is at rest either way: green at the top right."
    )
    save(figure, out / "stability", bottom=0.03)


def keep(out: Path) -> None:
    """Keep the two main charts and the table of who is on the front."""
    KEPT.mkdir(parents=True, exist_ok=True)
    for name in ("work_precision", "stability"):
        for suffix in (".png", ".svg", ".csv"):
            shutil.copyfile(out / (name + suffix), KEPT / (name + suffix))
    shutil.copyfile(out / "stability_bounds.csv", KEPT / "stability_bounds.csv")
    shutil.copyfile(out / "fronts.csv", FRONTS)


def where_methods_fail() -> str:
    return "\n".join(f"  {m.label} (order {m.order}, {m.kind}): {m.purpose}.\n    {m.fails}" for m in METHODS.values())


if __name__ == "__main__":
    raise SystemExit(main())
