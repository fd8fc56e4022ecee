"""Runs of rows in a text: its tables, whether apart or printed in pages that repeat their header."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base import Floats
from ..messages import Message
from .dialect import Dialect, is_row, number, split
from .question import Candidate, Question
from .vocabulary import is_known

MAX_ROWS = 100_000  # rows kept of a table; of more, every n-th
MIN_ROWS = 8
_PREAMBLE = 2000  # lines in which a table must have begun
_SEEN = 100  # rows of a page that are looked at
_ONWARD = 3.0  # times the largest step of a page: from its last row to the first of the next


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A run of rows.

    start: line of the first row, counted from 0.
    end: line after the last row.
    header: the line that ended the run before this one, "" where none did.
    lines: its rows, and lines between them that are none.
    """

    start: int
    end: int
    header: str
    lines: tuple[str, ...]


def find_blocks(lines: Sequence[str], dialect: Dialect) -> list[Block]:
    """Return every run of rows long enough to be fitted, else the first; a few lines that are none do not end it."""
    blocks: list[Block] = []
    start, end, header = -1, -1, ""
    for i, line in enumerate(lines):
        if start < 0 and i > _PREAMBLE and not blocks:
            break
        if start >= 0 and line[:1].isdigit() and end == i and len(lines) > MAX_ROWS:
            end = i + 1  # a huge file: what begins like a row is one until its numbers are read
            continue
        cells = split(line, dialect.delimiter)
        if is_row(cells, dialect):
            if start < 0:
                start = i
            end = i + 1
        elif start >= 0 and line.strip() and _is_header(cells):
            blocks.append(Block(start=start, end=end, header=header, lines=tuple(lines[start:end])))
            start, header = -1, line.strip()
    if start >= 0:
        blocks.append(Block(start=start, end=end, header=header, lines=tuple(lines[start:end])))
    blocks = _bound(blocks, lines, dialect)
    return [block for block in blocks if len(block.lines) >= MIN_ROWS] or blocks[:1]


def which_table(lines: Sequence[str], blocks: Sequence[Block]) -> Question:
    """Ask which of several tables is the measurement."""

    def label(block: Block) -> str:
        above = next((lines[i].strip() for i in range(block.start - 1, -1, -1) if lines[i].strip()), "")
        return Message(
            "lines {start} to {end}, under “{above}”", start=block.start + 1, end=block.end, above=above[:60]
        )

    return Question(
        name="table",
        text=Message("The file holds {tables} tables. Which one is the measurement?", tables=len(blocks)),
        candidates=tuple(Candidate(value=str(i + 1), label=label(block)) for i, block in enumerate(blocks)),
    )


def _is_header(cells: Sequence[str]) -> bool:
    named = [cell for cell in cells if cell and any(c.isalpha() for c in cell)]
    return len(named) >= 2 and sum(map(is_known, named)) >= 2


def _bound(blocks: Sequence[Block], lines: Sequence[str], dialect: Dialect) -> list[Block]:
    """Bind pages together: runs under the header of the first one whose numbers go on where the last run ended."""
    pages: list[list[Block]] = []
    headers: list[str] = []
    for block in blocks:
        if pages and block.header in headers and _goes_on(pages[-1][-1], block, dialect):
            pages[-1].append(block)
        else:
            headers = [line.strip() for line in lines[pages[-1][-1].end if pages else 0 : block.start]]
            pages.append([block])
    return [_whole(each, dialect) if len(each) > 1 else each[0] for each in pages]


def _whole(pages: Sequence[Block], dialect: Dialect) -> Block:
    """Return pages as one run, without the lines between rows."""
    rows = [line for page in pages for line in page.lines if is_row(split(line, dialect.delimiter), dialect)]
    return Block(start=pages[0].start, end=pages[-1].end, header=pages[0].header, lines=tuple(rows))


def _goes_on(one: Block, other: Block, dialect: Dialect) -> bool:
    """Return whether the numbers of a run go on in another, with steps like its own."""
    before, after = _numbers(one.lines[-_SEEN:], dialect), _numbers(other.lines[:_SEEN], dialect)
    if before.shape[1:] != after.shape[1:]:
        return False
    steps = np.abs(np.concatenate([np.diff(before, axis=0), np.diff(after, axis=0)]))
    jump, largest = np.abs(after[0] - before[-1]), np.nan_to_num(steps).max(axis=0, initial=0)
    known = np.isfinite(jump)
    return bool(known.sum() >= 2 and (jump[known] <= _ONWARD * largest[known]).all())


def _numbers(lines: Sequence[str], dialect: Dialect) -> Floats:
    """Return the numbers (n, c) of the rows among lines that are as wide as the first, NaN where there is none."""
    rows = [cells for line in lines if is_row(cells := split(line, dialect.delimiter), dialect)]
    rows = [row for row in rows if len(row) == len(rows[0])]
    values = [[number(cell, dialect.decimal) for cell in row] for row in rows]
    return np.array([[np.nan if value is None else value for value in row] for row in values], dtype=np.float64)
