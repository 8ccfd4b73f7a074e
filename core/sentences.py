"""Sentences for people: each has a code, by which the page says it in another language.

`static/i18n/en.json` has the words of each under `console.<code>`, with names in braces for the values in it; a
translation has the same keys. Where a sentence comes from, only its code stands.
"""

import json
import operator
import re
from functools import cache
from pathlib import Path
from typing import Final, Literal, NamedTuple, Self

KEY = "console."  # before the code, in the catalogue
Language = Literal["en", "de"]  # of the page
ENGLISH: Final = "en"
HOLE = re.compile(r"\{(\w+)\}")
AFTER_SENTENCE = re.compile(r" [A-Z]")  # what a hole at the begin of a sentence holds is one itself
WITHIN = r"(?:(?![.!?] [“A-Z]).)"  # a letter in a hole of a sentence
INTRODUCED = r"(?:(?![.!?] [“A-Z]|: ).)"  # … at its begin: what introduces a sentence is no part of it
SENTENCE_END = re.compile(r"(?<=[.!?]) (?=\S)")  # between sentences that were put together
ABOUT = re.compile(r"(\S+: )(.+)", re.DOTALL)  # a sentence about something that it begins with
CLAUSE = re.compile(r"[A-Z].*\.", re.DOTALL)  # written as a sentence
COUNTED = re.compile(r"\d+ (?:×|because) ")  # begins reasons
REASON_END = re.compile(r"; (?=\d)")


class SentenceCode(NamedTuple):
    """The code of a sentence, which keeps its meaning, and the values in it by their names."""

    code: str | None = None  # None: the sentence has none, and stays English
    values: dict[str, str] | None = None


class Statement(str):
    """The English words of a code, which know it: `Statement("lease.took_over", name="Ann")` reads "Ann took over."

    Without values it is a pattern, which a call fills in. What is put together of it with other words is a plain
    string, and has no code. Raises KeyError for a code, or a value, that is not there.
    """

    said: SentenceCode

    def __new__(cls, code: str, /, **values: object) -> "Statement":
        """Put `values` into the words of `code`."""
        if not values:
            return _pattern(code)
        text = catalogue()[KEY + code]
        texts = {name: str.__str__(str(value)) for name, value in values.items()}  # plain, whatever they are
        return cls.of(text.format_map(texts), code, texts)

    @classmethod
    def of(cls, text: str, code: str | None, values: dict[str, str] | None) -> Self:
        """Make the sentence that another process, or an earlier run, put into these words."""
        sentence = super().__new__(cls, text)
        sentence.said = SentenceCode(code, values)
        return sentence

    def __call__(self, **values: object) -> Self:
        """Fill in the values of a pattern."""
        return type(self)(self.said.code or "", **values)

    def __str__(self) -> Self:  # so that the code is not lost on the way through an error
        return self

    def __reduce__(self) -> tuple[object, ...]:
        return Statement.of, (plain(self), *self.said)


def coded(text: str, said: SentenceCode) -> str:
    """The words of a sentence and its code, as they came from elsewhere → the sentence."""
    return text if said.code is None else Statement.of(text, *said)


def code_of(text: str) -> SentenceCode:
    """Return the code of a sentence."""
    return text.said if isinstance(text, Statement) else SentenceCode()


def plain(value: object) -> str:
    """A sentence → its words alone: what `msgspec` calls for what it cannot write. Raises NotImplementedError."""
    if not isinstance(value, Statement):
        raise NotImplementedError(f"Objects of type {type(value).__name__} cannot be written.")
    return str.__str__(value)


@cache
def _pattern(code: str) -> Statement:
    """The sentence of a code without values; a pilot asks for eight with every frame."""
    return Statement.of(catalogue()[KEY + code], code, {})


@cache
def catalogue(name: str = ENGLISH) -> dict[str, str]:
    """Return the texts of the page in a language, among them those of the console, by their keys."""
    return json.loads((static_folder() / "i18n" / f"{name}.json").read_bytes())


