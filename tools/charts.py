"""Draw the charts of the studies: `python -m tools.charts --out DIR [--quick]`, each as PNG, SVG and CSV.

The numbers come from core.study; drawing and the independent solver are development only.
"""

from __future__ import annotations

import argparse
import csv
import math
import time
from collections.abc import Iterable, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from scipy.integrate import solve_ivp

from core.base import Floats
from core.integrators.methods import METHODS
from core.model import Model, State
from core.study import conservation, literal_against_consistent, stability, work_precision
from core.study.motion import right_hand_side

LABELS = ("stable", "inaccurate", "blown up")
COLOURS = ("#4c9f70", "#f2c14e", "#d1495b")
STYLES = dict(zip(METHODS, plt.get_cmap("tab10").colors, strict=False))  # type: ignore[attr-defined]
MARKERS = dict(zip(METHODS, "ov^sDPX*", strict=False))


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("build/charts"), metavar="DIR")
    parser.add_argument("--quick", action="store_true", help="smaller bodies, fewer points: under 50 seconds")
    options = parser.parse_args(words)
    options.out.mkdir(parents=True, exist_ok=True)
    plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "svg.hashsalt": "dimple"})
    for draw in (draw_work_precision, draw_stability, draw_energy, draw_literal):
        started = time.perf_counter()
        draw(options.out, options.quick)
        print(f"{draw.__name__.removeprefix('draw_')}: {time.perf_counter() - started:.1f} s", flush=True)
    print("\nWhere each method fails, and why\n" + where_methods_fail(), flush=True)
    return 0


def dop853(model: Model, start: State, seconds: float) -> Floats:
    """Return the positions (3, n) after a time by SciPy's DOP853, rtol 1e-10."""
    y = np.concatenate([start.positions.ravel(), start.velocities.ravel()])
    answer = solve_ivp(right_hand_side(model), (0, seconds), y, method="DOP853", rtol=1e-10, atol=1e-13)
    return np.asarray(answer.y[: start.positions.size, -1]).reshape(3, -1)


def draw_work_precision(out: Path, quick: bool) -> None:
    cases = work_precision.cases(quick=quick)
    points = {case.name: list(work_precision.measure(case, reference=dop853, quick=quick)) for case in cases}
    rows = [point for case in cases for point in points[case.name]]
    write_csv(
        out / "work_precision.csv",
        ("scene", "method", "steps", "relative_error", "finger_force_n", "cpu_s", "unsolved_steps"),
        ((p.case, p.method, p.steps, p.error, p.force, p.cost, p.unsolved) for p in rows),
    )
    figure, panels = plt.subplots(1, len(cases), figsize=(4.1 * len(cases), 4.6), sharey=False)
    for case, axes in zip(cases, panels, strict=True):
        for name, method in METHODS.items():
            good = [p for p in points[case.name] if p.method == name and math.isfinite(p.error)]
            axes.loglog(
                [max(p.error, 1e-9) for p in good], [p.cost for p in good], color=STYLES[name], marker=MARKERS[name],
                ms=5, lw=1.2, label=method.label,
            )  # fmt: skip
            odd = [p for p in good if p.unsolved]
            axes.loglog([p.error for p in odd], [p.cost for p in odd], "x", color="black", ms=7)
        how = f"fingertip down {1e3 * case.depth:.0f} mm" if case.depth else "no contact"
        axes.set_title(f"{case.label}\n{case.model.mass.size} vertices, {1e3 * case.seconds:.0f} ms, {how}")
        axes.set_xlabel("error of the positions over the motion")
        axes.invert_xaxis()
    panels[0].set_ylabel("processor time [s], lower is better")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=len(labels), frameon=False)
    figure.suptitle(
        "Work against precision. Right and low is good; runs that blew up are left out; x: steps without a solution"
    )
    save(figure, out / "work_precision", bottom=0.1)
    lines = [("scene", *(f"<= {bound:.0e}" for bound in work_precision.DECADES))]
    for case in cases:
        best = work_precision.front(points[case.name])
        lines.append((case.name, *(f"{p.method} {1e3 * p.cost:.0f} ms" if p else "-" for p in best.values())))
    write_csv(out / "work_precision_front.csv", lines[0], lines[1:])
    print("\nThe cheapest method for an error of at most\n" + table(lines) + "\n", flush=True)


def draw_stability(out: Path, quick: bool) -> None:
    stiffness = np.logspace(0.8, 4.8, 5 if quick else 13)
    steps = np.logspace(-4, -1, 7 if quick else 25)
    found = list(stability.stability_map(list(METHODS), stiffness.tolist(), steps.tolist()))
    cells = {(c.method, c.k, c.dt): c for c in found if isinstance(c, stability.Cell)}
    bounds = [b for b in found if not isinstance(b, stability.Cell)]
    write_csv(
        out / "stability.csv",
        ("method", "k_n_per_m", "dt_s", "label", "error"),
        ((c.method, c.k, c.dt, c.label, c.error) for c in cells.values()),
    )
    write_csv(out / "stability_bounds.csv", ("method", "k_n_per_m", "bound_dt_s", "product_dt_s"), bounds)
    columns = math.ceil(len(METHODS) / 2)
    figure, panels = plt.subplots(2, columns, figsize=(3.6 * columns, 7.2), sharex=True, sharey=True)
    for axes in panels.flat[len(METHODS) :]:
        axes.set_axis_off()
    for (name, method), axes in zip(METHODS.items(), panels.flat, strict=False):
        codes = [[LABELS.index(cells[name, k, dt].label) for k in stiffness] for dt in steps]
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
    keys: list[Patch | Line2D] = [Patch(color=c, label=label) for c, label in zip(COLOURS, LABELS, strict=True)]
    keys.append(Line2D([], [], color="black", lw=1.8, label="bound in theory"))
    keys.append(Line2D([], [], color="black", ls=":", label="step the product takes (semi-implicit)"))
    figure.legend(handles=keys, loc="lower center", ncols=5, frameon=False)
    figure.suptitle(
        f"Where methods blow up: ball of 12 vertices. Blown up: deformed over {stability.BLOWN:.0f} times the start; "
        f"inaccurate: off by more than {100 * stability.INACCURATE:.0f} % of it"
    )
    save(figure, out / "stability", bottom=0.07)


