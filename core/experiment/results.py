"""What the answers of an experiment come to: ratings counted, comparisons fitted, one condition never with another."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass

from ..errors import DimpleError
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
    lines = [
        f"{each.object}, {each.condition}: rated {each.mean:.2f} on the average of {sum(each.counts)} "
        f"({' '.join(map(str, each.counts))})"
        for each in rated(rows)
    ]
    for each in compared(rows):
        if each.fitted is None:
            lines.append(f"{each.object}, {each.condition}: {each.why}")
            continue
        f = each.fitted
        lines.append(
            f"{each.object}, {each.condition}: equal at {f.pse:.3f} times its stiffness "
            f"({f.pse_95[0]:.3f} to {f.pse_95[1]:.3f}), just noticeable {100 * f.jnd:.1f} % "
            f"({100 * f.jnd_95[0]:.1f} to {100 * f.jnd_95[1]:.1f}), of {f.trials} answers"
        )
    return lines
