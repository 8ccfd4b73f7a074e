"""Codes of the console's sentences, by which the page says them in another language.

`static/i18n/en.json` has each of them under `console.<code>`, with its values as names in braces; a translation has
the same keys. A code is found by the sentence itself, so it is known however the sentence came here: from the core,
from the gate's process or out of the history of an earlier run.
"""

from __future__ import annotations

import re
from functools import cache, lru_cache
from pathlib import Path
from typing import NamedTuple

import msgspec

KEY = "console."  # before the code, in the catalogue
HOLE = re.compile(r"\{(\w+)\}")


class SentenceCode(NamedTuple):
    """The code of a sentence, which keeps its meaning, and the values in it by their names."""

    code: str | None  # None: the sentence has none, and stays English
    values: dict[str, str] | None


NONE = SentenceCode(None, None)


def static_folder() -> Path:
    """Return the folder of the page's files: inside the installed package, or next to it in a checkout."""
    console = Path(__file__).parent
    packed = console / "_static"
    return packed if packed.is_dir() else console.parent / "static"


@lru_cache(maxsize=1024)
def code_of(sentence: str) -> SentenceCode:
    """Find the code of a sentence; the pattern with the most words of its own counts."""
    plain, patterns = _catalogue()
    if sentence in plain:
        return SentenceCode(plain[sentence], {})
    for pattern, code in patterns:
        if (found := pattern.fullmatch(sentence)) is not None:
            return SentenceCode(code, found.groupdict())
    return NONE


@cache
def _catalogue() -> tuple[dict[str, str], list[tuple[re.Pattern[str], str]]]:
    """Return the codes of whole sentences, and the patterns of the others."""
    texts = msgspec.json.decode((static_folder() / "i18n" / "en.json").read_bytes(), type=dict[str, str])
    codes = {text: key.removeprefix(KEY) for key, text in texts.items() if key.startswith(KEY)}
    holed = sorted((text for text in codes if HOLE.search(text)), key=lambda text: -len(HOLE.sub("", text)))
    plain = {text: code for text, code in codes.items() if text not in holed}
    return plain, [(_pattern(text), codes[text]) for text in holed]


def _pattern(text: str) -> re.Pattern[str]:
    literal, *rest = HOLE.split(text)
    parts = [re.escape(literal)]
    for name, then in zip(rest[::2], rest[1::2], strict=True):
        hole = f"(?P={name})" if any(f"(?P<{name}>" in part for part in parts) else f"(?P<{name}>.+?)"
        parts.append(hole + re.escape(then))
    return re.compile("".join(parts), re.DOTALL)
