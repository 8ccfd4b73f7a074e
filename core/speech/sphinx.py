"""The default engine: pocketsphinx (hidden Markov models, as in the paper), asked more than once.

First against everything that is no command. What remains is read again without the competition, from the sound with
its noise and at other speeds: a number that changes with that was not heard well enough to drive by. A command of a
single word, which a breath may resemble, has to hold against the competition every time.
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
SPEEDS = ((20, 19), (10, 9), (18, 19))
"""At how much slower or faster speeds it is read again: like a deeper or a higher voice."""


class Sphinx:
    """Sentences of the grammar, or none."""

    def __init__(self, settings: SpeechSettings | None = None) -> None:
        """Makes both decoders, in about a second. Raises Unavailable when pocketsphinx is not installed."""
        self._settings = chosen = settings or SpeechSettings()
        options = options_of(chosen)
        words = competing_words(chosen.competing_words)
        jsgf = grammar(words, chosen.competing_price, chosen.competing_share)
        self._strict = grammar_decoder(jsgf, **options)
        self._willing = grammar_decoder(plain_grammar(), **options)

    def read(self, utterance: Utterance) -> Hypothesis:
        """A sentence of the grammar; no words where other speech fits better; a doubt where it is not sure."""
        views, offset = views_of(utterance, self._settings.clear_ratio)
        spans, score = decoded(self._strict, views[0])
        words = " ".join(span.word for span in spans)
        if any(is_competing(span.word) for span in spans):
            words, spans = "", ()
        return Hypothesis(
            words=words,
            begin=utterance.begin,
            end=utterance.end,
            score=score,
            doubt=self._doubt(utterance, views, offset, spans) if words else "",
        )

    def _doubt(self, utterance: Utterance, views: list[Array], offset: float, spans: tuple[Span, ...]) -> str:
        """Why the words must not be believed; "" for no reason."""
        if utterance.cut:
            return "That was longer than any command."
        if left_over(utterance, spans, offset) > MOST_LEFT:
            return "More was said than a command."
        if any(late.begin - early.end > LONGEST_PAUSE for early, late in pairwise(spans)):
            return "There was a long pause within the sentence."
        words = [span.word for span in spans]
        slower = (resample_poly(views[0], up, down) for up, down in SPEEDS[: self._settings.opinions])
        again = self._willing if len(words) > 1 else self._strict
        for view in (*views[1:], *slower):
            if [span.word for span in decoded(again, view)[0]] != words:
                return "I am not sure that I heard every word right."
        return ""


def options_of(settings: SpeechSettings) -> dict[str, Any]:
    """What the settings say to pocketsphinx."""
    return {
        "bestpath": False,
        "wip": settings.insertion,
        "topn": settings.gaussians,
        "maxhmmpf": settings.most_models,
        "cmn": "batch",
    }


def views_of(utterance: Utterance, clear_ratio: float) -> tuple[list[Array], float]:
    """The utterance's sound, as it is read first and as it may be read too; and when [s] they begin in it.

    In noise, voice less than `clear_ratio` [dB] over it, they are the sound without that noise and the sound as it
    is, else only that.
    """
    samples, before = utterance.samples, len(utterance.before) - round(LEAST_BEFORE * RATE)
    noise = float(np.mean(samples[:before] ** 2)) if before > 0 else 0.0
    voice = float(np.quantile(np.abs(samples), 0.95)) ** 2 / 2
    noisy = voice < 10 ** (clear_ratio / 10) * noise
    views = [without_noise(samples, RATE, before), samples] if noisy else [samples]
    first, last = _around_voice(views[0])
    return [view[first:last] for view in views], first / RATE


def _around_voice(samples: Array) -> tuple[int, int]:
    """Samples (N,) → from where to where the voice and a little beside it reach.

    Far voices in the pauses before and behind would be heard as words.
    """
    begin, end = voiced(samples)
    if begin >= end:
        return 0, len(samples)
    return max(round((begin - BESIDE) * RATE), 0), min(round((end + BESIDE) * RATE), len(samples))


def decoded(decoder: Any, samples: Array) -> tuple[tuple[Span, ...], float | None]:
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
