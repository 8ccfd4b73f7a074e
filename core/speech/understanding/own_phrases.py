"""Phrases of the user's own for the commands of the vocabulary, out of a `phrases.toml`:

    come_here = ["come to papa"]
    continue = ["drive {distance_m} meters"]

A phrase that sounds like one of another command, or says another motion than its command's, is refused when the file
is read.
"""

import difflib
import re
import tomllib
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from core.commands import SPECS, VOCABULARY
from core.commands.command import CommandSpec
from core.commands.routes import START_ROUTE
from core.commands.stop_at import STOP_AT, TO_PLACE
from core.commands.stop_moving import AROUND_STOP, STOP_MOVING
from core.errors import BadInput
from core.files import text_of
from core.speech.understanding.grammar import (
    OTHER_LENGTHS,
    OTHER_UNITS,
    OTHER_WORDS,
    OwnPhrase,
    OwnPhrases,
    compiled,
    may_mean_stop,
    says_stop,
    slips,
)

MOST_BYTES, MOST_PHRASES = 20_000, 50
LEAST_LETTERS, MAX_LETTERS = 3, 60  # of a phrase
PHRASE = re.compile(r"[a-z]+(?: (?:[a-z]+|\{\w+\}))*")
SLOT = re.compile(r"\{(\w+)\}")
SYLLABLE = re.compile(r"[aeiouy]+(?!\b)|[aiouy]+\b|\b[st]?he\b|\bme\b")  # another last e is silent
MIN_SYLLABLES = 2  # of a phrase that moves the robot; a number is one
EVERYDAY_WORDS = re.compile(
    rf"(?:(?:{'|'.join(AROUND_STOP)}|a|an|and|are|i|in|is|it|of|on|that|the|this|to|we|yes|you)\b ?)*"
)
"""Words that are in all talk: a phrase of these alone moves nothing."""
STOPS_ABROAD = re.compile(
    r"\b(?:alto|anhalten|arret|arreter?|aufhoeren|basta|emergency|fermat?[io]?|ferma|halten?|nein|nicht|non|notaus"
    r"|notfall|nunca|par[ae]r?|pas|stehen(?:bleiben)?)\b"
)
"""Words that mean stop, or not, in other languages and in need."""
CONTRADICTIONS = {
    "turn_left": "right",
    "turn_right": "left",
    "continue": "back|backwards?|behind|reverse|retreat|left|right",
    "come_here": "away|leave",
    "follow_me": "away|leave|lead",
    "stop_at": r"x \{y_m\}|y \{x_m\}",
}
"""Words that say another motion than that of the command."""
OTHER_MEASURE = re.compile(rf"\}} (?:{OTHER_LENGTHS}|{OTHER_UNITS})\b")
SOUNDS_ALIKE = (
    (r"(?<=[a-z]{2})e\b", ""),
    ("ph|v", "f"),
    ("gh(?=t)", ""),
    ("gh?|ck|q|c(?![eiyh])", "k"),
    ("(?:t|s)?ch|sh|j", "s"),
    ("c|z", "s"),
    ("x", "ks"),
    (r"\bkn", "n"),
    (r"\bwr", "r"),
    ("b", "p"),
    ("d|th", "t"),
    ("n", "m"),
    ("[aeiouy]+[hw]?", "a"),
    (" ", ""),
    (r"(.)\1+", r"\1"),
)
"""Letters, and one that stands for all that sound like them; in this order."""


def own_phrases(path: str) -> OwnPhrases:
    """Read the phrases of a file; "": none. Raises BadInput, which names the pair that is too close."""
    if not path:
        return ()
    file = Path(path)
    try:
        file = file.expanduser()
        if file.stat().st_size > MOST_BYTES:
            raise BadInput(f"{file.name!r} is too long for a file of phrases.")
        entries = tomllib.loads(text_of(file.read_bytes(), file.name))
    except (ValueError, RecursionError) as trouble:
        raise BadInput(f"{file.name!r} is not valid TOML: {trouble}.") from None
    except (OSError, RuntimeError) as trouble:  # RuntimeError: no such home
        why = getattr(trouble, "strerror", None) or trouble
        raise BadInput(f"The phrases in {file.name!r} cannot be read ({why}).") from None
    try:
        phrases = tuple(_phrase(words, spec) for spec, words in _listed(entries))
        _check_apart(phrases)
    except BadInput as trouble:
        raise BadInput(f"{file.name!r}: {trouble}") from None
    return phrases


def sound_key(phrase: str) -> str:
    """Letters that stand for how words sound: those that are mistaken for each other are one."""
    key = SLOT.sub("#", phrase)
    for letters, one in SOUNDS_ALIKE:
        key = re.sub(letters, one, key)
    return key


