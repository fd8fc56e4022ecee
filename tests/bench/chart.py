"""Cost of a step against vertices, with the bounds no kernel of this shape can pass."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

# of one step of one vertex with six neighbours, single precision, counted in core/native/rings.c and integrate.c
FLOPS = 318
BYTES = 290  # slots 98, state 48, matter 32, next 48, records 64
PEAK = 94.5e9  # [flop/s] of the reference machine, one core, AVX2 without fused multiply-add counted as one each


def draw(cases: list[dict[str, Any]], lines: dict[str, Any], bandwidth: float, stem: Path) -> None:
    """Write stem.png and stem.svg.

    Args:
        cases, lines: of bench.py.
        bandwidth: [bytes/s] of memory.
    """
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams["svg.hashsalt"] = "dimple"
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8, 5.5), layout="constrained")
    backends = dict.fromkeys(case["backend"] for case in cases if case["backend"] != "session")
    for scene, backend in [*(("poke_ball", each) for each in backends), ("everything", "native")]:
        mine = [case for case in cases if (case["scene"], case["backend"]) == (scene, backend)]
        n = np.array([case["vertices"] for case in mine])
        cost = n * [case["ns_per_vertex_step"] for case in mine] * 1e-3
        slope = lines.get(f"{scene}, {backend}", {}).get("slope", float("nan"))
        axes.loglog(n, cost, "o-", label=f"{scene}, {backend}: slope {slope:.2f}")
    n = np.array([600, 170_000])
    axes.loglog(n, n * FLOPS / PEAK * 1e6, "k--", lw=1, label=f"{FLOPS} flop at {PEAK / 1e9:.0f} Gflop/s")
    label = f"{BYTES} bytes at {bandwidth / 1e9:.0f} GB/s (memory; caches are faster)"
    axes.loglog(n, n * BYTES / bandwidth * 1e6, "k:", lw=1, label=label)
    axes.axhline(100, color="0.7", lw=1)
    axes.annotate("10 substeps at 1 kHz", (n[0], 100), va="bottom", color="0.4", fontsize=8)
    axes.set(xlabel="vertices", ylabel="one step [µs], one core")
    axes.grid(alpha=0.3, which="both", lw=0.4)
    axes.legend(fontsize=8)
    for suffix in (".png", ".svg"):
        metadata = {"Date": None} if suffix == ".svg" else None
        figure.savefig(stem.with_name(stem.name + suffix), dpi=110, metadata=metadata)
    plt.close(figure)
