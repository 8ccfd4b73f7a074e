"""The worker that reads words out of sound: decoding would hold up everything else in the console's own process."""

from collections.abc import Iterable
from dataclasses import replace

import msgspec
import numpy as np

from console.workers.job import job
from core.heap import Rests, give_back
from core.navigation.places import NamedPlace
from core.sensors.microphones import MicrophoneArray, Sound
from core.sentences import SentenceCode, code_of
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.recognition.engines import ActiveEngine, chosen, open_engine, open_keyword_spotter
from core.speech.recognition.recognizer import KeywordSpotter, LearnsPhrases, at_16_khz
from core.speech.settings import SpeechSettings
from core.speech.transcription.array_transcriber import ArrayTranscriber
from core.speech.transcription.transcriber import RejectedCommands, Transcriber
from core.speech.understanding.own_phrases import own_phrases
from core.speech.understanding.place_names import place_phrases

NAMES_NEED_WHISPER = "The names of places are not heard: they need Whisper."


class ReadUtterance(msgspec.Struct, frozen=True):
    """An utterance on its way, with the code of why it is rejected."""

    utterance: RecognizedUtterance
    reason: SentenceCode


class TranscriptionWorker:
    """Remembers the sound so far: pieces come in the order in which they were heard."""

    def __init__(self) -> None:
        self._transcriber: Transcriber | ArrayTranscriber | None = None
        self._engine: tuple[SpeechSettings, ActiveEngine] | None = None
        self._spotter: KeywordSpotter | None = None  # of that engine, one for all who listen in turn: it takes 16 MB
        self._places: tuple[NamedPlace, ...] = ()  # that the recognizer hears by their names
        self._speaker = 0
        self._rejected = RejectedCommands()  # of this speaker's, by whichever transcriber heard it

    @job
    def begin(
        self,
        settings: SpeechSettings,
        held: bool = False,
        array: MicrophoneArray | None = None,
        speaker: int = 0,
        places: tuple[NamedPlace, ...] = (),
    ) -> str:
        """Listen again with the engine that the settings name → which engine reads the words, and why, in a sentence.

        `held`: everything up to `finish` is one utterance. With an array the sound has a channel for each of its
        microphones, and the beam towards the voice is read; it listens all the time, so `held` says nothing there.
        What was rejected is forgotten when another `speaker` begins. `places` are heard by their names. Raises
        Unavailable and BadInput with a sentence.
        """
        if speaker != self._speaker:
            self._speaker, self._rejected = speaker, RejectedCommands()
        known = self._engine  # a model may have been fetched since
        if known is None or known[0] != settings or known[1].spec is not chosen(settings):
            opened = open_engine(settings)
            self._spotter = open_keyword_spotter(settings, opened.recognizer)
            self._engine = known = settings, opened
            self._places = ()
            give_back()
        engine = known[1]
        self._learn(places)
        if array is None:
            self._transcriber = Transcriber(
                settings, held=held, recognizer=engine.recognizer, spotter=self._spotter, rejected=self._rejected
            )
        else:
            channels = tuple(range(len(array.positions)))
            in_order = replace(array, channels=channels, rate=None)
            self._transcriber = ArrayTranscriber(
                in_order, settings, recognizer=engine.recognizer, spotter=self._spotter, rejected=self._rejected
            )
        unheard = places and not isinstance(engine.recognizer, LearnsPhrases)
        return f"{engine.why} {NAMES_NEED_WHISPER}" if unheard else engine.why

    def _learn(self, places: tuple[NamedPlace, ...]) -> None:
        """Hear these places by their names, where the engine can."""
        if self._engine is None or places == self._places:
            return
        settings, engine = self._engine
        if isinstance(engine.recognizer, LearnsPhrases):
            engine.recognizer.learn((*own_phrases(settings.phrases), *place_phrases(places)))
        self._places = places

    @job
    def hear(
        self,
        samples: bytes,
        rate: int,
        stamp: float,
        channels: int = 1,
        rejected: tuple[tuple[str, float], ...] = (),
        places: tuple[NamedPlace, ...] | None = None,
    ) -> list[ReadUtterance]:
        """The next sound, in the order in which it was heard → the utterances known with it.

        `samples`: 32-bit numbers, channel by channel of each moment, at `rate` [Hz], the first at `stamp` [s];
        `rejected`: commands understood and then rejected, and how long [s] before the end; `places` are heard by
        their names from now on, None: those of before.
        """
        assert self._transcriber is not None
        if places is not None:
            self._learn(places)
        numbers = np.frombuffer(samples, np.float32).astype(float).reshape(-1, channels)
        sound = at_16_khz(Sound(stamp=stamp, rate=rate, samples=numbers))
        for words, ago in rejected:
            self._rejected.reject(words, stamp + sound.duration - ago)
        return _packed(self._transcriber.feed(sound))

    @job
    def read_so_far(self) -> str:
        """The words of the sentence under way, as far as it goes; "" where none are known."""
        assert self._transcriber is not None
        return self._transcriber.words_so_far()

    def rest(self) -> None:
        """Nobody has spoken for a while: give back the engine's numbers."""
        if self._engine is not None and isinstance(self._engine[1].recognizer, Rests):
            self._engine[1].recognizer.rest()

    @job
    def finish(self) -> list[ReadUtterance]:
        """End the sound → the utterances that became known with that."""
        assert self._transcriber is not None
        return _packed(self._transcriber.finish())


def _packed(utterances: Iterable[RecognizedUtterance]) -> list[ReadUtterance]:
    return [ReadUtterance(one, code_of(one.decision.reason)) for one in utterances]
