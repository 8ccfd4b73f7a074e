"""The worker that reads words out of sound, as those who listen ask it. Its answers are not trusted."""

import time
from collections import deque
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from console.speech.transcription_worker import ReadUtterance, TranscriptionWorker
from console.workers.worker import Worker
from core.commands.routes import START_ROUTE
from core.commands.stop_at import command_to
from core.message import Array
from core.navigation.places import NamedPlace
from core.sensors.microphones import MicrophoneArray
from core.sentences import coded
from core.speech.recognition.decision import Decision, RecognizedUtterance
from core.speech.settings import SpeechSettings
from core.speech.understanding.grammar import Refusal, command_of

BUDGET_S = 20.0  # of processor time for a piece of sound
MAX_SENTENCE_CHARACTERS = 300  # characters of a sentence under way
PARTIAL_PERIOD_S = 0.4  # [s] between two readings of a sentence under way, at least
PARTIAL_REST = 2.0  # times as long as such a reading took, the next one waits
MAX_REJECTED = 8  # commands rejected while nobody listens: of more than these only the newest count


class TranscriptionClient(Worker):
    """The worker of one listener. Lives on the event loop; raises WorkerLost and the errors of the process."""

    def __init__(self) -> None:
        super().__init__("words")
        self.engine = ""  # a sentence: which engine reads the words, and why; "": none has begun
        self._rejected: deque[tuple[str, float]] = deque(maxlen=MAX_REJECTED)  # sent with the next sound
        self._speaker = 0
        self._begun = 0  # the process's start that knows how to listen
        self._partial_from = 0.0  # [s] from when on a sentence under way is read again
        self._places: tuple[NamedPlace, ...] = ()
        self._places_sent = True  # to the process

    @property
    def listens(self) -> bool:
        """True if the words of the next sound are read without starting a process first."""
        return self.alive and self.starts == self._begun

    def learn(self, places: tuple[NamedPlace, ...]) -> None:
        self._places, self._places_sent = places, False

    async def begun(self) -> bool:
        """Start the process where there is none; return whether it knows how to listen."""
        await self.ready()
        return self.starts == self._begun

    async def begin(
        self, settings: SpeechSettings, *, held: bool = False, array: MicrophoneArray | None = None, speaker: int = 0
    ) -> None:
        """Listen again; `held`: everything up to `finish` is one utterance; `array`: to the beam towards the voice.

        Another `speaker` has another clock, and what was rejected before was not theirs.
        """
        if speaker != self._speaker:
            self._rejected.clear()
        self._speaker, self._partial_from = speaker, 0.0
        job = TranscriptionWorker.begin(settings, held, array, speaker, self._places)
        self._places_sent = True
        self.engine = await self.ask(job, budget=BUDGET_S)
        self._begun = self.starts

    async def feed(self, samples: Array, rate: int, stamp: float) -> list[RecognizedUtterance]:
        """Samples (N,) of full scale ±1, or (N, M) of the array's microphones in their order, first at `stamp` [s] →
        what became known with them.
        """
        raw = np.ascontiguousarray(samples, np.float32).tobytes()
        now = time.monotonic()
        rejected = tuple((words, now - then) for words, then in self._rejected)
        self._rejected.clear()
        channels = samples[0].size if len(samples) else 1
        job = TranscriptionWorker.hear(
            raw, rate, stamp, channels, rejected, None if self._places_sent else self._places
        )
        self._places_sent = True
        return received(await self.ask(job, budget=BUDGET_S), self._places)

    def reject(self, words: str) -> None:
        """These words, as a command, were rejected: said again, they most likely are others."""
        self._rejected.append((words, time.monotonic()))

    async def words_so_far(self) -> str:
        """The words of the sentence under way, as far as it goes; "" where none are known, or too soon after the last
        ones: the end of the sentence must not wait for them.
        """
        begun = time.monotonic()
        if begun < self._partial_from:
            return ""
        words = (await self.ask(TranscriptionWorker.read_so_far(), budget=BUDGET_S))[:MAX_SENTENCE_CHARACTERS]
        now = time.monotonic()
        self._partial_from = now + max(PARTIAL_PERIOD_S, PARTIAL_REST * (now - begun))
        return words

    async def finish(self) -> list[RecognizedUtterance]:
        """End the sound → the utterances that became known with that."""
        return received(await self.ask(TranscriptionWorker.finish(), budget=BUDGET_S), self._places)


def received(heard: Iterable[ReadUtterance], places: Iterable[NamedPlace] = ()) -> list[RecognizedUtterance]:
    """A worker's utterances as the console takes them: none asks for more than speech may, or for a place that is
    none of these.
    """
    utterances: list[RecognizedUtterance] = []
    for one in heard:
        decision = one.utterance.decision
        decision = within_bounds(replace(decision, reason=coded(decision.reason, one.reason)), places)
        utterances.append(replace(one.utterance, decision=decision))
    return utterances


def within_bounds(decision: Decision, places: Iterable[NamedPlace] = ()) -> Decision:
    """The decision with its command built again within the bounds of speech, or the rejection of that command."""
    given = decision.command
    if given is None or decision.verdict == "reject":
        return replace(decision, verdict="reject", command=None)
    if given.place:
        of_route = given.name == START_ROUTE.name
        place = next((one for one in places if one.name == given.place and one.route == of_route), None)
        command = Refusal("There is no place of that name any more.") if place is None else command_to(place)
    else:
        command = command_of(given.name, given.numbers, spoken=True)
    if isinstance(command, Refusal):
        return Decision(
            verdict="reject", words=decision.words, reason=command.reason, suggestions=command.suggestions
        )
    return replace(decision, command=replace(command, remark=given.remark))
