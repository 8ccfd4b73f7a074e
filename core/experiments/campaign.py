"""A campaign: the runs of an experiment on any number of workers, kept as they end, resumed after a kill.

The answers depend on the numbers of the runs alone, and are put together in that order: one process, several and a
cluster give the same result to the last digit.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from core.errors import Unavailable
from core.experiments.plan import ExperimentPlan
from core.experiments.result import ExperimentResult, SpeedUp
from core.experiments.run_log import RunLog
from core.experiments.workers import Workers, killed, timed, versions

MAX_BREAKS = 3  # of the workers in succession without a run between them
PROGRESS_LINES = 10  # of the progress at least
REPORT_EVERY_S = 10.0
IN_HAND = 2  # runs that every worker is given at a time


@dataclass(frozen=True)
class Campaign:
    """How runs are carried out. `progress` is given a line now and then, `tell` what remains to be read."""

    experiment: str
    seed: int = 0
    out: Path | None = None
    tell: Callable[[str], None] | None = None
    workers: int | None = None  # None: as many as this computer has, where the runs are worth it
    cluster: str = ""  # address of a scheduler of dask; "": this computer
    resume: bool = False  # the runs in `out` are not carried out again
    progress: Callable[[str], None] | None = None  # None: `tell`
    report_every_s: float = REPORT_EVERY_S

    def carry_out(self, plan: ExperimentPlan) -> ExperimentResult:
        """Carry out every run that lacks → the result. Raises BeckonError."""
        answers, figures = self.answers(plan)
        result: ExperimentResult = plan.finish(answers, self.out)
        result["files"] |= {} if self.runs_file is None else {"runs": str(self.runs_file)}
        return cast(ExperimentResult, {**result, **figures})

    @property
    def runs_file(self) -> Path | None:
        """The file of the runs that are done."""
        return None if self.out is None else self.out / f"{self.experiment.replace('-', '_')}_runs.jsonl"

    def answers(self, plan: ExperimentPlan) -> tuple[list[Any], SpeedUp]:
        """Carry out every run that lacks → all answers by number, and how it went. Raises BeckonError."""
        path, count = self.runs_file, plan.count
        found = versions()
        heading = {"experiment": self.experiment, "seed": self.seed} | found
        began = time.monotonic()
        with Workers(self.workers, self.cluster, count) as workers, RunLog(path, plan, heading, self.resume) as log:
            done = _Progress(self, count, log.resumed)
            try:
                _Rounds(plan, log, workers, done, found["Beckon"]).run()
            except BaseException:
                if path is not None and self.tell is not None:
                    self.tell(f"Ended after {len(log.answers)} of {count} runs; their figures are in {path}.")
                raise
        seconds = time.monotonic() - began
        figures: SpeedUp = {
            "workers": workers.count,
            "seconds": seconds,
            "resumed_runs": log.resumed,
            "serial_seconds": done.serial,
            "speed_up": done.serial / seconds if done.serial and seconds else None,
        }
        return [log.answers[number] for number in range(count)], figures


class _Rounds:
    """The runs that lack, handed out until all are done."""

    def __init__(self, plan: ExperimentPlan, log: RunLog, workers: Workers, progress: _Progress, source: str) -> None:
        self._plan, self._log, self._workers, self._progress = plan, log, workers, progress
        self._source = source
        self._missing = [number for number in reversed(range(plan.count)) if number not in log.answers]
        self._under_way: dict[Future[tuple[Any, float]], int] = {}
        self._breaks = 0

    def run(self) -> None:
        """Hand out, wait, keep; where a process was killed, what it had is handed out again."""
        while self._missing or self._under_way:
            try:
                self._hand_out()
                self._keep()
            except Exception as error:
                if not killed(error):
                    raise
                self._begin_again()

    def _hand_out(self) -> None:
        most = 1 if self._workers.count == 1 else IN_HAND * self._workers.count
        while self._missing and len(self._under_way) < most:
            batch, number = self._plan.batch_of(self._missing[-1])
            future = self._workers.executor.submit(timed, batch.work, number, self._source)
            self._under_way[future] = self._missing.pop()

    def _keep(self) -> None:
        finished, _ = wait(self._under_way, return_when=FIRST_COMPLETED)
        for future in finished:
            try:
                answer, seconds = future.result()
            except CancelledError:
                raise Unavailable("The scheduler of the cluster is gone; the runs that were done are kept.") from None
            self._log.add(self._under_way.pop(future), answer, seconds)
            self._progress.add(seconds)
            self._breaks = 0

    def _begin_again(self) -> None:
        self._missing += sorted(self._under_way.values(), reverse=True)
        self._under_way.clear()
        self._workers.discard()
        self._breaks += 1
        if self._breaks > MAX_BREAKS:
            raise Unavailable(
                "The system kills the workers again and again before a run is done; use fewer --workers, each needs "
                "its memory."
            )


class _Progress:
    """Lines such as "12 of 40 runs, 1.3 a second, 22 s to go"."""

    def __init__(self, campaign: Campaign, count: int, resumed: int) -> None:
        self._say = campaign.progress or campaign.tell
        self._every_s = campaign.report_every_s
        self._count, self._done, self._resumed = count, resumed, resumed
        self._began = self._said = time.monotonic()
        self.serial = 0.0  # [s] of processor time
        if resumed and campaign.tell is not None:
            campaign.tell(f"Resumed: {resumed} of {count} runs were done.")

    def add(self, seconds: float) -> None:
        """A run is done."""
        self._done += 1
        self.serial += seconds
        now = time.monotonic()
        tenth = self._done * PROGRESS_LINES // self._count > (self._done - 1) * PROGRESS_LINES // self._count
        if self._say is not None and (tenth or now - self._said >= self._every_s):
            self._said = now
            rate = (self._done - self._resumed) / max(now - self._began, 1e-3)
            left = _in_words((self._count - self._done) / rate)
            pace = f"{rate:.2g} a second" if rate >= 1 else f"{1 / rate:.2g} s each"
            self._say(f"{self._done} of {self._count} runs, {pace}, {left} to go")


def _in_words(seconds: float) -> str:
    """A time to go."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"
