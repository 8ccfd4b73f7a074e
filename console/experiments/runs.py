"""The experiments: their catalogue, and runs by the command line in processes of its own, with their files."""

import asyncio
import contextlib
import os
import re
import signal
import sys
from asyncio.subprocess import PIPE
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import msgspec

from console.access.logins import Person
from console.http.problems import Problem
from console.run_store import RunState, RunStore, StoredRun
from console.workers.child_process import ROOT
from console.workers.job import job
from console.workers.tasks import end, to_the_end
from console.workers.worker import Worker
from core.errors import Unavailable
from core.experiments import EXPERIMENTS
from core.experiments.plan import ChapterValue, figure_at
from core.experiments.result import as_text
from core.files import saving, write_atomic
from core.library_threads import ONE_THREAD

# The catalogue: each experiment as its own file declares it.

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


class ExperimentsWorker:
    """Imports every experiment, which the console itself does not."""

    @job
    def every(self) -> list[ExperimentEntry]:
        """Every experiment, in the order of their names."""
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
            return await self._worker.ask(ExperimentsWorker.every(), budget=BUDGET_S)
        finally:
            self._worker.kill()


# One experiment in processes of its own: the command line itself, so that the files are the same.

MAX_RESULT_BYTES = 2**24  # of JSON
MAX_LINE_BYTES = 2**16  # [bytes] of a line that it says
COUNTED = re.compile(r"(\d+) of (\d+)")
BROKE = "The experiment broke off; the log says more."


class ExperimentProcess:
    """`beckon experiment` with its progress, from its start until it has ended or was killed."""

    def __init__(self, name: str, runs: int, seed: int, out: Path) -> None:
        self._arguments = ["experiment", name, "--runs", str(runs), "--seed", str(seed), "--out", str(out), "--json"]
        self._child: asyncio.subprocess.Process | None = None
        self.said: list[str] = []  # the newest lines

    async def run(self, tell: Callable[[str, float | None], None]) -> bytes:
        """Run it → its result as JSON; `tell` gets what it says, and 0..1 when that counts something.

        Killed when cancelled. Raises Unavailable with its sentence when it fails.
        """
        path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
        self._child = await asyncio.create_subprocess_exec(
            *(sys.executable, "-P", "-m", "console.workers.leashed", "console", *self._arguments),
            stdin=PIPE,
            stdout=PIPE,
            stderr=PIPE,
            env={**os.environ, **ONE_THREAD, "PYTHONPATH": path},
            start_new_session=True,
            limit=MAX_LINE_BYTES,
        )
        try:
            result, _ = await asyncio.gather(self._result(), self._listen(tell))
            code = await self._child.wait()
        finally:
            await self._kill()
        if code != 0:
            raise Unavailable(self.said[-1] if code == 1 and self.said else BROKE)
        return result

    async def _result(self) -> bytes:
        assert self._child is not None and self._child.stdout is not None
        parts = bytearray()
        while part := await self._child.stdout.read(2**18):
            parts += part
            if len(parts) > MAX_RESULT_BYTES:
                raise Unavailable("The experiment's result is too large to be kept.")
        return bytes(parts)

    async def _listen(self, tell: Callable[[str, float | None], None]) -> None:
        assert self._child is not None and self._child.stderr is not None
        while True:
            try:
                raw = await self._child.stderr.readline()
            except ValueError:
                continue  # a line without an end
            if not raw:
                return
            line = raw.decode(errors="replace").strip()[:300]
            if line:
                self.said = [*self.said[-20:], line]
                tell(line, counted(line))

    async def _kill(self) -> None:
        child = self._child
        if child is None:
            return
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)
        if child.stdin is not None:
            child.stdin.close()
        await asyncio.shield(child.wait())


def counted(line: str) -> float | None:
    """'12 of 40 runs…' → 0.3; None where nothing is counted."""
    found = COUNTED.search(line)
    if found is None or int(found[2]) == 0:
        return None
    return min(1.0, int(found[1]) / int(found[2]))


MAX_KEPT_RUNS = 40
FILE = re.compile(r"[\w-]+\.(svg|png|csv|jsonl|json|html|txt|wav|xml)")
DRAWN = (".svg", ".png")
BUSY = "Another experiment runs; wait until it is done, or cancel it."


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
    state: RunState
    doing: str
    reason: str  # why it failed
    progress: float | None  # 0..1; None: it does not count
    took_s: float  # so far
    compared: list[ComparedFigure]
    text: str  # the result as the command line prints it
    files: list[ResultFile]


class ExperimentRun(StoredRun, kw_only=True):
    entry: ExperimentEntry
    runs: int
    seed: int
    compared: list[ComparedFigure] = []
    text: str = ""
    files: list[ResultFile] = []

    @property
    def shown(self) -> ExperimentRunState:
        of = {"experiment": self.entry.name, "title": self.entry.title, "took_s": self.elapsed_s}
        return msgspec.convert({**msgspec.structs.asdict(self), **of}, ExperimentRunState)


class ExperimentRuns(RunStore[ExperimentRun]):
    """Processes are there only while an experiment runs."""

    def __init__(self, home: Path) -> None:
        super().__init__(home / "experiments", ExperimentRun, MAX_KEPT_RUNS, BUSY)
        self.catalogue = Catalogue()

    async def close(self) -> None:
        await super().close()
        await self.catalogue.close()

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
        return self.start(ExperimentRun(entry=entry, who=who.name, runs=runs or entry.runs, seed=seed), self._work)

    def file(self, run: ExperimentRun, name: str) -> Path:
        """The path of one of its files. Raises Problem 404."""
        if not any(one.name == name for one in run.files):
            raise Problem(404, "This run has no such file.")
        return self.files_folder(run) / name

    async def _work(self, run: ExperimentRun) -> None:
        def tell(said: str, progress: float | None) -> None:
            run.doing, run.progress = said, run.progress if progress is None else progress

        folder = self.files_folder(run)
        with saving("The experiment's folder could not be made"):
            await asyncio.to_thread(folder.mkdir, mode=0o700, parents=True)
        try:
            raw = await ExperimentProcess(run.entry.name, run.runs, run.seed, folder).run(tell)
            result = msgspec.json.decode(raw, type=dict[str, Any])
            run.compared = [
                ComparedFigure(one.name, one.unit, one.value, figure_at(result, one.ours))
                for one in run.entry.chapter
            ]
            run.text = as_text({name: value for name, value in result.items() if name != "files"})
            run.progress = 1.0
            with saving("The result could not be saved"):
                await to_the_end(lambda: write_atomic(folder / "result.json", raw))
        finally:  # a run that is over has its files
            run.files = await to_the_end(lambda: _files_in(folder))


def _files_in(folder: Path) -> list[ResultFile]:
    if not folder.is_dir():
        return []
    found = [one for one in folder.iterdir() if FILE.fullmatch(one.name) and one.is_file() and not one.is_symlink()]
    found.sort(key=lambda one: (one.suffix not in DRAWN, one.name))
    return [ResultFile(one.name, one.stat().st_size, one.suffix in DRAWN) for one in found]
