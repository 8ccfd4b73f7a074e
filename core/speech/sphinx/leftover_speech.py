"""Check that the recognized words cover all of the speech: only whole utterances move the robot.

A decoder likes to take speech that fits nowhere for silence: "follow my instructions" becomes "follow me" and a long
pause. What is as loud as the words but lies outside of them gives that away.
"""

from __future__ import annotations

import numpy as np

from core.message import Array, message
from core.speech.recognition.endpointing import HOP, SIZE, levels
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE

BELOW = 14.0  # [dB] under the loudest word, down to which sound counts as speech
ABOVE = 3.0  # standard deviations over the noise before the speech, from which it does
BESIDE = 0.1  # [s] by which the bounds of a word may be wrong
EDGE = 0.15  # [s] at the end of the noise before the speech, that are not taken for noise


@message
class WordSpan:
    """A word in time."""

    word: str
    begin: float  # [s] from the first sample of the utterance's sound
    end: float  # [s]


def left_over(utterance: Utterance, spans: tuple[WordSpan, ...], offset: float = 0.0) -> float:
    """[s] of the utterance that sound like speech and belong to no word; the words' times count from `offset` [s]."""
    if len(utterance.samples) < SIZE or not spans:
        return 0.0
    level = levels(utterance.samples)
    times = (SIZE / 2 + HOP * np.arange(len(level))) / RATE - offset
    within, beside = np.zeros(len(level), bool), np.zeros(len(level), bool)
    for span in spans:
        within |= (times >= span.begin) & (times <= span.end)
        beside |= (times >= span.begin - BESIDE) & (times <= span.end + BESIDE)
    if not within.any() or beside.all():
        return 0.0
    least = max(float(np.quantile(level[within], 0.9)) - BELOW, _noise_reaches(level, times + offset, utterance))
    return float(np.count_nonzero(level[~beside] > least)) * HOP / RATE


def _noise_reaches(level: Array, times: Array, utterance: Utterance) -> float:
    """[dB] that the noise before the speech seldom exceeds."""
    before = level[times < utterance.begin - utterance.sound.stamp - EDGE]
    return float(before.mean() + ABOVE * before.std()) if len(before) else -np.inf
