"""The parts of the package pocketsphinx: the decoder, the acoustic model, the dictionary and the word frequencies.

The package is imported when it is first needed, never before: nothing else of Beckon depends on it.
"""

import heapq
import math
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from core.commands import VOCABULARY
from core.errors import Unavailable
from core.install import install_packages
from core.message import Array
from core.speech.recognition.recognizer import pcm
from core.speech.sphinx.fsg import automaton
from core.speech.sphinx.garbage_model import PHONE_WORD, choose, command_words, entries, phones_of, read_dictionary
from core.speech.sphinx.jsgf import words_of

MISSING = (
    "Recognising words needs the package pocketsphinx, which brings its model: "
    f"{install_packages('pocketsphinx>=5.1.1')}"
)
MODEL = "en-us"
FRAME_S = 0.01  # in which it counts
MOST_COMMON = 5000  # words among which those that compete are looked for first; 3,000 are enough
SEARCH = "heard"  # what a decoder with a grammar or a keyword calls it


def decoder(**options: Any) -> Any:
    """A decoder of American English with the given options of pocketsphinx. Raises Unavailable."""
    sphinx = _package()
    common = {"lm": None, "loglevel": "FATAL"}
    try:
        return sphinx.Decoder(**(common | options))
    except (RuntimeError, ValueError, OSError) as trouble:
        raise Unavailable(f"pocketsphinx does not start ({trouble}). {MISSING}") from None


def keyword_decoder(word: str, phones: str, threshold: float, delay: int) -> Any:
    """A decoder that spots one word, said as `phones`, from a likelihood ratio on. Raises Unavailable.

    It knows no other word: the package's dictionary takes 23 MB.
    """
    made = decoder(dict=None, kws_threshold=threshold, kws_delay=delay)
    made.add_word(word, phones, True)
    made.add_keyphrase(SEARCH, word)
    made.activate_search(SEARCH)
    return made


def grammar_decoder(jsgf: str, **options: Any) -> Any:
    """A decoder that hears sentences of the grammar, which may use PHONE_WORD. Raises Unavailable.

    It knows the words of the grammar and no others, for the same reason.
    """
    made = decoder(dict=None, **options)
    known = read_dictionary(dictionary_file(), frozenset(words_of([jsgf])))
    also = {word: sounds for spec in VOCABULARY for word, sounds in spec.pronunciations.items()}
    add_words(
        made, {word: (*map(" ".join, ways), *([also[word]] if word in also else ())) for word, ways in known.items()}
    )
    listen_for(made, SEARCH, jsgf)
    return made


def add_words(decoder: Any, words: Mapping[str, Sequence[str]]) -> None:
    """Teach words to a decoder without a dictionary, and PHONE_WORD of every phone."""
    add_more_words(decoder, words)
    phones = phones_of(dictionary_file())
    for phone in phones:
        decoder.add_word(PHONE_WORD.format(phone.lower()), phone, phone == phones[-1])


def add_more_words(decoder: Any, words: Mapping[str, Sequence[str]]) -> None:
    """Teach words, each by its pronunciations; searches that are made afterwards know them."""
    for word, ways in words.items():
        for number, way in enumerate(ways, 1):
            decoder.add_word(word if number == 1 else f"{word}({number})", way, False)


def listen_for(decoder: Any, search: str, jsgf: str) -> None:
    """Make a decoder hear sentences of the grammar; `search` is its name there, which may exist already."""
    chains = automaton(jsgf)
    arcs = [(arc.source, arc.target, math.exp(arc.nats), *([arc.word] if arc.word else [])) for arc in chains.arcs]
    decoder.add_fsg(search, decoder.create_fsg(search, chains.start, chains.final, arcs))
    decoder.activate_search(search)


def take_in(decoder: Any, samples: Array, *, whole: bool = False) -> None:
    """Samples (N,) into a decoder's utterance; `whole`: they are all of it. The package itself breaks at N = 0."""
    if len(samples):
        decoder.process_raw(pcm(samples), full_utt=whole)


@cache
def garbage_words(count: int, resembling: int) -> tuple[str, ...]:
    """The phones as words, and the most common words: `count` that no command's word can be mistaken for, and
    `resembling` that one can.
    """
    path = dictionary_file()
    any_decoder = decoder(dict=None)
    model = _package().NGramModel(any_decoder.config, any_decoder.logmath, str(_file("en-us.lm.bin")))

    def frequency(word: str) -> float:
        return model.prob([word])

    found: tuple[str, ...] = ()
    for most in (MOST_COMMON, sys.maxsize):
        words = (word for word, _ in entries(path) if word.isalpha())
        common = heapq.nsmallest(most, words, key=lambda word: (-frequency(word), word))
        found = choose(read_dictionary(path, {*common, *command_words()}), frequency, count, resembling)
        if len(found) == count + resembling:
            break
    return tuple(PHONE_WORD.format(phone.lower()) for phone in phones_of(path)) + found


def dictionary_file() -> Path:
    """The pronouncing dictionary. Raises Unavailable."""
    return _file("cmudict-en-us.dict")


def _package() -> Any:
    """The package; its sound-card part, which wants PortAudio, is never touched. Raises Unavailable."""
    try:
        return import_module("pocketsphinx")
    except (ImportError, OSError):
        raise Unavailable(MISSING) from None


def _file(name: str) -> Path:
    """A file of the model. Raises Unavailable when the package came without."""
    path = Path(_package().get_model_path(MODEL)) / name
    if not path.is_file():
        raise Unavailable(
            f"pocketsphinx came without its model ({name}). Install its wheel: "
            f"{install_packages('-U', 'pocketsphinx')}"
        )
    return path
