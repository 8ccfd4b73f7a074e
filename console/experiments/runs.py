"""Runs of experiments: one at a time, watched, cancelled, and kept with their files."""

from __future__ import annotations

import asyncio
import logging
import re
import secrets
import shutil
import time
from pathlib import Path
from typing import Any, Literal

import msgspec

from console.access.logins import Person
from console.experiments.catalogue import Catalogue, ExperimentEntry
from console.experiments.process import ExperimentProcess
from console.http.problems import Problem
from console.workers.tasks import end, to_the_end
from core.errors import BeckonError, Unwritable
from core.experiments.about import figure_at
from core.experiments.result import as_text
from core.files import saving, write_atomic

log = logging.getLogger(__name__)

MOST_KEPT = 40  # runs
NAME = re.compile(r"[0-9a-f]{12}")
FILE = re.compile(r"[\w-]+\.(svg|png|csv|jsonl|json|html|txt|wav|xml)")
DRAWN = (".svg", ".png")
CANCELLED = "Cancelled before it was done."

ExperimentState = Literal["running", "done", "cancelled", "failed"]


class ComparedFigure(msgspec.Struct, frozen=True):
    """A figure of the chapter beside ours."""

    name: str
    unit: str
    chapter: float
    ours: float | None  # None: the result has none


class ResultFile(msgspec.Struct, frozen=True):
    """A file of a run."""

    name: str
    bytes: int
    figure: bool  # a picture to be shown


class ExperimentRunState(msgspec.Struct, frozen=True, kw_only=True):
    """A run as the page shows it."""

    id: str
    experiment: str
    title: str
    who: str
    at_s: float  # Unix time
    runs: int
    seed: int
    state: ExperimentState
    doing: str
    reason: str  # why it failed
    progress: float | None  # 0..1; None: it does not count
    took_s: float  # so far
    compared: list[ComparedFigure]
    text: str  # the result as the command line prints it
    files: list[ResultFile]


class ExperimentRun(msgspec.Struct, kw_only=True):
    """One run, as it is kept."""

    id: str
    entry: ExperimentEntry
    who: str
    at_s: float
    runs: int
    seed: int
    state: ExperimentState = "running"
    doing: str = "Starting…"
    reason: str = ""
    progress: float | None = None
    took_s: float = 0.0
    compared: list[ComparedFigure] = []
    text: str = ""
    files: list[ResultFile] = []

    @property
    def shown(self) -> ExperimentRunState:
        """Everything as it is now."""
        running = self.state == "running"
        return ExperimentRunState(
            id=self.id,
            experiment=self.entry.name,
            title=self.entry.title,
            who=self.who,
            at_s=self.at_s,
            runs=self.runs,
            seed=self.seed,
            state=self.state,
            doing=self.doing,
            reason=self.reason,
            progress=self.progress,
            took_s=time.time() - self.at_s if running else self.took_s,
            compared=self.compared,
            text=self.text,
            files=self.files,
        )


