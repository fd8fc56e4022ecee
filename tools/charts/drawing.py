"""Styles, tables and files that all charts share."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from core.base import Floats
from studies.methods.registry import METHODS

NATIVE_LABEL = "semi-implicit Euler, native core"
LABELS = {name: method.label for name, method in METHODS.items()} | {"native": NATIVE_LABEL}
STYLES = dict(zip(LABELS, [*plt.get_cmap("tab10").colors[:9], "black"], strict=True))  # type: ignore[attr-defined]
MARKERS = dict(zip(LABELS, "ov^sDPX*p+", strict=True))

plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "svg.hashsalt": "dimple"})


def edges(centres: Floats) -> Floats:
    """Return the borders of cells round centres on a logarithmic scale."""
    ratio = math.sqrt(centres[1] / centres[0])
    return np.append(centres / ratio, centres[-1] * ratio)


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
