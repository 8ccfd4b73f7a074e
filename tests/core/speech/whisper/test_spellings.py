"""The automaton of spellings: all in it are commands, and all that commands may be spelt as is in it."""

import random
import tracemalloc

import pytest

from core.commands import VOCABULARY
from core.speech.whisper.recognizer import key_of
from core.speech.whisper.spellings import (
    Spellings,
    as_understood,
    count_digits,
    has_more_decimals,
    lacks_whole_part,
    seldom_said,
)


def by_letters(text: str) -> tuple[int, ...]:
    return tuple(text.encode())


SPELLINGS = Spellings(by_letters)


def accepts(sentence: str) -> bool:
    state = SPELLINGS.begin
    for token in by_letters(f" {sentence}"):
        arcs = SPELLINGS.arcs(state)
        if token not in arcs.tokens:
            return False
        state = arcs.targets[arcs.tokens.tolist().index(token)]
    return SPELLINGS.arcs(state).final


def walked(seed: int) -> str:
    choose = random.Random(seed)
    state, spelt = SPELLINGS.begin, bytearray()
    while True:
        arcs = SPELLINGS.arcs(state)
        if arcs.final and (not len(arcs.tokens) or choose.random() < 0.5):
            return spelt.decode()
        at = choose.randrange(len(arcs.tokens))
        spelt.append(int(arcs.tokens[at]))
        state = arcs.targets[at]


@pytest.mark.parametrize("seed", range(300))
def test_every_spelling_is_understood_as_a_command(seed):
    assert key_of(walked(seed)) is not None


@pytest.mark.parametrize("kind", VOCABULARY, ids=lambda kind: kind.name)
def test_the_example_of_every_command_is_a_spelling(kind):
    assert accepts(kind.example) and accepts(f"{kind.example.capitalize()}.")


@pytest.mark.parametrize(
    "words",
    [
        "Continue 2.5 meters.",
        "continue two point five metres",
        "continue 2 point 5 meters",
        "continue seven meters",
        "continue one hundred meters",
        "continue twenty-five meter",
        "stop at minus one, and 0.5",
        "Stop at -1 and point three",
        "go to 1 meters and 2 meters!",
        "continue 0.05 meters",
        "continue 1.555 meters",
        "continue 1.2.3 meters",
        "stop at one point two point three and 1",
        "continue 12.5 point 3 meters",
        "Follow the world.",
        "Father wall",
        "stop",
    ],
)
def test_numbers_are_spelt_in_digits_in_words_and_beyond_their_bounds(words):
    assert accepts(words)
    assert key_of(words) is not None


@pytest.mark.parametrize(
    "words",
    [
        "continue meters",
        "father me",
        "father the wall",
        "turn left right",
        "stop at one",
        "come here often",
        "continue",
        "continue 0.10 meters",
    ],
)
def test_what_is_no_whole_command_is_no_spelling(words):
    assert not accepts(words)


@pytest.mark.parametrize(
    ("words", "read"),
    [
        ("Go on with the root.", "go on with the route"),
        ("start root night watch", "start route night watch"),
        ("Pause the root!", "pause the route"),
        ("go to the root cellar", "go to the root cellar"),
        ("start the rooted", "start the rooted"),
    ],
)
def test_a_route_may_be_written_as_a_root(words, read):
    assert as_understood(words) == read


@pytest.mark.parametrize(
    ("words", "more"),
    [
        ("continue 1.555 meters", True),
        ("continue one point zero zero five meters", True),
        ("continue 1.2.3 meters", True),
        ("stop at 1 and one point two point three", True),
        ("continue 1 point 2 point 3 meters", True),
        ("stop at one point five five and two point three two", False),
        ("continue 100.25 meters", False),
        ("stop at 1.25 and 2.5.", False),
        ("go to room 317", False),
    ],
)
def test_a_number_with_more_points_or_decimals_than_are_obeyed_is_known(words, more):
    assert has_more_decimals(words) is more


@pytest.mark.parametrize(
    ("words", "lacks"),
    [
        ("continue .3 meters", True),
        ("continue point three meters", True),
        ("stop at 1 and .5", True),
        ("stop at minus point five and 1", True),
        ("continue 0.3 meters", False),
        ("continue four point three meters", False),
        ("continue 4 point 3 meters.", False),
        ("turn left.", False),
    ],
)
def test_a_number_without_its_whole_part_is_known(words, lacks):
    assert lacks_whole_part(words) is lacks


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("Stop at 1 and 9 3.", 3),
        ("stop at one and minus 3", 2),
        ("Continue twelve meters", 2),
        ("twenty two of one hundred", 5),
        ("2 point 5", 2),
        ("Stop at 1.5 and 2.2.5", 5),
        ("continue 1.2-8 meter", 3),
        ("someone, tenfold", 0),
        ("", 0),
        ("continue to 3 meters", 2),
        ("continue 1 or to meters", 2),
        ("continue for a 3 meters", 2),
        ("continue to 0.5 meters", 2),
        ("continue to .5 meters", 2),
        ("Continue to 0. 5 meters", 2),
        ("continue to meters", 0),
        ("go to 1 and 2", 2),
        ("stop at 1 and to", 1),
    ],
)
def test_digits_are_counted_however_they_are_written(text, count):
    assert count_digits(text) == count


@pytest.mark.parametrize(
    ("words", "seldom"),
    [
        ("continue 3.0 meters", True),
        ("Stop at two point zero, and 1.", True),
        ("stop at 1 and 2 point 0", True),
        ("continue 0.77 meters", True),
        ("continue three point zero two meters", True),
        ("stop at 1 and minus point seven seven", True),
        ("continue 1.05 meters", True),
        ("continue 1.25 meters", False),
        ("continue one point two five meters", False),
        ("continue 3.2 meters", False),
        ("stop at two point two and minus 0.7", False),
        ("continue 10 meters", False),
        ("continue zero point five meters", False),
    ],
)
def test_zeros_behind_the_point_and_repeated_decimals_are_known(words, seldom):
    assert seldom_said(words) is seldom


def test_the_automaton_takes_few_bytes() -> None:
    """With a set for each arc and each place it took 74 MB, letter by letter."""
    tracemalloc.start()
    try:
        spellings = Spellings(by_letters)
        taken, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(spellings.tokens) > 30 and taken < 45e6
