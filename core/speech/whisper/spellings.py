"""Every way in which a sentence of the vocabulary may be written down, as an automaton of tokens.

It is generated out of VOCABULARY, the user's own phrases and the words of numbers. It is determinised while it is
searched, so only what may have been said is ever built.
"""

import re
from collections.abc import Callable, Iterable
from functools import cached_property
from itertools import pairwise

import numpy as np

from core.commands import VOCABULARY
from core.commands.stop_moving import AROUND_STOP, SOUGHT_STOP_PHRASES
from core.message import Array
from core.speech.understanding.grammar import HUNDREDTHS, UNITS
from core.speech.understanding.numbers import (
    AND_A_HALF,
    DIGITS,
    HALF,
    NUMBER,
    TEEN_WORDS,
    TENS,
    number_words,
    read_number,
    write_number,
)
from core.speech.understanding.own_phrases import sound_key

MAX_COMPETING_NUMBER = 100  # beyond the bounds of speech: else "seven" would be read as the nearest below
SPELT_DECIMALS = 3  # behind the point: one more than are obeyed, for the same reason
SLOT = re.compile(r"\{(\w+)\}")
POINT_BETWEEN_DIGITS = re.compile(r"(?<=\d) point (?=\d)")
DIGIT = rf"(?:\d|(?:{'|'.join(DIGITS)})\b)"
SECOND_POINT = re.compile(rf"(\.\d+)(?:\.| point )(?=\d)|(\bpoint(?: {DIGIT})+) point(?= {DIGIT})")
MORE_DECIMALS = re.compile(rf"(?:\.|\bpoint )(?:\d{{3}}|{DIGIT} {DIGIT} {DIGIT})")
ANY_NUMBER = re.compile(rf"(?<!\w)(?:{NUMBER})(?!\w)")
SELDOM_SAID = re.compile(rf"\.(?:0|(\d)\1)|\bpoint (?:0|zero|({DIGIT}) \2)")
LIKE_DIGITS = frozenset(("ate", "fore", "for", "free", "to", "too", "tree", "won"))
"""Words that may have been written for a digit, where they stand beside a number."""
BEFORE_ZERO = re.compile(rf"\b(?:{'|'.join(sorted(LIKE_DIGITS))}) (?=0? ?\. ?\d)")
FILLERS = frozenset(("a", "an", "at", "or", "the", "uh", "um"))  # between the two
ENDS = (".", "!")  # of a sentence, if any
WRITTEN_FOR = {"follow world": "follow wall", "follow the world": "follow the wall"}
"""Words that are written where a British voice says a sentence of the vocabulary → that sentence."""
MISHEARD_FOR = dict.fromkeys(("father wall", "father world", "father woe"), "follow wall")
"""The same of an American voice in a room with echoes: nothing else that is written may be nearly as likely."""
MISSPELT = WRITTEN_FOR | MISHEARD_FOR
ROUTE_SPELLINGS = ("route", "root")  # which sound the same
ROOT = re.compile(r"(?<=^start )root\b|((?:^start|^pause|^go on with) the )root\b")

State = frozenset[int]


class Arcs:
    """The tokens that may follow in a state of the automaton."""

    def __init__(self, tokens: Iterable[int], targets: Iterable[State], final: bool) -> None:
        self.tokens: Array = np.array(list(tokens), dtype=np.intp)  # (A,)
        self.targets = list(targets)
        self.final = final  # whether the sentence may end here