def draw_energy(out: Path, quick: bool) -> None:
    omega_dt = 0.2
    long = conservation.energy_trace("velocity_verlet", omega_dt=omega_dt, steps=10_000 if quick else 100_000)
    short = conservation.energy_traces(list(METHODS), omega_dt=omega_dt, steps=100 if quick else 300)
    sizes = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)
    measured = [
        conservation.artificial_damping(conservation.energy_trace("backward_euler", omega_dt=s, steps=40, looks=40))
        for s in sizes
    ]
    write_csv(
        out / "energy.csv", ("method", "omega_dt", "phase", "energy_over_start"),
        ((t.method, t.omega_dt, p, r) for t in [*short, long] for p, r in zip(t.phases, t.ratios, strict=True)),
    )  # fmt: skip
    theory = [conservation.backward_euler_damping(s) for s in sizes]
    write_csv(
        out / "energy_backward_euler.csv", ("omega_dt", "damping_ratio_measured", "damping_ratio_theory"),
        zip(sizes, measured, theory, strict=True),
    )  # fmt: skip
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(14, 4.4))
    for trace in short:
        left.plot(
            np.array(trace.phases) / (2 * np.pi), trace.ratios, color=STYLES[trace.method],
            label=METHODS[trace.method].label,
        )  # fmt: skip
    left.set(ylim=(0, 2), xlabel="periods", ylabel="energy over that at the start", title=f"omega dt = {omega_dt}")
    left.legend(frameon=False, fontsize=7)
    steps = len(long.phases) and round(long.phases[-1] / omega_dt)
    middle.plot(np.array(long.phases) / omega_dt, np.array(long.ratios) - 1, ".", ms=3)
    middle.set(xlabel="steps", ylabel="energy error", title=f"velocity Verlet, {steps:,} undamped steps: no drift")
    right.loglog(sizes, theory, "k-", label="theory: ln(1 + (omega dt)^2) / (2 omega dt)")
    right.loglog(sizes, measured, "o", label="measured")
    right.set(xlabel="omega dt", ylabel="damping ratio", title="what backward Euler adds by itself")
    right.legend(frameon=False, fontsize=8)
    save(figure, out / "energy")


def draw_literal(out: Path, quick: bool) -> None:
    presses = list(literal_against_consistent.presses(cells=4 if quick else 10))
    write_csv(
        out / "literal_against_consistent.csv",
        ("law_set", "depth_m", "volume_over_rest", "finger_force_n", "law_force_n"),
        ((p.law_set, p.depth, p.volume_ratio, p.force, p.law_force) for p in presses),
    )
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.4))
    for law_set, label in (("consistent", "consistent laws"), ("paper", "the paper to the letter")):
        mine = [p for p in presses if p.law_set == law_set]
        depths = [1e3 * p.depth for p in mine]
        left.plot(depths, [100 * (p.volume_ratio - 1) for p in mine], label=label)
        right.plot(depths, [p.force for p in mine], label=label)
    measured = sorted((1e3 * p.depth, p.law_force) for p in presses if p.law_set == "consistent")
    right.plot([m[0] for m in measured], [m[1] for m in measured], "k--", label="K(x), Eq. (1)")
    left.set(xlabel="depth [mm]", ylabel="change of volume [%]", title="Object 3, water: volume")
    right.set(xlabel="depth [mm]", ylabel="force on the fingertip [N]", title="force, 20 mm fingertip", yscale="symlog")
    left.legend(frameon=False)
    right.legend(frameon=False)
    save(figure, out / "literal_against_consistent")


def edges(centres: Floats) -> Floats:
    """Return the borders of cells round centres on a logarithmic scale."""
    ratio = math.sqrt(centres[1] / centres[0])
    return np.append(centres / ratio, centres[-1] * ratio)


def where_methods_fail() -> str:
    return "\n".join(f"  {m.label} (order {m.order}, {m.kind}): {m.purpose}.\n    {m.fails}" for m in METHODS.values())


def table(lines: Sequence[Sequence[str]]) -> str:
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    return "\n".join("  ".join(w.ljust(n) for w, n in zip(line, widths, strict=True)).rstrip() for line in lines)


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)


def save(figure: Figure, stem: Path, *, bottom: float = 0.0) -> None:
    figure.tight_layout(rect=(0, bottom, 1, 1))
    figure.savefig(stem.with_suffix(".png"), dpi=130)
    figure.savefig(stem.with_suffix(".svg"), metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    raise SystemExit(main())
