"""Two texts word by word: what was substituted, deleted and inserted (Levenshtein), after writing both alike."""

import re
import unicodedata
from collections.abc import Sequence
from typing import Literal

import numpy as np

from core.errors import BadInput
from core.message import message
from core.speech.understanding.numbers import DIGITS, WHOLE_WORDS

Kind = Literal["same", "substituted", "deleted", "inserted"]

MOST_WORDS = 5_000  # of one text: the table of distances has a cell for every pair of words
MAX_CHARACTERS = 1_000_000  # characters
END_OF_PHRASE = re.compile(r"[;:!?\n\r]|[.,](?![0-9])|[.,]$")
WORD = re.compile(r"-?(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)|[^\W\d_]+(?:['’][^\W\d_]+)*")
SPELLINGS = {"metre": "meter", "metres": "meters"}


@message
class Pair:
    """A word of the original with the word recognized for it."""

    kind: Kind
    original: str  # "" where something was inserted
    heard: str  # "" where a word was deleted
    phrase: int  # of the original, from 0; an inserted word belongs to the phrase of the word before it


def phrases_of(text: str) -> list[list[str]]:
    """A text → its phrases as lists of plain words: small letters, no punctuation, numbers in words.

    Phrases end at a line's end and at ; : . , ! ? (not within a number). Raises BadInput when it is too long.
    """
    if len(text) > MAX_CHARACTERS:
        raise BadInput(f"A text of {len(text):,} characters is too long to compare; cut it into parts.")
    plain = unicodedata.normalize("NFKC", text).casefold().replace("−", "-")
    found = [_words(part) for part in END_OF_PHRASE.split(plain)]
    phrases = [words for words in found if words]
    count = sum(map(len, phrases))
    if count > MOST_WORDS:
        raise BadInput(f"A text of {count:,} words is too long to compare; cut it into parts of {MOST_WORDS:,}.")
    return phrases


def _words(text: str) -> list[str]:
    words: list[str] = []
    for word in WORD.findall(text):
        if word[-1].isdigit():
            words += number_words(word)
        else:
            plain = str(word).replace("’", "'")
            words.append(SPELLINGS.get(plain, plain))
    return words


def number_words(digits: str) -> list[str]:
    """'-12.5' → ['minus', 'twelve', 'point', 'five']; what is too long for words is read digit by digit."""
    sign = ["minus"] if digits.startswith("-") else []
    whole, dot, decimals = digits.lstrip("-").partition(".")
    tail = ["point", *(DIGITS[int(digit)] for digit in decimals)] if dot else []
    if len(whole) > 3 or whole[:1] in ("", "0"):
        return [*sign, *(DIGITS[int(digit)] for digit in whole), *tail]
    hundreds, rest = divmod(int(whole), 100)
    words = [DIGITS[hundreds], "hundred"] if hundreds else []
    if rest or not hundreds:
        words += WHOLE_WORDS[str(rest)].split()
    return [*sign, *words, *tail]


def align(original: Sequence[Sequence[str]], heard: Sequence[str]) -> tuple[Pair, ...]:
    """Phrases of the original and the words heard → all words side by side with the fewest differences.

    Of equal ways the one that substitutes is taken before the one that deletes and inserts.
    """
    words = [word for phrase in original for word in phrase]
    places = [number for number, phrase in enumerate(original) for _ in phrase]
    table = _distances(words, heard)
    pairs: list[Pair] = []
    i, j = len(words), len(heard)
    while i or j:
        here = table[i, j]
        phrase = places[max(i - 1, 0)] if places else 0
        if i and j and here == table[i - 1, j - 1] + (words[i - 1] != heard[j - 1]):
            i, j = i - 1, j - 1
            kind: Kind = "same" if words[i] == heard[j] else "substituted"
            pairs.append(Pair(kind=kind, original=words[i], heard=heard[j], phrase=phrase))
        elif i and here == table[i - 1, j] + 1:
            i -= 1
            pairs.append(Pair(kind="deleted", original=words[i], heard="", phrase=phrase))
        else:
            j -= 1
            pairs.append(Pair(kind="inserted", original="", heard=heard[j], phrase=phrase))
    return tuple(reversed(pairs))


def _distances(words: Sequence[str], heard: Sequence[str]) -> np.ndarray[tuple[int, int], np.dtype[np.int16]]:
    """Fewest differences between the first i words and the first j heard, (N+1, M+1)."""
    names = {word: number for number, word in enumerate({*words, *heard})}
    ours = np.array([names[word] for word in words], np.int32)
    theirs = np.array([names[word] for word in heard], np.int32)
    along = np.arange(len(heard) + 1, dtype=np.int32)
    table = np.zeros((len(words) + 1, len(heard) + 1), np.int16)
    table[0] = along
    for i, word in enumerate(ours, 1):
        above = table[i - 1].astype(np.int32)
        row = above + 1
        row[1:] = np.minimum(row[1:], above[:-1] + (theirs != word))
        table[i] = np.minimum.accumulate(row - along) + along  # insertions: from any place further left
    return table