class _SpellingBuilder:
    """All spellings of all sentences, with the places between their tokens."""

    def __init__(self, encode: Callable[[str], tuple[int, ...]], own: Iterable[str]) -> None:
        self._encode = encode
        self.arcs: list[dict[int, tuple[int, ...]]] = []  # tuples: 57,000 sets of one place would take 12 MB
        self.free: list[tuple[int, ...]] = []  # places that are reached without a token
        self.begin, self.end = self._new(), self._new()
        last = self._new()
        for pattern in (
            *(words for kind in VOCABULARY for words in kind.words),
            *own,
            *MISSPELT,
            *(f"{word} {phrase}".strip() for word in ("", *AROUND_STOP) for phrase in SOUGHT_STOP_PHRASES),
        ):
            self._write_sentence(pattern, self.begin, last)
        self._skip(last, self.end)
        for mark in ENDS:
            self._write(mark, last, self.end)

    def _new(self) -> int:
        self.arcs.append({})
        self.free.append(())
        return len(self.arcs) - 1

    def _skip(self, source: int, target: int) -> None:
        self.free[source] += (target,)

    def _write(self, text: str, source: int, target: int) -> None:
        *first, last = self._encode(text)
        for token in first:
            place = self._new()
            self._lead(source, token, place)
            source = place
        self._lead(source, last, target)

    def _lead(self, source: int, token: int, target: int) -> None:
        self.arcs[source][token] = (*self.arcs[source].get(token, ()), target)

    def _write_sentence(self, pattern: str, begin: int, end: int) -> None:
        """Add "stop at {x_m} and {y_m} meters": its first word small or capital."""
        words = pattern.split(" ")
        places = [begin, *(self._new() for _ in words[1:]), end]
        alone = len(SLOT.findall(pattern)) == 1
        for i, (word, source, target) in enumerate(zip(words, places, places[1:], strict=False)):
            if SLOT.fullmatch(word):
                self._write_number(source, target)
                if alone:
                    self._write_half(source, target)
            elif word == UNITS[0]:
                for unit in (*UNITS, *HUNDREDTHS) if alone else UNITS:
                    self._write(f" {unit}", source, target)
            else:
                if i > 0 and SLOT.fullmatch(words[i - 1]):
                    comma = self._new()
                    self._write(",", source, comma)
                    self._write(f" {word}", comma, target)
                same = ROUTE_SPELLINGS if word == "route" else (word,)
                for spelling in {*same, word.capitalize() if i == 0 else word}:
                    self._write(f" {spelling}", source, target)

    def _write_half(self, source: int, target: int) -> None:
        """Add "half a" and "two and a half"."""
        self._write(f" {HALF}", source, target)
        whole = self._new()
        self._write_whole(source, whole, whole)
        self._write(AND_A_HALF, whole, target)

    def _write_number(self, source: int, target: int) -> None:
        """Add a number up to 100, in digits or in words; with more decimals and points, too, than any has."""
        negative, digits, words = self._new(), self._new(), self._new()
        self._write(" minus", source, negative)
        self._skip(source, negative)
        self._write_whole(negative, digits, words)
        minus = self._new()
        self._write(" -", source, minus)
        for value in range(MAX_COMPETING_NUMBER + 1):
            self._write(str(value), minus, digits)
        for whole in (digits, words):
            self._skip(whole, target)
        behind = self._new()  # a point: there may be another, which is no number
        self._write_digits(" .", negative, behind)
        self._write_decimals(digits, behind)
        self._write_decimals(behind, target)
        self._skip(behind, target)
        spoken = self._new()
        for whole in (words, negative):
            self._write(" point", whole, spoken)
        for _ in range(SPELT_DECIMALS):
            following = self._new()
            for digit in DIGITS:
                self._write(f" {digit}", spoken, following)
            self._skip(following, target)
            for digit in DIGITS:
                self._write(f" point {digit}", following, target)
            spoken = following

    def _write_decimals(self, source: int, target: int) -> None:
        self._write_digits(".", source, target)
        point = self._new()
        self._write(" point", source, point)
        for digit in range(10):
            self._write(f" {digit}", point, target)

    def _write_digits(self, point: str, source: int, target: int) -> None:
        """Add what stands behind the point. Without a last zero: "0.10" is written where "0.9" was said."""
        place = self._new()
        self._write(point, source, place)
        for count in range(1, SPELT_DECIMALS + 1):
            for value in range(10**count):
                if count == 1 or value % 10:
                    self._write(f"{value:0{count}}", place, target)

    def _write_whole(self, source: int, digits: int, words: int) -> None:
        for value in range(MAX_COMPETING_NUMBER + 1):
            self._write(f" {value}", source, digits)
        for word in (*DIGITS, *TEEN_WORDS, *TENS, "one hundred"):
            self._write(f" {word}", source, words)
        for tens in TENS:
            place = self._new()
            self._write(f" {tens}", source, place)
            for digit in DIGITS[1:]:
                self._write(f" {digit}", place, words)
                self._write(f"-{digit}", place, words)


