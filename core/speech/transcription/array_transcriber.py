"""Decisions about the sound of an array: one microphone finds the utterances, all of them together give the words.

Every utterance is located and read from the beam towards its voice. In noise and in rooms that is what keeps numbers
apart; `tests.benchmarks.words` shows by how much.
"""

from collections import deque
from dataclasses import replace

import numpy as np

from core.errors import BadInput
from core.message import Array, message
from core.perception.sound.beamforming import How, beamform
from core.perception.sound.dereverberation import without_late_echoes
from core.perception.sound.locate import locate
from core.perception.sound.settings import DirectionFindingSettings
from core.sensors.microphones import MicrophoneArray, Sound
from core.speech.recognition.decision import Decision, RecognizedUtterance
from core.speech.recognition.engines import has_sphinx, open_engine
from core.speech.recognition.recognizer import KeywordSpotter, Recognizer, Utterance
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.sphinx.keyword_spotting import BeamformedStop
from core.speech.transcription.transcriber import LOOK_PIECE_S, RejectedCommands, Transcriber

MAX_GAP_S = 0.02  # missing between two pieces of sound, beyond which what was before is forgotten
BEFORE_VOICE_S = 0.1  # before an utterance's first voiced frame, that may already belong to it


@message
class BeamReading:
    """One way to read a voice out of an array."""

    how: How  # the beam is formed
    dry: bool  # late echoes are taken out first

    def heard(self, whole: Sound) -> Sound:
        """All channels as this reading takes them."""
        return replace(whole, samples=without_late_echoes(whole.samples, RATE_HZ)) if self.dry else whole


WET, DRY = BeamReading(how="mvdr", dry=False), BeamReading(how="mvdr", dry=True)
PLAIN = BeamReading(how="delay-and-sum", dry=False)
SHORT_SENTENCE_S = 1.5  # of a sentence of two or three words: it tells little of its echoes


@message
class BeamReadings:
    """In which ways a voice is read, one after the other, until it is a command."""

    short: tuple[BeamReading, ...]  # of sentences up to SHORT_SENTENCE_S
    long: tuple[BeamReading, ...]


READINGS = BeamReadings(short=(WET, DRY, PLAIN), long=(DRY, WET))


class ArrayTranscriber:
    """The recognizer for sound of several microphones; its sound has all channels and 16 kHz."""

    def __init__(
        self,
        array: MicrophoneArray,
        settings: SpeechSettings | None = None,
        hearing: DirectionFindingSettings | None = None,
        *,
        recognizer: Recognizer | None = None,
        spotter: KeywordSpotter | None = None,
        readings: BeamReadings = READINGS,
        rejected: RejectedCommands | None = None,
    ) -> None:
        """Raises Unavailable when the engine is not there."""
        chosen = settings or SpeechSettings()
        remembered = chosen.longest + 3 * chosen.pre_roll + chosen.hangover
        inner = recognizer or open_engine(chosen).recognizer
        self._beamed = _Beamed(inner, array, hearing or DirectionFindingSettings(), readings, remembered)
        self._array, self._pre_roll = array, chosen.pre_roll
        self._one = Transcriber(chosen, recognizer=self._beamed, spotter=spotter, rejected=rejected)
        self._stop_in_noise = BeamformedStop(chosen) if has_sphinx() else None

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        """The next piece of sound → STOP at once, and the sentences that ended in it. Raises BadInput.

        A long piece is heard in short ones: the STOP of a sentence that ends in it would be missed.
        """
        samples = self._array.heard(sound)
        if sound.rate != RATE_HZ:
            raise BadInput(f"Words from an array need sound at {RATE_HZ} Hz; this has {sound.rate} Hz.")
        heard: list[RecognizedUtterance] = []
        alone = Sound(stamp=sound.stamp, rate=RATE_HZ, samples=samples[:, :1])
        for piece, one in zip(sound.pieces(LOOK_PIECE_S), alone.pieces(LOOK_PIECE_S), strict=True):
            self._beamed.remember(piece)
            heard += self._one.feed(one)
            heard += self._spotted(piece.stamp + piece.duration)
        return tuple(heard)

    def _spotted(self, now: float) -> tuple[RecognizedUtterance, ...]:
        """STOP in the utterance under way, where one microphone may not have heard it."""
        since = self._one.speaking_since
        if since is None or self._stop_in_noise is None or not self._stop_in_noise.wants(since, now):
            return ()
        beam = self._beamed.beam(since - self._pre_roll, now, since - BEFORE_VOICE_S)
        return () if beam is None else self._stop_in_noise.find(beam, since)

    def words_so_far(self) -> str:
        """Return the words of the utterance under way; "": nothing."""
        return self._one.words_so_far()

    def finish(self) -> tuple[RecognizedUtterance, ...]:
        """The sound ends here → the sentence that was under way."""
        return self._one.finish()


class _Beamed:
    """A recognizer of what the array hears of an utterance."""

    def __init__(
        self,
        recognizer: Recognizer,
        array: MicrophoneArray,
        hearing: DirectionFindingSettings,
        readings: BeamReadings,
        remembered: float,
    ) -> None:
        self._recognizer, self._array, self._hearing = recognizer, array, hearing
        self._readings = readings
        self._remembered = remembered  # [s]
        self._pieces: deque[Sound] = deque()

    def remember(self, sound: Sound) -> None:
        """Keep a piece of sound of all channels."""
        if self._pieces:
            last = self._pieces[-1]
            if abs(last.stamp + last.duration - sound.stamp) > MAX_GAP_S or last.channels != sound.channels:
                self._pieces.clear()
        self._pieces.append(sound)
        while self._pieces[0].stamp + self._pieces[0].duration < sound.stamp - self._remembered:
            self._pieces.popleft()

    def decide(self, utterance: Utterance) -> Decision:
        """Decide about the beam towards the voice; in one microphone when no direction is found.

        Of single words only STOP is read in more than one way: another one has to be understood every time.
        """
        begin, end = utterance.sound.stamp, utterance.sound.stamp + utterance.sound.duration
        since = utterance.begin - BEFORE_VOICE_S
        whole, towards = self._located(begin, end, since)
        if towards is None:
            return self._recognizer.decide(utterance)

        def read(reading: BeamReading) -> Decision:
            beam = beamform(reading.heard(whole), self._array, towards, since, reading.how)
            return self._recognizer.decide(replace(utterance, sound=beam))

        readings = (
            self._readings.short if utterance.end - utterance.begin <= SHORT_SENTENCE_S else self._readings.long
        )
        first = read(readings[0])
        if first.command is not None:
            return first
        others = map(read, readings[1:])
        return next((one for one in others if one.command is not None and (one.stops or " " in one.words)), first)

    def beam(self, begin: float, end: float, since: float) -> Sound | None:
        """The sound from the voice's direction between two moments [s]; before `since` [s] there is only noise."""
        whole, towards = self._located(begin, end, since)
        return None if towards is None else beamform(whole, self._array, towards, since)

    def _located(self, begin: float, end: float, since: float) -> tuple[Sound, Array | None]:
        """All channels between two moments [s], and the direction of the voice (3,); None when unknown."""
        within = [one for one in self._pieces if one.stamp < end and one.stamp + one.duration > begin]
        if not within:  # the sound had a gap since
            return self._pieces[-1], None
        samples = np.concatenate([one.samples for one in within])
        whole = Sound(stamp=within[0].stamp, rate=RATE_HZ, samples=samples).part(begin, end)
        direction = locate(whole, self._array, speech_from=since, settings=self._hearing)
        return whole, None if direction is None else direction.towards
