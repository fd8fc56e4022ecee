"""A running experiment: the next trial, the samples recorded in it, and its answer."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ..device.limits import STATE_GAP
from ..errors import DimpleError
from ..material import Material
from .log import END, Log
from .plan_file import Plan, Trial

AXES = ("x_m", "y_m", "z_m", "fx_n", "fy_n", "fz_n")  # columns of a tip in a sample, after the time


@dataclass(slots=True, kw_only=True)
class Interval:
    """The presentation of one interval of a trial."""

    times: int = 1  # number of presentations, interrupted ones included
    needed: float = 0.0  # [N/m] stiffness that the device must be able to render
    least_n: float = 0.0  # [N] force from which on there is contact
    most_n: float = math.inf  # [N] force up to which the stimulus is rendered faithfully
    seconds: float = 0.0  # [s] time of contact with faithful rendering throughout
    samples: list[Sequence[float]] = field(default_factory=list)  # time, positions and forces, see `Servo.sample`

    def feel(self, samples: Sequence[Sequence[float]], cap: float) -> None:
        """Add samples of the device.

        If the device cannot render the stiffness, or the press is too hard, the time of contact begins again at 0.

        Args:
            cap: stiffness that the device can render now [N/m].
        """
        for sample in samples:
            passed = sample[0] - self.samples[-1][0] if self.samples else 0.0
            self.samples.append([round(value, 6) for value in sample])  # to 1 µs, 1 µm and 1 µN
            force = max(math.hypot(*sample[at : at + 3]) for at in range(4, len(sample), 6))
            if force > self.most_n or cap < self.needed:
                self.seconds = 0.0
            elif force >= self.least_n:
                self.seconds += min(passed, STATE_GAP)


class Experiment:
    """A participant's experiment; it resumes where the file of answers ends.

    Args:
        path: file of answers.
        materials: label of an object: its material.
        stated: further facts for the file of answers: version, device...

    Raises:
        DimpleError: the file cannot be used, is of another participant, or the plan or a material has changed since.
    """

    def __init__(
        self, plan: Plan, participant: str, path: Path, materials: Mapping[str, Material], stated: Mapping[str, Any]
    ) -> None:
        self.plan, self.participant, self.materials = plan, participant, materials
        self.trials = plan.participants[participant]
        presented = {"plan": replace(plan, participants={}), "constants": dict(materials)}
        whole = json.dumps([presented, self.trials], default=asdict)
        self._key, self.stated = hashlib.sha256(whole.encode()).hexdigest()[:12], {**presented, **stated}
        self.log = Log(path)
        if any((row["plan"], row["participant"]) != (self._key, participant) for row in self.log.rows):
            self.log.file.close()
            raise DimpleError(
                "{path} has answers of another participant, or to another plan or other materials. Restore the plan "
                "and the materials, or choose another file.",
                path=path
            )  # fmt: skip
        self._answers = {int(row["trial"]): int(row["answer"]) for row in self.log.rows if row["event"] == "answer"}
        self.agreed, self._rested = False, 0.0
        self.trial: Trial | None = None  # the next one
        self.intervals: list[Interval] = []  # the intervals of that trial that have begun

    def left(self) -> list[Trial]:
        """Return the unanswered trials."""
        return [trial for trial in self.trials if trial.number not in self._answers]

    @property
    def due(self) -> int:
        """Return the index of the next interval of the trial, which is the number of completed ones."""
        return sum(each.seconds >= self.plan.exposure_s for each in self.intervals)

    @property
    def is_shown(self) -> bool:
        """Return whether all intervals of the trial are completed."""
        return self.trial is None or self.due == len(self.trial.show)

    @property
    def rests(self) -> bool:
        """Return whether the break before the trial is still on."""
        return time.monotonic() < self._rested

    def agree(self) -> None:
        """Record the consent of the participant, with the plan and the constants, and go to the first trial."""
        self._append(event="consent", details=json.dumps(self.stated, default=asdict))
        self.agreed = True
        self._go_on()

    def begin(self, *, needed: float = 0.0, least_n: float = 0.0, most_n: float = math.inf) -> None:
        """Begin the due interval, see `Interval` for the arguments; an interrupted one begins again."""
        times = 1 + sum(each.times for each in self.intervals[self.due :])
        self.intervals[self.due :] = [Interval(times=times, needed=needed, least_n=least_n, most_n=most_n)]

    def answer(self, chosen: int) -> None:
        """Write the answer to the trial, counted from 1, and the trace of the trial; go to the next trial.

        Raises:
            DimpleError: there is no such answer, contact with an object was too short, or it cannot be written.
        """
        trial = self.trial
        if trial is None or not 1 <= chosen <= len(self.plan.answers):
            raise DimpleError("There is no answer {chosen}.", chosen=chosen)
        if not self.is_shown:
            raise DimpleError("Touch each object for at least {seconds:g} s.", seconds=self.plan.exposure_s)
        cells = {}
        for name, stimulus, each in zip(("first", "second"), trial.show, self.intervals, strict=False):
            cells[name], level = stimulus.real or stimulus.object, "real" if stimulus.real else f"{stimulus.level:g}"
            cells |= {f"{name}_level": level, f"{name}_s": f"{each.seconds:.3f}", f"{name}_times": str(each.times)}
        head = ("interval", "time_s", *(f"tip{tip}_{axis}" for tip in (1, 2, 3) for axis in AXES))
        rows = [(i, *sample) for i, each in enumerate(self.intervals, start=1) for sample in each.samples]
        cells["trace"] = self.log.keep_trace(trial.number, [head, *rows])
        self._append(
            event="answer", trial=str(trial.number), part=trial.part, answer=str(chosen),
            answer_text=self.plan.answers[chosen - 1], **cells,
        )  # fmt: skip
        self._answers[trial.number] = chosen
        self._go_on()

    def _go_on(self) -> None:
        self.trial = next(iter(self.left()), None)
        self.intervals, self._rested = [], time.monotonic() + (self.trial.rest_s if self.trial else 0.0)

    def _append(self, **cells: str) -> None:
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        self.log.append({"time": now, "participant": self.participant, "plan": self._key, "end": END, **cells})
