"""An experiment under way: the trial that is next, what was felt in it, and its answer."""

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
from .plan import Plan, Stimulus, Trial

AXES = ("x_m", "y_m", "z_m", "fx_n", "fy_n", "fz_n")  # of a tip in a sample, after the time


@dataclass(slots=True, kw_only=True)
class Interval:
    """What was presented in one interval of a trial."""

    times: int = 1  # how often it was presented
    needed: float = 0.0  # stiffness that the device must be able to render [N/m]
    least_n: float = 0.0  # force of a touch
    most_n: float = math.inf  # force up to which the stimulus is rendered as it is
    seconds: float = 0.0  # how long it was felt, and nothing else
    samples: list[Sequence[float]] = field(default_factory=list)  # of the device, see `Servo.sample`

    def feel(self, samples: Sequence[Sequence[float]], cap: float) -> None:
        """Take what the device did, and the stiffness that it can render now [N/m].

        Where that is too low, or the press too hard, something else was felt: the time begins again.
        """
        for sample in samples:
            passed = sample[0] - self.samples[-1][0] if self.samples else 0.0
            self.samples.append([round(value, 6) for value in sample])  # [µs], [µm] and [µN]
            force = max(math.hypot(*sample[at : at + 3]) for at in range(4, len(sample), 6))
            if force > self.most_n or cap < self.needed:
                self.seconds = 0.0
            elif force >= self.least_n:
                self.seconds += min(passed, STATE_GAP)


class Experiment:
    """A participant's experiment, which continues where the file of answers ends.

    Args:
        materials: of each object, by its label.
        stated: what else the file of answers states: version, device...

    Raises:
        DimpleError: the file cannot be used, is of another participant, or anything presented has changed since.
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
                "{path} has answers of another participant, or to another plan or other materials. Restore these, or "
                "choose another file.",
                path=path
            )  # fmt: skip
        self._answers = {int(row["trial"]): int(row["answer"]) for row in self.log.rows if row["event"] == "answer"}
        self.agreed, self._rested = False, 0.0
        self.trial: Trial | None = None  # the next, with the levels that its staircases have reached
        self.intervals: list[Interval] = []  # of that trial, as far as they were presented

    def left(self) -> list[Trial]:
        """Return the trials that are not answered."""
        return [trial for trial in self.trials if trial.number not in self._answers]

    @property
    def due(self) -> int:
        """Return which interval of the trial is to be presented next, from 0 on; 2 of 2 where all were."""
        return sum(each.seconds >= self.plan.exposure_s for each in self.intervals)

    @property
    def is_shown(self) -> bool:
        """Tell whether all of the trial was presented."""
        return self.trial is None or self.due == len(self.trial.show)

    @property
    def rests(self) -> bool:
        """Tell whether the participant is still to rest."""
        return time.monotonic() < self._rested

    def agree(self) -> None:
        """Keep that the participant agreed, and all that is presented from now on."""
        self._append(event="consent", details=json.dumps(self.stated, default=asdict))
        self.agreed = True
        self._go_on()

    def begin(self, *, needed: float = 0.0, least_n: float = 0.0, most_n: float = math.inf) -> None:
        """Begin the interval that is due, see Interval; one that was interrupted begins again."""
        times = 1 + sum(each.times for each in self.intervals[self.due :])
        self.intervals[self.due :] = [Interval(times=times, needed=needed, least_n=least_n, most_n=most_n)]

    def answer(self, chosen: int) -> None:
        """Keep the answer to the trial, from 1 on, and what was felt before it; go on to the next.

        Raises:
            DimpleError: there is no such answer, an object was not felt for long enough, or it cannot be kept.
        """
        trial = self.trial
        if trial is None or not 1 <= chosen <= len(self.plan.answers):
            raise DimpleError("There is no answer {chosen}.", chosen=chosen)
        if not self.is_shown:
            raise DimpleError("Each object must be felt for {seconds:g} s.", seconds=self.plan.exposure_s)
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
        trial = next(iter(self.left()), None)
        self.trial = trial and replace(trial, show=tuple(self._placed(trial, each) for each in trial.show))
        self.intervals, self._rested = [], time.monotonic() + (trial.rest_s if trial else 0.0)

    def _placed(self, trial: Trial, stimulus: Stimulus) -> Stimulus:
        """Return a stimulus at the level that its staircase has reached: one step down if it was the stiffer, else up.

        That converges on the point of equality.
        """
        if not stimulus.track:
            return stimulus
        ladder, at = self.plan.ladder, self.plan.tracks[stimulus.track]
        for before in self.trials[: trial.number - 1]:
            for interval, each in enumerate(before.show, start=1):
                if each.track == stimulus.track:
                    step = -1 if self._answers[before.number] == interval else 1
                    at = min(max(at + step, 0), len(ladder) - 1)
        return replace(stimulus, level=ladder[min(max(at + stimulus.beside, 0), len(ladder) - 1)])

    def _append(self, **cells: str) -> None:
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        self.log.append({"time": now, "participant": self.participant, "plan": self._key, "end": END, **cells})
