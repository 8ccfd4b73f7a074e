"""Microphones of browsers: one at a time speaks to the robot, and a worker reads its words.

Lives on the event loop. Sound waits for the worker within bounds; older sound is not heard, and the page shows that.
"""

import asyncio
import logging
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from console.messages.audio import AUDIO_RATE_HZ, ListenMode
from console.part import Part
from console.speech.transcription_client import TranscriptionClient
from console.workers.tasks import HeldTasks, end
from console.workers.worker import WorkerLost
from core.errors import BeckonError, Refused
from core.message import Array
from core.navigation.places import NamedPlace
from core.sentences import Statement
from core.speech.recognition.decision import RecognizedUtterance, said_back
from core.speech.settings import SpeechSettings
from core.speech.understanding.grammar import OwnPhrases
from core.speech.understanding.place_names import place_phrases

log = logging.getLogger(__name__)

MICROPHONE_PIECE_S = 0.1  # of sound that go to the worker at once
MAX_WAITING_S = 15.0  # of sound that may wait for it: it may just be starting
MAX_CLOCK_JUMP_S = 0.1  # by which the browser's clock may be off before the sound counts as interrupted
MAX_IDLE_S = 120.0  # after which a worker that nobody needs is ended
TAKEN = Statement("speech.operator_speaks")
BUSY = Statement("speech.someone_speaks")


class TalkTurn:
    """One person's turn to speak, from the press to the words."""

    def __init__(
        self,
        mode: ListenMode,
        hear: Callable[[RecognizedUtterance, float], None],
        say: Callable[[str, bool], None],
        page: int = 0,
        rank: Callable[[], int] = lambda: 0,
        show: Callable[[str], None] = lambda _: None,
        read: Callable[[], None] = lambda: None,
    ) -> None:
        """`hear`: words, and how long after their sound they came [s]; `say`: a sentence, and whether it goes on;
        `page`: one number for all turns at the same browser's page; `rank`: now, the higher takes the microphone
        from the lower; `show`: the words so far, while the button is held; `read`: all of it was read.
        """
        self.mode: ListenMode = mode
        self.page = page
        self.rank = rank
        self.hear, self.say, self.show, self.read = hear, say, show, read
        self.over = False  # nothing more will be said
        self.news = asyncio.Event()
        self._waiting: list[Array] = []
        self._samples = 0  # that wait
        self._start: float | None = None  # [s] of the first that waits, by the browser's clock
        self._on_its_way = 0.0  # [s] that the first of it may have been, at most
        self._lead = -np.inf  # [s] by which the browser's clock is ahead of ours, as far as its sound shows

    def sent(self, oldest: float, now: float) -> None:
        """The page began this turn not before `oldest` [s] of our clock; the sound that comes first is from then."""
        self._on_its_way = max(0.0, now - oldest)

    def add(self, samples: Array, stamp: float) -> None:
        """Sound (N,) of full scale ±1, first at `stamp` [s] of the browser's clock."""
        if self.over:
            return
        end = stamp + len(samples) / AUDIO_RATE_HZ
        self._lead = max(self._lead, end - time.monotonic() + self._on_its_way)
        self._on_its_way = 0.0
        expected = None if self._start is None else self._start + self._samples / AUDIO_RATE_HZ
        if expected is None or abs(stamp - expected) > MAX_CLOCK_JUMP_S or self.waiting > MAX_WAITING_S:
            if self.waiting > MAX_WAITING_S:
                self.say(Statement("speech.too_slow"), True)
            self._waiting, self._samples, self._start = [], 0, stamp
        self._waiting.append(samples)
        self._samples += len(samples)
        if self.waiting >= MICROPHONE_PIECE_S:
            self.news.set()

    @property
    def waiting(self) -> float:
        """Sound [s] that waits for the worker."""
        return self._samples / AUDIO_RATE_HZ

    def rest(self) -> None:
        """The button was let go."""
        self.over = True
        self.news.set()

    def give_way(self) -> None:
        """A person of a higher rank speaks: waiting sound is not heard."""
        self.say(TAKEN, False)
        self._waiting, self._samples = [], 0
        self.rest()

    def take(self) -> tuple[Array, float]:
        """All that waits: samples (N,), and the stamp [s] of the first."""
        samples = np.concatenate(self._waiting) if self._waiting else np.zeros(0)
        start = self._start or 0.0
        self._waiting, self._samples, self._start = [], 0, start + len(samples) / AUDIO_RATE_HZ
        self.news.clear()
        return samples, start

    def delay_since(self, end: float) -> float:
        """How long ago [s] sound that ended at `end` [s] of the browser's clock arrived."""
        return max(0.0, time.monotonic() - (end - self._lead))


