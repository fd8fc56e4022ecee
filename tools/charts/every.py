"""Draw all charts, and copy those that the documentation shows."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

from studies.methods.registry import METHODS

from . import KEPT
from .model import draw_cost, draw_energy, draw_literal, draw_space, draw_stiff_nylon
from .proxies import draw_proxies
from .stability import draw_stability
from .work import draw_work_precision

CHARTS = (
    draw_work_precision, draw_stability, draw_energy, draw_literal, draw_cost, draw_space, draw_stiff_nylon,
    draw_proxies,
)  # fmt: skip


def draw(out: Path, quick: bool) -> None:
    """Draw every chart into a folder and print how long each took."""
    for chart in CHARTS:
        started = time.perf_counter()
        chart(out, quick)
        print(f"{chart.__name__.removeprefix('draw_')}: {time.perf_counter() - started:.1f} s", flush=True)


def keep(out: Path) -> None:
    """Copy the charts that the documentation shows, and the fronts, to where tests compare them."""
    KEPT.mkdir(parents=True, exist_ok=True)
    charts = ("work_precision", "stability", "proxies")
    names = [name + ending for name in charts for ending in (".png", ".svg", ".csv")]
    for name in (*names, "stability_bounds.csv", "fronts.csv"):
        shutil.copyfile(out / name, KEPT / name)


def where_methods_fail() -> str:
    """Return a paragraph for each method: its purpose, and where it fails."""
    return "\n".join(f"  {m.label} (order {m.order}, {m.kind}): {m.purpose}.\n    {m.fails}" for m in METHODS.values())
