"""Charts of the planner: its fit repeated, and its choices against the best ones on bodies it was not fitted on."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from core.reduction import error_model
from studies import bodies, proxies
from studies.proxies import COARSEST, FINEST, GROWTH, JUDGED, KEPT, LINE, Candidate, Choice, ProxyBenchmark, Row

from .drawing import save, table, write_csv

FORCE_FACTOR, FORCE_POWER, COARSE_POWER = error_model.FORCE_ERROR
FITS = (  # field of a row, label, the planner's fit: factor, power and power of the spread, and power beyond COARSE
    ("error", "surface: error over fingertip radius", (*error_model.ERROR, error_model.ERROR[1])),
    ("force_error", "force: error as a share", (FORCE_FACTOR, FORCE_POWER, 0.0, COARSE_POWER)),
)


def draw_proxies(out: Path, quick: bool) -> None:
    """Draw the fit, ladders of proxies and the outcomes of the planner's choices; print the tables."""
    known = (
        []
        if quick
        else [row for body in bodies.FITTED for row in proxies.rows(ProxyBenchmark(body, bodies.build(body)))]
    )
    benchmarks = [benchmark_of(body, quick) for body in (bodies.UNSEEN[2:3] if quick else bodies.UNSEEN)]
    choices = [choice for benchmark in benchmarks for choice in choices_of(benchmark, quick)]
    unseen = [row for benchmark in benchmarks for row in proxies.rows(benchmark)]
    write_rows(out, known, choices)
    write_ladders(out, benchmarks)
    figure, ((surface, force), (ladder, verdict)) = plt.subplots(2, 2, figsize=(13, 10))
    for axes, (what, label, fit) in zip((surface, force), FITS, strict=True):
        draw_fit(axes, known, unseen, what, fit)
        axes.set_ylabel(label)
    draw_ladders(ladder, benchmarks, choices)
    draw_verdict(verdict, choices)
    figure.suptitle(
        "Proxies: the errors the planner expects, and the outcomes of its choices on bodies it was not fitted on"
    )
    save(figure, out / "proxies")
    print(choices_table(choices), flush=True)
    if known:
        again = proxies.fit(known)
        print(f"The fit made again: {again}; the planner's: {error_model.ERROR}, {error_model.FORCE_ERROR}", flush=True)


def benchmark_of(body: bodies.BodyCase, quick: bool) -> ProxyBenchmark:
    return ProxyBenchmark(body, bodies.build(body, 12 if quick else bodies.FINE), presses=4 if quick else JUDGED)


def choices_of(benchmark: ProxyBenchmark, quick: bool) -> list[Choice]:
    near = proxies.tolerances(benchmark.body)
    return list(proxies.choices(benchmark, near[-1:] if quick else near))


def write_rows(out: Path, known: Sequence[Row], choices: Sequence[Choice]) -> None:
    write_csv(
        out / "proxies_fit.csv",
        ("body", "vertices", "spacing_over_radius", "spread_over_radius", "error_over_radius", "force_error"),
        ((r.body, r.vertices, f"{r.share:.4g}", f"{r.spread:.4g}", f"{r.error:.4g}", f"{r.force_error:.4g}")
         for r in known),
    )  # fmt: skip
    write_csv(
        out / "proxies.csv",
        ("body", "tolerance_mm", "force_tolerance", "vertices", "steps", "cost_s_per_s", "best_vertices", "best_steps",
         "best_cost_s_per_s", "presses", "missed", "work_ratio", "cost_ratio"),
        ((c.body.name, f"{1e3 * c.near[0]:.3g}", c.near[1], c.ours.vertices, c.ours.steps, f"{c.ours.cost:.3g}",
          c.best.vertices, c.best.steps, f"{c.best.cost:.3g}", len(c.ours.errors), c.missed, f"{c.ratio:.3g}",
          f"{c.cost_ratio:.3g}")
         for c in choices),
    )  # fmt: skip


def write_ladders(out: Path, benchmarks: Sequence[ProxyBenchmark]) -> None:
    """Write error against cost of every rung, errors as 49 of 50 presses keep them."""
    write_csv(
        out / "proxies_ladder.csv",
        ("body", "vertices", "steps", "cost_s_per_s", "error_over_radius", "force_error"),
        ((b.body.name, r.vertices, r.steps, f"{r.cost:.3g}", f"{_kept(r) / b.body.radius:.3g}",
          f"{np.quantile(r.force_errors, KEPT):.3g}")
         for b in benchmarks for r in b.ladder(GROWTH**2)),
    )  # fmt: skip


