"""Sound as it comes: what was said, and from where. The console hears with the same parts."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from core.geometry import Pose
from core.message import message
from core.pilot.sound_perception import SoundPerception
from core.robots import Profile
from core.sensors.microphones import MicrophoneArray, Sound
from core.settings import Settings
from core.slam.estimate import Estimate
from core.snapshot import VoiceDirection, voice_between
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.recognition.engines import ActiveEngine, open_engine
from core.speech.recognition.recognizer import at_16_khz, for_words
from core.speech.transcription.array_transcriber import ArrayTranscriber
from core.speech.transcription.transcriber import Transcriber

STILL = Estimate(pose=Pose(), covariance=np.zeros((3, 3)))  # of microphones that stay where they are


@message
class HeardSpeech:
    """Words, and the voice that said them."""

    utterance: RecognizedUtterance
    voice: VoiceDirection | None  # None: no direction is known


class WordReader:
    """Reads the words of sound with any rate: in the array's beam towards each voice, or in one channel."""

    def __init__(
        self, settings: Settings, engine: ActiveEngine, array: MicrophoneArray | None, channel: int = 0
    ) -> None:
        """`array`: of which a beam is made; None: words are read in `channel`."""
        self._channel = channel if array is None else None
        self.transcriber: Transcriber | ArrayTranscriber
        if array is None:
            self.transcriber = Transcriber(settings.speech, recognizer=engine.recognizer)
        else:
            given = (replace(array, rate=None), settings.speech, settings.direction_finding)
            self.transcriber = ArrayTranscriber(*given, recognizer=engine.recognizer)

    def prepared(self, sound: Sound) -> Sound:
        """The channels in which words are read, at the recognizer's rate. Raises BadInput."""
        return at_16_khz(sound) if self._channel is None else for_words(sound, self._channel)


class SpeechListener:
    """Listens with microphones that stay where they are."""

    def __init__(self, settings: Settings, array: MicrophoneArray | None) -> None:
        """Without an array, words alone are read, in the first channel. Raises Unavailable without a recognizer."""
        self._voices: tuple[VoiceDirection, ...] = ()
        self.engine = open_engine(settings.speech)
        self.locates = array is not None and array.dimensions >= 2  # a line of microphones has no directions
        self._words = WordReader(
            settings, self.engine, array if self.locates else None, 0 if array is None else array.channels[0]
        )
        arrays = (array,) if array is not None and self.locates else ()
        self._ears = SoundPerception(Profile(name="microphones", url="", arrays=arrays), settings.direction_finding)

    def feed(self, sound: Sound) -> tuple[HeardSpeech, ...]:
        """The next piece of sound → STOP at once, and the sentences that ended in it. Raises BadInput."""
        stamp = sound.stamp + sound.duration
        self._ears.listen(sound, stamp)
        heard = self._ears.hear(stamp, STILL)
        if heard is not None:
            self._voices = heard.voices or self._voices
        return self._located(self._words.transcriber.feed(self._words.prepared(sound)))

    def finish(self) -> tuple[HeardSpeech, ...]:
        """The sound ends here → the sentence that was under way."""
        return self._located(self._words.transcriber.finish())

    def _located(self, utterances: Iterable[RecognizedUtterance]) -> tuple[HeardSpeech, ...]:
        return tuple(
            HeardSpeech(utterance=one, voice=voice_between(self._voices, one.begin, one.end)) for one in utterances
        )
