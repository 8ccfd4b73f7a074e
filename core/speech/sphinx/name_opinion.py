"""A second opinion about names of places and routes, from the sound alone: hidden Markov models beside Whisper.

Whisper writes what people often write; where a name sounds otherwise than by most voices it writes another word, or
another known name. Here the same sound is forced upon each name's phones and upon any chain of phones at all, at two
speeds, and the difference of the two scores is returned.
"""

import math
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from core.commands.routes import START_ROUTE
from core.commands.stop_at import TO_PLACE, command_to
from core.message import Array
from core.sensors.resampling import resampled
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.sphinx.decoded_path import DecodedPath, decoded
from core.speech.sphinx.decoder import add_more_words, add_words, decoder, dictionary_file, listen_for
from core.speech.sphinx.garbage_model import PHONE_WORD, Dictionary, phones_of, read_dictionary
from core.speech.sphinx.jsgf import written
from core.speech.sphinx.recognizer import options_of, views_of
from core.speech.understanding.grammar import OwnPhrases

SLOWER_TIMES = 1.1  # times as long the sound lasts in the second view
MIN_PART_LETTERS = 3  # of each half of a word that is made of two
NAME_BEGINNINGS = tuple(dict.fromkeys(words.split(" {name}")[0] for words in (*TO_PLACE, *START_ROUTE.words)))
NAMES_SEARCH, PHONES_SEARCH, WORDS_SEARCH = "all names", "any phones", "other words"
"""Searches; that of a single name is called by its key."""
BEAM_SHARE = 1e-100  # share of the best path, below which another is given up: every name is followed to its end
WORST_NATS = -400.0  # of a name that does not fit at all
POSSESSIVE_ENDING = "'s"


