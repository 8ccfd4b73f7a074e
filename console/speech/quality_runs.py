"""Runs that measure the recognition of voices here: one at a time, watched, given up, and kept."""

from __future__ import annotations

import asyncio
import logging
import re
import secrets
import time
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path
from typing import Literal

import msgspec

from console.access.logins import Person
from console.http.problems import Problem
from console.speech.quality_jobs import BeginQuality, ListenClose, MeasureQuality, QualityRow, QualitySetup
from console.workers.tasks import end, to_the_end
from console.workers.worker import Worker, WorkerLost
from core.errors import BeckonError, Unwritable
from core.files import saving, write_atomic
from core.simulation.settings import MicrophoneSettings
from core.speech.settings import SpeechSettings

log = logging.getLogger(__name__)

MOST_KEPT = 30  # runs
BUDGET = 180.0  # [s] of processor time for one place
NAME = re.compile(r"[0-9a-f]{12}")
GIVEN_UP = "Given up before it was done."

RunState = Literal["running", "done", "cancelled", "failed"]


class QualityRunState(msgspec.Struct, frozen=True, kw_only=True):
    """A run as the page shows it."""

    id: str
    who: str
    at_s: float  # Unix time
    setup: QualitySetup
    state: RunState
    doing: str
    reason: str
    progress: float  # 0..1
    voice: str
    rows: list[QualityRow]
    reports: list[bool]  # whether a row has a page
    summary: str


class QualityRun(msgspec.Struct):
    """One run, as it is kept."""

    id: str
    who: str
    at_s: float  # Unix time
    setup: QualitySetup = msgspec.field(name="wish")  # in files that exist
    state: RunState = "running"
    doing: str = "Making ready…"
    reason: str = ""  # why it failed
    progress: float = 0.0  # 0..1
    voice: str = ""
    rows: list[QualityRow] = []
    pages: list[str] = []  # of each row; "" where nobody could speak

    @property
    def shown(self) -> QualityRunState:
        """Everything but the pages."""
        return QualityRunState(
            id=self.id,
            who=self.who,
            at_s=self.at_s,
            setup=self.setup,
            state=self.state,
            doing=self.doing,
            reason=self.reason,
            progress=self.progress,
            voice=self.voice,
            rows=list(self.rows),
            reports=[bool(page) for page in self.pages],
            summary=summary(self.rows),
        )


