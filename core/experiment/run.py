"""An experiment under way: the trial that is next, and its answer."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from ..errors import DimpleError
from .log import Log, Row, Sample
from .plan import ExperimentPlan, Trial, order
from .staircase import next_level


class Experiment:
    """A participant's experiment, which continues where its log ends.

    Raises:
        DimpleError: the log is of another plan or another participant.
    """

    def __init__(self, plan: ExperimentPlan, participant: str, log: Log) -> None:
        self.plan, self.participant, self.log = plan, participant, log
        self._trials = order(plan, participant)
        for row in log.rows:
            if (row.plan, row.participant) != (plan.checksum, participant):
                raise DimpleError(
                    "{path} has answers of participant {participant}, or of another version of the experiment. "
                    "Choose another file.",
                    path=log.path, participant=row.participant
                )  # fmt: skip
        if len(log.rows) > len(self._trials):
            raise DimpleError("{path} has more answers than the experiment has trials.", path=log.path)

    def next(self) -> Trial | None:
        """Return the next trial, None where all are answered."""
        number = len(self.log.rows)
        if number >= len(self._trials):
            return None
        trial = self._trials[number]
        if trial.task.staircase:
            answers = [(row.level, bool(row.response)) for row in self.log.rows if row.task == trial.task_number]
            trial = trial._replace(level=next_level(trial.task.start, trial.task.step, answers))
        return trial

    def answer(self, chosen: int, *, seconds: float = 0.0, samples: Sequence[Sample] = ()) -> None:
        """Keep the answer to the next trial.

        Args:
            chosen: of a rating the step, of a comparison which was the stiffer: from 1 on.
            seconds: that it took [s].
            samples: what was touched.

        Raises:
            DimpleError: there is no such answer, nothing to answer, or it cannot be kept.
        """
        trial = self.next()
        if trial is None:
            raise DimpleError("All trials are answered.")
        rating = trial.task.kind == "rating"
        if not 1 <= chosen <= (len(trial.task.steps) if rating else 2):
            raise DimpleError("There is no answer {chosen}.", chosen=chosen)
        row = Row(
            trial=trial.number, plan=self.plan.checksum, participant=self.participant,
            time=datetime.now(UTC).isoformat(timespec="microseconds"), task=trial.task_number,
            kind=trial.task.kind, condition=trial.task.condition, object=trial.task.object, label=trial.label,
            level=trial.level, test_first=int(trial.test_first),
            response=chosen if rating else int((chosen == 1) == trial.test_first), seconds=round(seconds, 3),
            force_max_n=round(max((force for *_, force in samples), default=0.0), 4),
            depth_max_mm=round(1e3 * max((depth for _, depth, _ in samples), default=0.0), 4),
        )  # fmt: skip
        self.log.append(row, samples)
