"""The garbage model: everything that people say and that is no command, as a loop that competes with the commands.

A plain grammar makes a command of every sound: 78 % of ordinary sentences. Against it stand here the phones of the
language, its most common words, the most common of those that resemble a word of a command ("top moving"), and the
words with which commands begin: "stop talking" begins like one and is none. What the loop fits clearly better is
refused. Words and their frequencies are those of the model that comes with pocketsphinx.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path

from core.commands import VOCABULARY
from core.speech.sphinx.jsgf import command_rules, phrases, words_of, written

Pronunciation = tuple[str, ...]
Dictionary = dict[str, tuple[Pronunciation, ...]]

PHONE_WORD = "phone_{}"  # a word that consists of one phone; no dictionary has such
MIN_PHONES = 3  # phones of a competing word; shorter ones fit into everything
REST = "antidisestablishmentarianism"
"""JSGF knows only shares of a whole; this word, which is never said, takes the rest, and so weighs the others."""


def grammar(garbage_model: Iterable[str], price: float) -> str:
    """JSGF: any chain of competing words, each with probability 1/`price`.

    What commands begin with is in the chain too, but for what a measure always follows: all their words would cost
    numbers that are said unclearly.
    """
    others = " | ".join(f"/1/ {word}" for word in dict.fromkeys((*garbage_model, *openings())))
    return written({"other": f"/{price:g}/ {REST} | {others}"}, "<other>+")


@cache
def command_words() -> frozenset[str]:
    """All words of all commands and numbers."""
    return frozenset(words_of(command_rules().values()))


@cache
def openings() -> tuple[str, ...]:
    """List the first words of commands but those before a number: next to them "two point five" would be lost."""
    before_numbers = {words.split(" {")[0] for spec in VOCABULARY for words in spec.words if " {" in words}
    return tuple(sorted({phrase.split()[0] for phrase in phrases()} - before_numbers))


@cache
def fixed_words() -> frozenset[str]:
    """The words of commands that are no part of a number."""
    return frozenset(words_of(phrases()))


def entries(path: Path) -> Iterator[tuple[str, str]]:
    """Read a pronouncing dictionary of CMU's form, line by line → each word and the phones of one way to say it.

    A word that is said in several ways comes several times.
    """
    with path.open(encoding="utf-8") as lines:
        for line in lines:
            name, _, phones = line.strip().partition(" ")
            yield name.partition("(")[0], phones


def read_dictionary(path: Path, words: Collection[str]) -> Dictionary:
    """Return the pronunciations of these of a dictionary's words. All 126,000 would take 62 MB."""
    found: dict[str, tuple[Pronunciation, ...]] = {}
    for word, phones in entries(path):
        if word in words:
            found[word] = (*found.get(word, ()), tuple(phones.split()))
    return found


@cache
def phones_of(path: Path) -> tuple[str, ...]:
    """Return the phones of the language of a dictionary."""
    return tuple(sorted({phone for _, phones in entries(path) for phone in phones.split()}))


def choose(
    dictionary: Dictionary, frequency: Callable[[str], float], count: int, resembling: int = 0
) -> tuple[str, ...]:
    """The `count` most frequent words that are more than one phone away from every word of a command; and the
    `resembling` most frequent that are one phone away from a word of a command that is no number.

    Words that sound like one of a command are in neither: "hear" is as good as "here".
    """
    own = [way for word in sorted(command_words()) for way in dictionary.get(word, ())]
    fixed = [way for word in sorted(fixed_words()) for way in dictionary.get(word, ()) if len(way) >= MIN_PHONES]
    apart: list[str] = []
    alike: list[str] = []
    for word in sorted((word for word in dictionary if word.isalpha()), key=lambda word: (-frequency(word), word)):
        if len(apart) == count and len(alike) == resembling:
            break
        ways = dictionary[word]
        if any(len(way) < MIN_PHONES or way in own for way in ways):
            continue
        if not any(_near(way, other) for way in ways for other in own):
            apart += [word] * (len(apart) < count)
        elif any(_near(way, other) for way in ways for other in fixed):
            alike += [word] * (len(alike) < resembling)
    return (*apart, *alike)


def _near(a: Sequence[str], b: Sequence[str]) -> bool:
    """Return whether inserting, dropping or changing at most one phone turns a into b."""
    if len(a) > len(b):
        a, b = b, a
    if len(b) - len(a) > 1:
        return False
    same = next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), len(a))
    return list(a[same + (len(a) == len(b)) :]) == list(b[same + 1 :])
