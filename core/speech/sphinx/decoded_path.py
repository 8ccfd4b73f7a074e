"""The result of a decoder: words with their bounds, and how well every piece of the sound fits them."""

import math
import sys
from itertools import pairwise
from typing import Any

from core.message import Array, message
from core.speech.sphinx.decoder import FRAME_S, take_in

NATS_FACTOR = 1024.0
"""pocketsphinx counts in steps of 1024 times its smallest; its figures are exponentials of what is left then."""

TINY = sys.float_info.min  # what has become 0 on the way here was at least as small


@message
class WordSpan:
    """A word in time."""

    word: str
    begin: float  # [s] from the first sample of the utterance's sound
    end: float  # [s]


@message
class DecodedPiece:
    """A stretch of sound and how well it fits what it is taken for, a word or none."""

    begin: float  # [s]
    end: float  # [s]
    fit: float  # [nats] its log-likelihood, from 0 for the best model of every frame down, with the price of the word


@message
class DecodedPath:
    """The way through a grammar that fits best."""

    spans: tuple[WordSpan, ...]  # the words
    pieces: tuple[DecodedPiece, ...]  # all of the sound: the words and what lies between

    @property
    def words(self) -> tuple[str, ...]:
        """The recognized words."""
        return tuple(span.word for span in self.spans)

    @property
    def fit(self) -> float:
        """[nats] of the whole sound."""
        return sum(piece.fit for piece in self.pieces)

    @property
    def longest_pause(self) -> float:
        """[s] between two of its words."""
        return max((late.begin - early.end for early, late in pairwise(self.spans)), default=0.0)

    def fit_within(self, begin: float, end: float) -> float:
        """[nats] of a part [s] of the sound: a piece of which a share lies within counts by that share."""
        shares = (
            (max(min(end, piece.end) - max(begin, piece.begin), 0.0) / (piece.end - piece.begin), piece.fit)
            for piece in self.pieces
        )
        return sum(share * fit for share, fit in shares)


NOTHING = DecodedPath(spans=(), pieces=())


def decoded(decoder: Any, samples: Array) -> DecodedPath:
    """Samples (N,) → the best path of a decoder's grammar; NOTHING where none fits."""
    decoder.start_utt()
    take_in(decoder, samples, whole=True)
    decoder.end_utt()
    best = decoder.hyp()
    if best is None or not best.hypstr:
        return NOTHING
    found = [one for one in decoder.seg() if one.end_frame >= one.start_frame and one.word[0] != "("]
    pieces = tuple(
        DecodedPiece(
            begin=FRAME_S * one.start_frame,
            end=FRAME_S * (one.end_frame + 1),
            fit=NATS_FACTOR * (math.log(max(one.ascore, TINY)) + math.log(max(one.lscore, TINY))),
        )
        for one in found
    )
    spans = tuple(
        WordSpan(word=one.word.partition("(")[0], begin=piece.begin, end=piece.end)  # another pronunciation: "a(2)"
        for one, piece in zip(found, pieces, strict=True)
        if one.word[0] not in "<["
    )
    return DecodedPath(spans=spans, pieces=pieces)
