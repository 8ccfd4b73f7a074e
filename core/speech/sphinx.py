"""The default engine: pocketsphinx (hidden Markov models, as in the paper), asked more than once.

The same sound is read twice, as a command and as anything else, and both scores are compared: a command may fit a
little worse, because voices differ, but no word of it much worse. One grammar that holds both would not do: the
decoder drops what is behind for a moment, and with it half of the commands of an unusual voice.
What remains is read again from the sound with its noise and at other speeds: a number that changes with that was not
heard well enough to drive by. A command of a single word, which a breath may resemble, has to fit better than
anything else every time.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from scipy.signal import resample_poly

from core.message import Array
from core.perception.sound.wiener import without_noise
from core.speech.competing import grammar
from core.speech.coverage import left_over
from core.speech.endpointing import over_noise, voiced
from core.speech.grammar import Refusal, understand
from core.speech.jsgf import plain_grammar
from core.speech.path import Path, decoded
from core.speech.pocketsphinx import competing_words, grammar_decoder
from core.speech.recognizer import Hypothesis, Utterance
from core.speech.rivalry import holds
from core.speech.settings import RATE, SpeechSettings

LEAST_BEFORE = 0.15  # [s] of noise before the speech that are left out of learning it: the speech may begin there
MOST_LEFT = 0.12  # [s] of speech beside the words, that may be the end of a consonant
BESIDE = 0.25  # [s] before and behind the voice, that are read with it
LONGEST_PAUSE = 0.7  # [s] within a sentence
SPEEDS = ((20, 19), (10, 9), (18, 19))
"""At how much slower or faster speeds it is read again: like a deeper or a higher voice."""


class Sphinx:
    """Sentences of the grammar, or none."""

    def __init__(self, settings: SpeechSettings | None = None) -> None:
        """Makes its decoders, in about a second. Raises Unavailable when pocketsphinx is not installed."""
        self._settings = chosen = settings or SpeechSettings()
        options = options_of(chosen)
        # For comparison the scores of both grammars must count from the same best model of every frame: from that of
        # all models, where else only those are evaluated that a grammar is about to use.
        fair = options | {"compallsen": True}
        words = competing_words(chosen.competing_words, chosen.resembling_words)
        self._commands = grammar_decoder(plain_grammar(), **fair)
        self._others = grammar_decoder(grammar(words, chosen.competing_price), **fair)
        self._quick = grammar_decoder(plain_grammar(), **options)  # where only the words count

    def read(self, utterance: Utterance) -> Hypothesis:
        """A sentence of the grammar; no words where other speech fits better; a doubt where it is not sure."""
        views, offset = views_of(utterance, self._settings.clear_ratio)
        said = decoded(self._commands, views[0])
        told = bool(said.words) and self._holds(said, views[0])
        return Hypothesis(
            words=" ".join(said.words) if told else "",
            begin=utterance.begin,
            end=utterance.end,
            score=said.fit if said.words else None,
            doubt=self._doubt(utterance, views, offset, said) if told else "",
        )

    def _holds(self, said: Path, samples: Array) -> bool:
        """Whether the command stands against anything else that the samples (N,) may be."""
        return holds(said, decoded(self._others, samples), self._settings)

    def _doubt(self, utterance: Utterance, views: list[Array], offset: float, said: Path) -> str:
        """Why the words must not be believed; "" for no reason."""
        if utterance.cut:
            return "That was longer than any command."
        if left_over(utterance, said.spans, offset) > MOST_LEFT:
            return "More was said than a command."
        if said.longest_pause > LONGEST_PAUSE:
            return "There was a long pause within the sentence."
        if not all(self._agrees(said, view) for view in self._other_views(views)):
            return "I am not sure that I heard every word right."
        return ""

    def _other_views(self, views: list[Array]) -> Iterator[Array]:
        """What is read again: in noise the sound with it; and other speeds."""
        yield from views[1:]
        for up, down in SPEEDS[: self._settings.opinions]:
            yield resample_poly(views[0], up, down)

    def _agrees(self, said: Path, view: Array) -> bool:
        """Whether the same is read from another view of the sound."""
        if len(said.words) > 1:
            return _meaning(decoded(self._quick, view)) == _meaning(said)
        again = decoded(self._commands, view)
        return again.words == said.words and self._holds(again, view)


def _meaning(said: Path) -> object:
    """What the words ask for, "meter" or "meters", "wall" or "the wall"; the words, where that is nothing."""
    read = understand(" ".join(said.words))
    return said.words if isinstance(read, Refusal) else (read.name, read.numbers)


def options_of(settings: SpeechSettings) -> dict[str, Any]:
    """What the settings say to pocketsphinx."""
    return {
        "bestpath": False,
        "wip": settings.insertion,
        "silprob": settings.silence,
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
    noisy = over_noise(samples, samples[: max(before, 0)]) < 10 ** (clear_ratio / 10)
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
