"""Results of the sensory comparison: for each participant first, fitted by psignifit, then for the group of them.

A fit is refused where the answers do not rise with the stiffness, or the levels do not reach the point of equality.
Participants are never pooled: the intervals of a group are over people.
"""

from __future__ import annotations

import json
import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from core.base import DimpleError
from core.experiment.log import Row, parsed

QUARTER: Final = 0.6744897501960817  # standard deviations from the middle to three quarters
WIDTH: Final = 2 * 1.6448536269514722  # standard deviations from 5 to 95 %, which psignifit calls the width
FEWEST: Final = 20  # answers: with fewer, the interval of the JND is as wide as the range of the levels
RISES: Final = 3.841  # 95 % quantile of chi squared: a rise that is less likely a chance than one in twenty
Interval = tuple[float, float]
Shown = tuple[str, str, float]  # the real object, the object of the virtual one, and its level


@dataclass(frozen=True, slots=True, kw_only=True)
class Pairs:
    """The pairs of one participant.

    levels, stiffer, trials: how often the test was judged the stiffer.
    first: share of the answers "First", with its 95 % interval: an even half where the order does not matter.
    catch: how many catch trials were right, and of how many.
    refused: why there is no fit, "" where there is one.
    pse, jnd: point of equality, and step to three quarters, as shares of the standard's stiffness; 95 % intervals.
    lapse: share of answers at random, on each side.
    deviance: of the fit from the answers: of the order of the number of levels where it fits.
    """

    participant: str
    levels: tuple[float, ...]
    stiffer: tuple[int, ...]
    trials: tuple[int, ...]
    first: tuple[float, Interval]
    catch: tuple[int, int]
    refused: str = ""
    pse: float = math.nan
    jnd: float = math.nan
    pse_95: Interval = (math.nan, math.nan)
    jnd_95: Interval = (math.nan, math.nan)
    lapse: float = math.nan
    deviance: float = math.nan

    def sentence(self) -> str:
        """Return a line of the table."""
        share, (low, high) = self.first
        bias = f'"First" {share:.2f} ({low:.2f} to {high:.2f}), catch {self.catch[0]}/{self.catch[1]}'
        if self.refused:
            return f"{self.participant}  refused: {self.refused}  {bias}"
        return (
            f"{self.participant}  equal at {self.pse:.3f} ({self.pse_95[0]:.3f} to {self.pse_95[1]:.3f}), just "
            f"noticeable {self.jnd:.1%} ({self.jnd_95[0]:.1%} to {self.jnd_95[1]:.1%}), lapse {self.lapse:.3f}, "
            f"deviance {self.deviance:.1f} of {len(self.levels)} levels  {bias}"
        )


@dataclass(slots=True, kw_only=True)
class Ratings:
    """The ratings of one participant.

    steps: what the answers say.
    answers: from 1 on, by the real object, the object whose constants the virtual one had, and its level.
    catch: how many catch trials were right, and of how many.
    """

    participant: str
    steps: list[str]
    catch: tuple[int, int]
    answers: dict[Shown, list[int]] = field(default_factory=lambda: defaultdict(list))

    @property
    def told(self) -> float:
        """Return how often a twin was rated above a foil of the same object, ties half: 0.5 is chance."""
        pairs = [
            (a > b) + (a == b) / 2
            for twin, twins in self.answers.items() for foil, foils in self.answers.items()
            if is_twin(twin) and not is_twin(foil) and twin[0] == foil[0] for a in twins for b in foils
        ]  # fmt: skip
        return float(np.mean(pairs)) if pairs else math.nan

    @property
    def chance(self) -> float:
        """Return how likely so high ratings of the twins would be if they were rated as the foils are."""
        from scipy import stats

        twins, foils = ([each for shown, some in self.answers.items() if is_twin(shown) == twin for each in some]
                        for twin in (True, False))  # fmt: skip
        return float(stats.mannwhitneyu(twins, foils, alternative="greater").pvalue)

    @property
    def refused(self) -> str:
        """Return why the ratings say nothing, "" where they do."""
        if len({each for some in self.answers.values() for each in some}) == 1:
            return "all answers are alike"
        if 2 * self.catch[0] <= self.catch[1] > 0:  # someone who guesses gets half of them right
            return "half of the catch trials or more are wrong"
        return ""

    def sentence(self) -> str:
        """Return a line of the table."""
        bias = f"catch {self.catch[0]}/{self.catch[1]}"
        if self.refused:
            return f"{self.participant}  refused: {self.refused}  {bias}"
        above = f"twin rated above foil in {self.told:.0%} (chance 50 %, p = {self.chance:.3f})"
        return f"{self.participant}  {above}  {bias}"


