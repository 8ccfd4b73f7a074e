"""Jobs of the worker that reads words out of sound."""

from msgspec import Struct

from console.workers.job import Job
from core.navigation.places import NamedPlace
from core.sensors.microphones import MicrophoneArray
from core.sentences import SentenceCode
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.settings import SpeechSettings


class BeginListening(Job[str], frozen=True):
    """Listen again with the engine that the settings name → which engine reads the words, and why, in a sentence.

    `held`: everything up to `FinishListening` is one utterance. With an array the sound has a channel for each of its
    microphones, and the beam towards the voice is read; it listens all the time, so `held` says nothing there. What
    was rejected is forgotten when another `speaker` begins. `places` are heard by their names. Raises
    Unavailable and BadInput with a sentence.
    """

    settings: SpeechSettings
    held: bool = False
    array: MicrophoneArray | None = None
    speaker: int = 0
    places: tuple[NamedPlace, ...] = ()


class ReadUtterance(Struct, frozen=True):
    """An utterance on its way, with the code of why it is rejected."""

    utterance: RecognizedUtterance
    reason: SentenceCode


class HearSound(Job[list[ReadUtterance]], frozen=True):
    """The next sound → the utterances known with it. Pieces come in the order in which they were heard."""

    samples: bytes  # 32-bit numbers, channel by channel of each moment
    rate: int  # [Hz]
    stamp: float  # [s] of the first
    channels: int = 1
    rejected: list[tuple[str, float]] = []  # commands understood and then rejected; how long [s] before the end
    places: tuple[NamedPlace, ...] | None = None  # that are heard by their names from now on; None: those of before


class ReadSoFar(Job[str], frozen=True):
    """→ the words of the sentence under way, as far as it goes; "" where none are known."""


class FinishListening(Job[list[ReadUtterance]], frozen=True):
    """The sound has ended → the utterances that became known with that."""
