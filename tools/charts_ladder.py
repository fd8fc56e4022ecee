"""Chart of the ladder: proxies uniform and graded, bodies awake near the press, equilibria; error against work."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import NullFormatter

from core.base import TICK
from studies import bodies, graded, quasi_static

from .drawing import save

KINDS = {
    "uniform": "uniform proxy", "graded": "fine near this press", "path": "fine near four places",
    "region": "of 800 vertices, awake near the press",
}  # fmt: skip


def draw_ladder(out: Path, quick: bool) -> None:
    """Draw error against the work of a frame of a sixtieth of a second, a panel a body; keep the numbers."""
    chosen = graded.CHOSEN[:1] if quick else graded.CHOSEN
    found = list(graded.rungs(chosen, 1 if quick else graded.PRESSES))
    slow = [quasi_static.press_slowly(bodies.FITTED[k], size) for k in chosen for size in quasi_static.VERTICES]
    graded.write(out / "graded.csv", found)
    quasi_static.write(out / "quasi_static.csv", slow)
    figure, panels = plt.subplots(2, 3, figsize=(13, 8))
    ticks = quasi_static.FRAME / TICK
    for axes, name in zip(panels.flat, dict.fromkeys(rung.body for rung in found), strict=False):
        rungs: dict[str, dict[int, list[tuple[float, float]]]] = defaultdict(lambda: defaultdict(list))
        for rung in found:
            if rung.body == name:
                rungs[rung.seeds][rung.rung].append((rung.work * ticks, rung.error))
        for kind, label in KINDS.items():
            at = np.array([np.median(some, axis=0) for _, some in sorted(rungs[kind].items())])
            axes.loglog(*at.T, "o-", ms=4, lw=1, label=label)
        works, errors = np.array([np.median(some, axis=0) for _, some in sorted(rungs["uniform"].items())]).T
        for each in slow:  # an equilibrium errs as the dynamic proxy of its size does, or more
            if each.body == name:
                like = np.exp(np.interp(np.log(each.vertices * each.steps), np.log(works), np.log(errors)))
                once = "equilibrium" if each is slow[0] else None
                axes.loglog(each.vertices * np.median(each.products), like, "kx", label=once)
        axes.set_title(name)
        axes.xaxis.set_minor_formatter(NullFormatter())  # they would lie on one another
        axes.set(xlabel="vertices x steps (or products) a frame", ylabel="error of the surface over fingertip radius")
    panels.flat[0].legend(frameon=False, fontsize=7)
    title = "The ladder, medians over the presses of each body: lower left is better"
    crosses = "of an equilibrium the work is measured; the error is taken to be that of the dynamic proxy of its size"
    figure.suptitle(f"{title}\n{crosses}", fontsize=10)
    save(figure, out / "ladder")
