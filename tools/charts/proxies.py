"""The chart of proxies: the error of their dents, measured and as the planner states it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt

from core.reduction.proxy_rule import surface_error
from studies import bodies, proxies
from studies.proxies import COARSEST, FINEST, Row

from .drawing import save, write_csv


def draw_proxies(out: Path, quick: bool) -> None:
    """Measure and draw the errors of proxies against their edges."""
    cases = bodies.BODIES[2:3] if quick else bodies.BODIES
    fine, presses = (12, 4) if quick else (bodies.FINE, proxies.PRESSES)
    draw_rows(out, [row for body in cases for row in proxies.rows(body, fine, presses=presses)])


def draw_rows(out: Path, rows: Sequence[Row]) -> None:
    """Draw the errors of proxies and write them to a table."""
    write_csv(
        out / "proxies.csv",
        ("body", "vertices", "spacing_over_radius", "spread_over_radius", "error_over_radius"),
        ((r.body, r.vertices, f"{r.share:.4g}", f"{r.spread:.4g}", f"{r.error:.4g}") for r in rows),
    )
    figure, axes = plt.subplots(figsize=(7, 5))
    axes.loglog([r.share for r in rows], [r.error for r in rows], "o", ms=4, alpha=0.6, label="proxies of 30 bodies")
    stated = [surface_error(share, 1.0) for share in (FINEST, COARSEST)]
    axes.loglog((FINEST, COARSEST), stated, "k-", label="the planner: a chord's height, (h / R)^2 / 8")
    axes.set(
        xlabel="edges of the proxy over fingertip radius, h / R",
        ylabel="error of the dent over fingertip radius, in 49 of 50 presses",
    )
    axes.legend(frameon=False)
    save(figure, out / "proxies")
