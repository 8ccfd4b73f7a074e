"""Numbers on which the views of a sound do not agree."""

import math

import numpy as np
import pytest

from core.message import Array
from core.speech.practice_voice import practice_voice
from core.speech.recognition.recognizer import Utterance, for_words
from core.speech.settings import RATE_HZ
from core.speech.sphinx.decoded_path import DecodedPath
from core.speech.sphinx.jsgf import FAR_LIKELIHOOD, FINE_LIKELIHOOD
from core.speech.sphinx.rescoring import REJECTED_NATS, likelihood, nearest_others, vote
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, can_speak, speak
from tests.core.speech.ears import engine, mono, padded
from tests.core.speech.sphinx.test_likelihood_ratio import path

TEN = math.log(FAR_LIKELIHOOD)


@pytest.mark.parametrize(
    ("words", "nats"),
    [
        ("turn left", 0.0),
        ("continue one point five meters", 0.0),
        ("continue eleven meters", TEN),
        ("stop at twenty one and minus one hundred two", 2 * TEN),
        ("continue one point two five meters", math.log(FINE_LIKELIHOOD)),
        ("stop at one point two five and two point one", math.log(FINE_LIKELIHOOD)),
        ("stop at one point two and three", 0.0),
    ],
)
def test_far_numbers_and_fine_ones_are_unlikely_before_anything_is_heard(words: str, nats: float) -> None:
    assert likelihood(tuple(words.split())) == pytest.approx(nats)


class Views:
    """A decoder that fits each sentence differently to each view, and hears what it is told to without one."""

    def __init__(self, fits: dict[str, tuple[float, ...]], heard: tuple[str, ...] = ()) -> None:
        self.fits, self.heard, self.forced = fits, list(heard), ""
        self.searches: list[str] = []
        self.seen = 0

    def listen_for(self, _: object, name: str, grammar: str) -> None:
        self.searches.append(name)
        self.forced = grammar.partition("<heard> = ")[2].partition(";")[0]
        self.seen = 0

    def activate_search(self, name: str) -> None:
        self.searches.append(name)
        if name == "heard":
            self.forced = ""

    def decoded(self, decoder: object, samples: Array) -> DecodedPath:
        words = self.forced or self.heard.pop(0)
        fit = self.fits[words][self.seen] if self.forced else -1.0
        self.seen += 1
        spans = [(word, 0.7 + n / 5, 0.9 + n / 5, 0.0) for n, word in enumerate(words.split())]
        return path(*spans, ("", 3.0, 3.1, fit))


def hear_by(monkeypatch: pytest.MonkeyPatch, views: Views) -> None:
    """The engine of these tests hears what the views hear, and nothing that competes."""
    reader, rival = engine(), path(("", 0.0, 3.0, -1000.0))
    monkeypatch.setattr(reader, "_quick", views)
    monkeypatch.setattr("core.speech.sphinx.rescoring.decoded", views.decoded)
    monkeypatch.setattr("core.speech.sphinx.rescoring.listen_for", views.listen_for)
    monkeypatch.setattr(
        "core.speech.sphinx.recognizer.decoded",
        lambda who, view: rival if who is reader._others else views.decoded(who, view),
    )
    monkeypatch.setattr("core.speech.sphinx.recognizer.left_over", lambda *_: 0.0)


def test_the_sentence_wins_that_fits_all_views_best_on_average(monkeypatch: pytest.MonkeyPatch) -> None:
    views = Views({"stop at one": (-50.0, -10.0), "stop at nine": (-20.0, -60.0), "stop at ten": (-20.0, -20.0)})
    monkeypatch.setattr("core.speech.sphinx.rescoring.decoded", views.decoded)
    monkeypatch.setattr("core.speech.sphinx.rescoring.listen_for", views.listen_for)
    sentences = [tuple(words.split()) for words in views.fits]
    told = vote(views, sentences, [np.zeros(3)] * 2)
    assert [one.path.words[-1] for one in told] == ["one", "nine", "ten"]
    assert [one.fit for one in told] == pytest.approx([-30.0, -40.0, -20.0 + TEN])
    assert views.searches[-1] == "heard"  # the decoder hears its own grammar again


@pytest.mark.parametrize(
    ("fits", "words", "verdict"),
    [
        ((-30.0, -10.0), "continue three meters", "confirm"),
        ((-30.0, -100.0), "continue two meters", "confirm"),
        ((-30.0, -28.0), "", "reject"),
    ],
)
def test_numbers_that_a_view_reads_otherwise_are_put_to_the_vote(
    monkeypatch: pytest.MonkeyPatch, fits: tuple[float, float], words: str, verdict: str
) -> None:
    """Two meters were heard first, three meters at another speed; in doubt where they fit alike."""
    two, three = "continue two meters", "continue three meters"
    reader = engine()
    views = Views({two: (fits[0],) * 9, three: (fits[1],) * 9}, heard=(two, three, two))
    hear_by(monkeypatch, views)
    sound = mono(padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)))
    read = reader.decide(Utterance(sound=sound, begin=0.7, end=1.7))
    if words:
        assert (read.words, read.verdict) == (words, verdict)
    else:
        assert read.verdict == "reject" and "not sure" in read.reason


