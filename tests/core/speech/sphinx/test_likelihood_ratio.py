"""How a command compares with what is none."""

import math

import numpy as np
import pytest

from core.message import Array
from core.speech.practice_voice import practice_voice
from core.speech.recognition.recognizer import Utterance
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.sphinx.decoded_path import NOTHING, DecodedPath, DecodedPiece, WordSpan, decoded
from core.speech.sphinx.decoder import decoder, listen_for
from core.speech.sphinx.jsgf import written
from core.speech.sphinx.recognizer import compare, headroom
from tests.core.speech.ears import engine, mono, padded


def path(*pieces: tuple[str, float, float, float]) -> DecodedPath:
    """(word or "", begin, end, fit) …"""
    return DecodedPath(
        spans=tuple(WordSpan(word=word, begin=begin, end=end) for word, begin, end, _ in pieces if word),
        pieces=tuple(DecodedPiece(begin=begin, end=end, fit=fit) for _, begin, end, fit in pieces),
    )


def said(words: str) -> DecodedPath:
    """Words that all fit alike."""
    return path(*((word, 0.5 + n / 5, 0.7 + n / 5, -1.0) for n, word in enumerate(words.split())))


COMMAND = path(("", 0.0, 0.5, -10.0), ("turn", 0.5, 0.8, -60.0), ("left", 0.8, 1.5, -80.0), ("", 1.5, 2.0, -5.0))


def test_a_piece_counts_by_the_share_that_lies_within():
    assert COMMAND.fit == pytest.approx(-155.0)
    assert COMMAND.fit_within(0.0, 2.0) == pytest.approx(COMMAND.fit)
    assert COMMAND.fit_within(0.65, 1.15) == pytest.approx(-30.0 - 40.0)
    assert COMMAND.fit_within(2.0, 3.0) == 0.0


def test_a_command_against_itself_is_even():
    even = compare(COMMAND, COMMAND)
    assert even.lead == pytest.approx(0.0) and even.weakest == pytest.approx(0.0)


def test_the_lead_counts_by_the_second_of_speech_and_the_weakest_word_by_its_own():
    """The other path is 20 nats better in "turn" of 0.3 s and 10 worse in "left": 10 in a second of speech."""
    other = path(("", 0.0, 0.5, -10.0), ("", 0.5, 0.8, -40.0), ("", 0.8, 1.5, -90.0), ("", 1.5, 2.0, -5.0))
    likelihood_ratio = compare(COMMAND, other)
    assert likelihood_ratio.lead == pytest.approx(-10.0)
    assert likelihood_ratio.weakest == pytest.approx(-20.0 / 0.3)


def test_no_words_never_hold_and_no_rival_never_wins():
    assert compare(NOTHING, COMMAND).lead == -math.inf
    assert compare(COMMAND, NOTHING).weakest == math.inf


def shifted(nats: float) -> DecodedPath:
    """As COMMAND, but `nats` better in its last word."""
    last = ("", 0.8, 1.5, -80.0 + nats)
    return path(("", 0.0, 0.5, -10.0), ("", 0.5, 0.8, -60.0), last, ("", 1.5, 2.0, -5.0))


def test_a_command_may_be_a_little_behind_but_no_word_of_it_far():
    settings = SpeechSettings(most_behind=50.0, word_behind=1000.0)
    assert headroom(COMMAND, shifted(49.0), settings) > 0 > headroom(COMMAND, shifted(51.0), settings)
    settings = SpeechSettings(most_behind=1000.0, word_behind=50.0)
    assert headroom(COMMAND, shifted(34.0), settings) > 0 > headroom(COMMAND, shifted(36.0), settings)


@pytest.mark.parametrize(
    ("within", "beside", "stands"),
    [(35.0, 90.0, True), (45.0, 90.0, False), (35.0, 110.0, False), (60.0, 1.0, True), (75.0, 1.0, False)],
)
def test_what_fits_within_its_words_may_echo_beside_them(within: float, beside: float, stands: bool):
    """COMMAND is a second of words: [nats] that something else fits better there, and behind them."""
    first, last = -60.0 + 0.3 * within, -80.0 + 0.7 * within
    other = path(("", 0.0, 0.5, -10.0), ("", 0.5, 0.8, first), ("", 0.8, 1.5, last), ("", 1.5, 2.0, beside - 5.0))
    likelihood_ratio = compare(COMMAND, other)
    assert (likelihood_ratio.within, likelihood_ratio.beside) == pytest.approx((-within, -beside))
    assert (headroom(COMMAND, other, SpeechSettings()) > 0) is stands


