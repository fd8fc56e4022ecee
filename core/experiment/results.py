"""What the answers of an experiment come to: ratings counted, comparisons fitted, one condition never with another."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from ..errors import DimpleError
from ..messages import Message
from .log import Row
from .psychometric import Psychometric, fit


@dataclass(frozen=True, slots=True, kw_only=True)
class Ratings:
    """The ratings of one object in one condition: how many chose each step, from the first on."""

    object: str
    condition: str
    counts: tuple[int, ...]

    @property
    def mean(self) -> float:
        """Return the mean step, from 1 on."""
        return sum((i + 1) * count for i, count in enumerate(self.counts)) / max(sum(self.counts), 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """The comparisons of one object in one condition.

    levels, stiffer, trials: how often the test was judged the stiffer at each level.
    fitted: the function, None where the answers give none: then `why`.
    """

    object: str
    condition: str
    levels: tuple[float, ...]
    stiffer: tuple[int, ...]
    trials: tuple[int, ...]
    fitted: Psychometric | None
    why: str = ""


def rated(rows: Iterable[Row], steps: int = 4) -> list[Ratings]:
    """Return the ratings by object and condition."""
    counts: dict[tuple[str, str], list[int]] = defaultdict(lambda: [0] * steps)
    for row in rows:
        if row.kind == "rating":
            each = counts[row.object, row.condition]
            each += [0] * (row.response - len(each))
            each[row.response - 1] += 1
    return [
        Ratings(object=name, condition=condition, counts=tuple(each))
        for (name, condition), each in sorted(counts.items())
    ]


def compared(rows: Iterable[Row]) -> list[Comparison]:
    """Return the comparisons by object and condition."""
    answers: dict[tuple[str, str], dict[float, list[int]]] = defaultdict(lambda: defaultdict(lambda: [0, 0]))
    for row in rows:
        if row.kind == "comparison":
            each = answers[row.object, row.condition][row.level]
            each[0] += row.response
            each[1] += 1
    found = []
    for (name, condition), by_level in sorted(answers.items()):
        levels = sorted(by_level)
        stiffer, trials = zip(*(by_level[level] for level in levels), strict=True)
        fitted, why = None, ""
        try:
            fitted = fit(levels, stiffer, trials)
        except DimpleError as error:
            why = str(error)
        found.append(
            Comparison(
                object=name, condition=condition, levels=tuple(levels), stiffer=stiffer, trials=trials, fitted=fitted,
                why=why,
            )
        )  # fmt: skip
    return found


def sentences(rows: Iterable[Row]) -> list[str]:
    """Return the results, a sentence for each object and condition."""
    rows = list(rows)
    lines: list[str] = [
        Message(
            "{object}, {condition}: rated {mean:.2f} on the average of {answers} ({counts})",
            object=each.object, condition=each.condition, mean=each.mean, answers=sum(each.counts),
            counts=" ".join(map(str, each.counts))
        )
        for each in rated(rows)
    ]  # fmt: skip
    for each in compared(rows):
        if each.fitted is None:
            said = "{object}, {condition}: {why}"
            lines.append(Message(said, object=each.object, condition=each.condition, why=each.why))
            continue
        f = each.fitted
        lines.append(Message(
            "{object}, {condition}: equal at {pse:.3f} times its stiffness ({pse_low:.3f} to {pse_high:.3f}), just "
            "noticeable {jnd:.1f} % ({jnd_low:.1f} to {jnd_high:.1f}), of {trials} answers",
            object=each.object, condition=each.condition, pse=f.pse, pse_low=f.pse_95[0], pse_high=f.pse_95[1],
            jnd=100 * f.jnd, jnd_low=100 * f.jnd_95[0], jnd_high=100 * f.jnd_95[1], trials=f.trials
        ))  # fmt: skip
    return lines
