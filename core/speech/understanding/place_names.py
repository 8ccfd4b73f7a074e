"""Names of places as words of STOP AT ("go to NAME"); a name that sounds like other words is refused."""

import itertools
import re
from collections.abc import Iterable

from core.commands import VOCABULARY
from core.commands.routes import PAUSE_ROUTE, RESUME_ROUTE, START_ROUTE
from core.commands.stop_at import STOP_AT, TO_PLACE
from core.commands.stop_moving import STOP_PHRASES
from core.errors import BadInput
from core.navigation.places import NamedPlace
from core.sentences import Statement
from core.speech.understanding.grammar import (
    OTHER_WORDS,
    READ,
    OwnPhrase,
    OwnPhrases,
    compiled,
    plain_letters,
    says_stop,
    slips,
)
from core.speech.understanding.numbers import VALUES, WHOLE_WORDS
from core.speech.understanding.own_phrases import sound_key, too_close

MIN_NAME_LETTERS, MAX_NAME_LETTERS = 3, 40
MAX_PLACES = 60
NEAR_SOUNDS, NEAR_LETTERS = 0.25, 0.5  # shares of two names that differ, up to which both together are too near
SAME_LETTERS = 0.2  # share of the letters that differ, up to which they alone are
NAME = re.compile(r"[A-Za-z0-9]+(?:['-][A-Za-z0-9]+)*(?: [A-Za-z0-9]+(?:['-][A-Za-z0-9]+)*)*")
ARTICLE = "the "


def tidy_name(name: str) -> str:
    """A name as it is kept: single spaces, letters from a to z, without an article. Raises BadInput with what a name
    may be.
    """
    tidy = plain_letters(" ".join(name.split()))
    tidy = tidy[len(ARTICLE) :] if tidy.lower().startswith(ARTICLE) else tidy
    if not MIN_NAME_LETTERS <= len(tidy) <= MAX_NAME_LETTERS or not NAME.fullmatch(tidy):
        raise BadInput(Statement("places.name_form", least=MIN_NAME_LETTERS, most=MAX_NAME_LETTERS))
    if not re.search("[A-Za-z]", tidy):
        raise BadInput(Statement("places.number"))
    if says_stop(tidy):
        raise BadInput(Statement("places.stops", name=tidy))
    return tidy


def place_phrases(places: Iterable[NamedPlace]) -> OwnPhrases:
    """Return the phrases that go to these places, with the numbers in their names in digits and in words.

    Where there are routes among them, also those that start, pause and resume a route.
    """
    known = list(places)
    named = tuple(
        OwnPhrase(pattern.format(name=said), kind, _read(pattern, said), place)
        for place in known
        for kind, patterns in ((START_ROUTE, START_ROUTE.words) if place.route else (STOP_AT, TO_PLACE),)
        for said in _said(place.name)
        for pattern in patterns
    )
    steering = (PAUSE_ROUTE, RESUME_ROUTE) if any(place.route for place in known) else ()
    return (*named, *(OwnPhrase(words, kind, compiled(words)) for kind in steering for words in kind.words))


def check_name_apart(name: str, places: Iterable[str], own: OwnPhrases = ()) -> None:
    """Raise BadInput for a tidy name that sounds like a command, a number or another place, with the pair.

    `places`: names of the others; `own`: phrases of the user's.
    """
    for other in places:
        if names_alike(spoken_name(name), spoken_name(other)):
            raise _alike(name, other)
    for pattern in TO_PLACE:
        words = pattern.format(name=spoken_name(name))
        if spoken_name(name) in VALUES or any(READ[point].fullmatch(words) for point in STOP_AT.words):
            raise BadInput(Statement("places.number"))
        known = [one for kind in VOCABULARY for one in kind.words if kind is not STOP_AT or _like_numbers(name)]
        for phrase in (*known, *OTHER_WORDS, *(one.pattern for one in own)):
            if _confusable(words, phrase):
                raise _alike(words, phrase)
    for word in (*STOP_PHRASES, *VALUES):
        if sound_key(spoken_name(name)) == sound_key(word):
            raise _alike(name, word)


def _confusable(one: str, other: str) -> bool:
    """Return whether two phrases sound the same, or resemble each other both in sound and in letters."""
    alike = too_close(one, other) and 3 * slips(one, other) <= max(len(one), len(other))
    return alike or sound_key(one) == sound_key(other)


def names_alike(one: str, other: str) -> bool:
    """Return whether two names are too near: nobody hears which of them stands alone after "go to"."""
    keys = sound_key(one), sound_key(other)
    sounds, letters = slips(*keys) / max(map(len, keys)), slips(one, other) / max(len(one), len(other))
    near = (sounds <= NEAR_SOUNDS and letters <= NEAR_LETTERS) or letters <= SAME_LETTERS
    return near or _confusable(one, other)


def spoken_name(name: str) -> str:
    """A name as it is said: small letters, numbers in words, without marks."""
    return re.sub("[-']", "", _said(name)[-1])


def _read(pattern: str, name: str) -> re.Pattern[str]:
    """Words of STOP AT with this name, whether its parts are written together or not: "book shelf", "bookshelf"; its
    marks are not heard: "lunch-room", "lunchroom".
    """
    letters = "[ '-]?".join(letter for letter in name if letter.isalnum())
    return re.compile(compiled(pattern.format(name="@")).pattern.replace("@", letters))


def _said(name: str) -> tuple[str, ...]:
    """The ways to write a name in small letters: as it is, and with its numbers in words."""
    ways = [(word, WHOLE_WORDS[word]) if word in WHOLE_WORDS else (word,) for word in name.lower().split()]
    return tuple(dict.fromkeys(" ".join(words) for words in itertools.product(*ways)))


def _like_numbers(name: str) -> bool:
    """Return whether a name may be taken for the two numbers of STOP AT: it is two things with “and” between them."""
    parts = spoken_name(name).split(" and ")
    return len(parts) == 2 and any(part in VALUES for part in parts)


def _alike(one: str, other: str) -> BadInput:
    return BadInput(Statement("places.alike", one=one, other=other))
