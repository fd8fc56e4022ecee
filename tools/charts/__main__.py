"""Draw the charts of the studies, each as PNG, SVG and CSV: `python3 dev.py charts [--out DIR] [--quick]`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command's words; it needs no environment."""
    made = argparse.ArgumentParser(prog="dev.py charts", description=(__doc__ or "").strip(), allow_abbrev=False)
    made.add_argument("--out", type=Path, default=Path("build/charts"), metavar="DIR", help="where the charts go")
    kinds = made.add_mutually_exclusive_group()
    kinds.add_argument("--quick", action="store_true", help="smaller bodies, fewer points: under 50 seconds")
    kinds.add_argument("--keep", action="store_true", help="copy the charts of the documentation into tests/studies")
    return made


def main(words: Sequence[str] | None = None) -> int:
    """Draw the charts and print where each method fails."""
    options = parser().parse_args(words)
    from . import every

    options.out.mkdir(parents=True, exist_ok=True)
    every.draw(options.out, options.quick)
    if options.keep:
        every.keep(options.out)
    print("\nWhere each method fails, and why\n" + every.where_methods_fail(), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
