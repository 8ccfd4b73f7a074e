"""The recognizer of human voices: Whisper, scored against the grammar.

Three numbers decide about the meaning that fits best: its score, which adds up the probabilities of all its
spellings; how far the best free text is ahead of it; and how far it is ahead of the second meaning. The bounds for
words without numbers are narrow, because everything that resembles a command resembles one of those.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from core.commands import VOCABULARY
from core.commands.stop_moving import START, STOP_MOVING
from core.message import Array, message
from core.speech.recognition.decision import (
    MOST_OFFERED,
    TOO_LONG,
    Decision,
    Scores,
    Sentence,
    Thresholds,
    decide,
    no_command,
    not_a_command,
    stop,
)
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE
from core.speech.understanding.grammar import STOP_WORD, OwnPhrases, Refusal, parse
from core.speech.whisper.joint_search import Columns, Found, JointSearch
from core.speech.whisper.log_mel import log_mel
from core.speech.whisper.model_file import ModelFile
from core.speech.whisper.spellings import Spellings, as_understood, lacks_whole_part
from core.speech.whisper.tokenizer import Tokenizer
from core.speech.whisper.transformer import Decoder, Encoder

LONGEST = 28  # [s] of sound that are read: its end, where it is longer
SHORTEST = 0.1  # [s] of sound below which nothing was said
NO_WHOLE_NUMBER = "I did not hear the whole number."
THRESHOLDS = Thresholds(reject=1.0, accept=2.0)  # [nats] before the second meaning
REJECTED_BEFORE = 3.0  # [nats] by which a command is less likely that was rejected just before
OFFERED = 6.0  # [nats] behind the best free text, down to which a meaning is offered
BELOW = 2.0  # [nats] below its bound, down to which its score may be then
NAME_STOP = frozenset(
    kind.name for kind in VOCABULARY if kind is not STOP_MOVING and any(STOP_WORD.search(one) for one in kind.words)
)
"""Commands with the word stop in them that go somewhere."""

Key = tuple[str, tuple[tuple[str, float], ...], bool]
"""A command's name and numbers, and whether a number lacks its whole part."""


@message
class Bounds:
    """How well a meaning must fit."""

    score: float  # [nats] at least
    behind_free: float  # [nats] behind the best free text that means something else, at most


NUMBERS, FIXED, STOP = (
    Bounds(score=-8, behind_free=4),
    Bounds(score=-6, behind_free=0.7),
    Bounds(score=-8, behind_free=2),
)
"""Middles of wide plateaus (`tests.benchmarks.voices`). Whisper rather writes "to", "by" or "for" than numbers."""


@message
class Meaning:
    """A command, and all spellings of it together."""

    spelling: str  # the likeliest
    nats: float  # logarithm of the sum of their probabilities
    key: Key

    @property
    def bounds(self) -> Bounds:
        """How well this command must fit."""
        name, numbers, _ = self.key
        if name == STOP_MOVING.name:
            return STOP
        return NUMBERS if numbers else FIXED