def is_twin(shown: Shown) -> bool:
    """Tell whether a virtual object had the constants of the real one."""
    return shown[0] == shown[1] and shown[2] == 1


def read(paths: Iterable[Path]) -> tuple[list[Pairs], list[Ratings], list[str]]:
    """Return the results in files of answers, and what is to be said of them.

    Raises:
        DimpleError: one cannot be read, is another file, or a participant is there twice.
    """
    pairs, ratings, notes, seen = list[Pairs](), list[Ratings](), list[str](), set[tuple[str, str]]()
    for path in paths:
        try:
            rows = parsed(path, path.read_bytes())
        except OSError as error:
            raise DimpleError(f"{path} cannot be read: {error.strerror}.") from None
        answers = {int(row["trial"]): row for row in rows if row["event"] == "answer"}  # a later one counts
        if len(answers) < sum(row["event"] == "answer" for row in rows):
            notes.append(f"{path.name}: a trial was answered twice; the later answer counts.")
        if not answers:
            notes.append(f"{path.name}: there are no answers yet.")
            continue
        if missing := set(range(1, max(answers) + 1)) - set(answers):
            notes.append(f"{path.name}: trials {sorted(missing)} are missing.")
        for key in {(row["plan"], row["participant"]) for row in rows}:
            if key in seen:
                raise DimpleError(f"The answers of participant {key[1]} are given twice ({path.name}).")
            seen.add(key)
        plan = json.loads(next(row["details"] for row in rows if row["details"]))["plan"]
        if plan["made"].get("kind") == "pair":
            pairs.append(_pairs(list(answers.values()), plan["made"].get("standard", "")))
        else:
            ratings.append(_ratings(list(answers.values()), plan["answers"]))
    return pairs, ratings, notes


def _level(cell: str) -> float:
    return float(cell.replace(",", "."))  # as some spreadsheets save it


def _caught(answers: Sequence[Row]) -> tuple[int, int]:
    caught = [row["answer"] in row["part"].split()[1:] for row in answers if row["part"].startswith("catch")]
    return sum(caught), len(caught)


def _pairs(answers: Sequence[Row], standard: str) -> Pairs:
    main = [row for row in answers if row["part"] == "main"]
    counts: dict[float, list[int]] = defaultdict(lambda: [0, 0])
    for row in main:
        first_is_test = row["second_level"] == "real" or row["second"] == standard
        level = _level(row["first_level"] if first_is_test else row["second_level"])
        counts[level][0] += (row["answer"] == "1") == first_is_test
        counts[level][1] += 1
    levels = tuple(sorted(counts))
    stiffer, trials = (tuple(counts[level][i] for level in levels) for i in (0, 1))
    firsts = sum(row["answer"] == "1" for row in main)
    known: dict[str, Any] = {
        "participant": answers[0]["participant"], "levels": levels, "stiffer": stiffer, "trials": trials,
        "first": (firsts / max(len(main), 1), _share_95(firsts, len(main))), "catch": _caught(answers),
    }  # fmt: skip
    return Pairs(**known, **fit(levels, stiffer, trials))


