"""The files that the commands write, and their tables in the terminal; what cannot be written ends in `__main__`."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Sequence
from importlib import import_module, util
from pathlib import Path
from typing import Any

from core.base import DimpleError


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def read_csv(path: Path) -> list[dict[str, str]]:
    """Read the rows of a table by their headers."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write_json(path: Path, record: object) -> None:
    """Write a record."""
    path.write_text(json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")


def aligned(lines: Sequence[Sequence[str]]) -> str:
    """Return lines of words as text in columns."""
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    return "\n".join("  ".join(w.ljust(n) for w, n in zip(line, widths, strict=True)).rstrip() for line in lines)


def new_figure(width: float, height: float) -> Any:
    """Return an empty figure of matplotlib [inches].

    Raises:
        DimpleError: matplotlib is not installed.
    """
    if util.find_spec("matplotlib") is None:
        raise DimpleError("A picture needs matplotlib, which is not installed here. Everything else works without it.")
    return import_module("matplotlib.figure").Figure(figsize=(width, height), layout="constrained")


def save_picture(figure: Any, path: Path) -> None:
    """Write a figure as the picture that its ending names.

    Raises:
        DimpleError: matplotlib writes no such picture.
    """
    try:
        figure.savefig(path, dpi=130)
    except ValueError as error:
        raise DimpleError(f"The picture {path} cannot be written: {error}.") from None
