"""Check that the recognized words cover all of the speech: only whole utterances move the robot.

A decoder likes to take speech that fits nowhere for silence: "follow my instructions" becomes "follow me" and a long
pause. What is as loud as the words but lies outside of them gives that away.
"""

import numpy as np

from core.message import Array, message
from core.speech.recognition.endpointing import FRAME_SAMPLES, HOP_SAMPLES, levels
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE_HZ

BELOW_DB = 14.0  # under the loudest word, down to which sound counts as speech
ABOVE_SDS = 3.0  # standard deviations over the noise before the speech, from which it does
WORD_MARGIN_S = 0.1  # by which the bounds of a word may be wrong
NOISE_EDGE_S = 0.15  # at the end of the noise before the speech, that are not taken for noise


@message
class WordSpan:
    """A word in time."""

    word: str
    begin: float  # [s] from the first sample of the utterance's sound
    end: float  # [s]


def left_over(utterance: Utterance, spans: tuple[WordSpan, ...], offset: float = 0.0) -> float:
    """[s] of the utterance that sound like speech and belong to no word; the words' times count from `offset` [s]."""
    if len(utterance.samples) < FRAME_SAMPLES or not spans:
        return 0.0
    level = levels(utterance.samples)
    times = (FRAME_SAMPLES / 2 + HOP_SAMPLES * np.arange(len(level))) / RATE_HZ - offset
    within, beside = np.zeros(len(level), bool), np.zeros(len(level), bool)
    for span in spans:
        within |= (times >= span.begin) & (times <= span.end)
        beside |= (times >= span.begin - WORD_MARGIN_S) & (times <= span.end + WORD_MARGIN_S)
    if not within.any() or beside.all():
        return 0.0
    least = max(float(np.quantile(level[within], 0.9)) - BELOW_DB, _noise_reaches(level, times + offset, utterance))
    return float(np.count_nonzero(level[~beside] > least)) * HOP_SAMPLES / RATE_HZ


def _noise_reaches(level: Array, times: Array, utterance: Utterance) -> float:
    """[dB] that the noise before the speech seldom exceeds."""
    before = level[times < utterance.begin - utterance.sound.stamp - NOISE_EDGE_S]
    return float(before.mean() + ABOVE_SDS * before.std()) if len(before) else -np.inf