def too_close(one: str, other: str) -> bool:
    """Return whether two phrases sound alike: they differ in a third of their sounds at most.

    Of phrases that hold numbers, and not as many, the words before the first one count: "meters" ends them all.
    """
    counts = {len(SLOT.findall(phrase)) for phrase in (one, other)}
    if len(counts) > 1 and 0 not in counts:
        one, other = (phrase.partition("{")[0].strip() for phrase in (one, other))
    keys = sound_key(one), sound_key(other)
    return 3 * slips(*keys) <= max(map(len, keys))


def _listed(entries: dict[str, Any]) -> Iterable[tuple[CommandSpec, str]]:
    count = 0
    for name, phrases in entries.items():
        if name == START_ROUTE.name:
            raise BadInput(f"{name} takes no phrases of your own: only the name of a route says which one starts.")
        if name not in SPECS:
            close = difflib.get_close_matches(name[:40], SPECS, 1)
            there = f"did you mean {close[0]}?" if close else f"there are {', '.join(SPECS)}."
            raise BadInput(f"there is no command {name[:40]!r}; {there}")
        if not isinstance(phrases, list) or not all(isinstance(one, str) for one in phrases):
            raise BadInput(f'{name} takes a list of phrases in quotes, like ["come to papa"].')
        for one in phrases:
            count += 1
            if count > MOST_PHRASES:
                raise BadInput(f"there are more than {MOST_PHRASES} phrases.")
            yield SPECS[name], one


def _phrase(words: str, spec: CommandSpec) -> OwnPhrase:
    shown = f"“{words[:MAX_LETTERS]}”"
    if not LEAST_LETTERS <= len(words) <= MAX_LETTERS or not PHRASE.fullmatch(words):
        raise BadInput(
            f"the phrase {shown} must have {LEAST_LETTERS} to {MAX_LETTERS} letters: small ones from a to z, single "
            "spaces, and numbers as {name}."
        )
    needed = Counter(number.name for number in spec.numbers if number.default is None)
    if Counter(SLOT.findall(words)) != needed:
        wanted = " and ".join(f"{{{name}}}" for name in needed) or "no number"
        raise BadInput(f"the phrase {shown} must hold {wanted}, once, as “{spec.words[0]}” does.")
    if spec is not STOP_MOVING and says_stop(words):
        raise BadInput(f"the phrase {shown} always stops the robot.")
    if spec is not STOP_MOVING:
        _check_meaning(words, spec, shown)
    return OwnPhrase(words, spec, compiled(words))


def _check_meaning(words: str, spec: CommandSpec, shown: str) -> None:
    """Raise BadInput for a phrase that says something else than its command, or nothing of its own."""
    said = " ".join(SLOT.sub(" ", words).split())
    if spec.moves and (may_mean_stop(words) or STOPS_ABROAD.search(words)):
        raise BadInput(
            f"who says {shown} may want the robot to stop, and {spec.name} moves it. Choose another phrase."
        )
    if spec.moves and (EVERYDAY_WORDS.fullmatch(said) or _syllables(words) < MIN_SYLLABLES):
        raise BadInput(f"the phrase {shown} is in all talk, and {spec.name} moves the robot. Take a longer one.")
    if other := re.search(rf"(?<!\w)(?:{CONTRADICTIONS.get(spec.name, '(?!)')})(?!\w)", words):
        raise BadInput(f"the phrase {shown} says “{other[0]}”, which {spec.name} does not do.")
    if other := OTHER_MEASURE.search(words):
        raise BadInput(f"the phrase {shown} counts in “{other[0][2:]}”; the numbers of {spec.name} are metres.")
    for pattern in (*(TO_PLACE if spec is not STOP_AT else ()), *START_ROUTE.words):
        if words.startswith(begin := pattern.partition("{")[0]):
            raise BadInput(f"the phrase {shown} begins with “{begin.strip()}”, as the names of places and routes do.")


def _syllables(words: str) -> int:
    """About how many syllables a phrase has; a number counts as one."""
    return len(SYLLABLE.findall(SLOT.sub("1", words))) + len(SLOT.findall(words))


def _check_apart(phrases: OwnPhrases) -> None:
    """Raise BadInput for the first pair of phrases of different commands that sound alike."""
    known = [(words, kind.name) for kind in VOCABULARY for words in kind.words]
    known += [(words, words) for words in OTHER_WORDS]
    for phrase in phrases:
        for words, name in known:
            if name != phrase.kind.name and too_close(phrase.pattern, words):
                raise BadInput(
                    f"“{phrase.pattern}” ({phrase.kind.name}) and “{words}” ({name}) sound too much alike: one "
                    "would be heard as the other. Choose another phrase."
                )
        known.append((phrase.pattern, phrase.kind.name))