@pytest.mark.parametrize(
    ("words", "behind", "stands"),
    [
        ("stop at one and two", 10.1, True),
        ("stop at one and two", 12.4, True),
        ("stop at one and two", 12.6, False),
        ("continue one point five", 10.1, False),
        ("stop moving", 14.9, True),
        ("stop moving", 15.1, False),
        ("turn left", 10.1, False),
    ],
)
def test_a_sentence_of_many_words_may_be_further_behind_and_a_stop_most(words: str, behind: float, stands: bool):
    """10 nats a second are allowed, a quarter more from five words, and half as much again where they stop it."""
    command = said(words)
    begin, end = command.spans[0].begin, command.spans[-1].end
    other = path(("", begin, end, command.fit + behind * (end - begin)))
    assert (
        headroom(command, other, SpeechSettings(most_behind=10.0, word_behind=1000.0, echoing_behind=0.0)) > 0
    ) is stands
    assert (headroom(command, other, SpeechSettings(most_behind=1000.0, word_behind=10.0)) > 0) is stands


def test_a_command_of_a_single_word_must_be_ahead():
    come = path(("come", 0.5, 1.0, -50.0))
    assert headroom(come, path(("", 0.5, 1.0, -51.0)), SpeechSettings()) > 0
    assert headroom(come, path(("", 0.5, 1.0, -50.0)), SpeechSettings()) <= 0


@pytest.mark.parametrize(("misread", "rejected"), [(None, False), ("turn right", True)])
def test_what_is_read_otherwise_at_another_speed_is_rejected(monkeypatch, misread, rejected):
    """At every speed the sound has another length."""
    lengths = dict[int, str]()
    rival = path(("", 0.5, 1.5, -1000.0))

    def read(decoder: object, samples: Array) -> DecodedPath:
        words = lengths.setdefault(len(samples), misread if misread and len(lengths) == 2 else "turn left")
        return rival if decoder is reader._others else said(words)

    reader = engine()
    monkeypatch.setattr("core.speech.sphinx.recognizer.decoded", read)
    monkeypatch.setattr("core.speech.sphinx.recognizer.left_over", lambda *_: 0.0)
    sound = mono(padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)))
    heard = reader.decide(Utterance(sound=sound, begin=0.7, end=1.7))
    assert heard.words == "turn left"
    assert (heard.offered[:1] == ("turn left",)) == rejected
    assert (heard.verdict == "reject") == rejected
    assert len(lengths) == 3


def test_meter_and_meters_ask_for_the_same(monkeypatch):
    heard = iter(["continue two meters", "nothing that counts", "continue two meter", "continue two meters"])
    monkeypatch.setattr("core.speech.sphinx.recognizer.decoded", lambda *_: said(next(heard)))
    monkeypatch.setattr("core.speech.sphinx.recognizer.left_over", lambda *_: 0.0)
    sound = mono(padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)))
    read = engine().decide(Utterance(sound=sound, begin=0.7, end=1.7))
    assert (read.words, read.verdict) == ("continue two meters", "accept")


def test_the_longest_pause_lies_between_words():
    said = path(("stop", 0.0, 0.3, 0.0), ("", 0.3, 0.9, 0.0), ("at", 0.9, 1.0, 0.0), ("", 1.0, 5.0, 0.0))
    assert said.longest_pause == pytest.approx(0.6)
    assert COMMAND.longest_pause == 0.0


def test_the_pieces_of_a_decoded_path_cover_the_sound_and_sum_up_to_its_score():
    pytest.importorskip("pocketsphinx", reason="Recognising words needs pocketsphinx: pip install pocketsphinx")
    reader = decoder(bestpath=False)
    listen_for(reader, "two", written({}, "(turn | come) (left | here)"))
    samples = padded(0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ))
    said = decoded(reader, samples)
    assert len(said.spans) == 2
    assert said.fit == pytest.approx(1024 * math.log(reader.hyp().score), abs=1.0)
    assert said.fit < 0
    ends = [piece.end for piece in said.pieces]
    assert [piece.begin for piece in said.pieces] == pytest.approx([0.0, *ends[:-1]])
    assert ends[-1] == pytest.approx(len(samples) / RATE_HZ, abs=0.05)
