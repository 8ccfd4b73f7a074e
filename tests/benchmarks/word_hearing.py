"""Listening to clips and judging what came of it: right, wrong or refused."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from core.message import Array
from core.sensors.microphones import Sound
from core.speech.recognition.recognizer import Recognizer, WordHypothesis, for_words
from core.speech.settings import RATE
from core.speech.understanding.grammar import OTHER_WORDS, Refusal, understand
from tests.benchmarks.word_scenes import LEAD, TAIL

PIECE = 320  # samples that are fed at a time


class FirstOnly:
    """A recognizer that hears the first channel."""

    def __init__(self, recognizer: Recognizer) -> None:
        self._recognizer = recognizer

    def feed(self, sound: Sound) -> tuple[WordHypothesis, ...]:
        return self._recognizer.feed(for_words(sound))

    def finish(self) -> tuple[WordHypothesis, ...]:
        return self._recognizer.finish()


@dataclass(frozen=True)
class Told:
    """One hypothesis, and when it was there."""

    hypothesis: WordHypothesis
    ready: float  # [s] on the sound's clock: when it was told, had the sound come in as it is spoken


def listened(transcriber: Recognizer, samples: Array, stamp: float) -> list[Told]:
    """All that is told while samples (N,) or (N, C) come in; times count from their begin."""
    told: list[Told] = []
    ready = 0.0
    channels = samples.shape[1] if samples.ndim == 2 else 1
    for at in range(0, len(samples), PIECE):
        piece = Sound(stamp=stamp + at / RATE, rate=RATE, samples=samples[at : at + PIECE].reshape(-1, channels))
        begun = time.process_time()
        found = transcriber.feed(piece)
        ready = max(ready, (at + PIECE) / RATE) + time.process_time() - begun
        told += [Told(one, ready) for one in found]
    return told + [Told(one, ready) for one in transcriber.finish()]


def padded(samples: Array, seed: int, lead: float = LEAD, tail: float = TAIL) -> Array:
    """A clip with faint noise before, behind and beneath it."""
    rng = np.random.default_rng(seed)
    whole = np.concatenate((np.zeros(int(lead * RATE)), samples, np.zeros(int(tail * RATE))))
    return whole + 3e-4 * rng.normal(size=len(whole))


def meaning(words: str) -> tuple[str, tuple[float, ...]] | None:
    """What words ask for, whether or not it is within the bounds of speech; None for no phrase of the grammar."""
    if words in OTHER_WORDS:
        return words, ()
    read = understand(words)
    return None if isinstance(read, Refusal) else (read.name, tuple(read.numbers.values()))


def acted_on(hypothesis: WordHypothesis) -> bool:
    """Whether it passes for one of the phrases: as a command, or as one that is refused by its bounds or for now."""
    return hypothesis.final and not hypothesis.doubt and meaning(hypothesis.words) is not None


def outcome(told: list[Told], text: str) -> str:
    """Right, wrong (another phrase passes) or refused."""
    passed = [one.hypothesis.words for one in told if acted_on(one.hypothesis)]
    if not passed:
        return "refused"
    return "right" if all(meaning(words) == meaning(text) for words in passed) else "wrong"


def doubts(told: list[Told], text: str) -> list[str]:
    """What the doubts did: words that were wrong and are refused, or right and lost."""
    doubted = [one.hypothesis.words for one in told if one.hypothesis.doubt]
    return ["right but doubted" if meaning(words) == meaning(text) else "wrong but doubted" for words in doubted]
