"""Table 2's motion commands by all English voices of espeak-ng: `python -m tests.benchmarks.accents`.

Eight accents, and the male and female voices of the American one, at their natural pace. Each sentence stands in half
a second of faint noise, is cut by the endpointer, and is read by the engine, as a recording is by `beckon hear`. Told
for every voice: right, refused, wrong; every wrong motion is listed, with `--misses` every miss. `--others` speaks
other sentences, in turn a tenth slower and faster; `--drawn SEED` draws numbers with decimals for every voice;
`--noisy FOLDER` speaks sentences in nine noises (FOLDER holds speech_real). As with people, no two readings of a
sentence are the same: `--times N` speaks all of them N times.
"""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np

from core.message import Array
from core.speech.recognition.engines import ENGINES, open_engine
from core.speech.recognition.recognizer import for_words
from core.speech.settings import SpeechSettings
from core.speech.synthesis import ENGLISH_VOICES, NATURAL_WORDS_MIN, VoiceSettings, speak
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.voices import RIGHT, STOPPED, WRONG, Noises, as_cut, outcome_of_all
from tests.benchmarks.word_hearing import padded

SENTENCES = (
    "turn left",
    "turn right",
    "come here",
    "follow me",
    "follow the wall",
    "continue 1 meters",
    "continue 2.5 meters",
    "continue 0.7 meters",
    "continue 4 meters",
    "continue 3.2 meters",
    "stop at 2 and 1",
    "stop at 1.5 and 0.5",
    "stop at 3 and -1",
    "stop at 0.8 and 2.4",
    "go to 4 and 2",
)
OTHERS = (
    "follow wall",
    "follow the wall",
    "turn right",
    "turn left",
    "come here",
    "follow me",
    "continue 3 meters",
    "continue 1.4 meters",
    "continue 1.9 meters",
    "continue 0.9 meters",
    "continue 2 meters",
    "stop at 1 and 3",
    "stop at 2.2 and -0.7",
    "stop at 4 and 2.5",
)
IN_NOISE = (
    "turn left",
    "turn right",
    "come here",
    "follow me",
    "follow the wall",
    "stop moving",
    "continue 1.25 meters",
    "continue 2.75 meters",
    "continue 1.7 meters",
    "continue 0.6 meters",
    "stop at 1.5 and 2.25",
    "stop at 2 and -3",
    "stop at -0.8 and 3.2",
)
PACES = (0.9, 1.1)
DRAWN_PACES = (0.9, 1.0, 1.1)


def drawn_sentences(seed: int) -> list[tuple[str, float]]:
    """Sentences with numbers that have decimals, with and without a whole part, and their paces."""
    chance = np.random.default_rng(seed)

    def below_one() -> str:
        return f"0.{chance.integers(1, 10)}"

    def above(bound: int) -> str:
        return f"{chance.integers(1, bound)}.{chance.integers(1, 10)}"

    texts = (
        f"continue {below_one()} meters",
        f"continue {above(5)} meters",
        f"continue {above(5)} meters",
        f"stop at {below_one()} and {above(4)}",
        f"stop at {above(4)} and {below_one()}",
        f"stop at {below_one()} and {below_one()}",
        f"stop at {above(4)} and {above(4)}",
    )
    return [(text, DRAWN_PACES[n % 3]) for n, text in enumerate(texts)]


def said(text: str, voice: str, seed: int, pace: float = 1.0) -> Array:
    """A sentence at 16 kHz (N,), with faint noise around it."""
    settings = VoiceSettings(voice=voice, speed=round(pace * NATURAL_WORDS_MIN))
    return padded(for_words(speak(text, settings)).samples[:, 0], seed)


def main(
    *,
    engine: Annotated[str, ENGINES] = "whisper",
    voices: Sequence[str] = ENGLISH_VOICES,
    misses: bool = False,
    others: bool = False,  # other sentences, at other paces
    drawn: int | None = None,  # numbers drawn for every voice
    noisy: Path | None = None,  # sentences in nine noises
    times: int = 1,  # how often each sentence is spoken
) -> None:
    settings = SpeechSettings(engine=engine)
    decide = as_cut(open_engine(settings).recognizer, settings)
    sentences = [(text, 1.0) for text in (IN_NOISE if noisy else SENTENCES)]
    if others:
        sentences = [(text, PACES[n % 2]) for n, text in enumerate(OTHERS)]
    noises = Noises(noisy) if noisy else None
    shares: list[float] = []
    wrong = 0
    for number, voice in enumerate(voices):
        found: Counter[str] = Counter()
        if drawn is not None:
            sentences = drawn_sentences(drawn + number)
        for seed, (text, pace) in enumerate(times * sentences):
            spoken = said(text, voice, seed, pace)
            for where, samples in noises.around(spoken) if noises else [("quiet", spoken)]:
                decisions = decide(samples)
                result = outcome_of_all(text, decisions)
                found[result] += 1
                if result in (WRONG, STOPPED) or (misses and result != RIGHT):
                    heard = ", ".join(one.echo for one in decisions)
                    print_row(f"  {result} {voice} {where} “{text}” → {heard}")
        shares.append(found[RIGHT] / found.total())
        wrong += found[WRONG]
        print_row({"voice": voice, "of": found.total(), **found})
    told = {"mean_share": round(float(np.mean(shares)), 3), "least": round(min(shares), 3), "wrong": wrong}
    print_row(told)


if __name__ == "__main__":
    run_command(main)
