"""What experiments there are, as each declares it in its own file."""

from __future__ import annotations

import msgspec

from console.workers.job import Handler, Job
from console.workers.worker import Worker
from core.experiments import EXPERIMENTS

BUDGET = 60.0  # [s] of processor time: every algorithm is imported once


class PrintedFigure(msgspec.Struct, frozen=True):
    """A figure that the chapter prints."""

    name: str
    value: float
    unit: str
    ours: str  # keys of the result, joined by dots


class ExperimentEntry(msgspec.Struct, frozen=True):
    """One experiment."""

    name: str  # for the command line and for a new run
    title: str
    reproduces: str
    runs: int  # when nobody says anything else
    counts: str  # what `runs` counts
    base_s: float  # [s] of processor time, and
    run_s: float  # for each run; both 0: not known
    chapter: list[PrintedFigure]


class ListExperiments(Job[list[ExperimentEntry]], frozen=True):
    """Every experiment, in the order of their names."""


class ExperimentsWorker:
    """Imports every experiment, which the console itself does not."""

    @property
    def handlers(self) -> tuple[Handler, ...]:
        """Every job it knows."""
        return (ListExperiments.handled_by(self.every),)

    def every(self, _: ListExperiments) -> list[ExperimentEntry]:
        """Read all declarations."""
        return [entry(name) for name in sorted(EXPERIMENTS)]


def entry(name: str) -> ExperimentEntry:
    """One experiment as it declares itself."""
    about = EXPERIMENTS[name].about
    chapter = [PrintedFigure(one.name, one.value, one.unit, one.ours) for one in about.chapter]
    return ExperimentEntry(
        name, about.title, about.reproduces, about.runs, about.counts, about.base_s, about.run_s, chapter
    )


class Catalogue:
    """Asks once, in a worker that ends afterwards."""

    def __init__(self) -> None:
        self._worker = Worker("experiments")
        self._entries: list[ExperimentEntry] | None = None

    async def entries(self) -> list[ExperimentEntry]:
        """Every experiment. Raises WorkerLost."""
        if self._entries is None:
            try:
                self._entries = await self._worker.ask(ListExperiments(), budget=BUDGET)
            finally:
                if not self._worker.busy:
                    self._worker.kill()
        return self._entries

    async def close(self) -> None:
        """End the worker."""
        self._worker.kill()
        await self._worker.gone()