def draw_fit(
    axes: Axes, known: Sequence[Row], unseen: Sequence[Row], what: str, fit: tuple[float, float, float, float]
) -> None:
    """Draw the errors of proxies against their spacing, less what the spread explains, and the planner's fit."""
    factor, power, spread_power, coarse_power = fit
    for rows, marker, label in ((known, "o", "fitted bodies"), (unseen, "x", "unseen bodies")):
        less = [getattr(r, what) / r.spread**spread_power for r in rows]
        axes.loglog([r.share for r in rows], less, marker, ms=4, alpha=0.6, label=label)
    share = np.array([FINEST, error_model.COARSE, COARSEST])
    line = factor * share**power * np.maximum(share / error_model.COARSE, 1) ** (coarse_power - power)
    label = f"planner: {factor:g} (h / R)^{power:g} (s / R)^{spread_power:g} to {error_model.COARSE:g}, drawn for s = R"
    axes.loglog(share, line, "k-", label=label)
    axes.set_xlabel("spacing of the proxy over fingertip radius, h / R")
    axes.legend(frameon=False, fontsize=8)


def draw_ladders(axes: Axes, benchmarks: Sequence[ProxyBenchmark], choices: Sequence[Choice]) -> None:
    """Draw error against cost for every unseen body, with the planner's choices for it."""
    for benchmark, colour in zip(benchmarks, plt.get_cmap("tab20").colors, strict=False):  # type: ignore[attr-defined]
        radius = benchmark.body.radius
        rungs = [rung for rung in benchmark.ladder(GROWTH**2) if rung.asked]
        axes.loglog([r.cost for r in rungs], [_kept(r) / radius for r in rungs], color=colour, lw=1)
        taken = [c.ours for c in choices if c.body is benchmark.body and c.plan.asked]
        axes.loglog([t.cost for t in taken], [_kept(t) / radius for t in taken], "o", ms=5, color=colour)
    axes.set(xlabel="processor time [s] per second", ylabel="error of the surface over fingertip radius")
    axes.set_title("ladders of proxies, a line a body; points: the planner's choices", fontsize=9)


def _kept(candidate: Candidate) -> float:
    return float(np.quantile(candidate.errors, KEPT))


def draw_verdict(axes: Axes, choices: Sequence[Choice]) -> None:
    """Draw work over that of the best choice against error over tolerance; good choices are lower left."""
    excess = [float(np.quantile(c.ours.excess(c.near), KEPT)) for c in choices]
    axes.semilogy(excess, [c.ratio for c in choices], "o", alpha=0.6)
    axes.axvline(1.0, color="0.5", lw=1)
    axes.axhline(LINE, color="0.5", lw=1)
    axes.set(xlabel="error over its tolerance, that 49 of 50 presses keep", ylabel="work over that of the best choice")
    axes.set_title("choice by choice", fontsize=9)


def choices_table(choices: Sequence[Choice]) -> str:
    """Return every choice beside the best one, then a summary."""
    lines = [("body", "asked", "chosen", "best", "work", "cost", "missed")]
    for c in choices:
        lines.append((
            c.body.name, f"{1e3 * c.near[0]:.2f} mm {c.near[1]:.0%}", f"{c.ours.vertices}", f"{c.best.vertices}",
            f"{c.ratio:.2f}", f"{c.cost_ratio:.2f}", f"{c.missed} of {len(c.ours.errors)}",
        ))  # fmt: skip
    presses, missed = sum(len(c.ours.errors) for c in choices), sum(c.missed for c in choices)
    ratios = np.array([c.ratio for c in choices])
    bodies_work = [_by_body(choices, body) for body in dict.fromkeys(c.body.name for c in choices)]
    return (
        f"{table(lines)}\ntolerances not kept by {missed} of {presses} presses, one in {presses / max(missed, 1):.0f}; "
        f"work over that of the best choice: mean {ratios.mean():.2f}, median {np.median(ratios):.2f}, within {LINE:g} "
        f"for {(ratios <= LINE).sum()} of {len(ratios)}, at worst {ratios.max():.2f}; of a body at its tolerances "
        f"together at worst {max(bodies_work):.2f}"
    )


def _by_body(choices: Sequence[Choice], body: str) -> float:
    """Return the work of all choices for a body over that of the best ones."""
    ours, best = zip(*((c.ours.work, c.best.work) for c in choices if c.body.name == body), strict=True)
    return float(sum(ours) / sum(best))
