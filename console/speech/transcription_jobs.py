"""Jobs of the worker that reads words out of sound."""

from __future__ import annotations

from console.speech.utterance import UtteranceMessage
from console.workers.array_jobs import ArrayMessage
from console.workers.job import Job
from core.speech.settings import SpeechSettings


class BeginListening(Job[None], frozen=True):
    """Listen again with the engine that the settings name. Raises Unavailable and BadInput with a sentence.

    `held`: everything up to `FinishListening` is one utterance. With an array the sound has a channel for each of its
    microphones, and the beam towards the voice is read; it listens all the time, so `held` says nothing there. What
    was held back is forgotten when another `speaker` begins.
    """

    settings: SpeechSettings
    held: bool = False
    array: ArrayMessage | None = None
    speaker: int = 0


class HearSound(Job[list[UtteranceMessage]], frozen=True):
    """The next sound → the utterances known with it. Pieces come in the order in which they were heard."""

    samples: bytes  # 32-bit numbers, channel by channel of each moment
    rate: int  # [Hz]
    stamp: float  # [s] of the first
    channels: int = 1
    rejected: list[tuple[str, float]] = []  # words understood and then held back, and how long [s] before the end


class FinishListening(Job[list[UtteranceMessage]], frozen=True):
    """The sound has ended → the utterances that became known with that."""