def spoken(words: str) -> Array:
    """(N,) of a synthetic voice."""
    if not can_speak():
        pytest.skip("nothing here speaks: pip install espeakng-loader")
    return padded(0.3 * for_words(speak(words, VoiceSettings(voice=PERSONS_VOICE))).samples[:, 0])


def test_the_nearest_other_sentences_differ_in_one_digit_and_none_comes_twice():
    quick, view = engine()._quick, spoken("continue one point five meters")
    words = ("continue", "one", "point", "five", "meters")
    others = nearest_others(quick, words, view, 3)
    assert len(set(others)) == 3
    assert all(sum(a != b for a, b in zip(words, other, strict=True)) == 1 for other in others)
    assert nearest_others(quick, words, view) == others[:1]
    all_others = nearest_others(quick, words, view, 99)
    assert 3 < len(all_others) == len(set(all_others)) <= 18 and all_others[:3] == others


def test_one_digit_may_stand_for_two_decimals_and_where_there_is_none_there_is_no_other():
    quick, view = engine()._quick, spoken("continue zero point nine meters")
    (other,) = nearest_others(quick, ("continue", "zero", "point", "five", "eight", "meters"), view)
    assert other == ("continue", "zero", "point", "nine", "meters")
    assert nearest_others(quick, ("continue", "eleven", "meters"), view) == []
    assert nearest_others(quick, ("turn", "left"), view) == []


@pytest.mark.parametrize(
    ("words", "other", "fits", "verdict"),
    [
        ("continue two meters", "continue three meters", (-30.0, -50.0), "confirm"),
        ("continue two meters", "continue three meters", (-30.0, -90.0), "accept"),
        ("continue two meters", "continue three meters", (-90.0, -30.0), "confirm"),
        ("continue four meters", "continue three meters", (-30.0, -31.0), "accept"),  # it waits whatever it is
        ("turn left", "", (-30.0, 0.0), "accept"),
    ],
)
def test_a_number_that_begins_at_once_is_far_ahead_of_the_nearest_other(
    monkeypatch: pytest.MonkeyPatch, words: str, other: str, fits: tuple[float, float], verdict: str
) -> None:
    reader = engine()
    views = Views({words: (fits[0],) * 9, other: (fits[1],) * 9}, heard=(words,) * 3)
    hear_by(monkeypatch, views)
    monkeypatch.setattr(
        "core.speech.sphinx.recognizer.nearest_others", lambda *_: [tuple(other.split())] if other else []
    )
    sound = mono(padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)))
    read = reader.decide(Utterance(sound=sound, begin=0.7, end=1.7))
    assert (read.words, read.verdict) == (words, verdict)


@pytest.mark.parametrize(
    ("fits", "words"),
    [
        ((-30.0, -30.0 - REJECTED_NATS + 20.0), "continue three meters"),
        ((-30.0, -30.0 - REJECTED_NATS - 20.0), "continue two meters"),
        ((-30.0, -30.0 - REJECTED_NATS + 5.0), ""),
    ],
)
def test_what_was_held_back_is_heard_again_only_where_it_fits_far_better(
    monkeypatch: pytest.MonkeyPatch, fits: tuple[float, float], words: str
) -> None:
    """All views hear two meters; three meters are put to the vote with it, and whatever wins is said back."""
    two, three = "continue two meters", "continue three meters"
    reader = engine()
    views = Views({two: (fits[0],) * 9, three: (fits[1],) * 9}, heard=(two,) * 3)
    hear_by(monkeypatch, views)
    monkeypatch.setattr("core.speech.sphinx.recognizer.nearest_others", lambda *_: [tuple(three.split())])
    sound = mono(padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)))
    read = reader.decide(Utterance(sound=sound, begin=0.7, end=1.7, rejected=(two,)))
    if words:
        assert (read.words, read.verdict) == (words, "confirm")
    else:
        assert read.verdict == "reject" and "not sure" in read.reason


def test_an_order_without_numbers_that_was_held_back_is_read_at_other_speeds_as_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hear_by(monkeypatch, Views({}, heard=("come here", "turn left")))
    monkeypatch.setattr("core.speech.sphinx.recognizer.nearest_others", lambda *_: [])
    sound = mono(padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)))
    read = engine().decide(Utterance(sound=sound, begin=0.7, end=1.7, rejected=("come here",)))
    assert read.verdict == "reject" and "not sure" in read.reason