def fit(levels: Sequence[float], stiffer: Sequence[int], trials: Sequence[int]) -> dict[str, Any]:
    """Return what psignifit finds, or why it is refused; see Pairs."""
    import psignifit

    x, k, n = (np.asarray(each, float) for each in (levels, stiffer, trials))
    if n.sum() < FEWEST or len(x) < 2:
        return {"refused": f"fewer than {FEWEST} answers, or one level"}
    slope = float(((x - np.average(x, weights=n)) * (k - n * k.sum() / n.sum())).sum())
    spread = float(k.sum() / n.sum() * (1 - k.sum() / n.sum()) * (n * (x - np.average(x, weights=n)) ** 2).sum())
    if spread <= 0 or slope**2 < RISES * spread:  # the score test of a slope
        return {"refused": "the answers do not rise with the stiffness"}
    if slope < 0:
        return {"refused": "the answers fall with the stiffness: the buttons were taken for each other"}
    data = np.array([x, k, n]).T
    result = psignifit.psignifit(data, experiment_type="equal asymptote", sigmoid="norm", verbose=False)
    found, ends = result.parameter_estimate, {name: each["0.95"] for name, each in result.confidence_intervals.items()}
    if not x.min() < found["threshold"] < x.max():
        return {"refused": "the levels do not reach the point of equality"}
    p = np.clip(result.proportion_correct(x), 1e-9, 1 - 1e-9)
    seen = np.clip(k / n, 1e-9, 1 - 1e-9)
    low, high = ends["width"]
    return {
        "pse": found["threshold"], "pse_95": tuple(ends["threshold"]), "jnd": QUARTER / WIDTH * found["width"],
        "jnd_95": (QUARTER / WIDTH * low, QUARTER / WIDTH * high), "lapse": found["lambda"],
        "deviance": float(2 * (k * np.log(seen / p) + (n - k) * np.log((1 - seen) / (1 - p))).sum()),
    }  # fmt: skip


def _ratings(answers: Sequence[Row], steps: list[str]) -> Ratings:
    made = Ratings(participant=answers[0]["participant"], steps=steps, catch=_caught(answers))
    for row in (row for row in answers if row["part"] == "main"):
        real, virtual = ("first", "second") if row["first_level"] == "real" else ("second", "first")
        made.answers[row[real], row[virtual], _level(row[f"{virtual}_level"])].append(int(row["answer"]))
    return made


def group(values: Sequence[float]) -> tuple[float, float, float]:
    """Return the mean over people, and its 95 % interval by Student's t."""
    from scipy import stats

    x = np.asarray(values)
    if len(x) < 2:
        return float(x.mean()) if len(x) else math.nan, -math.inf, math.inf
    half = float(stats.t.ppf(0.975, len(x) - 1) * x.std(ddof=1) / math.sqrt(len(x)))
    return float(x.mean()), float(x.mean()) - half, float(x.mean()) + half


def _share_95(count: int, trials: int) -> Interval:
    from scipy import stats

    interval = stats.binomtest(count, max(trials, 1)).proportion_ci()
    return float(interval.low), float(interval.high)


def summary(pairs: Sequence[Pairs], ratings: Sequence[Ratings]) -> list[str]:
    """Return the sentences about the groups."""
    lines, fitted = list[str](), [each for each in pairs if not each.refused]
    if pairs:
        mean, low, high = group([each.pse for each in fitted])
        jnd = [math.exp(each) for each in group([math.log(each.jnd) for each in fitted])]
        lines.append(
            f"group  {len(fitted)} of {len(pairs)} people fitted: equal at {mean:.3f} ({low:.3f} to {high:.3f}), just "
            f"noticeable {jnd[0]:.1%} ({jnd[1]:.1%} to {jnd[2]:.1%}); mean and 95 % interval over people"
        )
    kept = [each for each in ratings if not each.refused]
    if ratings:
        mean, low, high = group([each.told for each in kept])
        lines.append(
            f"group  {len(kept)} of {len(ratings)} people kept: twin rated above foil in {mean:.0%} ({low:.0%} to "
            f"{high:.0%}), chance 50 %; mean and 95 % interval over people"
        )
        for (real, virtual, level), counts in totals(kept).items():
            said = ", ".join(f"{count} {step}" for step, count in counts.items())
            lines.append(f"  real {real}, virtual {virtual} x {level:g}: {said}")
    return lines


def totals(ratings: Sequence[Ratings]) -> dict[Shown, dict[str, int]]:
    """Return how often each step was answered."""
    counts: dict[Shown, Counter[int]] = defaultdict(Counter)
    for each in ratings:
        for shown, answers in each.answers.items():
            counts[shown].update(answers)
    steps = ratings[0].steps if ratings else []
    ordered = sorted(counts, key=lambda shown: (shown[0], not is_twin(shown), shown))
    return {shown: {step: counts[shown][i] for i, step in enumerate(steps, start=1)} for shown in ordered}
