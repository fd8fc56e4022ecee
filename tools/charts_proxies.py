"""Charts of the planner: its fit repeated, and its choices against the best ones on bodies it was not fitted on."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from core.reduction import planner
from studies import bodies, proxies
from studies.proxies import COARSEST, FINEST, LINE, NEVER, SLACK, Choice, ProxyBenchmark, Row

from .drawing import save, table, write_csv

BUDGETS = (0.05, 0.2, 0.6, 2.0)  # [s] per second
FITS = (  # field of a row, label, factor and power of the planner's fit
    ("error", "surface: error over fingertip radius", planner.ERROR, planner.ERROR_POWER),
    ("force_error", "force: error as a share", planner.FORCE_ERROR, planner.FORCE_POWER),
)


def draw_proxies(out: Path, quick: bool) -> None:
    """Draw the fit, ladders of proxies and the outcomes of the planner's choices; print the tables."""
    known = (
        []
        if quick
        else [row for body in bodies.FITTED for row in proxies.rows(ProxyBenchmark(body, bodies.build(body)))]
    )
    benchmarks = [benchmark_of(body, quick) for body in (bodies.UNSEEN[2:3] if quick else bodies.UNSEEN + bodies.FRESH)]
    choices = [choice for benchmark in benchmarks for choice in choices_of(benchmark, quick)]
    unseen = [row for benchmark in benchmarks for row in proxies.rows(benchmark)]
    write_rows(out, known, unseen, choices)
    figure, ((surface, force), (ladder, verdict)) = plt.subplots(2, 2, figsize=(13, 10))
    for axes, (what, label, factor, power) in zip((surface, force), FITS, strict=True):
        draw_fit(axes, known, unseen, what, factor, power)
        axes.set_ylabel(label)
    draw_ladders(ladder, benchmarks, choices)
    draw_verdict(verdict, choices)
    figure.suptitle(
        "Proxies: the errors the planner expects, and the outcomes of its choices on bodies it was not fitted on"
    )
    save(figure, out / "proxies")
    print(choices_table(choices), flush=True)
    print(budgets_table(benchmarks), flush=True)
    if known:
        again = proxies.fit(known)
        print("The fit made again:", ", ".join(f"{value:.3g}" for value in again), end="; the planner's: ")
        print(planner.ERROR, planner.ERROR_POWER, planner.FORCE_ERROR, planner.FORCE_POWER, sep=", ", flush=True)


def benchmark_of(body: bodies.BodyCase, quick: bool) -> ProxyBenchmark:
    return ProxyBenchmark(body, bodies.build(body, 12 if quick else bodies.FINE), half=2 if quick else proxies.HALF)


def choices_of(benchmark: ProxyBenchmark, quick: bool) -> list[Choice]:
    near = proxies.tolerances(benchmark.body)
    return list(proxies.choices(benchmark, budget=NEVER, near=near[-1:] if quick else near))


def write_rows(out: Path, known: Sequence[Row], unseen: Sequence[Row], choices: Sequence[Choice]) -> None:
    write_csv(
        out / "proxies_fit.csv",
        ("body", "fitted", "vertices", "spacing_over_radius", "error_over_radius", "force_error"),
        ((r.body, int(r in known), r.vertices, f"{r.share:.4g}", f"{r.error:.4g}", f"{r.force_error:.4g}")
         for r in (*known, *unseen)),
    )  # fmt: skip
    write_csv(
        out / "proxies.csv",
        ("body", "tolerance_mm", "force_tolerance", "vertices", "steps", "error_mm", "force_error",
         "cost_s_per_s", "best_vertices", "best_steps", "best_cost_s_per_s", "excess", "work_ratio", "cost_ratio"),
        ((c.body.name, f"{1e3 * c.tolerance:.3g}", c.force_tolerance, c.ours.vertices, c.ours.steps,
          f"{1e3 * c.ours.error:.3g}", f"{c.ours.force_error:.3g}", f"{c.ours.cost:.3g}", c.best.vertices,
          c.best.steps, f"{c.best.cost:.3g}", f"{c.excess:.3g}", f"{c.ratio:.3g}", f"{c.cost_ratio:.3g}")
         for c in choices),
    )  # fmt: skip


