"""Runs that measure the recognition of voices here, place by place."""

import asyncio
import contextlib
import logging
from collections.abc import Iterable
from dataclasses import fields
from pathlib import Path

import msgspec

from console.access.logins import Person
from console.messages import filled
from console.run_store import RunState, RunStore, StoredRun
from console.speech.quality_worker import QualityRow, QualitySetup, QualityWorker
from console.workers.worker import Worker, WorkerLost
from core.errors import Unavailable
from core.simulation.settings import MicrophoneSettings
from core.speech.settings import SpeechSettings

log = logging.getLogger(__name__)

MAX_KEPT_RUNS = 30
PLACE_BUDGET_S = 180.0  # of processor time
BUSY = "Hearing is being measured already; wait until that is done, or cancel it."


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


class QualityRun(StoredRun, kw_only=True):
    setup: QualitySetup = msgspec.field(name="wish")  # in files that exist
    voice: str = ""
    rows: list[QualityRow] = []
    pages: list[str] = []  # of each row; "" where nobody could speak

    @property
    def shown(self) -> QualityRunState:
        reports = [bool(page) for page in self.pages]
        own = {"progress": self.progress or 0.0, "rows": list(self.rows), "reports": reports}
        return filled(QualityRunState, self, summary=summary(self.rows), **own)


class QualityRuns(RunStore[QualityRun]):
    """The worker is there only while something runs."""

    def __init__(
        self, home: Path, microphones: MicrophoneSettings | None = None, speech: SpeechSettings | None = None
    ) -> None:
        super().__init__(home / "speech_quality", QualityRun, MAX_KEPT_RUNS, BUSY)
        self.microphones, self.speech = microphones or MicrophoneSettings(), speech or SpeechSettings()
        self._worker = Worker("quality")

    async def open(self) -> None:
        """Find the runs of before; earlier versions kept each in a file of its own."""
        await asyncio.to_thread(self._move_single_files)
        await super().open()

    def _move_single_files(self) -> None:
        for file in self._folder.glob("*.json"):
            with contextlib.suppress(OSError):
                (self._folder / file.stem).mkdir(mode=0o700, exist_ok=True)
                file.replace(self._folder / file.stem / "run.json")

    async def close(self) -> None:
        await super().close()
        await self._worker.gone()

    def begin(self, setup: QualitySetup, who: Person) -> QualityRun:
        """Start a run. Raises Problem 409 while another one is under way."""
        return self.start(QualityRun(who=who.name, setup=setup), self._work)

    async def _work(self, run: QualityRun) -> None:
        try:
            await self._measure(run)
        except WorkerLost as lost:
            log.warning("The worker that measures hearing was lost: %s", lost)
            raise Unavailable("The worker that measures broke; try again with fewer phrases.") from None
        finally:
            self._worker.kill()

    async def _measure(self, run: QualityRun) -> None:
        known = {one.name: getattr(self.microphones, one.name) for one in fields(MicrophoneSettings)}
        job = QualityWorker.begin(run.setup, MicrophoneSettings(**known), self.speech)
        answer = await self._worker.ask(job, budget=PLACE_BUDGET_S)
        run.voice, run.rows, run.pages = answer.voice, answer.places, [""] * len(answer.places)
        run.doing = "The text, close to the mouth…"
        await self._worker.ask(QualityWorker.listen_close(), budget=PLACE_BUDGET_S)
        for number, row in enumerate(run.rows):
            run.progress = (number + 1) / (len(run.rows) + 1)
            run.doing = f"{row.distance_m:g} m away, {row.snr_db:g} dB over the noise…"
            if not row.refused:
                measured = await self._worker.ask(QualityWorker.measure(number), budget=PLACE_BUDGET_S)
                run.rows[number], run.pages[number] = measured.row, measured.page
                await self.keep(run)
        run.progress = 1.0


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
    return sum(count for count in counts if count is not msgspec.UNSET)
