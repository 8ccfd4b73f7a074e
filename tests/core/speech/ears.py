"""One engine for all tests of hearing words, which takes a second to make, and decisions to begin with."""

import os
from functools import cache

import numpy as np
import pytest

from core.message import Array
from core.models import MODEL, find
from core.sensors.microphones import Sound
from core.speech.recognition.decision import (
    NOT_SURE,
    Decision,
    RecognizedUtterance,
    Scores,
    Sentence,
    Thresholds,
    decide,
)
from core.speech.recognition.recognizer import StreamingRecognizer
from core.speech.settings import RATE_HZ
from core.speech.sphinx.recognizer import Sphinx
from core.speech.whisper.recognizer import WhisperRecognizer

PIECE = 320  # samples


@cache
def engine() -> Sphinx:
    """The default engine; skips where pocketsphinx is not installed."""
    pytest.importorskip("pocketsphinx", reason="Recognising words needs pocketsphinx: pip install pocketsphinx")
    return Sphinx()


@cache
def whisper() -> WhisperRecognizer:
    """The recognizer of human voices; without its model this skips, and fails where BECKON_REQUIRE_VOICES is set."""
    found = find(MODEL)
    if found is None:
        why = "The model of human voices is not here: beckon models get whisper-tiny.en."
        pytest.fail(why) if os.environ.get("BECKON_REQUIRE_VOICES") else pytest.skip(why)
    return WhisperRecognizer(found.folder)


def mono(samples: Array, stamp: float = 0.0) -> Sound:
    """Samples (N,) as a sound."""
    return Sound(stamp=stamp, rate=RATE_HZ, samples=samples[:, None])


def pieces(samples: Array, stamp: float = 0.0, length: int = PIECE) -> list[Sound]:
    """Samples (N,) as a sound card delivers them."""
    return [mono(samples[at : at + length], stamp + at / RATE_HZ) for at in range(0, len(samples), length)]


def listened(recognizer: StreamingRecognizer, samples: Array, stamp: float = 0.0) -> list[RecognizedUtterance]:
    """All that is told about samples (N,), to their end."""
    told = [one for piece in pieces(samples, stamp) for one in recognizer.feed(piece)]
    return [*told, *recognizer.finish()]


def padded(samples: Array, lead: float = 0.7, tail: float = 0.8) -> Array:
    """Samples (N,) with faint noise before, behind and beneath."""
    whole = np.concatenate((np.zeros(int(lead * RATE_HZ)), samples, np.zeros(int(tail * RATE_HZ))))
    return whole + 3e-4 * np.random.default_rng(0).normal(size=len(whole))


def sure(words: str) -> Decision:
    """The decision of an engine that is sure of these words."""
    return decide(Sentence(words), Scores(sentence=0.0), Thresholds(reject=0.0, accept=0.0))


def confirming(words: str) -> Decision:
    """The decision of an engine whose words have to be confirmed."""
    return decide(Sentence(words), Scores(sentence=0.0, over_second_best=0.0), Thresholds(reject=0.0, accept=0.0))


def unsure(words: str, objection: str = NOT_SURE) -> Decision:
    """The decision of an engine that objects to these words."""
    return decide(Sentence(words), Scores(sentence=0.0), Thresholds(reject=0.0, accept=0.0), objection=objection)
