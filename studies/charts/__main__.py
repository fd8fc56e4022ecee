"""Measure the charts of the documentation and draw them, each as PNG and CSV: `python3 dev.py charts [--quick]`."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command's words; it needs no environment."""
    made = argparse.ArgumentParser(prog="dev.py charts", description=(__doc__ or "").strip(), allow_abbrev=False)
    made.add_argument("--out", type=Path, default=Path("build/charts"), metavar="DIR", help="where the charts go")
    kinds = made.add_mutually_exclusive_group()
    kinds.add_argument("--quick", action="store_true", help="smaller bodies, fewer points: under 50 seconds")
    kinds.add_argument("--redraw", action="store_true", help="only draw the tables that lie in DIR")
    return made


def main(words: Sequence[str] | None = None) -> int:
    """Make the charts and print where each method fails."""
    options = parser().parse_args(words)
    from studies.charts import proxies, stability, work_precision
    from studies.methods.registry import METHODS

    options.out.mkdir(parents=True, exist_ok=True)
    for chart in (work_precision, stability, proxies):
        started = time.perf_counter()
        if not options.redraw:
            chart.measure(options.out, options.quick)
        chart.draw(options.out)
        print(f"{chart.__name__.rpartition('.')[2]}: {time.perf_counter() - started:.1f} s", flush=True)
    print("\nWhere each method fails, and why")
    for method in METHODS.values():
        print(f"  {method.label} (order {method.order}, {method.kind}): {method.purpose}.\n    {method.fails}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
