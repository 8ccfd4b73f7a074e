"""Grammars as automata: the same sentences, as likely as JSGF says, and few states."""

import itertools
import math
import re
from collections import defaultdict

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.speech.recognition.recognizer import for_words
from core.speech.sphinx.decoded_path import decoded
from core.speech.sphinx.decoder import SEARCH, grammar_decoder
from core.speech.sphinx.fsg import Automaton, automaton
from core.speech.sphinx.garbage_model import grammar
from core.speech.sphinx.jsgf import plain_grammar, written
from core.speech.synthesis import NO_VOICE, PERSONS_VOICE, VoiceSettings, can_speak, speak
from tests.core.speech.ears import padded

WIDE = {"bestpath": False, "compallsen": True, "cmn": "batch", "maxhmmpf": -1} | dict.fromkeys(
    ("beam", "pbeam", "wbeam"), 1e-150
)  # nothing is dropped on the way
LONGEST = 4  # words of the sentences that are compared


def sentences(made: Automaton) -> dict[tuple[str, ...], float]:
    """All sentences of at most LONGEST words → the best log-probability of each."""
    leaving = defaultdict(list)
    for arc in made.arcs:
        leaving[arc.source].append(arc)
    found: dict[tuple[str, ...], float] = {}
    waiting: list[tuple[int, tuple[str, ...], float, bool]] = [(made.start, (), 0.0, False)]
    while waiting:
        state, words, nats, silent = waiting.pop()
        if state == made.final:
            found[words] = max(nats, found.get(words, -math.inf))
        for arc in leaving[state]:
            if (arc.word and len(words) < LONGEST) or not (arc.word or silent):
                spoken = (*words, arc.word) if arc.word else words
                waiting.append((arc.target, spoken, nats + arc.nats, not arc.word))
    return found


def likelihoods(body: str, **rules: str) -> dict[str, float]:
    """Sentences → probabilities of a rule."""
    told = sentences(automaton(written(rules, body)))
    return {" ".join(words): pytest.approx(math.exp(nats)) for words, nats in told.items()}


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("turn left", {"turn left": 1.0}),
        ("left | right | here", {"left": 1 / 3, "right": 1 / 3, "here": 1 / 3}),
        ("/3/ left | /1/ right", {"left": 0.75, "right": 0.25}),
        ("turn [to the] left", {"turn left": 0.5, "turn to the left": 0.5}),
        ("turn [/2/ a | /1/ b]", {"turn": 0.25, "turn a": 0.5, "turn b": 0.25}),
        ("(turn | come) (left | here)", dict.fromkeys(("turn left", "turn here", "come left", "come here"), 0.25)),
        (
            "<number> and <number>",
            {"one and one": 0.25, "one and two": 0.25, "two and one": 0.25, "two and two": 0.25},
        ),
        ("ha+", {"ha": 0.5, "ha ha": 0.25, "ha ha ha": 0.125, "ha ha ha ha": 0.0625}),
        ("[a] [b]", {"": 0.25, "a": 0.25, "b": 0.25, "a b": 0.25}),
        ("[[a] b] c", {"c": 0.5, "b c": 0.25, "a b c": 0.25}),
    ],
)
def test_sentences_are_as_likely_as_their_weights_say(body: str, told: dict[str, float]) -> None:
    assert likelihoods(body, number="one | two") == told


def test_what_is_repeated_may_change_each_time() -> None:
    told = likelihoods("(a | b)+")
    assert set(told) == {" ".join(some) for n in range(1, 5) for some in itertools.product("ab", repeat=n)}
    assert told["a b a"] == pytest.approx(0.5**6)


@settings(max_examples=60, deadline=None)
@given(
    st.recursive(
        st.sampled_from("abc"),
        lambda part: st.one_of(
            st.lists(part, min_size=2, max_size=3).map(lambda some: f"({' | '.join(some)})"),
            st.lists(part, min_size=2, max_size=3).map(" ".join).map("({})".format),
            part.map("[{}]".format),
            part.filter(lambda one: "[" not in one).map("({})+".format),
        ),
        max_leaves=6,
    )
)
def test_it_takes_the_sentences_of_its_grammar_and_no_others(body: str) -> None:
    """Silent arcs one at a time, as sphinx takes them."""
    told = sentences(automaton(written({}, body)))
    spelled = re.compile(re.sub(r"\s", "", body.replace("[", "(?:").replace("]", ")?")))
    chains = ("".join(some) for n in range(LONGEST + 1) for some in itertools.product("abc", repeat=n))
    assert {"".join(words) for words in told} == {chain for chain in chains if spelled.fullmatch(chain)}
    assert sum(math.exp(nats) for nats in told.values()) <= 1 + 1e-9


def test_the_grammars_have_few_states() -> None:
    assert automaton(plain_grammar()).states < 200
    assert automaton(grammar([f"word{n}" for n in range(900)], 30_000.0)).states < 8


def test_a_decoder_knows_the_words_of_its_grammar_and_no_others() -> None:
    """The whole dictionary takes 30 MB in each of three decoders."""
    pytest.importorskip("pocketsphinx", reason="Recognising words needs pocketsphinx: pip install pocketsphinx")
    reader = grammar_decoder(plain_grammar(), **WIDE)
    found = [reader.lookup_word(word) for word in ("zebra", "left", "turn(2)")]
    assert found == [None, "L EH F T", "T AH N"]


@pytest.mark.parametrize(
    "words",
    [
        "follow wall",
        *(
            pytest.param(one, marks=pytest.mark.campaign)
            for one in ("follow the wall", "stop at minus 3 and 0.5", "continue 2 meters")
        ),
    ],
)
def test_every_word_fits_the_sound_as_well_as_in_what_sphinx_makes_of_the_grammar(words: str) -> None:
    """What a state follows colours the word behind it: states are not put together where that would differ."""
    pytest.importorskip("pocketsphinx", reason="Recognising words needs pocketsphinx: pip install pocketsphinx")
    if not can_speak():
        pytest.skip(NO_VOICE)
    samples = padded(0.3 * for_words(speak(words, VoiceSettings(voice=PERSONS_VOICE))).samples[:, 0])
    fits = []
    for own in (True, False):
        reader = grammar_decoder(plain_grammar(), **WIDE)
        if not own:
            reader.add_jsgf_string("theirs", plain_grammar())
            reader.activate_search("theirs")
        decoded(reader, samples)
        assert (reader.current_search() == SEARCH) == own
        fits.append([(one.word, one.start_frame, one.ascore) for one in reader.seg() if one.word != "(NULL)"])
    assert fits[0] == fits[1]