class SphinxNameOpinion:
    """How well the names that were learnt fit a sound; without any, no decoder is made."""

    def __init__(self, settings: SpeechSettings) -> None:
        self._settings = settings
        self._said: dict[tuple[str, ...], str] = {}  # the words, as the decoder calls them → the command's key
        self._plain: dict[str, str] = {}  # words → what the decoder calls them, whatever marks are in them

    def learn(self, own: OwnPhrases) -> None:
        """Know the names in these phrases, and no others; those with a word that nobody can pronounce are left out.

        Raises Unavailable.
        """
        phrases = {tuple(one.pattern.split()): command_to(one.place).heard_as for one in own if one.place is not None}
        self._said = {}
        if not phrases:
            return
        begins = [tuple(begin.split()) for begin in NAME_BEGINNINGS]
        beams = dict.fromkeys(("beam", "pbeam", "wbeam"), BEAM_SHARE)
        self._decoder = decoder(dict=None, **(options_of(self._settings) | {"compallsen": True} | beams))
        add_words(self._decoder, {})
        self._plain = {}
        self._know(word for words in (*phrases, *begins) for word in words)
        self._said = {called: key for phrase, key in phrases.items() if (called := self._called(phrase))}
        if not self._said:
            return
        begun = " | ".join(" ".join(self._plain[word] for word in begin) for begin in begins)
        loop = " | ".join(PHONE_WORD.format(phone.lower()) for phone in phones_of(dictionary_file()))
        listen_for(self._decoder, PHONES_SEARCH, written({"begin": begun, "phone": loop}, "<begin> <phone>+"))
        listen_for(self._decoder, NAMES_SEARCH, written({}, " | ".join(map(" ".join, self._said))))
        for key in set(self._said.values()):
            ways = (" ".join(words) for words, named in self._said.items() if named == key)
            listen_for(self._decoder, key, written({}, " | ".join(ways)))

    def weigh(self, utterance: Utterance, also: str = "") -> dict[str, float]:
        """The names that fit best, and `also` that one, by their keys → by how much [nats] each fits better than any
        phones, in the mean of both views; {} where none was learnt.
        """
        if not self._said:
            return {}
        views = self._views(utterance)
        found = [self._said.get(self._path(NAMES_SEARCH, one).words, "") for one in views]
        keys = {key for key in (*found, also) if key in self._said.values()}
        anything = [self._path(PHONES_SEARCH, one).fit for one in views]
        return {
            key: float(np.mean([self._fit(key, *one) for one in zip(views, anything, strict=True)])) for key in keys
        }

    def over_words(self, utterance: Utterance, key: str, texts: Iterable[str]) -> dict[str, float]:
        """Small words → by how much [nats] the name of this key fits better than they do, in the mean of both views.

        Words that nobody can pronounce are missing.
        """
        views = self._views(utterance)
        paths = [self._path(key, view) for view in views]
        fits = [path.fit if path.words else -math.inf for path in paths]
        others = {text: tuple(text.split()) for text in texts}
        self._know(word for words in others.values() for word in words)
        over: dict[str, float] = {}
        for text, words in others.items():
            if called := self._called(words):
                listen_for(self._decoder, WORDS_SEARCH, written({}, " ".join(called)))
                over[text] = -float(np.mean([self._fit(WORDS_SEARCH, *one) for one in zip(views, fits, strict=True)]))
        return over

    def _views(self, utterance: Utterance) -> list[Array]:
        """The utterance's sound at both speeds."""
        view = views_of(utterance, self._settings.clear_ratio)[0][0]
        return [view, resampled(view, RATE_HZ, round(SLOWER_TIMES * RATE_HZ))]

    def _know(self, words: Iterable[str]) -> None:
        """Teach the decoder those of these words that it does not know yet, and that can be pronounced."""
        known = pronunciations(set(words) - self._plain.keys(), dictionary_file())
        fresh = {word: f"word_{len(self._plain) + number}" for number, word in enumerate(known)}
        add_more_words(self._decoder, {fresh[word]: tuple(map(" ".join, ways)) for word, ways in known.items()})
        self._plain |= fresh

    def _called(self, words: Iterable[str]) -> tuple[str, ...]:
        """Words as the decoder calls them; (): it does not know one."""
        called = tuple(self._plain.get(word, "") for word in words)
        return called if all(called) else ()

    def _fit(self, key: str, view: Array, anything: float) -> float:
        path = self._path(key, view)
        return max(path.fit - anything, WORST_NATS) if path.words else WORST_NATS

    def _path(self, search: str, view: Array) -> DecodedPath:
        self._decoder.activate_search(search)
        return decoded(self._decoder, view)


def pronunciations(words: Iterable[str], dictionary: Path) -> Dictionary:
    """Small words → how those are said that can be, by a dictionary of CMU's form.

    A word that is not in it may be made of two that are ("whiteboard"), or of one and whose it is ("Sophie's").
    """
    wanted = {word: list(_ways_to_write(word)) for word in words}
    parts = {part for ways in wanted.values() for way in ways for part in way}
    found = read_dictionary(dictionary, parts) | {POSSESSIVE_ENDING: (("Z",),)}
    known: Dictionary = {}
    for word, ways in wanted.items():
        way = next((way for way in ways if all(part in found for part in way)), None)
        if way is not None:
            known[word] = (
                found[way[0]] if len(way) == 1 else (tuple(phone for part in way for phone in found[part][0]),)
            )
    return known


def _ways_to_write(word: str) -> Iterator[tuple[str, ...]]:
    """The parts of which a dictionary may hold a word: itself, without its marks, those between them, two halves."""
    yield (word,)
    yield (re.sub("[-']", "", word),)
    if "-" in word:
        yield tuple(part for part in word.split("-") if part)
    if word.endswith("'s"):
        yield word.removesuffix("'s"), POSSESSIVE_ENDING
    halves = ((word[:cut], word[cut:]) for cut in range(MIN_PART_LETTERS, len(word) - MIN_PART_LETTERS + 1))
    yield from sorted(halves, key=lambda pair: -min(map(len, pair)))
