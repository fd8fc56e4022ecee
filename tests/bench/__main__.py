"""Measure the cost of steps, of sessions, of drawing and of exports: `python3 dev.py bench`."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command's words; it needs no environment."""
    made = argparse.ArgumentParser(
        prog="dev.py bench",
        description="Measure steps and sessions on several scenes, sizes and backends, or one of the subjects below.",
        allow_abbrev=False,
    )
    quick = "under 50 seconds: few repeats, slow backends to 10,000 vertices only"
    made.add_argument("--quick", action="store_true", help=quick)
    made.add_argument("--json", type=Path, metavar="FILE", help="write the numbers (steps, --peers and --scale)")
    subjects = made.add_mutually_exclusive_group()
    subjects.add_argument("--exports", action="store_true", help="the cost of an export in each format")
    subjects.add_argument("--peers", action="store_true", help="Dimple beside Bullet on the same bodies")
    subjects.add_argument("--scale", action="store_true", help="many bodies, many vertices")
    made.add_argument("--full", action="store_true", help="with --scale: press the full million too; takes minutes")
    return made


def main(words: list[str]) -> int:
    """Measure one subject and return the exit code."""
    options = parser().parse_args(words)
    from tests.bench import bench

    if options.scale:
        from tests.bench import scale

        found = scale.main(full=options.full)
    elif options.peers:
        from tests.bench import peers

        found = {"cases": peers.measure_all()}
    else:
        found = bench.main(quick=options.quick)
    if options.json:
        options.json.write_text(json.dumps({"machine": bench.machine()} | found, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
