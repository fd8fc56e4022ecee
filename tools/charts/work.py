"""The work-precision chart: the cost of each method against its error, and the cheapest method for each error."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from scipy.integrate import solve_ivp

from core.base import Floats
from core.body.model import Model
from studies import work_precision
from studies.methods.registry import METHODS
from studies.motion import right_hand_side
from studies.reference.laws import State
from studies.work_precision import DECADES, NATIVE, Case, Point

from .drawing import LABELS, MARKERS, STYLES, save, table, write_csv

RING: dict[str, Any] = {"color": "goldenrod", "marker": "o", "ms": 12, "mfc": "none", "mew": 2, "ls": ""}


def dop853(model: Model, start: State, seconds: float) -> Floats:
    """Return the positions (3, n) after a time by SciPy's DOP853, rtol 1e-10."""
    y = np.concatenate([start.positions.ravel(), start.velocities.ravel()])
    answer = solve_ivp(right_hand_side(model), (0, seconds), y, method="DOP853", rtol=1e-10, atol=1e-13)
    return np.asarray(answer.y[: start.positions.size, -1]).reshape(3, -1)


def draw_work_precision(out: Path, quick: bool) -> None:
    cases = work_precision.cases(quick=quick)
    points: dict[str, list[Point]] = {}
    for case in cases:
        started = time.perf_counter()
        points[case.name] = list(work_precision.measure(case, reference=dop853, quick=quick))
        print(f"  {case.name}: {time.perf_counter() - started:.1f} s", flush=True)
    write_csv(
        out / "work_precision.csv",
        ("scene", "method", "steps", "relative_error", "cpu_s", "unsolved_steps"),
        ((p.case, p.method, p.steps, p.error, p.cost, p.unsolved) for some in points.values() for p in some),
    )
    best = {scene: {b: p for b, p in work_precision.front(some).items() if p} for scene, some in points.items()}
    write_csv(
        out / "fronts.csv", ("scene", "error_at_most", "method", "steps", "relative_error", "cpu_ms"),
        ((scene, bound, p.method, p.steps, f"{p.error:.3g}", f"{1e3 * p.cost:.3g}")
         for scene, found in best.items() for bound, p in found.items()),
    )  # fmt: skip
    print_fronts(points, best)
    chosen = {p.method for found in best.values() for p in found.values()}
    columns = math.ceil(len(cases) / 2)
    figure, panels = plt.subplots(2, columns, figsize=(3.7 * columns, 8.4))
    for case, axes in zip(cases, panels.flat, strict=True):
        draw_panel(axes, case, points[case.name], list(best[case.name].values()), chosen)
    handles = [line(name, name in chosen, label=label) for name, label in LABELS.items()]
    handles.append(Line2D([], [], **RING, label="the cheapest in numpy for its error"))
    handles.append(Line2D([], [], color="black", marker="x", ls="", label="steps without a solution"))
    figure.legend(handles=handles, loc="lower center", frameon=False, ncols=columns + 1)
    figure.suptitle("The price of precision. Lower is faster, further right more exact.\nDashed: nowhere the cheapest")
    save(figure, out / "work_precision", bottom=0.12)


def draw_panel(axes: Axes, case: Case, points: list[Point], best: list[Point], chosen: set[str]) -> None:
    """Draw cost against error on one scene, with the cheapest points ringed."""
    for name in LABELS:
        good = [p for p in points if p.method == name and math.isfinite(p.error)]
        if good:
            axes.add_line(line(name, name in chosen, [max(p.error, 1e-9) for p in good], [p.cost for p in good]))
    axes.plot([p.error for p in best], [p.cost for p in best], **RING)
    odd = [p for p in points if p.unsolved and math.isfinite(p.error)]
    axes.plot([p.error for p in odd], [p.cost for p in odd], "x", color="black", ms=6)
    how = f"fingertip {1e3 * case.depth:.0f} mm down" if case.depth else "nothing touches it"
    axes.set(xscale="log", yscale="log", xlabel="error of the positions / motion", ylabel="processor time [s]")
    axes.set_title(f"{case.label}\n{case.model.mass.size} vertices, {1e3 * case.seconds:.0f} ms, {how}", fontsize=9)
    axes.minorticks_off()
    axes.autoscale_view()
    axes.invert_xaxis()


def line(name: str, chosen: bool, x: Sequence[float] = (), y: Sequence[float] = (), label: str = "") -> Line2D:
    """Return the line of a method, bold if the method is the cheapest for some error or is the native core."""
    bold = chosen or name == NATIVE
    return Line2D(
        x, y, color=STYLES[name], marker=MARKERS[name], ms=5, lw=1.8 if bold else 1.0, ls="-" if bold else "--",
        alpha=1.0 if bold else 0.75, label=label,
    )  # fmt: skip


def print_fronts(points: dict[str, list[Point]], best: dict[str, dict[float, Point]]) -> None:
    lines = [("scene", *(f"<= {bound:.0e}" for bound in DECADES), "in C")]
    for scene, found in best.items():
        cheapest = [
            f"{found[b].method} {1e3 * found[b].cost:.0f} ms" if b in found else "-" for b in work_precision.DECADES
        ]
        both = [
            next((p.cost for p in points[scene] if p.method == name), math.nan) for name in ("semi_implicit", NATIVE)
        ]
        lines.append((scene, *cheapest, f"{both[0] / both[1]:.0f} times faster"))
    print("\nThe cheapest method in numpy for each error; semi-implicit Euler in C\n" + table(lines), flush=True)
    chosen = {p.method for found in best.values() for p in found.values()}
    print("Nowhere the cheapest: " + ", ".join(n for n in METHODS if n not in chosen) + "\n", flush=True)
