"""The planner against the best choice there was: the fit made again, and its plans for bodies it was not fitted on."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from core.reduction import planner
from studies import bodies, proxies
from studies.proxies import COARSEST, FINEST, LINE, NEVER, SLACK, Choice, Judge, Row

from .drawing import save, table, write_csv

BUDGETS = (0.05, 0.2, 0.6, 2.0)  # [s] of a second
COLOURS = {"presses": "tab:blue", "heavy": "tab:orange"}
FITS = (  # what a row has, what it is, the planner's line
    ("error", "skin: error over fingertip radius", planner.ERROR, planner.ERROR_POWER),
    ("force_error", "force: error as a share", planner.FORCE_ERROR, planner.FORCE_POWER),
)


def draw_stand_ins(out: Path, quick: bool) -> None:
    """Draw the fit, ladders of stand-ins and what the planner's choices come to; print the table."""
    known = [] if quick else [row for body in bodies.FITTED for row in proxies.rows(Judge(body, bodies.build(body)))]
    judges = [judge_of(body, quick) for body in (bodies.UNSEEN[2:3] if quick else bodies.UNSEEN + bodies.FRESH)]
    choices = [choice for judge in judges for choice in choices_of(judge, quick)]
    unseen = [row for judge in judges for row in proxies.rows(judge)]
    write_rows(out, known, unseen, choices)
    figure, ((skin, force), (ladder, verdict)) = plt.subplots(2, 2, figsize=(13, 10))
    for axes, (what, label, factor, power) in zip((skin, force), FITS, strict=True):
        draw_fit(axes, known, unseen, what, factor, power)
        axes.set_ylabel(label)
    draw_ladders(ladder, judges, choices)
    draw_verdict(verdict, choices)
    figure.suptitle("Stand-ins: what the planner expects of them, and what its choices come to on bodies it never saw")
    save(figure, out / "proxies")
    print(told(choices), flush=True)
    print(told_budgets(judges), flush=True)
    if known:
        again = proxies.fit(known)
        print("The fit made again:", ", ".join(f"{value:.3g}" for value in again), end="; the planner's: ")
        print(planner.ERROR, planner.ERROR_POWER, planner.FORCE_ERROR, planner.FORCE_POWER, sep=", ", flush=True)


def judge_of(body: bodies.Body, quick: bool) -> Judge:
    return Judge(body, bodies.build(body, 12 if quick else bodies.FINE), half=2 if quick else proxies.HALF)


def choices_of(judge: Judge, quick: bool) -> list[Choice]:
    near = proxies.tolerances(judge.body)
    return list(proxies.choices(judge, budget=NEVER, near=near[-1:] if quick else near))


def write_rows(out: Path, known: Sequence[Row], unseen: Sequence[Row], choices: Sequence[Choice]) -> None:
    write_csv(
        out / "stand_ins_fit.csv",
        ("body", "fitted", "vertices", "spacing_over_radius", "error_over_radius", "force_error"),
        ((r.body, int(r in known), r.vertices, f"{r.share:.4g}", f"{r.error:.4g}", f"{r.force_error:.4g}")
         for r in (*known, *unseen)),
    )  # fmt: skip
    write_csv(
        out / "proxies.csv",
        ("body", "tolerance_mm", "force_tolerance", "by", "vertices", "steps", "error_mm", "force_error",
         "cost_s_per_s", "best_vertices", "best_steps", "best_cost_s_per_s", "excess", "work_ratio", "cost_ratio"),
        ((c.body.name, f"{1e3 * c.tolerance:.3g}", c.force_tolerance, c.by, c.ours.vertices, c.ours.steps,
          f"{1e3 * c.ours.error:.3g}", f"{c.ours.force_error:.3g}", f"{c.ours.cost:.3g}", c.best.vertices,
          c.best.steps, f"{c.best.cost:.3g}", f"{c.excess:.3g}", f"{c.ratio:.3g}", f"{c.cost_ratio:.3g}")
         for c in choices),
    )  # fmt: skip


def draw_fit(axes: Axes, known: Sequence[Row], unseen: Sequence[Row], what: str, factor: float, power: float) -> None:
    """Draw the error of rungs against their spacing, and the planner's line."""
    for rows, marker, label in ((known, "o", "fitted bodies"), (unseen, "x", "unseen bodies")):
        axes.loglog([r.share for r in rows], [getattr(r, what) for r in rows], marker, ms=4, alpha=0.6, label=label)
    share = np.array([FINEST, COARSEST])
    axes.loglog(share, factor * share**power, "k-", label=f"planner: {factor:g} (h / R)^{power:g}")
    axes.set_xlabel("spacing of the stand-in over fingertip radius, h / R")
    axes.legend(frameon=False, fontsize=8)