class BrowserMicrophone(Part):
    def __init__(self, settings: SpeechSettings | None = None) -> None:
        self.settings = settings or SpeechSettings()
        self._worker = TranscriptionClient()
        self._names: OwnPhrases = ()
        self._turn: TalkTurn | None = None
        self._page = 0  # of the newest turn
        self._task: asyncio.Task[None] | None = None  # that reads the newest turn
        self._reading = HeldTasks()  # and those left from earlier turns
        self._warming: asyncio.Task[None] | None = None
        self._used = 0.0  # [s]

    def warm(self) -> None:
        """A person is about to speak: the worker may be started."""
        self._used = time.monotonic()
        if self._warming is None and not self._worker.alive:
            self._warming = asyncio.get_running_loop().create_task(self._warm())

    def begin(self, turn: TalkTurn) -> None:
        """Listen to this one from now on, until it rests. Raises Refused while one of no lower rank speaks."""
        former = self._turn
        read_still = former is not None and former.over and former.page == turn.page  # the next sentence waits for it
        if former is not None and former is not turn and not read_still:
            if former.rank() >= turn.rank():
                raise Refused(BUSY)
            former.give_way()
        self._turn, self._page = turn, turn.page
        self._task = self._reading.start(self._read(turn, self._task))

    def reject(self, words: str, page: int) -> None:
        """A command that was spoken at this page waited and was rejected."""
        if page == self._page:
            self._worker.reject(words)

    def learn(self, places: tuple[NamedPlace, ...]) -> None:
        self._names = place_phrases(places)
        self._worker.learn(places)

    def tick(self, now: float) -> None:
        """Now and then: a worker that nobody needs is ended."""
        if self._turn is None and self._worker.alive and now - self._used > MAX_IDLE_S:
            self._worker.kill()

    async def close(self) -> None:
        await self._reading.end()
        await end(self._warming)
        self._worker.kill()
        await self._worker.gone()

    async def _warm(self) -> None:
        try:
            await self._worker.begin(self.settings)
        except BeckonError as trouble:
            log.warning("Words cannot be read: %s", trouble)
        finally:
            self._warming = None

    async def _read(self, turn: TalkTurn, former: asyncio.Task[None] | None) -> None:
        """One turn, from its begin to its last word; the former one, if it had to give way, ends first."""
        try:
            if former is not None:
                await asyncio.wait({former})
            if self._warming is not None:
                await asyncio.gather(self._warming, return_exceptions=True)
            await self._worker.begin(self.settings, held=turn.mode == "held", speaker=turn.page)
            while True:
                await turn.news.wait()
                over = turn.over
                samples, start = turn.take()
                if len(samples):
                    self._tell(turn, await self._worker.feed(samples, AUDIO_RATE_HZ, start))
                if over:
                    self._tell(turn, await self._worker.finish())
                    return
                await self._read_so_far(turn)
        except WorkerLost as lost:
            log.warning("The worker that reads words was lost: %s", lost)
            turn.say(Statement("speech.broke"), False)
        except BeckonError as trouble:
            turn.say(str(trouble), False)
        finally:
            self._used = time.monotonic()
            turn.read()
            if self._turn is turn:
                self._turn = None

    async def _read_so_far(self, turn: TalkTurn) -> None:
        if turn.mode != "held" or turn.over or turn.waiting > MICROPHONE_PIECE_S:
            return
        words = await self._worker.words_so_far()
        if words and not turn.over:
            turn.show(words)

    def _tell(self, turn: TalkTurn, heard: list[RecognizedUtterance]) -> None:
        """Words with the button held were surely meant for the robot: those that are no command are said back."""
        for one in heard:
            utterance = replace(one, decision=said_back(one.decision, self._names)) if turn.mode == "held" else one
            turn.hear(utterance, turn.delay_since(one.end))
