"""Which columns of a table are the depth and the force, and whether its rows stand in the order of time."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..base import DimpleError, Floats
from ..messages import Message, in_a_row
from .known_words_and_units import KIND
from .question import Answers, Candidate, Question, Undecided
from .table import MIN_ROWS, SLIGHT, Table

_COUNT = re.compile(r"(no|nr|number|index|sample|row|point|#|番号|no\.|nr\.)", re.IGNORECASE)
_OTHER = {"depth": "force", "force": "depth"}


def choose(table: Table, answers: Answers, notes: list[str]) -> tuple[dict[str, int], list[Question]]:
    """Return the columns of depth and force that are known, and the questions for those that are not.

    Raises:
        DimpleError: there is nothing to choose from, or an answer names nothing.
    """
    if len(table.numeric) < 2:
        raise DimpleError("The table has one column of numbers; it needs a depth and a force.")
    named = {"depth": answers.depth_column, "force": answers.force_column}
    given = {role: _named(table, name, role) for role, name in named.items() if name is not None}
    chosen, open_options = dict(given), {}
    for role in (role for role in named if role not in given):
        options = open_options[role] = [i for i in _options(table, role) if i not in given.values()]
        if len(options) > 1 and _alike(table.numbers[:, options]):
            notes.append(
                Message(
                    "{title} was taken; {other} says the same.",
                    title=table.title(options[0]),
                    other=table.title(options[1]),
                )
            )
            options = options[:1]
        if len(options) == 1 and (table.role(options[0]) == role or table.kind(options[0]) == KIND[role]):
            chosen[role] = options[0]
    for role, other in _OTHER.items():  # of two columns the one that is left is the other
        if (given or not any(table.names)) and role not in chosen and other in chosen:
            left = [i for i in table.numeric if i != chosen[other]]
            chosen |= {role: left[0]} if len(left) == 1 else {}
    if len(chosen) == 2 and chosen["depth"] == chosen["force"]:
        raise DimpleError("{title} cannot be both the depth and the force.", title=table.title(chosen["depth"]))
    questions = []
    for role in (role for role in named if role not in chosen):
        options = open_options[role] or [i for i in _unnamed(table) if i not in given.values()]
        questions.append(_which_column(table, role, options, chosen.get(_OTHER[role])))
    return chosen, questions


def _options(table: Table, role: str) -> list[int]:
    """Return the columns that may be a role: by unit, where their name says it or nothing; else by name."""
    moving = [i for i in table.numeric if np.nanmin(table.numbers[:, i]) < np.nanmax(table.numbers[:, i])]
    numeric = moving or table.numeric
    named = [i for i in numeric if table.role(i) == role and table.kind(i) in (None, KIND[role])]
    measured = [i for i in numeric if table.kind(i) == KIND[role] and table.role(i) in (None, role)]
    if role == "time":
        return [i for i in named if i in measured] or named or measured
    return measured if any(i in measured for i in named) else named or measured


def _unnamed(table: Table) -> Sequence[int]:
    """Return the columns that could be anything, else all with numbers."""
    free = [i for i in table.numeric if table.role(i) is None and table.kind(i) is None]
    return free if len(free) > 1 else table.numeric


def _named(table: Table, name: str, role: str) -> int:
    """Return the column an answer means: a number counted from 1, or a header."""
    if name.isdigit() and 1 <= int(name) <= len(table.names):
        at = int(name) - 1
    else:
        wanted = name.strip().lower()
        found = [i for i, each in enumerate(table.names) if wanted in (each.lower(), table.title(i).lower())]
        if len(found) != 1:
            raise DimpleError(
                "No single column is called “{name}”. Give its number, 1 to {most}.", name=name, most=len(table.names)
            )
        at = found[0]
    count, rows = int(np.isfinite(table.numbers[:, at]).sum()), len(table.numbers)
    if count < MIN_ROWS:
        few = "numbers in {count} of {rows:,} rows only" if count else "no numbers"
        raise DimpleError(
            "Column {number} ({title}) holds {few}, so it cannot be the {role}.",
            number=at + 1,
            title=table.title(at),
            few=Message(few, count=count, rows=rows),
            role=Message(role),
        )
    return at


def _alike(columns: Floats) -> bool:
    """Return whether columns (n, c) are one but for sign and zero."""
    finite = np.isfinite(columns)
    if (finite != finite[:, :1]).any():
        return False
    centred = columns - np.nanmean(columns, axis=0)
    first, others = centred[:, :1], centred[:, 1:]
    apart = np.minimum(np.nanmax(np.abs(others - first), axis=0), np.nanmax(np.abs(others + first), axis=0))
    return bool((apart <= SLIGHT * (np.nanmax(first) - np.nanmin(first))).all())


def in_time(table: Table, notes: list[str]) -> tuple[Table, bool]:
    """Return a table whose clock or count of rows runs forward, and whether it has one."""
    counts = [i for i in table.numeric if _COUNT.fullmatch(table.names[i].strip())]
    for at in [*_clocks(table), *counts]:
        steps = np.diff(table.numbers[:, at])
        if (steps < 0).all():
            notes.append(
                Message(
                    "The rows stand from the last to the first by {title}; they were turned round.",
                    title=table.title(at),
                )
            )
            return replace(table, numbers=table.numbers[::-1]), True
        if (steps > 0).all():
            return table, True
    return table, False


def _clocks(table: Table) -> list[int]:
    """Return the first column that holds a time in every row, as a list that is empty where there is none."""
    return [i for i in _options(table, "time") if np.isfinite(table.numbers[:, i]).all()][:1]


def check_clock(table: Table, depth_at: int) -> None:
    """Ask where the column called time does not run like a clock, or the depth runs like one in its stead."""
    for at in _clocks(table):
        time, depth = table.numbers[:, at], table.numbers[:, depth_at]
        steps = np.diff(depth[np.isfinite(depth)])
        like_a_clock = depth[0] == 0 and len(steps) > 0 and steps.min() > 0 and np.ptp(steps) < SLIGHT * steps.mean()
        if (np.diff(time) < 0).mean() <= SLIGHT and not (time.min() < 0 and like_a_clock):
            continue
        why = Message(
            "“{title}” does not run like a clock: the headers may stand over the wrong columns.",
            title=table.title(at),
        )
        depth_question, force_question = (_which_column(table, role, table.numeric) for role in _OTHER)
        raise Undecided(replace(depth_question, text=in_a_row([why, depth_question.text])), force_question)


def _which_column(table: Table, role: str, options: Sequence[int], beside: int | None = None) -> Question:
    """Ask for a column; of tests side by side the one next to the other column is the likeliest."""
    near = "" if beside is None else str(min(options, key=lambda i: abs(i - beside - 0.1)) + 1)
    return Question(
        name=f"{role}_column",
        text=Message("Which column is the {role}?", role=role),
        candidates=tuple(Candidate(str(i + 1), _preview(table, i)) for i in options),
        default=near,
    )


def _preview(table: Table, at: int) -> str:
    """Show a column: its title, its first numbers and its range."""
    values = table.numbers[np.isfinite(table.numbers[:, at]), at]
    first = ", ".join(f"{value:g}" for value in values[:3])
    span = Message("{first}, ... from {least:g} to {most:g}", first=first, least=values.min(), most=values.max())
    return Message("{label}: {error}", label=table.title(at), error=span)
