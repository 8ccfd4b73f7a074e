"""Everything that people say and that is no command, as a loop that competes with the commands in the same grammar.

A plain grammar makes a command of every sound: 78 % of ordinary sentences. Beside the commands stand here the phones
of the language, its most common words, as far as they cannot be confused with a word of a command, and the words with
which commands begin: "stop talking" begins like one and is none. What the loop fits better is refused. Words and
their frequencies are those of the model that comes with pocketsphinx.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path

from core.speech.jsgf import command_rules, phrases, words_of, written

Pronunciation = tuple[str, ...]

PHONE_WORD = "phone_{}"  # a word that consists of one phone; no dictionary has such
SHORTEST = 3  # phones of a competing word; shorter ones fit into everything
REST = "antidisestablishmentarianism"
"""JSGF knows only shares of a whole; this word, which nobody says, takes the rest, and so prices the others."""


def grammar(competing: Iterable[str], price: float, share: float) -> str:
    """JSGF: a command, or any chain of competing words, each with probability 1/`price`, `share` for the first.

    What commands begin with is in the chain too, but for what a measure always follows: all their words would cost
    numbers that are said unclearly.
    """
    others = " | ".join(f"/1/ {word}" for word in (*competing, *openings()))
    rules = command_rules() | {"other": f"/{price:g}/ {REST} | {others}"}
    return written(rules, f"/1/ <command> | /{share:g}/ <other>+")


def is_competing(word: str) -> bool:
    """Whether a heard word stands for anything but a command."""
    return word not in command_words()


@cache
def command_words() -> frozenset[str]:
    """All words of all commands and numbers."""
    return frozenset(words_of(command_rules().values()))


@cache
def openings() -> tuple[str, ...]:
    """The first words of commands, without that of CONTINUE: beside it "two point five" would be lost."""
    return tuple(sorted({phrase.split()[0] for phrase in phrases()} - {"continue"}))


@cache
def read_dictionary(path: Path) -> dict[str, tuple[Pronunciation, ...]]:
    """A pronouncing dictionary of CMU's form → the pronunciations of every word."""
    found: dict[str, tuple[Pronunciation, ...]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        name, *phones = line.split()
        word = re.sub(r"\(\d+\)$", "", name)
        found[word] = (*found.get(word, ()), tuple(phones))
    return found


def phones_of(dictionary: dict[str, tuple[Pronunciation, ...]]) -> tuple[str, ...]:
    """The phones of the language."""
    return tuple(sorted({phone for ways in dictionary.values() for way in ways for phone in way}))


def choose(
    dictionary: dict[str, tuple[Pronunciation, ...]], frequency: Callable[[str], float], count: int
) -> tuple[str, ...]:
    """The `count` most frequent words that are more than one phone away from every word of a command."""
    own = [way for word in sorted(command_words()) for way in dictionary.get(word, ())]
    chosen: list[str] = []
    for word in sorted((word for word in dictionary if word.isalpha()), key=lambda word: (-frequency(word), word)):
        if len(chosen) == count:
            break
        ways = dictionary[word]
        if all(len(way) >= SHORTEST and not any(_near(way, other) for other in own) for way in ways):
            chosen.append(word)
    return tuple(chosen)


def _near(a: Sequence[str], b: Sequence[str]) -> bool:
    """Whether at most one phone must be inserted, dropped or changed to get from a to b."""
    if len(a) > len(b):
        a, b = b, a
    if len(b) - len(a) > 1:
        return False
    same = next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), len(a))
    return list(a[same + (len(a) == len(b)) :]) == list(b[same + 1 :])