class WhisperRecognizer:
    """Commands, and the words of everything else."""

    def __init__(self, folder: Path, own: OwnPhrases = ()) -> None:
        """`folder` with `model.bin` and `tokenizer.json` of an English-only model; `own`: phrases of the user's.

        Raises BadInput.
        """
        self._own = own
        tokenizer = Tokenizer(folder / "tokenizer.json")  # 30 MB, not needed after this
        spellings = Spellings(tokenizer.encode, (phrase.pattern for phrase in own))
        columns = Columns(spellings, tokenizer)
        model = ModelFile(folder / "model.bin")
        self.encode = Encoder(model)
        decoder = Decoder(model, self.encode.width, columns.tokens)
        self._search = JointSearch(decoder, spellings, columns)

    def decide(self, utterance: Utterance) -> Decision:
        """Compare the best meaning with free text and with the second meaning."""
        found = self.search(utterance.samples)
        free_text = found.free[0].text if found.free else ""
        decision = self._decided(utterance, found, free_text)
        goes = decision.command is not None and decision.command.name in NAME_STOP
        if STOP_WORD.search(free_text.lower()) and not goes and not decision.stops:
            return stop(free_text, remark=decision.reason)
        return decision

    def transcribe(self, utterance: Utterance) -> str:
        """Write down all speech, in any words."""
        found = self.search(utterance.samples)
        return found.free[0].text if found.free else ""

    def search(self, samples: Array) -> Found:
        """Samples (N,) of full scale ±1 at 16 kHz → the likeliest commands and free texts."""
        if len(samples) < SHORTEST * RATE or not np.any(samples):
            return Found(spellings=(), free=())
        heard = samples[-LONGEST * RATE :]
        return self._search.search(self.encode(log_mel(heard)), len(heard) / RATE)

    def meanings(self, found: Found, rejected: Iterable[str] = ()) -> list[Meaning]:
        """The commands of all spellings that were found, the likeliest first."""
        sums: dict[Key, Meaning] = {}
        for one in found.spellings:
            spelling = one.text
            key = key_of(spelling, self._own)
            if key is not None:
                known = sums.get(key)
                nats = one.nats if known is None else float(np.logaddexp(known.nats, one.nats))
                sums[key] = Meaning(spelling=known.spelling if known else spelling, nats=nats, key=key)
        unlikely = {key_of(words, self._own) for words in rejected}
        weighed = [
            Meaning(spelling=one.spelling, nats=one.nats - REJECTED_BEFORE * (one.key in unlikely), key=one.key)
            for one in sums.values()
        ]
        return sorted(weighed, key=lambda one: -one.nats)

    def _decided(self, utterance: Utterance, found: Found, free_text: str) -> Decision:
        meanings = self.meanings(found, utterance.rejected)
        if not meanings:
            return _not_understood(free_text, (), 0.0)
        best, free = meanings[0], found.free[0].nats if found.free else -math.inf
        other = max((one.nats for one in found.free if key_of(one.text, self._own) != best.key), default=-math.inf)
        fits = min(best.nats - best.bounds.score, best.nats - other + best.bounds.behind_free)
        second = meanings[1].nats if len(meanings) > 1 else -math.inf
        if fits <= 0:
            return _not_understood(free_text, map(self._sentence, _near(meanings, free)), fits)
        sentences = [self._sentence(one) for one in meanings[:3]]
        scores = Scores(sentence=best.nats, over_free_text=fits, over_second_best=best.nats - second)
        objection = TOO_LONG if utterance.cut else NO_WHOLE_NUMBER if best.key[2] else ""
        return decide(sentences[0], scores, THRESHOLDS, objection=objection, others=sentences[1:])

    def _sentence(self, meaning: Meaning) -> Sentence:
        return Sentence(as_understood(meaning.spelling).lower().rstrip(".!"), self._own)


def key_of(words: str, own: OwnPhrases = ()) -> Key | None:
    """The meaning of words, whatever the bounds of their numbers; None: no command."""
    found = parse(as_understood(words), own).found
    if isinstance(found, Refusal):
        return None
    spec, numbers = found
    return spec.name, tuple(numbers.items()), lacks_whole_part(words)


def _near(meanings: list[Meaning], free: float) -> list[Meaning]:
    """Those that are worth offering beside free text of that score [nats]; START changes nothing."""
    return [
        one
        for one in meanings
        if one.nats > max(free - OFFERED, one.bounds.score - BELOW) and one.key[0] != START.name and not one.key[2]
    ]


def _not_understood(free_text: str, resembling: Iterable[Sentence], fits: float) -> Decision:
    """Nothing fits: say back what was heard, and offer what resembles it."""
    if not free_text:
        return no_command()
    offered = (one.spoken for one in resembling)
    commands = tuple(one for one in offered if not isinstance(one, Refusal))[:MOST_OFFERED]
    confidence = 0.5 + 0.5 * math.tanh(fits / 2)
    if not commands:
        return replace(no_command(confidence), heard=free_text)
    return Decision(
        verdict="reject",
        confidence=confidence,
        alternatives=commands,
        words=free_text,
        reason=not_a_command(free_text),
    )
