"""What it would gain to learn a voice: `python -m tests.benchmarks.own_voice --data DATA --into FILE --out JSON`.

DATA and FILE as in `tests.benchmarks.left_out`. A speaker with 25 sentences or more reads 18 of them, drawn; from the
scores that the recognizer gave to all meanings of these, offsets [nats] of the words of numbers are learned (the
likeliest under a normal prior), or by how much the bounds have to give way for nine in ten of those that were right
(1 nat at most). The offsets are added to the scores of the other sentences of that speaker, which took no part.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from core.message import Array
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import SpeechSettings
from core.speech.understanding.numbers import number_words
from core.speech.whisper import recognizer as whisper
from core.speech.whisper.joint_search import Found
from tests.benchmarks.command import run_command
from tests.benchmarks.left_out import Remembered, clips
from tests.benchmarks.phrases import judged
from tests.benchmarks.voices import REFUSED, RIGHT, STOPPED, WRONG, utterance

READ, MIN_SENTENCES = 18, 25  # sentences that are read once, and that a speaker has at least
READING_DRAWS = 2  # of those that are read
OFFSET_PENALTY = 0.5  # weight of an offset's square, beside the log probability of a sentence
MAX_SHIFT, SHARE = 1.0, 0.9  # [nats] of a bound, and share of the sentences that it has to let pass
HUMAN_SPEAKERS = ("george", "jackson", "lucas")

Said = tuple[set[str], Utterance]  # the commands that it may be, and the sound


class Learned(Remembered):
    """A recognizer that knows a speaker's offsets."""

    offsets: dict[str, float] = {}
    shifts = (0.0, 0.0)  # [nats] of the least score, and behind free text

    def meanings(self, found: Found, rejected: Iterable[str] = ()) -> list[whisper.Meaning]:
        plain = super().meanings(found, rejected)
        moved = (
            replace(one, nats=one.nats + sum(self.offsets.get(word, 0.0) for word in _words(one))) for one in plain
        )
        return sorted(moved, key=lambda one: -one.nats)

    def _bounds(self, meaning: whisper.Meaning) -> whisper.Bounds:
        plain, (score, free) = super()._bounds(meaning), self.shifts
        return whisper.Bounds(score=plain.score - score, behind_free=plain.behind_free + free)

    def forget(self) -> None:
        """Be as any other again."""
        self.offsets, self.shifts = {}, (0.0, 0.0)

    def learn_offsets(self, read: list[Said]) -> None:
        """Learn the offsets of the words of numbers."""
        rows = [
            (meanings, right) for may, heard in read for meanings, right in self._judged(may, heard) if any(right)
        ]
        words = sorted({word for meanings, _ in rows for one in meanings for word in _words(one)})
        counts = [np.array([[_words(one).count(word) for word in words] for one in meanings]) for meanings, _ in rows]
        nats = [np.array([one.nats for one in meanings]) for meanings, _ in rows]

        def cost(offsets: Array) -> tuple[float, Array]:
            total, slope = OFFSET_PENALTY * float(offsets @ offsets), 2 * OFFSET_PENALTY * offsets
            for own, score, (_, right) in zip(counts, nats, rows, strict=True):
                chance = score + own @ offsets
                chance = np.exp(chance - np.logaddexp.reduce(chance))
                true = chance * right
                total -= float(np.log(max(true.sum(), 1e-30)))
                slope = slope + own.T @ chance - own.T @ true / max(true.sum(), 1e-30)
            return total, slope

        if words:
            found = minimize(cost, np.zeros(len(words)), jac=True, method="L-BFGS-B").x
            self.offsets = dict(zip(words, found.tolist(), strict=True))

    def learn_bounds(self, read: list[Said]) -> None:
        """Learn by how much the bounds have to give way."""
        short: list[tuple[float, float]] = []
        for may, heard in read:
            for meanings, right in self._judged(may, heard):
                if right[0]:
                    best, bounds = meanings[0], super()._bounds(meanings[0])
                    others = self._other_texts(best, self.search(_samples(heard)))
                    ahead = max((one.nats for one in others), default=-100.0) - best.nats
                    short.append((bounds.score - best.nats, ahead - bounds.behind_free))
        if short:
            score, free = np.clip(np.quantile(short, SHARE, axis=0), 0, MAX_SHIFT).tolist()
            self.shifts = score, free

    def _judged(self, may: set[str], heard: Utterance) -> list[tuple[list[whisper.Meaning], list[bool]]]:
        """The meanings of a sentence, and which are right; none or one of them."""
        meanings = whisper.WhisperRecognizer.meanings(self, self.search(_samples(heard)))
        return [(meanings, [not one.key[2] and _rule(one) in may for one in meanings])] if meanings else []


def _samples(heard: Utterance) -> Array:
    return heard.samples[max(len(heard.before) - round(whisper.LEAD_IN_S * whisper.RATE_HZ), 0) :]


def _words(meaning: whisper.Meaning) -> list[str]:
    return [word for _, value in meaning.key[1] for word in number_words(value)]


def _rule(meaning: whisper.Meaning) -> str:
    numbers = ",".join(f"{value:g}" for _, value in meaning.key[1])
    return f"{meaning.key[0]}({numbers})" if numbers else meaning.key[0]


def main(
    *,
    data: Path,
    into: Path,  # a file of searches
    out: Path,
) -> None:
    once = lru_cache(2048)(lambda pcm, rate, to: resampled(np.frombuffer(pcm), rate, to))
    resampled = whisper.resampled
    whisper.resampled = lambda samples, rate, to: once(np.asarray(samples, float).tobytes(), rate, to)
    recognizer = open_engine(SpeechSettings(engine="whisper")).recognizer
    assert isinstance(recognizer, whisper.WhisperRecognizer)
    learned = Learned(recognizer, into)
    spoken = [(speaker, (may, utterance(sound()))) for speaker, may, _, sound in clips(data)]
    ways: dict[str, Callable[[list[Said]], None]] = {
        "as it is": lambda _: None,
        "offsets of the words of numbers": learned.learn_offsets,
        "bounds that give way": learned.learn_bounds,
    }
    totals = {way: {"people": Counter[str](), "synthetic": Counter[str]()} for way in ways}
    for speaker, count in Counter(speaker for speaker, _ in spoken).items():
        own = [said for name, said in spoken if name == speaker] if count >= MIN_SENTENCES else []
        for draw in range(READING_DRAWS if own else 0):
            order = np.random.default_rng((draw, len(speaker))).permutation(len(own)).tolist()
            for way, learn in ways.items():
                learned.forget()
                learn([own[place] for place in order[:READ]])
                for may, heard in (own[place] for place in order[READ:]):
                    outcome = judged([learned.decide(heard).command], may)
                    totals[way]["people" if speaker in HUMAN_SPEAKERS else "synthetic"][outcome] += 1
    kinds = (RIGHT, REFUSED, STOPPED, WRONG)
    told = [
        {"way": way, "of": kind, "sentences": found.total(), **{one.lower(): found[one] for one in kinds}}
        for way, by_kind in totals.items()
        for kind, found in by_kind.items()
    ]
    out.write_text(json.dumps({"read": READ, "draws": READING_DRAWS, "rows": told}, indent=1))


if __name__ == "__main__":
    run_command(main)
