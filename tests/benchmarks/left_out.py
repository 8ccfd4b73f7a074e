"""Thresholds of numbers, fitted without the speaker who is scored: `python -m tests.benchmarks.left_out --data DATA`.

DATA holds speech_human_digits, speech_commands_tts and strangers/words/phr.tsv. Speakers are people (their digits
within synthetic sentences), voices of flite, and those of espeak-ng, who say drawn numbers, number phrases and odd
numbers; voices of one accent are one speaker, in whichever pitch. Every clip is one utterance and is searched once.

For each speaker the thresholds that decide about a number are chosen anew, one after the other, twice over, on all
others: as many right as possible, where a wrong one costs `--price` right ones. Told, with those and those in use:
right, refused, stopped, wrong, and how many wrong ones move without being said back. `--every N`: every Nth clip.
`--into FILE` keeps every search as it is ready, and goes on with those that it holds.
"""

import hashlib
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import msgspec

from core.message import Array
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import for_words
from core.speech.settings import SpeechSettings
from core.speech.synthesis import ENGLISH_VOICES, NATURAL_WORDS_MIN, VoiceSettings, speak
from core.speech.whisper import recognizer as whisper
from core.speech.whisper.joint_search import Found
from tests.benchmarks.accents import drawn_sentences, said
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.phrases import (
    NUMBER_PHRASES,
    SPEAKABLE,
    UNUSED_VOICES,
    as_it_sounds,
    as_typed,
    judged,
    number_phrases,
    odd_numbers,
    rule_of,
    said_back,
)
from tests.benchmarks.voices import REFUSED, RIGHT, STOPPED, WRONG, speaker_of, utterance
from tests.benchmarks.word_hearing import padded
from tests.benchmarks.word_scenes import Clip as Recorded
from tests.benchmarks.word_scenes import clips_of, synthetic

DRAWN_SEED = 300
GRID: dict[str, tuple[float, ...]] = {
    "lead": (0.4, 0.7, 1.03, 1.3, 1.63, 2.2, 3.0),  # [nats] over all other meanings
    "score": (-7.0, -8.0, -9.0),
    "behind_free": (3.0, 4.0, 5.0),
    "OTHERWISE_BEHIND_NATS": (1.0, 2.0, 3.0, 4.0),
    "ALIKE_LETTERS": (1.0, 2.0, 3.0),
    "UNHEARD_WORDS_NATS": (0.0, 1.0, 1.5, 2.0, 3.0),
    "NEAR_FREE_NATS": (0.5, 1.0, 1.5, 2.0),
}
"""What each threshold may be; `lead`, `score` and `behind_free` are those of numbers."""
USED = {
    "lead": round(whisper.NUMBER_THRESHOLDS.reject, 2),
    "score": whisper.NUMBER_BOUNDS.score,
    "behind_free": whisper.NUMBER_BOUNDS.behind_free,
    **{name: getattr(whisper, name) for name in GRID if name.isupper()},
}

Thresholds = tuple[float, ...]  # in the order of GRID
Clip = tuple[str, set[str], str, Callable[[], Array]]  # the speaker, what the words may be, the words, the sound


class Remembered(whisper.WhisperRecognizer):
    """A recognizer that searches each sound once, and keeps what it found in a file."""

    def __init__(self, other: whisper.WhisperRecognizer, kept: Path | None) -> None:
        self.__dict__.update(other.__dict__)
        lines = kept.read_text().splitlines() if kept is not None and kept.exists() else []
        self._known = dict(msgspec.json.decode(line, type=tuple[str, Found]) for line in lines)
        self._kept = kept

    def search(self, samples: Array, begun: tuple[int, ...] = ()) -> Found:
        sound = hashlib.sha256(samples.tobytes() + repr(begun).encode()).hexdigest()
        if (known := self._known.get(sound)) is None:
            known = self._known[sound] = super().search(samples, begun)
            if self._kept is not None:
                with self._kept.open("ab") as file:
                    file.write(msgspec.json.encode((sound, known)) + b"\n")
        return known


def clips(data: Path) -> Iterator[Clip]:
    """All that is said."""
    for kind, clip in (*clips_of(data / "speech_human_digits"), *(("", one) for one in synthetic(data, "command"))):
        yield (
            speaker_of(kind.removeprefix("espeak:"), clip.name).split()[0],
            rules(clip.text),
            clip.text,
            partial(_samples, clip),
        )
    for number, voice in enumerate(ENGLISH_VOICES):
        for seed, (words, pace) in enumerate(drawn_sentences(DRAWN_SEED + number)):
            yield voice, rules(words), words, partial(said, words, voice, seed, pace)
    phrases = (one for one in number_phrases(data) if SPEAKABLE.fullmatch(one[0]))
    for number, (words, may) in enumerate((*islice(phrases, NUMBER_PHRASES), *odd_numbers())):
        voice, pitch = UNUSED_VOICES[number % len(UNUSED_VOICES)]
        yield voice, as_it_sounds(words, may), words, partial(_pitched, words, voice, pitch, number)


