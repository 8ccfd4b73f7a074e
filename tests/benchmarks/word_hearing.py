"""Listening to clips and judging what came of it: right, wrong or refused."""

import time
from dataclasses import dataclass

import numpy as np

from core.commands.command import Command
from core.message import Array
from core.sensors.microphones import Sound
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.recognition.recognizer import StreamingRecognizer, for_words
from core.speech.settings import RATE_HZ
from core.speech.transcription.array_transcriber import PLAIN, WET, BeamReadings
from core.speech.understanding.grammar import OTHER_WORDS, Refusal, understand
from tests.benchmarks.word_scenes import LEAD, TAIL

PIECE = 320  # samples that are fed at a time
ECHOES_KEPT = BeamReadings(short=(WET, PLAIN), long=(WET,))
"""How an array reads a voice without taking out late echoes."""


class FirstOnly:
    """A recognizer that hears the first channel."""

    def __init__(self, recognizer: StreamingRecognizer) -> None:
        self._recognizer = recognizer

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        return self._recognizer.feed(for_words(sound))

    def finish(self) -> tuple[RecognizedUtterance, ...]:
        return self._recognizer.finish()


@dataclass(frozen=True)
class Told:
    """One utterance, and when its decision was there."""

    heard: RecognizedUtterance
    ready: float  # [s] on the sound's clock: when it was told, had the sound come in as it is spoken


def listened(transcriber: StreamingRecognizer, samples: Array, stamp: float) -> list[Told]:
    """All that is told while samples (N,) or (N, C) come in; times count from their begin."""
    told: list[Told] = []
    ready = 0.0
    channels = samples.shape[1] if samples.ndim == 2 else 1
    for at in range(0, len(samples), PIECE):
        piece = Sound(
            stamp=stamp + at / RATE_HZ, rate=RATE_HZ, samples=samples[at : at + PIECE].reshape(-1, channels)
        )
        begun = time.process_time()
        found = transcriber.feed(piece)
        ready = max(ready, (at + PIECE) / RATE_HZ) + time.process_time() - begun
        told += [Told(one, ready) for one in found]
    return told + [Told(one, ready) for one in transcriber.finish()]


def padded(samples: Array, seed: int, lead: float = LEAD, tail: float = TAIL) -> Array:
    """A clip with faint noise before, behind and beneath it."""
    rng = np.random.default_rng(seed)
    whole = np.concatenate((np.zeros(int(lead * RATE_HZ)), samples, np.zeros(int(tail * RATE_HZ))))
    return whole + 3e-4 * rng.normal(size=len(whole))


def meaning(words: str) -> tuple[str, tuple[float, ...]] | None:
    """What words ask for, whether or not it is within the bounds of speech; None for no phrase of the grammar."""
    if words in OTHER_WORDS:
        return words, ()
    read = understand(words)
    return None if isinstance(read, Refusal) else (read.name, tuple(read.numbers.values()))


def uncertain(heard: RecognizedUtterance) -> bool:
    """Whether the engine objected to its own words: they move nothing but stop the robot where STOP is among them."""
    command = heard.decision.command
    if command is None:
        return heard.decision.reason.endswith("say it again.")
    read = understand(heard.decision.words, spoken=True)
    return command.remark not in ("", read.remark if isinstance(read, Command) else "")


def acted_on(heard: RecognizedUtterance) -> bool:
    """Whether it passes for one of the phrases: as a command, or as one that is refused by its bounds or for now."""
    return heard.final and not uncertain(heard) and meaning(heard.decision.words) is not None


def outcome(told: list[Told], text: str) -> str:
    """Right, wrong (another phrase passes) or refused."""
    passed = [one.heard.decision.words for one in told if acted_on(one.heard)]
    if not passed:
        return "refused"
    return "right" if all(meaning(words) == meaning(text) for words in passed) else "wrong"


def rejections(told: list[Told], text: str) -> list[str]:
    """What the rejections did: words that were wrong and are refused, or right and lost."""
    rejected = [one.heard.decision.words for one in told if uncertain(one.heard)]
    return ["right but rejected" if meaning(words) == meaning(text) else "wrong but rejected" for words in rejected]
