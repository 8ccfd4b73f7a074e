"""Looking for people as the pilot asks for it: questions go to a worker, the newest answer comes back."""

import asyncio
import logging
import time
from collections.abc import Callable

from console.part import Part
from console.people.look_worker import LookWorker
from console.workers.worker import Worker, WorkerLost
from core.errors import BeckonError
from core.perception.people.engines import says, sees_people
from core.perception.people.looking import LookAnswer, LookQuestion, PersonLook
from core.perception.people.parts import PeopleSettings
from core.pilot.pilot import Pilot
from core.sensors import SensorFrame
from core.snapshot import Snapshot

log = logging.getLogger(__name__)

OPENING_BUDGET_S, LOOKING_BUDGET_S = 10.0, 2.0  # of processor time
RETRY_S = 5.0  # after a failure until the next try
MAX_IDLE_S = 60.0  # without a voice or a question, after which the worker gives its memory back


class LookService(Part):
    """Lives on the event loop; `ask` and `answer` are called from the pilot's thread.

    The newest question replaces one that waits; nothing queues.
    """

    def __init__(self, settings: PeopleSettings, tell: Callable[[str], None]) -> None:
        """`tell`: takes a warning for the operator."""
        self._settings, self._tell = settings, tell
        self._worker = Worker("look")
        self._opened = 0  # the start of the worker in which the detector was opened
        self._question: LookQuestion | None = None
        self._answer: LookAnswer | None = None
        self._wake: asyncio.Event | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._complaint = ""
        self._needed = 0.0  # [s] when there was a question or a voice last
        self.seconds: float | None = None  # that the newest look took

    @property
    def for_pilot(self) -> PersonLook | None:
        """The service that the pilot asks; None: the embedded detector looks in the pilot's own step."""
        return self if sees_people(self._settings) else None

    @property
    def says(self) -> str:
        return says(self._settings)

    def ask(self, question: LookQuestion) -> None:
        """Take a question, from any thread."""
        self._question, self._needed = question, time.monotonic()
        loop, wake = self._loop, self._wake
        if loop is not None and wake is not None and not loop.is_closed():
            loop.call_soon_threadsafe(wake.set)

    def answer(self) -> LookAnswer | None:
        """Return the newest answer once, from any thread."""
        answer, self._answer = self._answer, None
        return answer

    async def run(self) -> None:
        self._loop, self._wake = asyncio.get_running_loop(), asyncio.Event()
        while True:
            await self._woken(self._wake)
            if self._question is None:
                await self._start()
                continue
            ready = await self._ready()
            question, self._question = self._question, None
            if ready:
                await self._look(question)

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        """Start the process when someone is heard who may call: that takes the longest part of a second.

        The networks, which take more memory than the process, are opened for the first picture, in an eighth of one.
        """
        if snapshot.hearing is None or not snapshot.hearing.voices or self.for_pilot is None:
            return
        self._needed = time.monotonic()
        if not self._worker.alive and self._wake is not None:
            self._wake.set()

    def equip(self, pilot: Pilot) -> None:
        pilot.find_people_with(self.for_pilot)

    async def close(self) -> None:
        self._worker.kill()

    async def _woken(self, wake: asyncio.Event) -> None:
        """Wait for a question or a voice; end the worker meanwhile when it has not been needed for long."""
        while not wake.is_set():
            try:
                async with asyncio.timeout(MAX_IDLE_S if self._worker.alive else None):
                    await wake.wait()
            except TimeoutError:
                if time.monotonic() - self._needed >= MAX_IDLE_S:
                    self._worker.kill()
        wake.clear()

    async def _start(self) -> None:
        try:
            await self._worker.ready()
        except WorkerLost as lost:
            log.warning("The worker that looks for people did not start: %s", lost)

    async def _ready(self) -> bool:
        if self._worker.alive and self._opened == self._worker.starts:
            return True
        try:
            await self._worker.ask(LookWorker.open(self._settings), budget=OPENING_BUDGET_S)
        except BeckonError as trouble:
            await self._complain(f"I cannot look for people: {trouble}")
            return False
        self._opened, self._complaint = self._worker.starts, ""
        return True

    async def _look(self, question: LookQuestion) -> None:
        try:
            seen = await self._worker.ask(LookWorker.look(question), budget=LOOKING_BUDGET_S)
        except WorkerLost as lost:
            log.warning("The worker that looks for people was lost: %s", lost)
            return
        except BeckonError as trouble:
            await self._complain(f"I cannot look for people: {trouble}")
            return
        self.seconds = seen.processing_s
        self._answer = LookAnswer(stamp=question.stamp, found=seen.people)

    async def _complain(self, words: str) -> None:
        if words != self._complaint:
            self._complaint = words
            self._tell(words)
        await asyncio.sleep(RETRY_S)
