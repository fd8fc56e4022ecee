"""Draw the charts of the studies, each as PNG, SVG and CSV: `python3 dev.py charts [--out DIR] [--quick]`.

The numbers come from studies; drawing and the independent solver are development only.
"""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Sequence
from pathlib import Path

from studies.methods.registry import METHODS

from .charts_model import draw_cost, draw_energy, draw_literal, draw_space, draw_stiff_nylon
from .charts_proxies import draw_proxies
from .charts_stability import draw_stability
from .charts_work import draw_work_precision
from .environment import ROOT

KEPT = ROOT / "tests" / "studies" / "charts"  # what the README shows


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="dev.py charts", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("build/charts"), metavar="DIR")
    parser.add_argument("--quick", action="store_true", help="smaller bodies, fewer points: under 50 seconds")
    parser.add_argument("--keep", action="store_true", help="keep the main charts and the fronts")
    options = parser.parse_args(words)
    if options.keep and options.quick:
        parser.error("what is measured in a hurry is not kept: leave out --quick or --keep")
    options.out.mkdir(parents=True, exist_ok=True)
    for draw in (
        draw_work_precision, draw_stability, draw_energy, draw_literal, draw_cost, draw_space, draw_stiff_nylon,
        draw_proxies,
    ):  # fmt: skip
        started = time.perf_counter()
        draw(options.out, options.quick)
        print(f"{draw.__name__.removeprefix('draw_')}: {time.perf_counter() - started:.1f} s", flush=True)
    if options.keep:
        keep(options.out)
    print("\nWhere each method fails, and why\n" + where_methods_fail(), flush=True)
    return 0


def keep(out: Path) -> None:
    """Keep the main charts and the fronts."""
    KEPT.mkdir(parents=True, exist_ok=True)
    for name in ("work_precision", "stability", "proxies"):
        for suffix in (".png", ".svg", ".csv"):
            shutil.copyfile(out / (name + suffix), KEPT / (name + suffix))
    for name in ("stability_bounds.csv", "fronts.csv"):
        shutil.copyfile(out / name, KEPT / name)


def where_methods_fail() -> str:
    return "\n".join(f"  {m.label} (order {m.order}, {m.kind}): {m.purpose}.\n    {m.fails}" for m in METHODS.values())


if __name__ == "__main__":
    raise SystemExit(main())
