"""Sentences for people: each has a code, by which the page says it in another language.

`static/i18n/en.json` has the words of each under `console.<code>`, with names in braces for the values in it; a
translation has the same keys. Where a sentence comes from, only its code stands.
"""

import json
from functools import cache
from pathlib import Path
from typing import NamedTuple, Self

KEY = "console."  # before the code, in the catalogue


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
def catalogue() -> dict[str, str]:
    """Return the English texts of the page, among them those of the console, by their keys."""
    return json.loads((static_folder() / "i18n" / "en.json").read_bytes())


def static_folder() -> Path:
    """Return the folder of the page's files: inside the installed package, or next to it in a checkout."""
    root = Path(__file__).parents[1]
    packed = root / "console" / "_static"
    return packed if packed.is_dir() else root / "static"
