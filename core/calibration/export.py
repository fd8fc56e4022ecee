"""Write a press as CSV, in the paper's form: distance and force, what it is above them.

Spreadsheets run cells that begin like a formula, so text from outside is quoted and never begins like one.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..base import DimpleError, Floats

_FORMULA = ("=", "+", "-", "@", "\t", "\r", "|", "%")
HEADER = ("Distance x (mm)", "Force F (N)")


def write_press(path: str | Path, depth: Floats, force: Floats, *, about: Sequence[str] = ()) -> None:
    """Write a press.

    Args:
        depth: (n,) [m] from the touch.  force: (n,) [N].
        about: lines of text above the table.

    Raises:
        DimpleError: the file cannot be written.
    """
    lines = [text_cell(line) for line in about]
    lines.append(",".join(map(text_cell, HEADER)))
    lines += [f"{1e3 * x:.5f},{f:.5f}" for x, f in zip(depth.tolist(), force.tolist(), strict=True)]
    try:
        Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    except OSError as error:
        raise DimpleError("{path} cannot be written: {error}.", path=path, error=error.strerror or error) from None


def text_cell(text: str) -> str:
    """Return text as one quoted cell that no spreadsheet takes for a formula."""
    line = " ".join(text.split())
    if line.startswith(_FORMULA):
        line = "'" + line
    return '"' + line.replace('"', "'") + '"'
