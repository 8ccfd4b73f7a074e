"""Numbers as people say and type them."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.speech.understanding.numbers import NUMBER, read_number, write_number
from tests.core.speech.spelling import spell

hundredths = st.integers(-99999, 99999).map(lambda number: number / 100)


def read(words: str) -> float | None:
    return read_number(words) if re.fullmatch(NUMBER, words) else None


@given(hundredths)
def test_what_is_written_is_read_back(value: float) -> None:
    assert read(write_number(value)) == value


@given(hundredths)
def test_what_is_spelt_in_words_is_read_back(value: float) -> None:
    assert read(spell(value)) == value


@pytest.mark.parametrize(
    ("words", "value"),
    [
        ("two point five", 2.5),
        ("minus one", -1),
        ("one hundred", 100),
        ("nine hundred ninety nine", 999),
        ("twenty-one", 21),
        ("twenty one point zero five", 21.05),
        ("point five", 0.5),
        ("1.5", 1.5),
        (".5", 0.5),
        ("-1", -1),
        ("minus .25", -0.25),
        ("zero", 0),
        ("minus zero", 0),
        ("007", 7),
    ],
)
def test_a_number_has_its_value(words: str, value: float) -> None:
    assert read(words) == value


NO_NUMBERS = """to|too|for|won|ate|oh|a|half|dozen|one-half|
1.|1,5|1e3|+1|--1|-one|1.2.3|٣|３|½|inf|nan|one.5|0x10|1_000|
one point|one point ten|one hundred and five|five hundred thousand|1 point 5|twenty ten|- 1|11111111111|"""


@pytest.mark.parametrize("words", [words.strip() for words in NO_NUMBERS.split("|")])
def test_nothing_is_guessed(words: str) -> None:
    assert read(words) is None
