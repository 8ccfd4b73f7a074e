"""One engine for all tests of hearing words: it takes a second to make."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from core.message import Array
from core.sensors.microphones import Sound
from core.speech.recognition.recognizer import Recognizer, WordHypothesis
from core.speech.settings import RATE
from core.speech.sphinx.recognizer import Sphinx

PIECE = 320  # samples


@cache
def engine() -> Sphinx:
    """The default engine; skips where pocketsphinx is not installed."""
    pytest.importorskip("pocketsphinx", reason="Recognising words needs pocketsphinx: pip install pocketsphinx")
    return Sphinx()


def mono(samples: Array, stamp: float = 0.0) -> Sound:
    """Samples (N,) as a sound."""
    return Sound(stamp=stamp, rate=RATE, samples=samples[:, None])


def pieces(samples: Array, stamp: float = 0.0, length: int = PIECE) -> list[Sound]:
    """Samples (N,) as a sound card delivers them."""
    return [mono(samples[at : at + length], stamp + at / RATE) for at in range(0, len(samples), length)]


def listened(recognizer: Recognizer, samples: Array, stamp: float = 0.0) -> list[WordHypothesis]:
    """All that is told about samples (N,), to their end."""
    told = [one for piece in pieces(samples, stamp) for one in recognizer.feed(piece)]
    return [*told, *recognizer.finish()]


def padded(samples: Array, lead: float = 0.7, tail: float = 0.8) -> Array:
    """Samples (N,) with faint noise before, behind and beneath."""
    whole = np.concatenate((np.zeros(int(lead * RATE)), samples, np.zeros(int(tail * RATE))))
    return whole + 3e-4 * np.random.default_rng(0).normal(size=len(whole))
