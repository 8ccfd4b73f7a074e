"""The protocols of recognition: sound with speech goes in, decisions come out."""

from collections.abc import Iterable
from typing import Protocol, runtime_checkable

import numpy as np

from core.errors import BadInput
from core.message import Array, message
from core.sensors.microphones import NO_NUMBERS, Sound, usable
from core.sensors.resampling import resampled
from core.speech.recognition.decision import Decision, RecognizedUtterance
from core.speech.settings import RATE_HZ
from core.speech.understanding.grammar import OwnPhrases

MIN_RATE_HZ = 8_000  # a telephone; below, consonants are gone


@message
class Utterance:
    """The sound of one utterance, with what came before it."""

    sound: Sound  # one channel at 16 kHz
    begin: float  # [s] of the speech, on the sound's clock
    end: float  # [s]
    cut: bool = False  # whether it was still going on when it became too long
    rejected: tuple[str, ...] = ()  # words of commands that were rejected just before: these are less likely

    @property
    def samples(self) -> Array:
        """(N,) of all the sound."""
        return self.sound.samples[:, 0]

    @property
    def before(self) -> Array:
        """(N,) what was heard before the speech began."""
        return self.samples[: max(round((self.begin - self.sound.stamp) * RATE_HZ), 0)]


class Recognizer(Protocol):
    """The commands of one engine."""

    def decide(self, utterance: Utterance) -> Decision:
        """Decide about one whole utterance."""
        ...


@runtime_checkable
class LearnsPhrases(Protocol):
    """A recognizer that hears phrases of the user's, which may change while it listens."""

    def learn(self, own: OwnPhrases) -> None:
        """Hear these beside the vocabulary from now on, and no others."""
        ...


class NameOpinion(Protocol):
    """Another engine's opinion about names, by the sound alone."""

    def learn(self, own: OwnPhrases) -> None:
        """Know the names in these phrases, and no others."""
        ...

    def weigh(self, utterance: Utterance, also: str = "") -> dict[str, float]:
        """The names that fit an utterance best, and `also`, by the words of their commands → by how much [nats] each
        fits better than any sounds of speech. A name that this engine does not know is missing.
        """
        ...

    def over_words(self, utterance: Utterance, key: str, texts: Iterable[str]) -> dict[str, float]:
        """Other words that may have been said, in small letters → by how much [nats] the name of this key fits better
        than they do. Words that this engine cannot pronounce are missing.
        """
        ...


class Dictation(Protocol):
    """The words of one engine, whether they are a command or not."""

    def transcribe(self, utterance: Utterance) -> str:
        """Write down one whole utterance; "" where nothing was said."""
        ...


class KeywordSpotter(Protocol):
    """STOP in running speech, before the sentence is over."""

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        """The next piece of sound, one channel at 16 kHz → STOP, if it ended in there. Raises BadInput."""
        ...


class StreamingRecognizer(Protocol):
    """Decisions about sound as it comes."""

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        """The next piece of sound at 16 kHz → what became known with it. Raises BadInput."""
        ...

    def finish(self) -> tuple[RecognizedUtterance, ...]:
        """The sound ends here (the button was let go, the file is over) → what became known with that."""
        ...


def for_words(sound: Sound, channel: int = 0) -> Sound:
    """One channel of any sound at 16 kHz, as recognizers want it. Raises BadInput with a sentence."""
    check_channel(sound, channel)
    return at_16_khz(Sound(stamp=sound.stamp, rate=sound.rate, samples=sound.samples[:, channel : channel + 1]))


def check_channel(sound: Sound, channel: int) -> None:
    """Raise BadInput where a sound has no channel of this number."""
    if not 0 <= channel < sound.channels:
        raise BadInput(
            f"The sound has {sound.channels} channel(s); channel {channel}, counted from 0, is none of them."
        )


def at_16_khz(sound: Sound) -> Sound:
    """All channels of a sound, resampled where that is needed. Raises BadInput where that cannot be."""
    if sound.rate < MIN_RATE_HZ:
        raise BadInput(f"Words need sound of at least {MIN_RATE_HZ} Hz; this has {sound.rate} Hz. Record it again.")
    if sound.rate == RATE_HZ:
        return sound
    if not usable(sound.samples):
        raise BadInput(NO_NUMBERS)
    return Sound(stamp=sound.stamp, rate=RATE_HZ, samples=resampled(sound.samples, sound.rate, RATE_HZ))


def checked(sound: Sound) -> Array:
    """Sound for a recognizer → its samples (N,). Raises BadInput where it is not one channel at 16 kHz."""
    if sound.channels != 1 or sound.rate != RATE_HZ:
        raise BadInput(f"A recognizer wants one channel at {RATE_HZ} Hz, not {sound.channels} at {sound.rate} Hz.")
    if not usable(sound.samples):
        raise BadInput(NO_NUMBERS)
    return sound.samples[:, 0]


def pcm(samples: Array) -> bytes:
    """Samples (N,) of full scale ±1 → 16-bit integers, little-endian."""
    return np.clip(np.round(samples * 32767), -32768, 32767).astype("<i2").tobytes()
