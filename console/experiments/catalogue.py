"""Catalogue of the experiments, each as its own file declares it."""

import asyncio
from dataclasses import asdict

import msgspec

from console.workers.job import Job
from console.workers.tasks import end
from console.workers.worker import Worker
from core.experiments import EXPERIMENTS
from core.experiments.about import ChapterValue

BUDGET_S = 60.0  # of processor time: every algorithm is imported once


class ExperimentEntry(msgspec.Struct, frozen=True):
    """One experiment."""

    name: str  # for the command line and for a new run
    title: str
    reproduces: str
    runs: int  # when nobody says anything else
    counts: str  # what `runs` counts
    base_s: float  # [s] of processor time, and
    run_s: float  # for each run; both 0: not known
    chapter: tuple[ChapterValue, ...]


class ListExperiments(Job[list[ExperimentEntry]], frozen=True):
    """Every experiment, in the order of their names."""


class ExperimentsWorker:
    """Imports every experiment, which the console itself does not."""

    def every(self, _: ListExperiments) -> list[ExperimentEntry]:
        return [entry(name) for name in sorted(EXPERIMENTS)]


def entry(name: str) -> ExperimentEntry:
    return msgspec.convert({**asdict(EXPERIMENTS[name].about), "name": name}, ExperimentEntry)


class Catalogue:
    """Asks once, in a worker that ends afterwards. Lives on the event loop."""

    def __init__(self) -> None:
        self._worker = Worker("experiments")
        self._reading: asyncio.Task[list[ExperimentEntry]] | None = None

    @property
    def known(self) -> list[ExperimentEntry] | None:
        """Every experiment; None while they are being read, which this begins. Raises WorkerLost, once."""
        reading = self._reading = self._reading or asyncio.get_running_loop().create_task(self._read())
        if not reading.done():
            return None
        if reading.exception() is not None:
            self._reading = None
        return reading.result()

    async def close(self) -> None:
        await end(self._reading)
        self._worker.kill()
        await self._worker.gone()

    async def _read(self) -> list[ExperimentEntry]:
        try:
            return await self._worker.ask(ListExperiments(), budget=BUDGET_S)
        finally:
            self._worker.kill()