class PageTexts:
    """The page's texts in one of its languages, as `static/js/ui/texts.js` says them: for a file that leaves it."""

    def __init__(self, language: Language = ENGLISH) -> None:
        self.language = language
        self._texts = catalogue(language)
        self._uncoded = _sentences(language)

    def t(self, key: str, **values: object) -> str:
        """Return a text by its key, with values in the place of their names. Raises KeyError."""
        return self._texts[key].format_map(values)

    def said(self, sentence: str) -> str:
        """Return a sentence of the console in this language, by its code or its words; else as it came."""
        code, values = code_of(sentence)
        if code is not None:
            return self._filled(self._texts[KEY + code], values or {})
        if (words := self._uncoded.get(sentence)) is not None or self.language == ENGLISH:
            return words or sentence
        if COUNTED.match(sentence) and len(reasons := REASON_END.split(sentence)) > 1:
            return "; ".join(map(self.said, reasons))
        for row in _rows(self.language):
            if row.longest in sentence and (found := row.pattern().fullmatch(sentence)):
                return self._filled(row.words, found.groupdict())
        if len(parts := SENTENCE_END.split(sentence)) > 1:
            return " ".join(map(self.said, parts))
        if about := ABOUT.fullmatch(sentence):
            return about[1] + self.said(about[2])
        if not CLAUSE.fullmatch(sentence):
            return sentence
        clause = f"{sentence[0].lower()}{sentence[1:-1]}"
        words = self.said(clause)
        return sentence if words == clause else f"{words[0].upper()}{words[1:]}."

    def _filled(self, words: str, values: dict[str, str]) -> str:
        return HOLE.sub(lambda hole: self.said(values[hole[1]]), words)


@cache
def _sentences(language: Language) -> dict[str, str]:
    """Return the sentences of the console and the words of a language for them; without those of English."""
    if language == ENGLISH:
        return {}
    other = catalogue(language)
    coded = {text: other[key] for key, text in catalogue().items() if key.startswith(KEY)}
    return coded | catalogue(f"{language}.console") | catalogue(f"{language}.errors")


class _SentencePattern(NamedTuple):
    """A sentence of the console with holes."""

    longest: str  # of its fixed pieces
    pieces: tuple[str, ...]  # fixed, name, fixed …
    words: str  # of the other language

    def pattern(self) -> re.Pattern[str]:
        return _compiled(self.pieces)


@cache
def _compiled(pieces: tuple[str, ...]) -> re.Pattern[str]:
    """Fixed pieces and names → its expression.

    Only a hole at either end takes more than one sentence; one in quotation marks ends with them.
    """
    words = re.escape(pieces[0])
    for number, name in enumerate(pieces[1::2]):
        before, after = pieces[2 * number], pieces[2 * number + 2]
        begins = number == 0 and before == ""
        if before.endswith("“"):
            hole = "[^“”]"
        elif (after == "" and number == len(pieces) // 2 - 1) or (begins and AFTER_SENTENCE.match(after)):
            hole = "."
        else:
            hole = INTRODUCED if begins else WITHIN
        words += f"(?P<{name}>{hole}+){re.escape(after)}"
    return re.compile(words, re.DOTALL)


@cache
def _rows(language: Language) -> list[_SentencePattern]:
    """Every sentence of the console that has holes, those that say most first, as `allRows` of the page."""
    found = list[tuple[int, _SentencePattern]]()
    for text, words in _sentences(language).items():
        pieces = tuple(HOLE.split(text))
        fixed, names = pieces[::2], pieces[1::2]
        if names and len(set(names)) == len(names) and re.search(r"\w{2}|×", " ".join(fixed)):
            found.append((-len("".join(fixed)), _SentencePattern(max(fixed, key=len), pieces, words)))
    return [row for _, row in sorted(found, key=operator.itemgetter(0))]


def static_folder() -> Path:
    """Return the folder of the page's files: inside the installed package, or next to it in a checkout."""
    root = Path(__file__).parents[1]
    packed = root / "console" / "_static"
    return packed if packed.is_dir() else root / "static"
