"""Which numbers were said: what several views of the same sound heard, each weighed in all of them.

One view errs by a digit where a voice is unusual, another view elsewhere. Every sentence that any of them heard is
forced upon each, and its likelihoods are averaged, as recognizers' outputs are combined by their scores (Fiscus, "A
post-processing system to yield reduced word error rates: ROVER", 1997). What wins is likely, and is not sure.
"""

import math
from collections.abc import Collection, Iterator, Sequence
from typing import Any

import numpy as np

from core.message import Array, message
from core.speech.sphinx.decoded_path import DecodedPath, decoded
from core.speech.sphinx.decoder import SEARCH, listen_for
from core.speech.sphinx.jsgf import FAR_LIKELIHOOD, FINE_LIKELIHOOD, RARE, written
from core.speech.understanding.numbers import DIGITS

REJECTED_NATS = 50.0  # [nats] by which a rejected sentence is less likely: more than the wrong ones lead by

Words = tuple[str, ...]


@message
class Vote:
    """One sentence and what the views make of it."""

    path: DecodedPath  # through the first view
    fit: float  # [nats] mean over all views, with how likely its numbers are


def vote(
    decoder: Any, sentences: Sequence[Words], views: Sequence[Array], unlikely: Collection[Words] = ()
) -> list[Vote]:
    """Different sentences, weighed by a grammar's decoder in all views (N_i,) of one sound → the best first.

    `unlikely`: those of them that were rejected when they were heard just before.
    """
    votes = []
    for words in sentences:
        paths = forced(decoder, words, views)
        fits = [path.fit if path.spans else -math.inf for path in paths]
        before = likelihood(words) - REJECTED_NATS * (words in unlikely)
        votes.append(Vote(path=paths[0], fit=float(np.mean(fits)) + before))
    return sorted(votes, key=lambda one: one.fit, reverse=True)


def nearest_others(decoder: Any, words: Words, view: Array, count: int = 1) -> list[Words]:
    """The `count` sentences with one digit changed, or one for two decimals, that fit the samples (N,) best, the best
    first; fewer where no more fit.
    """
    known = [words]
    while len(known) <= count:
        others = list(_others(words, known))
        found = forced(decoder, (" | ".join(others),), [view])[0].words if others else ()
        if not found:
            break
        known.append(found)
    return known[1:]


def _others(words: Words, known: Sequence[Words]) -> Iterator[str]:
    """As JSGF, each as likely as its numbers: the sentences with one digit changed, or one for two decimals, but for
    those that are known.
    """
    for at, word in enumerate(words):
        if word not in DIGITS:
            continue
        shorter = at >= 2 and words[at - 2] == "point"
        for before in (words[:at], *([words[: at - 1]] if shorter else [])):
            left = [digit for digit in DIGITS if (*before, digit, *words[at + 1 :]) not in known]
            if left:
                weight = math.exp(likelihood((*before, left[0], *words[at + 1 :])))
                yield " ".join((f"/{weight:g}/", *before, f"({' | '.join(left)})", *words[at + 1 :]))


def forced(decoder: Any, words: Words, views: Sequence[Array]) -> list[DecodedPath]:
    """The best ways in which these words fit each of the samples (N_i,); NOTHING where they do not."""
    listen_for(decoder, "forced", written({}, " ".join(words)))
    try:
        return [decoded(decoder, view) for view in views]
    finally:
        decoder.activate_search(SEARCH)


def likelihood(words: Words) -> float:
    """[nats] of the numbers of a sentence, as the grammar weighs them before anything is heard."""
    total, decimals = 0.0, 0
    for word in words:
        if word == "point":
            decimals = 1
        elif word in DIGITS and decimals:
            total += math.log(FINE_LIKELIHOOD) * (decimals == 2)
            decimals += 1
        else:
            total += math.log(FAR_LIKELIHOOD) * (word in RARE)
            decimals = 0
    return total