def draw_fit(axes: Axes, known: Sequence[Row], unseen: Sequence[Row], what: str, factor: float, power: float) -> None:
    """Draw the errors of proxies against their spacing, and the planner's fit."""
    for rows, marker, label in ((known, "o", "fitted bodies"), (unseen, "x", "unseen bodies")):
        axes.loglog([r.share for r in rows], [getattr(r, what) for r in rows], marker, ms=4, alpha=0.6, label=label)
    share = np.array([FINEST, COARSEST])
    axes.loglog(share, factor * share**power, "k-", label=f"planner: {factor:g} (h / R)^{power:g}")
    axes.set_xlabel("spacing of the proxy over fingertip radius, h / R")
    axes.legend(frameon=False, fontsize=8)


def draw_ladders(axes: Axes, benchmarks: Sequence[ProxyBenchmark], choices: Sequence[Choice]) -> None:
    """Draw error against cost for every unseen body, with the planner's choices for it."""
    for benchmark, colour in zip(benchmarks, plt.get_cmap("tab20").colors, strict=False):  # type: ignore[attr-defined]
        radius = benchmark.body.radius
        rungs = [rung for rung in benchmark.ladder() if rung.asked]
        label = f"{benchmark.body.name}: the mesh {benchmark.mesh.cost:.2g}"
        axes.loglog([r.cost for r in rungs], [r.error / radius for r in rungs], color=colour, lw=1, label=label)
        taken = [c.ours for c in choices if c.body is benchmark.body and c.plan.asked]
        axes.loglog([t.cost for t in taken], [t.error / radius for t in taken], "o", ms=5, color=colour)
    axes.set(xlabel="processor time [s] per second", ylabel="error of the surface over fingertip radius")
    axes.set_title("ladders of proxies; points: the planner's choices", fontsize=9)
    axes.legend(frameon=False, fontsize=6)


def draw_verdict(axes: Axes, choices: Sequence[Choice]) -> None:
    """Draw work over that of the best choice against error over tolerance; good choices are lower left."""
    axes.semilogy([c.excess for c in choices], [c.ratio for c in choices], "o", alpha=0.6)
    axes.axvline(SLACK, color="0.5", lw=1)
    axes.axhline(LINE, color="0.5", lw=1)
    axes.set(xlabel="larger error over its tolerance (0: the full mesh)", ylabel="work over that of the best choice")
    axes.set_title(f"kept: below {LINE:g} and left of {SLACK:.2f}", fontsize=9)


def choices_table(choices: Sequence[Choice]) -> str:
    """Return every choice beside the best one, then a summary for each set of bodies."""
    lines = [("body", "asked", "chosen", "error", "force", "best", "work", "cost", "")]
    for c in choices:
        lines.append((
            c.body.name, f"{1e3 * c.tolerance:.2f} mm {c.force_tolerance:.0%}", f"{c.ours.vertices}",
            f"{1e3 * c.ours.error:.2f} mm", f"{c.ours.force_error:.0%}", f"{c.best.vertices}", f"{c.ratio:.2f}",
            f"{c.cost_ratio:.2f}", "" if c.keeps and c.ratio <= LINE else "not kept",
        ))  # fmt: skip
    parts = [table(lines)]
    sets = [("unseen", bodies.UNSEEN), ("fresh", bodies.FRESH)]
    for name, members in sets:
        some = [c for c in choices if c.body in members]
        if not some:
            continue
        near = sum(c.keeps for c in some)
        parts.append(
            f"{name}: at most {max(c.ratio for c in some):.2f} times the work of the best choice, "
            f"{sum(c.ratio <= LINE for c in some)} of {len(some)} within {LINE:g}; "
            f"tolerances kept up to a third over by {near} of {len(some)}, the worst {max(c.excess for c in some):.2f}"
        )
    return "\n".join(parts)


def budgets_table(benchmarks: Sequence[ProxyBenchmark]) -> str:
    """Return what is simulated as the budget grows, and how often the best choice would have kept a missed budget."""
    lines = [("budget", "mesh live", "proxy live", "slower", "of these the best choice would be live")]
    found = [choice for benchmark in benchmarks for choice in proxies.over_budgets(benchmark, BUDGETS)]
    for budget in BUDGETS:
        some = [c for c in found if c.budget == budget]
        live = [c for c in some if c.plan.cost <= budget]
        slow = [c for c in some if c.plan.cost > budget]
        lines.append((
            f"{budget:g} s/s", f"{sum(not c.plan.asked for c in live)}", f"{sum(c.plan.asked > 0 for c in live)}",
            f"{len(slow)}", f"{sum(c.best.cost <= budget for c in slow)}",
        ))  # fmt: skip
    return table(lines)
