"""The worker that reads words out of sound: decoding would hold up everything else in the console's own process."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from console.speech.transcription_jobs import BeginListening, FinishListening, HearSound, ReadSoFar, ReadUtterance
from core.heap import Rests, give_back
from core.navigation.places import NamedPlace
from core.sensors.microphones import Sound
from core.sentences import code_of
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.recognition.engines import ActiveEngine, chosen, open_engine, open_keyword_spotter
from core.speech.recognition.recognizer import KeywordSpotter, LearnsPhrases, at_16_khz
from core.speech.settings import SpeechSettings
from core.speech.transcription.array_transcriber import ArrayTranscriber
from core.speech.transcription.transcriber import RejectedCommands, Transcriber
from core.speech.understanding.own_phrases import own_phrases
from core.speech.understanding.place_names import place_phrases

NAMES_NEED_WHISPER = "The names of places are not heard: they need Whisper."


class TranscriptionWorker:
    """Remembers the sound so far: pieces come in the order in which they were heard."""

    def __init__(self) -> None:
        self._transcriber: Transcriber | ArrayTranscriber | None = None
        self._engine: tuple[SpeechSettings, ActiveEngine] | None = None
        self._spotter: KeywordSpotter | None = None  # of that engine, one for all who listen in turn: it takes 16 MB
        self._places: tuple[NamedPlace, ...] = ()  # that the recognizer hears by their names
        self._speaker = 0
        self._rejected = RejectedCommands()  # of this speaker's, by whichever transcriber heard it

    def begin(self, job: BeginListening) -> str:
        if job.speaker != self._speaker:
            self._speaker, self._rejected = job.speaker, RejectedCommands()
        known = self._engine  # a model may have been fetched since
        if known is None or known[0] != job.settings or known[1].spec is not chosen(job.settings):
            opened = open_engine(job.settings)
            self._spotter = open_keyword_spotter(job.settings, opened.recognizer)
            self._engine = known = job.settings, opened
            self._places = ()
            give_back()
        engine = known[1]
        self._learn(job.places)
        if job.array is None:
            self._transcriber = Transcriber(
                job.settings,
                held=job.held,
                recognizer=engine.recognizer,
                spotter=self._spotter,
                rejected=self._rejected,
            )
        else:
            channels = tuple(range(len(job.array.positions)))
            in_order = replace(job.array, channels=channels, rate=None)
            self._transcriber = ArrayTranscriber(
                in_order, job.settings, recognizer=engine.recognizer, spotter=self._spotter, rejected=self._rejected
            )
        unheard = job.places and not isinstance(engine.recognizer, LearnsPhrases)
        return f"{engine.why} {NAMES_NEED_WHISPER}" if unheard else engine.why

    def _learn(self, places: tuple[NamedPlace, ...]) -> None:
        """Hear these places by their names, where the engine can."""
        if self._engine is None or places == self._places:
            return
        settings, engine = self._engine
        if isinstance(engine.recognizer, LearnsPhrases):
            engine.recognizer.learn((*own_phrases(settings.phrases), *place_phrases(places)))
        self._places = places

    def hear(self, job: HearSound) -> list[ReadUtterance]:
        assert self._transcriber is not None
        if job.places is not None:
            self._learn(job.places)
        numbers = np.frombuffer(job.samples, np.float32).astype(float).reshape(-1, job.channels)
        sound = at_16_khz(Sound(stamp=job.stamp, rate=job.rate, samples=numbers))
        for words, ago in job.rejected:
            self._rejected.reject(words, job.stamp + sound.duration - ago)
        return _packed(self._transcriber.feed(sound))

    def read_so_far(self, _: ReadSoFar) -> str:
        assert self._transcriber is not None
        return self._transcriber.words_so_far()

    def rest(self) -> None:
        """Nobody has spoken for a while: give back the engine's numbers."""
        if self._engine is not None and isinstance(self._engine[1].recognizer, Rests):
            self._engine[1].recognizer.rest()

    def finish(self, _: FinishListening) -> list[ReadUtterance]:
        assert self._transcriber is not None
        return _packed(self._transcriber.finish())


def _packed(utterances: Iterable[RecognizedUtterance]) -> list[ReadUtterance]:
    return [ReadUtterance(one, code_of(one.decision.reason)) for one in utterances]