def _samples(clip: Recorded) -> Array:
    return clip.samples


def _pitched(words: str, voice: str, pitch: int, seed: int) -> Array:
    sound = speak(words, VoiceSettings(voice=voice, pitch=pitch, speed=NATURAL_WORDS_MIN))
    return padded(for_words(sound).samples[:, 0], seed)


def rules(words: str) -> set[str]:
    """The command that these words are, within the bounds of speech or not."""
    command = as_typed(words)
    return set() if command is None else {rule_of(command)}


class Scored:
    """What becomes of every clip with any thresholds."""

    def __init__(self, recognizer: Remembered, spoken: list[Clip], price: float) -> None:
        self._recognizer, self._price = recognizer, price
        self._spoken = [(speaker, may, utterance(sound())) for speaker, may, _, sound in spoken]
        self._known: dict[Thresholds, list[str]] = {}
        self.told: dict[Thresholds, list[str]] = {}
        self.unsaid = 0

    def outcomes(self, chosen: Thresholds) -> list[str]:
        """What became of each clip."""
        if chosen not in self._known:
            values = dict(zip(GRID, chosen, strict=True))
            whisper.NUMBER_THRESHOLDS = replace(whisper.NUMBER_THRESHOLDS, reject=values.pop("lead"))
            whisper.NUMBER_BOUNDS = whisper.Bounds(score=values.pop("score"), behind_free=values.pop("behind_free"))
            for name, value in values.items():
                setattr(whisper, name, value)
            decisions = [self._recognizer.decide(one) for *_, one in self._spoken]
            self._known[chosen] = [
                judged([one.command], may) for one, (_, may, *_) in zip(decisions, self._spoken, strict=True)
            ]
            self.told[chosen] = [one.echo for one in decisions]
            wrong = (one for one, what in zip(decisions, self._known[chosen], strict=True) if what == WRONG)
            self.unsaid += sum(not said_back([one]) for one in wrong)
        return self._known[chosen]

    def fitted(self, without: str) -> Thresholds:
        """The thresholds that are best for all other speakers; those in use where others are no better."""
        best = tuple(USED[name] for name in GRID)
        for place, values in [*enumerate(GRID.values())] * 2:
            tried = (best, *((*best[:place], value, *best[place + 1 :]) for value in values))
            best = max(tried, key=lambda one: self._worth(one, without))
        return best

    def _worth(self, chosen: Thresholds, without: str) -> float:
        found = Counter(
            what
            for what, (speaker, *_) in zip(self.outcomes(chosen), self._spoken, strict=True)
            if speaker != without
        )
        return found[RIGHT] - self._price * found[WRONG]


def main(
    *,
    data: Path,
    every: int = 1,
    into: Path | None = None,  # a file of searches
    price: float = 20.0,
) -> None:
    recognizer = open_engine(SpeechSettings(engine="whisper")).recognizer
    assert isinstance(recognizer, whisper.WhisperRecognizer)
    spoken = list(clips(data))[::every]
    scored = Scored(Remembered(recognizer, into), spoken, price)
    used = tuple(USED[name] for name in GRID)
    totals: dict[str, Counter[str]] = defaultdict(Counter)

    for speaker in dict.fromkeys(speaker for speaker, *_ in spoken):
        own = [place for place, one in enumerate(spoken) if one[0] == speaker]
        fitted = scored.fitted(speaker)
        row: dict[str, Any] = {"speaker": speaker, "of": len(own)}
        for name, thresholds in (("left out", fitted), ("in use", used)):
            outcomes = scored.outcomes(thresholds)
            found = Counter(outcomes[place] for place in own)
            totals[name] += found
            row[name] = {one: found[one] for one in (RIGHT, REFUSED, STOPPED, WRONG) if found[one]}
        changed = zip(GRID, fitted, used, strict=True)
        print_row(row | {"thresholds": {name: value for name, value, before in changed if value != before}})
        for place in own:
            if scored.outcomes(fitted)[place] == WRONG:
                print_row({WRONG: spoken[place][2], "heard": scored.told[fitted][place]})
    for name, found in totals.items():
        share = round(100 * found[WRONG] / found.total(), 2)
        print_row({"all": name, "of": found.total(), **found, "wrong_percent": share})
    print_row({"moved without being said back": scored.unsaid})


if __name__ == "__main__":
    run_command(main)
