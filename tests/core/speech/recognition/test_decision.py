"""The decision about one utterance."""

import math
from dataclasses import replace

import pytest

from core.speech.recognition.decision import (
    NO_COMMAND,
    NOT_SURE,
    TOO_LONG,
    Decision,
    Scores,
    Sentence,
    Thresholds,
    decide,
    log_odds,
    no_command,
    said_back,
    stop,
)
from core.speech.understanding.grammar import understand
from tests.core.speech.ears import confirming, sure, unsure

THRESHOLDS = Thresholds(reject=10.0, accept=30.0, scale=10.0)


def decided(words: str, free_text: float = math.inf, second_best: float = math.inf, objection: str = "") -> Decision:
    scores = Scores(sentence=-100.0, over_free_text=free_text, over_second_best=second_best)
    return decide(Sentence(words), scores, THRESHOLDS, objection=objection)


def test_a_whole_sentence_is_a_command_and_its_numbers_are_repeated():
    one = sure("continue two point five meters")
    assert one.verdict == "accept"
    assert one.command.numbers == {"distance_m": 2.5}
    assert one.echo == "continue 2.5 meters"


@pytest.mark.parametrize("words", ["", "continue two", "please turn left", "half phone_n home", "come over here"])
def test_what_is_no_whole_sentence_is_rejected_with_a_reason(words):
    one = sure(words)
    assert (one.verdict, one.command) == ("reject", None)
    assert one.reason


def test_a_number_beyond_the_bounds_of_speech_is_rejected_and_no_other_number_is_offered():
    one = sure("continue twelve meters")
    assert one.verdict == "reject"
    assert "by voice" in one.reason
    assert one.did_you_mean == one.suggestions == () and one.offered == ()


def test_uncertain_words_move_nothing_and_are_said_back_for_correction():
    one = unsure("continue two meters")
    assert one.verdict == "reject"
    assert one.reason == NOT_SURE + " I heard “continue two meters”; say it again."


@pytest.mark.parametrize(
    ("words", "offered"), [("continue two meters", "continue 2 meters"), ("come over here", ""), ("start", "")]
)
def test_uncertain_words_are_offered_when_they_are_a_command(words, offered):
    one = unsure(words)
    assert one.offered == one.did_you_mean == ((offered,) if offered else ())
    assert sure(words).offered == ()


def test_what_else_may_have_been_said_is_known_by_its_likelihood():
    said = Sentence("continue two meters")
    heard = ("continue three meters", "nonsense", "continue twelve meters", "continue four meters")
    others = [Sentence(words) for words in heard]
    uncertain = decide(said, Scores(sentence=0.0), THRESHOLDS, objection=NOT_SURE, others=others)
    meant = ("continue 2 meters", "continue 3 meters", "continue 4 meters")
    assert uncertain.did_you_mean == meant
    confirmed = decide(said, Scores(sentence=0.0, over_second_best=20.0), THRESHOLDS, others=others)
    assert tuple(one.heard_as for one in confirmed.alternatives) == meant[1:] and confirmed.did_you_mean == ()


@pytest.mark.parametrize(
    ("free_text", "second_best", "verdict", "reason"),
    [
        (1.0, 31.0, "accept", ""),
        (1.0, 30.0, "confirm", ""),
        (1.0, 10.0, "confirm", ""),
        (1.0, 9.9, "reject", NOT_SURE),
        (0.0, 99.0, "reject", NO_COMMAND),
        (-5.0, 99.0, "reject", NO_COMMAND),
    ],
)
def test_the_margins_of_a_sentence_decide(free_text, second_best, verdict, reason):
    one = decided("continue one meters", free_text, second_best)
    assert one.verdict == verdict and one.reason.startswith(reason)
    assert (one.command is None) == (verdict == "reject")


def test_what_is_no_command_has_no_words_and_offers_nothing():
    one = decided("turn left", free_text=-1.0)
    assert (one.words, one.did_you_mean) == ("", ())


def test_confidence_grows_with_the_narrower_margin_from_none_to_certain():
    assert decided("turn left").confidence == 1.0
    assert decided("").confidence == 0.0
    assert decided("turn left", 20.0, 40.0).confidence == pytest.approx(1 / (1 + math.exp(-2.0)))
    assert decided("turn left", 40.0, 20.0).confidence == pytest.approx(1 / (1 + math.exp(-2.0)))
    assert decided("turn left", -5.0, 40.0).confidence < 0.5 < decided("turn left", 5.0, 40.0).confidence
    assert decided("turn left", 5.0, -math.inf).confidence == 0.0


@pytest.mark.parametrize("probability", [0.1, 0.5, 0.93])
def test_log_odds_give_the_probability_back_as_confidence(probability):
    thresholds = Thresholds(reject=-math.inf, accept=-math.inf)
    scores = Scores(sentence=0.0, over_second_best=log_odds(probability))
    assert decide(Sentence("turn left"), scores, thresholds).confidence == pytest.approx(probability)
    assert (log_odds(0.0), log_odds(1.0)) == (-math.inf, math.inf)


def test_a_place_that_is_objected_to_still_stops():
    one = unsure("stop at one and two", TOO_LONG)
    assert one.stops and one.verdict == "accept"
    assert one.command.remark == TOO_LONG
    assert not sure("stop at one and two").stops


@pytest.mark.parametrize(
    ("decision", "waits"),
    [
        (sure("continue one meters"), True),
        (sure("turn left"), False),
        (sure("follow wall"), False),
        (sure("continue three meters"), True),
        (sure("come here"), True),
        (confirming("continue one meters"), True),
        (unsure("come here"), False),
        (stop(), False),
        (confirming("stop"), False),
    ],
)
def test_uncertain_and_far_commands_wait_for_confirmation(decision, waits):
    assert decision.waits is waits


@pytest.mark.parametrize(
    "words",
    [
        "turn left",
        "continue 7 meters",
        "continue minus 2 meters",
        "stop at 4 and 99",
        "go to 4 and 99",
        "stop at 1 and 2",
        "continue",
        "please stop",
        "",
    ],
)
def test_the_bounds_of_speech_are_the_same_whether_they_are_held_at_once_or_later(words):
    now, later = understand(words, spoken=True), Sentence(words).spoken
    assert type(now) is type(later) and repr(now) == repr(later)


def test_words_that_were_meant_for_the_robot_are_said_back_with_what_resembles_them() -> None:
    unheard = said_back(no_command())
    assert (unheard.words, unheard.reason) == ("", NO_COMMAND)
    told = said_back(replace(no_command(), heard="turn lift."))
    assert told.words == "turn lift." and told.reason == "I heard “turn lift”. That is no command."
    assert told.did_you_mean[0] == "turn left" and len(told.did_you_mean) <= 2
    assert said_back(replace(no_command(), heard="Come here.")).did_you_mean == ("come here",)
