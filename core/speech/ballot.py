"""Which numbers were said: what several views of the same sound heard, each weighed in all of them.

One view errs by a digit where a voice is unusual, another view elsewhere. Every sentence that any of them heard is
forced upon each, and its likelihoods are averaged, as recognizers' outputs are combined by their scores (Fiscus, "A
post-processing system to yield reduced word error rates: ROVER", 1997). What wins is likely, and is not sure.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from core.message import Array, message
from core.speech.jsgf import FAR, FINE, RARE, written
from core.speech.numbers import DIGITS
from core.speech.path import Path, decoded
from core.speech.pocketsphinx import SEARCH, listen_for

Words = tuple[str, ...]


@message
class Vote:
    """One sentence and what the views make of it."""

    path: Path  # through the first view
    fit: float  # [nats] mean over all views, with how likely its numbers are


def vote(decoder: Any, sentences: Sequence[Words], views: Sequence[Array]) -> list[Vote]:
    """Different sentences, weighed by a grammar's decoder in all views (N_i,) of one sound → the best first."""
    votes = []
    for words in sentences:
        paths = forced(decoder, words, views)
        fits = [path.fit if path.spans else -math.inf for path in paths]
        votes.append(Vote(path=paths[0], fit=float(np.mean(fits)) + likelihood(words)))
    return sorted(votes, key=lambda one: one.fit, reverse=True)


def nearest_other(decoder: Any, words: Words, view: Array) -> Words | None:
    """The sentence with one digit changed that fits the samples (N,) best; None where it has no digit."""
    others = []
    for at, word in enumerate(words):
        if word in DIGITS:
            choice = f"({' | '.join(digit for digit in DIGITS if digit != word)})"
            (path,) = forced(decoder, (*words[:at], choice, *words[at + 1 :]), [view])
            others.extend([path] if path.spans else [])
    return max(others, key=lambda path: path.fit).words if others else None


def forced(decoder: Any, words: Words, views: Sequence[Array]) -> list[Path]:
    """The best ways in which these words fit each of the samples (N_i,); NOTHING where they do not."""
    listen_for(decoder, "forced", written({}, " ".join(words)))
    try:
        return [decoded(decoder, view) for view in views]
    finally:
        decoder.activate_search(SEARCH)


def likelihood(words: Words) -> float:
    """[nats] of the numbers of a sentence, as the grammar weighs them before anything is heard."""
    told, decimals = 0.0, 0
    for word in words:
        if word == "point":
            decimals = 1
        elif word in DIGITS and decimals:
            told += math.log(FINE) * (decimals == 2)
            decimals += 1
        else:
            told += math.log(FAR) * (word in RARE)
            decimals = 0
    return told