def draw_ladders(axes: Axes, judges: Sequence[Judge], choices: Sequence[Choice]) -> None:
    """Draw error against cost for every unseen body, the planner's choices on it."""
    for judge, colour in zip(judges, plt.get_cmap("tab20").colors, strict=False):  # type: ignore[attr-defined]
        radius = judge.body.radius
        rungs = [tried for tried in judge.ladder() if tried.asked]
        label = f"{judge.body.name}: the mesh {judge.mesh.cost:.2g}"
        axes.loglog([r.cost for r in rungs], [r.error / radius for r in rungs], color=colour, lw=1, label=label)
        taken = [c.ours for c in choices if c.body is judge.body and c.by == "presses" and c.plan.asked]
        axes.loglog([t.cost for t in taken], [t.error / radius for t in taken], "o", ms=5, color=colour)
    axes.set(xlabel="processor time [s] of a second", ylabel="error of the skin over fingertip radius")
    axes.set_title("ladders of stand-ins; points: the planner's choices", fontsize=9)
    axes.legend(frameon=False, fontsize=6)


def draw_verdict(axes: Axes, choices: Sequence[Choice]) -> None:
    """Draw cost over the best choice's against error over tolerance: inside the box the line is kept."""
    for by, colour in COLOURS.items():
        some = [c for c in choices if c.by == by]
        label = {"presses": "pressed first", "heavy": "as if the mesh were too heavy to press"}[by]
        axes.semilogy([c.excess for c in some], [c.ratio for c in some], "o", color=colour, alpha=0.6, label=label)
    axes.axvline(SLACK, color="0.5", lw=1)
    axes.axhline(LINE, color="0.5", lw=1)
    axes.set(xlabel="larger error over its tolerance (0: the mesh itself)", ylabel="work over that of the best choice")
    axes.set_title(f"kept: below {LINE:g} and left of {SLACK:.2f}", fontsize=9)
    axes.legend(frameon=False, fontsize=8)


def told(choices: Sequence[Choice]) -> str:
    lines = [("body", "asked", "by", "chosen", "error", "force", "best", "work", "cost", "")]
    for c in choices:
        lines.append((
            c.body.name, f"{1e3 * c.tolerance:.2f} mm {c.force_tolerance:.0%}", c.by, f"{c.ours.vertices}",
            f"{1e3 * c.ours.error:.2f} mm", f"{c.ours.force_error:.0%}", f"{c.best.vertices}", f"{c.ratio:.2f}",
            f"{c.cost_ratio:.2f}", "" if c.keeps and c.ratio <= LINE else "not kept",
        ))  # fmt: skip
    said = [table(lines)]
    sets = [("unseen", bodies.UNSEEN), ("fresh", bodies.FRESH)]
    for by, (name, members) in itertools.product(COLOURS, sets):
        some = [c for c in choices if c.by == by and c.body in members]
        if not some:
            continue
        near = sum(c.keeps for c in some)
        said.append(
            f"By {by}, {name}: at most {max(c.ratio for c in some):.2f} times the work of the best choice, "
            f"{sum(c.ratio <= LINE for c in some)} of {len(some)} within {LINE:g}; "
            f"tolerances kept up to a third over by {near} of {len(some)}, the worst {max(c.excess for c in some):.2f}"
        )
    return "\n".join(said)


def told_budgets(judges: Sequence[Judge]) -> str:
    """Tell what moves as the budget grows, and how often a choice that misses it could have kept it."""
    lines = [("budget", "mesh live", "stand-in live", "slower", "of these the best choice would be live")]
    found = [choice for judge in judges for choice in proxies.over_budgets(judge, BUDGETS)]
    for budget in BUDGETS:
        some = [c for c in found if c.budget == budget]
        live = [c for c in some if c.plan.cost <= budget]
        slow = [c for c in some if c.plan.cost > budget]
        lines.append((
            f"{budget:g} s/s", f"{sum(not c.plan.asked for c in live)}", f"{sum(c.plan.asked > 0 for c in live)}",
            f"{len(slow)}", f"{sum(c.best.cost <= budget for c in slow)}",
        ))  # fmt: skip
    return table(lines)
