"""Results of an experiment: ratings counted, comparisons fitted for each participant; tasks are never pooled."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable
from operator import attrgetter
from typing import NamedTuple

from core.base import DimpleError
from core.experiment.log import Row
from studies.psychometric import Psychometric, fit


class Ratings(NamedTuple):
    """The ratings of one task: the number of participants, and of answers for each step, from the first on."""

    object: str
    condition: str
    people: int
    counts: tuple[int, ...]


class Comparison(NamedTuple):
    """The comparisons of one participant in one task: how often the test was judged the stiffer at each level.

    fitted: the function, or why the answers give none.
    """

    object: str
    condition: str
    participant: str
    levels: tuple[float, ...]
    stiffer: tuple[int, ...]
    trials: tuple[int, ...]
    fitted: Psychometric | str


def rated(rows: Iterable[Row], steps: int = 4) -> list[Ratings]:
    """Return the ratings by task."""
    found = []
    for answers in _grouped(rows, "rating", "object", "condition", "plan", "task"):
        counts = Counter(row.response for row in answers)
        each = tuple(counts[step] for step in range(1, max(steps, *counts) + 1))
        people = len({row.participant for row in answers})
        found.append(Ratings(answers[0].object, answers[0].condition, people, each))
    return found


def compared(rows: Iterable[Row]) -> list[Comparison]:
    """Return the comparisons by task and participant."""
    found = []
    for answers in _grouped(rows, "comparison", "object", "condition", "participant", "plan", "task"):
        all_of_it, yes = Counter(row.level for row in answers), Counter(row.level for row in answers if row.response)
        levels = tuple(sorted(all_of_it))
        stiffer, trials = tuple(yes[level] for level in levels), tuple(all_of_it[level] for level in levels)
        try:
            fitted: Psychometric | str = fit(levels, stiffer, trials)
        except DimpleError as error:
            fitted = str(error)
        one = answers[0]
        found.append(Comparison(one.object, one.condition, one.participant, levels, stiffer, trials, fitted))
    return found


def _grouped(rows: Iterable[Row], kind: str, *names: str) -> list[list[Row]]:
    groups: dict[object, list[Row]] = defaultdict(list)
    for row in sorted((row for row in rows if row.kind == kind), key=attrgetter(*names)):
        groups[attrgetter(*names)(row)].append(row)
    return list(groups.values())


def sentences(rows: Iterable[Row]) -> list[str]:
    """Return the results, a sentence for each task, of a comparison for each participant.

    Raises:
        DimpleError: the same trial of a participant is there twice.
    """
    rows = list(rows)
    if len({(row.participant, row.plan, row.trial) for row in rows}) < len(rows):
        raise DimpleError("A trial of a participant is there twice: analyse each file once, each person under a code.")
    lines = [
        f"{each.object}, {each.condition}: {each.counts} answers for each step, by {each.people} participants"
        for each in rated(rows)
    ]
    for one in compared(rows):
        about, f = f"{one.object}, {one.condition}, participant {one.participant}: ", one.fitted
        lines.append(about + (f if isinstance(f, str) else (
            f"equal at {f.pse:.3f} times its stiffness ({f.pse_95[0]:.3f} to {f.pse_95[1]:.3f}), just noticeable "
            f"{100 * f.jnd:.1f} % ({100 * f.jnd_95[0]:.1f} to {100 * f.jnd_95[1]:.1f}), of {f.trials} answers, "
            f"lapses {f.lapse:.3f}, deviance {f.deviance:.1f} at {len(one.levels)} levels"
        )))  # fmt: skip
    return lines
