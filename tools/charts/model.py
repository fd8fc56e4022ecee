"""Charts of the model and of speed: energy, laws, cost, space, the stiff cube with its proxies."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from core.reduction.proxy_rule import BUDGET
from studies import conservation, cost, literal_against_consistent, space, stiff_nylon
from studies.methods.registry import METHODS
from studies.stiff_nylon import TOLERANCE, Outcome

from .drawing import LABELS, MARKERS, STYLES, save, table, write_csv


def draw_energy(out: Path, quick: bool) -> None:
    omega_dt = 0.2
    long = conservation.energy_trace("velocity_verlet", omega_dt=omega_dt, steps=3_000 if quick else 100_000)
    short = conservation.energy_traces(list(METHODS), omega_dt=omega_dt, steps=100)
    sizes = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)
    measured = [
        conservation.artificial_damping(conservation.energy_trace("backward_euler", omega_dt=s, steps=40, samples=40))
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
    for i, trace in enumerate(short):  # several curves coincide, so the later ones are thinner
        left.plot(
            np.array(trace.phases) / (2 * np.pi), trace.ratios, color=STYLES[trace.method],
            label=LABELS[trace.method], lw=4 - 0.4 * i, ls=("-", "--")[i % 2],
        )  # fmt: skip
    left.set(
        ylim=(0, 2.6),
        xlabel="periods",
        ylabel="energy / energy at the start",
        title=f"\u03c9 dt = {omega_dt}, no damping",
    )
    left.legend(frameon=False, fontsize=7, loc="upper right")
    steps = len(long.phases) and round(long.phases[-1] / omega_dt)
    middle.plot(np.array(long.phases) / omega_dt, np.array(long.ratios) - 1, ".", ms=3)
    middle.set(xlabel="steps", ylabel="energy error", title=f"velocity Verlet, {steps:,} steps")
    right.loglog(sizes, theory, "k-", label="theory: ln(1 + (\u03c9 dt)\u00b2) / (2 \u03c9 dt)")
    right.loglog(sizes, measured, "o", label="measured")
    right.set(xlabel="\u03c9 dt", ylabel="damping ratio", title="damping that backward Euler adds")
    right.legend(frameon=False, fontsize=8)
    save(figure, out / "energy")


def draw_literal(out: Path, quick: bool) -> None:
    presses = list(literal_against_consistent.presses(cells=4 if quick else 10))
    write_csv(
        out / "literal_against_consistent.csv",
        ("laws", "depth_m", "volume_over_rest", "finger_force_n", "law_force_n"),
        ((p.laws, p.depth, p.volume_ratio, p.force, p.law_force) for p in presses),
    )
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.4))
    for laws, label in (("consistent", "consistent laws"), ("paper", "the paper to the letter")):
        mine = [p for p in presses if p.laws == laws]
        depths = [1e3 * p.depth for p in mine]
        left.plot(depths, [100 * (p.volume_ratio - 1) for p in mine], label=label)
        right.plot(depths, [p.force for p in mine], label=label)
    measured = sorted((1e3 * p.depth, p.law_force) for p in presses if p.laws == "consistent")
    right.plot([m[0] for m in measured], [m[1] for m in measured], "k--", label="K(x), Eq. (1)")
    left.set(xlabel="depth [mm]", ylabel="change of volume [%]", title="Object 3, water: volume")
    right.set(xlabel="depth [mm]", ylabel="force on the fingertip [N]", title="force, 20 mm fingertip", yscale="symlog")
    left.legend(frameon=False)
    right.legend(frameon=False)
    save(figure, out / "literal_against_consistent")


def draw_cost(out: Path, quick: bool) -> None:
    """Draw cost against vertices; methods in numpy get only small bodies, since a step of the slowest takes seconds."""
    slow, fast = ((2, 3), (2, 3, 4, 5)) if quick else ((2, 3, 4, 5), (2, 3, 4, 5, 6, 7))
    found = [*cost.costs(list(METHODS), slow), *cost.costs([cost.NATIVE], fast)]
    write_csv(
        out / "cost.csv", ("method", "vertices", "dt_s", "cpu_s_per_step", "ns_per_vertex_step"),
        ((c.method, c.vertices, c.dt, c.seconds, 1e9 * c.seconds / c.vertices) for c in found),
    )  # fmt: skip
    names = list(dict.fromkeys(c.method for c in found))
    slopes = {name: round(cost.slope(found, name), 3) for name in names}
    write_csv(out / "cost_slopes.csv", ("method", "log_log_slope"), slopes.items())
    figure, axes = plt.subplots(figsize=(10, 5.2))
    for name in names:
        mine = [c for c in found if c.method == name]
        axes.loglog(
            [c.vertices for c in mine], [1e3 * c.seconds for c in mine], color=STYLES[name], marker=MARKERS[name],
            label=f"{LABELS[name]}, slope {slopes[name]:.2f}",
        )  # fmt: skip
    axes.axhline(1, color="0.6", lw=1)
    axes.annotate("a tick of a millisecond", (0.02, 1), xycoords=("axes fraction", "data"), va="top")
    axes.set(xlabel="vertices", ylabel="processor time of one step [ms]", title="Cost of a step: twisted ball, free")
    axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1, 0.5))
    save(figure, out / "cost")


def draw_space(out: Path, quick: bool) -> None:
    """Draw dents on finer and finer meshes."""
    sizes = {"poke_ball": (2, 3, 4, 5), "poke_cube": (5, 10, 20, 41)}
    found = {scene: list(space.dents(scene, some[:-1] if quick else some)) for scene, some in sizes.items()}
    write_csv(
        out / "space.csv", ("scene", "vertices", "beside_m", "depth_m", "volume_over_rest"),
        ((f.scene, f.vertices, f.beside, f.depth, f.volume_ratio) for some in found.values() for f in some),
    )  # fmt: skip
    figure, panels = plt.subplots(1, 3, figsize=(13, 4.4))
    shown = {"poke_ball": "liquid ball", "poke_cube": "cube of vinyl and water"}
    for (scene, some), axes in zip(found.items(), panels, strict=False):
        counts = sorted({f.vertices for f in some})
        for n, shade in zip(counts, np.linspace(0.75, 0, len(counts)), strict=True):
            mine = [f for f in some if f.vertices == n]
            beside, height = [1e3 * f.beside for f in mine], [-1e3 * f.depth for f in mine]
            axes.plot(beside, height, color=str(shade), label=f"{n:,} vertices")
        axes.set(xlabel="beside the middle [mm]", ylabel="height over rest [mm]", title=f"dent, {shown[scene]}")
        axes.legend(frameon=False, fontsize=8)
        far = [100 * space.difference(some, n, counts[-1]) for n in counts[:-1]]
        panels[2].loglog(counts[:-1], far, "o-", label=f"{shown[scene]}, from {counts[-1]:,} vertices")
    low, high = panels[2].get_xlim()
    top = panels[2].get_ylim()[1]
    panels[2].loglog([low, high], [top, top * low / high], "k:", lw=1, label="second order in the edge length")
    ticks = (150, 300, 600) if quick else (150, 600, 2400)
    panels[2].set_xticks(ticks, [f"{n:,}" for n in ticks])
    panels[2].minorticks_off()
    panels[2].set(xlabel="vertices", ylabel="difference of the dent [% of its depth]", title="convergence in space")
    panels[2].legend(frameon=False, fontsize=8, loc="lower left")
    save(figure, out / "space")


def draw_stiff_nylon(out: Path, quick: bool) -> None:
    """Draw error against cost for each way to simulate the stiff cube, with a series of proxies."""
    skins = {"skin as the press was measured": False} | ({} if quick else {"all of k in the skin": True})
    found = {
        label: list(stiff_nylon.outcomes(12 if quick else 41, whole=whole, slow=not quick and not whole))
        for label, whole in skins.items()
    }
    write_csv(
        out / "stiff_nylon.csv",
        ("skin", "variant", "method", "backend", "vertices", "dt_s", "surface_error_m", "farthest_m", "cpu_s_per_s",
         "unsolved_steps", "within_tolerance", "live"),
        ((label, p.variant, p.method, p.backend, p.vertices, p.dt, p.surface, p.farthest, p.cost, p.unsolved, p.within,
          p.live) for label, some in found.items() for p in some),
    )  # fmt: skip
    print_stiff_nylon(found)
    figure, panels = plt.subplots(1, len(found), figsize=(5.5 * len(found), 4.8), squeeze=False)
    for (label, some), axes in zip(found.items(), panels[0], strict=True):
        draw_variants(axes, some)
        axes.set(
            xlabel="processor time per simulated second [s]", ylabel="error between the surfaces [mm]",
            title=f"{label}; {max(p.vertices for p in some):,} vertices",
        )  # fmt: skip
    figure.suptitle(
        "The stiff cube pressed 10 mm. Green: live and within the tolerance. Hollow: proxies, by their vertices. "
        "Star: the planner's choice.\nDotted: the change when the steps of the reference are halved; smaller errors "
        "mean nothing", fontsize=9,
    )  # fmt: skip
    save(figure, out / "stiff_nylon")


def draw_variants(axes: Axes, some: Sequence[Outcome]) -> None:
    for p in some:
        value = 1e3 * p.surface
        if p.variant == "reference":
            axes.axhline(value, color="0.5", lw=1, ls=":")
            continue
        key = "native" if p.backend == "native" else p.method
        star, hollow = p.variant == "planner", p.variant == "proxy"
        axes.loglog(
            p.cost, value, "*" if star else "o", ms=14 if star else 7, mec=STYLES[key],
            mfc="gold" if star else "none" if hollow else STYLES[key], zorder=3 if star else 2,
        )  # fmt: skip
        name = LABELS[key].partition(",")[0] if p.backend == "numpy" else "the mesh"
        axes.annotate(
            f"{p.vertices}" if star or hollow else f"{name}\n{1e3 * p.dt:.2g} ms", (p.cost, value),
            xytext=(-9 if star else 8 if hollow else 0, -3 if star or hollow else -25), textcoords="offset points",
            fontsize=8, ha="right" if star else "left" if hollow else "center",
        )  # fmt: skip
    axes.margins(x=0.15, y=0.12)
    low, bottom = axes.get_xlim()[0], axes.get_ylim()[0]
    axes.fill_between([low, BUDGET], bottom, 1e3 * TOLERANCE, color="#4c9f70", alpha=0.15, lw=0)
    axes.set(xlim=(low, None), ylim=(bottom, None))


def print_stiff_nylon(found: dict[str, list[Outcome]]) -> None:
    lines = [("skin", "variant", "method", "vertices", "step", "surface", "CPU s/s", "live, within")]
    for label, some in found.items():
        lines += [
            (label, p.variant, f"{p.method}, {p.backend}", f"{p.vertices:,}", f"{1e3 * p.dt:.3g} ms",
             f"{1e3 * p.surface:.2g} mm", f"{p.cost:.2g}", f"{p.live}, {p.within}")
            for p in some
        ]  # fmt: skip
    print("\nThe stiff cube pressed 10 mm\n" + table(lines) + "\n", flush=True)