class Spellings:
    """The automaton. States are sets of places in the spellings."""

    def __init__(self, encode: Callable[[str], tuple[int, ...]], own: Iterable[str] = ()) -> None:
        """`encode`: text → tokens; the pieces of a sentence are encoded one by one. `own`: patterns of the user's."""
        written = _SpellingBuilder(encode, own)
        self._arcs, self._free, self._end = written.arcs, written.free, written.end
        self._states: dict[State, Arcs] = {}
        self.begin = self._closed({written.begin})

    @cached_property
    def tokens(self) -> frozenset[int]:
        """Every token of every spelling."""
        return frozenset(token for arcs in self._arcs for token in arcs)

    def arcs(self, state: State) -> Arcs:
        """Return what may follow in a state."""
        known = self._states.get(state)
        if known is None:
            reached: dict[int, set[int]] = {}
            for place in state:
                for token, targets in self._arcs[place].items():
                    reached.setdefault(token, set()).update(targets)
            closed = [self._closed(targets) for targets in reached.values()]
            known = self._states[state] = Arcs(reached, closed, self._end in state)
        return known

    def _closed(self, places: set[int]) -> State:
        waiting, found = list(places), set(places)
        while waiting:
            fresh = set(self._free[waiting.pop()]) - found
            found |= fresh
            waiting += fresh
        return frozenset(found)


def as_understood(spelling: str) -> str:
    """A spelling as the grammar reads it: small, without its end, "2 point 5" is "2.5", and a route no root."""
    words = ROOT.sub(r"\1route", POINT_BETWEEN_DIGITS.sub(".", _plain(spelling)))
    return MISSPELT.get(words, words)


def sound_of(text: str) -> str:
    """How any text sounds, as letters: "to" and "two" differ in one of them."""
    return sound_key(" ".join(re.findall("[a-z]+", _numbers_in_words(text))))


def words_of(text: str) -> str:
    """Any text as small words, its numbers, too."""
    return " ".join(re.findall("[a-z]+(?:'[a-z]+)*", _numbers_in_words(text)))


def _numbers_in_words(text: str) -> str:
    return ANY_NUMBER.sub(lambda found: f" {' '.join(number_words(read_number(found[0])))} ", as_understood(text))


def misspelt(spelling: str) -> bool:
    """Return whether other words were written than those of the vocabulary."""
    return _plain(spelling) in MISSPELT


def misheard(spelling: str) -> bool:
    """Return whether these words resemble those of the vocabulary only in a room with echoes."""
    return _plain(spelling) in MISHEARD_FOR


def _plain(spelling: str) -> str:
    return spelling.strip().lower().rstrip(".!")


def seldom_said(spelling: str) -> bool:
    """Return whether a number has a zero behind its point, or the same decimal twice."""
    return SELDOM_SAID.search(spelling.lower()) is not None


def count_digits(text: str) -> int:
    """Return how many digits its numbers have, written in digits: 3 of "one and 9 3", 2 of "twelve meters".

    Words beside them that sound like a digit count, too, but in the place of an unspoken zero: 2 of "continue to 3
    meters" and of "continue to 0.5 meters", which is written for 2.5 meters.
    """
    found = ANY_NUMBER.findall(text.lower())
    digits = sum(character.isdigit() for number in found for character in write_number(read_number(number)))
    marked = ANY_NUMBER.sub("#", BEFORE_ZERO.sub("", text.lower().replace("go to", "go")))
    words = [word for word in re.findall(r"[a-z]+|#", marked) if word not in FILLERS]
    return digits + sum("#" in pair and not LIKE_DIGITS.isdisjoint(pair) for pair in pairwise(words))


def one_point(words: str) -> str:
    """Words that are understood, without the second point of a number: all digits behind the first are decimals."""
    return SECOND_POINT.sub(r"\1\2", words)


def has_more_decimals(spelling: str) -> bool:
    """Return whether a number has more digits behind its point than are obeyed, or a second point."""
    words = as_understood(spelling)
    return one_point(words) != words or MORE_DECIMALS.search(words) is not None


def lacks_whole_part(spelling: str) -> bool:
    """Return whether a number begins with its point: what stands before it may not have been heard."""
    words = re.findall(r"[a-z]+|[\d.]+", spelling.lower())
    numerals = {*DIGITS, *TEEN_WORDS, *TENS, "hundred"}
    return any(
        (word.startswith(".") and word != ".")
        or (word == "point" and before not in numerals and not before.isdigit())
        for before, word in pairwise(["", *words])
    )