class ExperimentRuns:
    """Lives on the event loop. Processes are there only while an experiment runs."""

    def __init__(self, home: Path) -> None:
        self.runs: dict[str, ExperimentRun] = {}  # oldest first
        self.catalogue = Catalogue()
        self._folder = home / "experiments"
        self._task: asyncio.Task[None] | None = None
        self._turn = asyncio.Lock()  # one write after the other

    async def open(self) -> None:
        """Find the runs of before."""
        for run in await asyncio.to_thread(lambda: sorted(_kept(self._folder), key=lambda one: one.at_s)):
            self.runs[run.id] = run

    async def close(self) -> None:
        """End what runs."""
        await end(self._task)
        await self.catalogue.close()

    def find(self, number: str) -> ExperimentRun:
        """Raises Problem 404."""
        if number not in self.runs:
            raise Problem(404, "There is no such run; it may have been deleted.")
        return self.runs[number]

    def begin(self, name: str, runs: int | None, seed: int, who: Person) -> ExperimentRun:
        """Start a run.

        Raises Problem 404 for an experiment that does not exist, 409 while another one runs, 503 while they are read.
        """
        known = self.catalogue.known
        if known is None:
            raise Problem(503, "What experiments there are is still being read; try again in a few seconds.")
        entry = next((one for one in known if one.name == name), None)
        if entry is None:
            raise Problem(404, "There is no such experiment; GET /api/experiments lists them.")
        if self._task is not None and not self._task.done():
            raise Problem(409, "Another experiment runs; wait until it is done, or cancel it.")
        run = ExperimentRun(
            id=secrets.token_hex(6),
            entry=entry,
            who=who.name,
            at_s=time.time(),
            runs=runs or entry.runs,
            seed=seed,
        )
        self.runs[run.id] = run
        self._task = asyncio.get_running_loop().create_task(self._carry_out(run))
        return run

    async def cancel(self, run: ExperimentRun) -> None:
        """End it with all its processes, and wait until it is so; its files so far stay."""
        if run.state == "running":
            await end(self._task)

    async def delete(self, run: ExperimentRun) -> None:
        """For good, with its files. Raises Unwritable."""
        await self.cancel(run)
        self.runs.pop(run.id, None)
        async with self._turn:
            with saving("The run could not be deleted"):
                await to_the_end(lambda: _remove(self._folder / run.id))

    def file(self, run: ExperimentRun, name: str) -> Path:
        """The path of one of its files. Raises Problem 404."""
        if not any(one.name == name for one in run.files):
            raise Problem(404, "This run has no such file.")
        return self._files(run) / name

    def _files(self, run: ExperimentRun) -> Path:
        return self._folder / run.id / "files"

    async def _carry_out(self, run: ExperimentRun) -> None:
        state: ExperimentState = "cancelled"
        try:
            await self._work(run)
            state = "done"
        except BeckonError as refusal:
            state, run.reason = "failed", str(refusal)
        except (OSError, msgspec.MsgspecError):
            log.exception("An experiment could not be run")
            state, run.reason = "failed", "The experiment could not be run on this computer; the log says more."
        finally:
            try:
                run.files = await to_the_end(lambda: _files_in(self._files(run)))
            finally:  # a run that is over has its files
                run.took_s, run.state = time.time() - run.at_s, state
                run.doing = CANCELLED if state == "cancelled" else ""
            await self._keep(run)

    async def _work(self, run: ExperimentRun) -> None:
        def tell(said: str, progress: float | None) -> None:
            run.doing, run.progress = said, run.progress if progress is None else progress

        with saving("The experiment's folder could not be made"):
            await asyncio.to_thread(self._files(run).mkdir, mode=0o700, parents=True)
        process = ExperimentProcess(run.entry.name, run.runs, run.seed, self._files(run))
        raw = await process.run(tell)
        result = msgspec.json.decode(raw, type=dict[str, Any])
        run.compared = [
            ComparedFigure(one.name, one.unit, one.value, figure_at(result, one.ours)) for one in run.entry.chapter
        ]
        run.text = as_text({name: value for name, value in result.items() if name != "files"})
        run.progress = 1.0
        with saving("The result could not be saved"):
            await to_the_end(lambda: write_atomic(self._files(run) / "result.json", raw))

    async def _keep(self, run: ExperimentRun) -> None:
        """Write a run to disk, and forget the oldest ones; where the disk refuses, the run says so."""
        async with self._turn:
            if run.id not in self.runs:
                return
            older = list(self.runs)[: max(0, len(self.runs) - MOST_KEPT)]
            for oldest in older:
                del self.runs[oldest]

            def write() -> None:
                for oldest in older:
                    _remove(self._folder / oldest)
                write_atomic(self._folder / run.id / "run.json", msgspec.json.encode(run))

            try:
                with saving("This run could not be saved, and is gone when the console ends"):
                    await to_the_end(write)
            except Unwritable as trouble:
                log.warning(str(trouble))
                run.reason = run.reason or str(trouble)


def _remove(folder: Path) -> None:
    """A run's folder, with all in it."""
    if folder.is_dir():
        shutil.rmtree(folder)


def _files_in(folder: Path) -> list[ResultFile]:
    """List the files that an experiment wrote, figures first."""
    if not folder.is_dir():
        return []
    found = [one for one in folder.iterdir() if FILE.fullmatch(one.name) and one.is_file() and not one.is_symlink()]
    found.sort(key=lambda one: (one.suffix not in DRAWN, one.name))
    return [ResultFile(one.name, one.stat().st_size, one.suffix in DRAWN) for one in found]


def _kept(folder: Path) -> list[ExperimentRun]:
    found: list[ExperimentRun] = []
    for file in folder.glob("*/run.json"):
        try:
            run = msgspec.json.decode(file.read_bytes(), type=ExperimentRun)
        except (OSError, msgspec.MsgspecError):
            log.warning("The experiment's run %s cannot be read.", file.parent.name)
            continue
        if NAME.fullmatch(run.id) and file.parent.name == run.id and run.state != "running":
            found.append(run)
    return found
