"""Speech quality by wrong words: eq. 41-46 and the alignment beneath."""

from functools import cache

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.errors import BadInput
from core.speech.quality.marked_text import (
    FIGURE_17_PERSON,
    FIGURE_17_ROBOT,
    as_json,
    marked_score,
    marked_words,
    unmarked,
)
from core.speech.quality.osqe import SpeechQuality, compare, score
from core.speech.quality.osqe import as_json as figures
from core.speech.quality.word_alignment import align, number_words, phrases_of
from core.speech.understanding.numbers import read_number, write_number

SPOKEN = "start; come; follow me; stop moving.\nstart; go to 1.5 and -2; turn left."
WORDS = st.lists(st.sampled_from(["turn", "left", "right", "stop"]), max_size=7)


def errors(original: str, heard: str) -> int:
    return compare(original, heard, "").score["erroneous_words_person"]


@cache
def fewest(words: tuple[str, ...], heard: tuple[str, ...]) -> int:
    """Levenshtein's distance by its definition."""
    if not words or not heard:
        return len(words) + len(heard)
    return min(
        fewest(words[1:], heard) + 1,
        fewest(words, heard[1:]) + 1,
        fewest(words[1:], heard[1:]) + (words[0] != heard[0]),
    )


def test_figure_17_gives_minus_six_and_a_half() -> None:
    one = marked_score(FIGURE_17_PERSON, FIGURE_17_ROBOT)
    assert (one["erroneous_words_person"], one["erroneous_words_robot"]) == (6, 12)
    assert (one["osqe_d"], one["osqe_r"]) == (-6, 0.5)  # eq. 45, 46


def test_the_texts_of_figure_17_are_those_of_the_print() -> None:
    assert unmarked(FIGURE_17_PERSON) == unmarked(FIGURE_17_ROBOT)
    phrases = phrases_of(unmarked(FIGURE_17_PERSON))
    assert (len(phrases), sum(map(len, phrases))) == (43, 73)


def test_a_mark_that_is_not_closed_is_told() -> None:
    with pytest.raises(BadInput, match="not closed"):
        marked_words("start; =come; follow me")


def test_marked_texts_are_told_with_their_words() -> None:
    told = as_json("=turn left=; stop", "turn left; stop")
    assert told["osqe_d"] == 2
    assert told["osqe_r"] is None
    assert [one["heard"] for one in told["differences"]] == ["turn", "left"]


def test_letters_punctuation_and_the_way_numbers_are_written_do_not_count() -> None:
    assert (
        errors(SPOKEN, "START come, follow me! stop moving start go to one point five and minus two turn left") == 0
    )


@pytest.mark.parametrize(
    ("digits", "words"),
    [
        ("0", "zero"),
        ("12", "twelve"),
        ("45.07", "forty five point zero seven"),
        ("-110", "minus one hundred ten"),
        ("2026", "two zero two six"),
        (".5", "point five"),
    ],
)
def test_digits_become_words(digits: str, words: str) -> None:
    assert number_words(digits) == words.split()


@given(st.integers(-999, 999))
def test_numbers_in_words_are_those_that_the_grammar_reads(value: int) -> None:
    assert read_number(" ".join(number_words(write_number(value)))) == value


@given(WORDS, WORDS)
@settings(max_examples=60, deadline=None)
def test_no_way_has_fewer_differences(words: list[str], heard: list[str]) -> None:
    pairs = align([words], heard) if words else align([], heard)
    assert sum(pair.kind != "same" for pair in pairs) == fewest(tuple(words), tuple(heard))
    assert [pair.original for pair in pairs if pair.original] == words
    assert [pair.heard for pair in pairs if pair.heard] == heard


def test_the_word_error_count_is_that_of_jiwer() -> None:
    jiwer = pytest.importorskip("jiwer", reason="jiwer is not installed; the distance is checked by its definition")
    heard = "start to come follow stop moving start go to one point nine and two turn turn left"
    original = " ".join(word for phrase in phrases_of(SPOKEN) for word in phrase)
    theirs = jiwer.process_words(original, heard)
    ours = compare(SPOKEN, heard, "").person
    assert ours.errors == theirs.substitutions + theirs.deletions + theirs.insertions


def test_what_was_substituted_lost_and_added_stands_at_its_phrase() -> None:
    original = "come; stop moving; turn left; follow me"
    told = figures(compare(original, "here stop turn left follow me me", original))
    assert [(one["kind"], one["phrase"]) for one in told["differences"]] == [
        ("substituted", 0),
        ("deleted", 1),
        ("inserted", 3),
    ]
    assert told["person"] == {
        "substitutions": 1,
        "deletions": 1,
        "insertions": 1,
        "word_error_rate": 3 / 7,
        "commands_exact": 1,
    }
    assert told["robot"]["commands_exact"] == 4


def test_an_empty_text_has_lost_all_words() -> None:
    assert compare(SPOKEN, "", SPOKEN).score["erroneous_words_person"] == sum(map(len, phrases_of(SPOKEN)))


def test_the_ratio_without_errors_of_the_robot_is_undefined_and_says_why() -> None:
    assert score(3, 0)["osqe_r"] is None
    assert "made no error" in score(3, 0)["reason"]
    assert "Neither" in score(0, 0)["reason"]
    assert score(3, 0)["osqe_r_bounded"] == 4.0
    assert score(0, 0)["osqe_r_bounded"] == 1.0


def test_swapping_the_paths_turns_the_sign_and_inverts_the_ratio() -> None:
    one, other = score(6, 12), score(12, 6)
    assert one["osqe_d"] == -other["osqe_d"]
    assert one["osqe_r"] == pytest.approx(1 / (other["osqe_r"] or 0))
    assert one["osqe_r_bounded"] == pytest.approx(1 / other["osqe_r_bounded"])


def test_an_original_without_words_is_refused() -> None:
    with pytest.raises(BadInput, match="no words"):
        compare(" ; . ", "turn left", "turn left")


def drill(wrong: int) -> SpeechQuality:
    """Thirty commands, of which the robot hears so many wrong."""
    original = ["turn left"] * 30
    heard = ["turn right"] * wrong + ["turn left"] * (30 - wrong)
    return compare(";".join(original), ";".join(original), ";".join(heard))


def test_the_interval_holds_the_figure_and_is_the_same_each_time() -> None:
    one = drill(8)
    assert one.difference_interval[0] <= one.score["osqe_d"] <= one.difference_interval[1]
    assert one.bounded_interval[0] <= one.score["osqe_r_bounded"] <= one.bounded_interval[1]
    assert drill(8).difference_interval == one.difference_interval


def test_the_verdict_follows_the_interval_and_is_kept_back_for_few_words() -> None:
    assert "worse" in drill(12).verdict
    assert "No difference" in drill(0).verdict
    assert "too few" in compare(SPOKEN, SPOKEN, "").verdict


def test_too_long_a_text_is_refused() -> None:
    with pytest.raises(BadInput, match="too long"):
        phrases_of("stop " * 6000)
