"""The default engine: pocketsphinx (hidden Markov models, as in the paper), asked more than once.

First against everything that is no command. What remains is read again from slightly different sound, without the
competition: a number that changes with that was not heard well enough to drive by.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.signal import resample_poly

from core.message import Array
from core.perception.sound.wiener import without_noise
from core.speech.competing import grammar, is_competing
from core.speech.coverage import Span, left_over
from core.speech.endpointing import voiced
from core.speech.jsgf import plain_grammar
from core.speech.pocketsphinx import competing_words, grammar_decoder
from core.speech.recognizer import Hypothesis, Utterance, pcm
from core.speech.settings import RATE, SpeechSettings

FRAME = 0.01  # [s]
LEAST_BEFORE = 0.15  # [s] of noise before the speech that are left out of learning it: the speech may begin there
MOST_LEFT = 0.12  # [s] of speech beside the words, that may be the end of a consonant
BESIDE = 0.25  # [s] before and behind the voice, that are read with it
LONGEST_PAUSE = 0.7  # [s] within a sentence
SPEEDS = ((20, 19), (18, 19), (14, 13), (12, 13))
"""How much slower or faster the further opinions hear the sentence: like a deeper or a higher voice."""


class Sphinx:
    """Sentences of the grammar, or none."""

    def __init__(self, settings: SpeechSettings | None = None) -> None:
        """Makes both decoders, in about a second. Raises Unavailable when pocketsphinx is not installed."""
        self._settings = chosen = settings or SpeechSettings()
        options = {
            "bestpath": False,
            "wip": chosen.insertion,
            "topn": chosen.gaussians,
            "maxhmmpf": chosen.most_models,
            "cmn": "batch",
        }
        words = competing_words(chosen.competing_words)
        jsgf = grammar(words, chosen.competing_price, chosen.competing_share)
        self._strict = grammar_decoder(jsgf, **options)
        self._willing = grammar_decoder(plain_grammar(), **options)

    def read(self, utterance: Utterance) -> Hypothesis:
        """A sentence of the grammar; no words where other speech fits better; a doubt where it is not sure."""
        before = len(utterance.before) - round(LEAST_BEFORE * RATE)
        clear, offset = _trimmed(self._cleaned(utterance.samples, before))
        spans, score = _decoded(self._strict, clear)
        words = " ".join(span.word for span in spans)
        if any(is_competing(span.word) for span in spans):
            words, spans = "", ()
        return Hypothesis(
            words=words,
            begin=utterance.begin,
            end=utterance.end,
            score=score,
            doubt=self._doubt(utterance, clear, offset, spans) if words else "",
        )

    def _cleaned(self, samples: Array, before: int) -> Array:
        """Samples (N,), the first `before` of them noise → with less noise, where there is enough of it to matter."""
        noise = float(np.mean(samples[: max(before, 0)] ** 2)) if before > 0 else 0.0
        voice = float(np.quantile(np.abs(samples[max(before, 0) :]), 0.95)) ** 2 / 2 if len(samples) else 0.0
        noisy = voice < 10 ** (self._settings.clear_ratio / 10) * noise
        return without_noise(samples, RATE, before) if noisy else samples

    def _doubt(self, utterance: Utterance, clear: Array, offset: float, spans: tuple[Span, ...]) -> str:
        """Why the words must not be believed; "" for no reason."""
        if utterance.cut:
            return "That was longer than any command."
        if left_over(utterance, spans, offset) > MOST_LEFT:
            return "More was said than a command."
        if any(late.begin - early.end > LONGEST_PAUSE for early, late in pairwise(spans)):
            return "There was a long pause within the sentence."
        words = [span.word for span in spans]
        for slower, faster in SPEEDS[: self._settings.opinions]:
            again, _ = _decoded(self._willing, resample_poly(clear, slower, faster))
            if [span.word for span in again] != words:
                return "I am not sure that I heard every word right."
        return ""


def _trimmed(samples: Array) -> tuple[Array, float]:
    """Samples (N,) → those with the voice and a little beside it, and when [s] they begin.

    Far voices in the pauses before and behind would be heard as words.
    """
    begin, end = voiced(samples)
    first = max(round((begin - BESIDE) * RATE), 0)
    return (samples[first : round((end + BESIDE) * RATE)], first / RATE) if end > begin else (samples, 0.0)


def _decoded(decoder: Any, samples: Array) -> tuple[tuple[Span, ...], float | None]:
    """Samples (N,) → the words with their bounds, and the path's score as the decoder counts it."""
    decoder.start_utt()
    decoder.process_raw(pcm(samples), full_utt=True)
    decoder.end_utt()
    best = decoder.hyp()
    if best is None or not best.hypstr:
        return (), None
    spans = tuple(
        Span(
            word=found.word.partition("(")[0],  # another pronunciation: "a(2)"
            begin=FRAME * found.start_frame,
            end=FRAME * (found.end_frame + 1),
        )
        for found in decoder.seg()
        if found.word[0] not in "<[("
    )
    return spans, float(best.score)
