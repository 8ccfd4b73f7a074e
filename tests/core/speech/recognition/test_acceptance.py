"""What is done about words that were heard."""

from __future__ import annotations

from dataclasses import replace

import pytest

from core.speech.recognition.acceptance import judge
from core.speech.recognition.recognizer import WordHypothesis

DOUBT = "I am not sure that I heard every word right."


def heard(words: str, *, final: bool = True, doubt: str = "") -> WordHypothesis:
    return WordHypothesis(words=words, begin=1.0, end=2.0, final=final, doubt=doubt)


def test_a_whole_sentence_is_a_command_and_its_numbers_are_said_back():
    spoken = judge(heard("continue two point five meters"))
    assert spoken.accepted
    assert spoken.command.numbers == {"distance_m": 2.5}
    assert spoken.echo == "continue 2.5 meters"


@pytest.mark.parametrize("words", ["", "continue two", "please turn left", "half phone_n home", "come over here"])
def test_what_is_no_whole_sentence_is_refused_with_a_reason(words):
    spoken = judge(heard(words))
    assert not spoken.accepted
    assert spoken.reason


def test_a_number_beyond_the_bounds_of_speech_is_refused():
    spoken = judge(heard("continue twelve meters"))
    assert not spoken.accepted
    assert "by voice" in spoken.reason


def test_words_in_doubt_move_nothing_and_are_said_back_for_correction():
    spoken = judge(heard("continue two meters", doubt=DOUBT))
    assert not spoken.accepted
    assert spoken.reason == DOUBT + " I heard “continue two meters”; say it again."


@pytest.mark.parametrize(
    ("words", "suggested_command"),
    [("continue two meters", "continue 2 meters"), ("come over here", ""), ("start", "")],
)
def test_words_in_doubt_are_offered_when_they_are_a_command(words, suggested_command):
    spoken = judge(heard(words, doubt=DOUBT))
    assert spoken.suggested_command == suggested_command and spoken.suggestions == (
        (suggested_command,) if suggested_command else ()
    )
    assert (
        judge(heard(words)).suggested_command == ""
        and judge(heard(words, doubt=DOUBT, final=False)).suggested_command == ""
    )


def test_a_number_that_may_be_another_is_told_with_the_command():
    likely = WordHypothesis(words="continue two meters", begin=1.0, end=2.0, uncertain=True)
    assert judge(likely).uncertain and judge(likely).accepted
    assert not judge(heard("continue two meters")).uncertain
    assert not judge(replace(likely, words="come over there")).uncertain


def test_a_place_in_doubt_still_stops():
    spoken = judge(heard("stop at one and two", doubt=DOUBT))
    assert spoken.command.name == "stop_moving"
    assert spoken.command.remark == DOUBT


@pytest.mark.parametrize(("words", "acts"), [("stop", True), ("turn left", False), ("stop at one and two", True)])
def test_before_the_sentence_is_over_only_stop_acts(words, acts):
    spoken = judge(heard(words, final=False))
    assert spoken.accepted is acts
    assert not acts or spoken.command.name == "stop_moving"