class QualityRuns:
    """Lives on the event loop. The worker is there only while something runs."""

    def __init__(
        self, home: Path, ears: MicrophoneSettings | None = None, speech: SpeechSettings | None = None
    ) -> None:
        self.ears, self.speech = ears or MicrophoneSettings(), speech or SpeechSettings()
        self.runs: dict[str, QualityRun] = {}  # oldest first
        self._folder = home / "speech_quality"
        self._worker = Worker("quality")
        self._task: asyncio.Task[None] | None = None
        self._turn = asyncio.Lock()  # one write after the other

    async def open(self) -> None:
        """Find the runs of before."""
        for run in await asyncio.to_thread(lambda: sorted(_kept(self._folder), key=lambda one: one.at_s)):
            self.runs[run.id] = run

    async def close(self) -> None:
        """End what runs."""
        await end(self._task)
        self._worker.kill()
        await self._worker.gone()

    def find(self, number: str) -> QualityRun:
        """Raises Problem 404."""
        if number not in self.runs:
            raise Problem(404, "There is no such run; it may have been deleted.")
        return self.runs[number]

    def begin(self, setup: QualitySetup, who: Person) -> QualityRun:
        """Start a run. Raises Problem 409 while another one is under way."""
        if self._task is not None and not self._task.done():
            raise Problem(409, "Hearing is being measured already; wait until that is done, or cancel it.")
        run = QualityRun(secrets.token_hex(6), who.name, time.time(), setup)
        self.runs[run.id] = run
        self._task = asyncio.get_running_loop().create_task(self._measure(run))
        return run

    def give_up(self) -> None:
        """End the run, soon; the results so far stay."""
        if self._task is not None and not self._task.done():
            self._task.cancel()

    async def cancel(self, run: QualityRun) -> None:
        """The same of one run, and wait until it is so."""
        if run.state == "running":
            await end(self._task)

    async def delete(self, run: QualityRun) -> None:
        """For good. Raises Unwritable."""
        await self.cancel(run)
        self.runs.pop(run.id, None)
        async with self._turn:
            with saving("The measurement could not be deleted"):
                await to_the_end(lambda: (self._folder / f"{run.id}.json").unlink(missing_ok=True))

    async def _measure(self, run: QualityRun) -> None:
        state: RunState = "cancelled"
        try:
            await self._steps(run)
            state = "done"
        except WorkerLost as lost:
            log.warning("The worker that measures hearing was lost: %s", lost)
            state, run.reason = "failed", "The worker that measures broke; try again with fewer phrases."
        except BeckonError as refusal:
            state, run.reason = "failed", str(refusal)
        finally:
            run.state, run.doing = state, GIVEN_UP if state == "cancelled" else ""
            self._worker.kill()
            await self._keep(run)

    async def _steps(self, run: QualityRun) -> None:
        ears = MicrophoneSettings(**{one.name: getattr(self.ears, one.name) for one in fields(MicrophoneSettings)})
        job = BeginQuality(run.setup, ears, self.speech)
        answer = await self._worker.ask(job, budget=BUDGET)
        run.voice = answer.voice
        run.rows = answer.places
        run.pages = [""] * len(run.rows)
        steps = len(run.rows) + 1
        run.doing = "The text, close to the mouth…"
        await self._worker.ask(ListenClose(), budget=BUDGET)
        for number, row in enumerate(run.rows):
            run.progress = (number + 1) / steps
            run.doing = f"{row.distance_m:g} m away, {row.snr_db:g} dB over the noise…"
            if not row.refused:
                measured = await self._worker.ask(MeasureQuality(number), budget=BUDGET)
                run.rows[number], run.pages[number] = measured.row, measured.page
                await self._keep(run)
        run.progress = 1.0

    async def _keep(self, run: QualityRun) -> None:
        """Write the results so far to disk, and forget the oldest runs; where the disk refuses, the run says so."""
        async with self._turn:
            if run.id not in self.runs:
                return
            raw = msgspec.json.encode(run)
            older = list(self.runs)[: max(0, len(self.runs) - MOST_KEPT)]
            for oldest in older:
                del self.runs[oldest]

            def write() -> None:
                for oldest in older:
                    (self._folder / f"{oldest}.json").unlink(missing_ok=True)
                write_atomic(self._folder / f"{run.id}.json", raw)

            try:
                with saving("This measurement could not be saved, and is gone when the console ends"):
                    await to_the_end(write)
            except Unwritable as trouble:
                log.warning(str(trouble))
                run.reason = run.reason or str(trouble)


def summary(rows: list[QualityRow]) -> str:
    """The score in a line: the recognition at each end of the measured range; "" before anything was measured."""
    commands = total(row.commands for row in rows)
    if not commands:
        return ""
    exact = total(row.commands_exact for row in rows)
    worse = total(row.erroneous_words_robot for row in rows) - total(row.erroneous_words_person for row in rows)
    words = total(row.words for row in rows)
    return f"{round(100 * exact / commands)} % of commands whole; OSQE_D {-worse:+d} over {words} words".replace(
        "+0", "0"
    ).replace("-", "−")


def total(counts: Iterable[int | msgspec.UnsetType]) -> int:
    """The sum of what was counted."""
    return sum(count for count in counts if count is not msgspec.UNSET)


def _kept(folder: Path) -> list[QualityRun]:
    found: list[QualityRun] = []
    for file in folder.glob("*.json"):
        try:
            run = msgspec.json.decode(file.read_bytes(), type=QualityRun)
        except (OSError, msgspec.MsgspecError):
            log.warning("The measurement %s cannot be read.", file.name)
            continue
        if NAME.fullmatch(run.id) and file.stem == run.id:
            if run.state == "running":
                run.state, run.doing = "cancelled", GIVEN_UP
            found.append(run)
    return found
