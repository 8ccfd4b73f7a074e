"""When words were said: chains through attention, and commands beside which someone else talks."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from core.message import Array
from core.speech.recognition.recognizer import Utterance, for_words
from core.speech.settings import RATE_HZ
from core.speech.synthesis import VoiceSettings, speak
from core.speech.whisper.recognizer import MAX_SOUND_S
from core.speech.whisper.word_times import FIRST_TOKEN_DELAY_S, FRAME_S, LAST_TOKEN_LENGTH_S, spans_of
from tests.core.speech.ears import mono, whisper


def attention(*frames: tuple[int, ...], length: int = 200) -> Array:
    """A row for every token, that looks at these frames, at the first a little more than at the next."""
    looks = np.full((len(frames), length), 1e-4)
    for row, chosen in zip(looks, frames, strict=True):
        row[list(chosen)] = 0.5 - 0.05 * np.arange(len(chosen))
    return looks


def test_words_last_from_before_their_first_token_to_behind_their_last() -> None:
    begin, end = next(iter(spans_of(attention((40,), (55,)))))
    assert (begin, end) == pytest.approx((40 * FRAME_S - FIRST_TOKEN_DELAY_S, 55 * FRAME_S + LAST_TOKEN_LENGTH_S))


def test_a_token_follows_the_one_before_soon() -> None:
    begin, _ = next(iter(spans_of(attention((10, 120), (135,)))))
    assert begin == pytest.approx(120 * FRAME_S - FIRST_TOKEN_DELAY_S)


def test_the_next_span_lies_behind_the_first() -> None:
    spans = spans_of(attention((20, 120), (30, 130)))
    first, second = islice(spans, 2)
    assert (first[0], second[0]) == pytest.approx(
        (20 * FRAME_S - FIRST_TOKEN_DELAY_S, 120 * FRAME_S - FIRST_TOKEN_DELAY_S)
    )


@pytest.mark.parametrize("shape", [(0, 50), (2, 0), (3, 3)])
def test_without_words_or_without_sound_there_are_no_spans(shape: tuple[int, int]) -> None:
    assert list(spans_of(np.full(shape, 0.1))) == []


def said(words: str, voice: str, pace: int = VoiceSettings().speed) -> Array:
    """Samples of a synthetic voice at `pace` [words/min], as loud as others."""
    samples = for_words(speak(words, VoiceSettings(voice=voice, speed=pace))).samples[:, 0]
    loud = np.flatnonzero(np.abs(samples) > 0.02 * np.abs(samples).max())
    return 0.1 * samples[loud[0] : loud[-1]] / np.std(samples)


def heard(samples: Array, begin: float) -> Utterance:
    """All of it is one utterance, which begins so many seconds from its own beginning, at 100 s."""
    end = 100.0 + len(samples) / RATE_HZ
    return Utterance(sound=mono(samples, 100.0), begin=100.0 + begin, end=end)


@pytest.mark.parametrize(
    ("command", "at"),
    [
        ("come here", 0.8),
        pytest.param("come here", 1.0, marks=pytest.mark.campaign),
        ("come here", 1.3),
        pytest.param("follow me", 0.8, marks=pytest.mark.campaign),
    ],
)
def test_the_words_of_a_command_end_before_those_of_another_talker(command: str, at: float) -> None:
    """Who is fainter, as in a beam, and begins `at` so much of them."""
    quiet = 0.001 * np.random.default_rng(0).normal(size=round(4.0 * RATE_HZ))
    words, talk = said(command, "en-us"), said("the meeting begins at nine", "en-gb-x-rp")
    begin = 0.4 + at * len(words) / RATE_HZ
    quiet[round(0.4 * RATE_HZ) :][: len(words)] += words
    quiet[round(begin * RATE_HZ) :][: len(talk)] += 0.2 * talk
    decision = whisper().decide(heard(quiet[: round(begin * RATE_HZ) + len(talk)], 0.35))
    assert decision.command is not None
    assert decision.command.heard_as == command
    assert decision.said is not None
    assert decision.said[0] == pytest.approx(100.4, abs=0.25)
    assert decision.said[1] == pytest.approx(100.4 + len(words) / RATE_HZ, abs=0.4)


def test_behind_another_talker_it_is_not_the_talk_that_is_taken_for_the_words() -> None:
    quiet = 0.001 * np.random.default_rng(0).normal(size=round(4.0 * RATE_HZ))
    talk, words = said("the meeting begins at nine", "en-gb-x-rp"), said("come here", "en-us")
    begin = 0.4 + len(talk) / RATE_HZ
    quiet[round(0.4 * RATE_HZ) :][: len(talk)] += 0.05 * talk
    quiet[round(begin * RATE_HZ) :][: len(words)] += words
    decision = whisper().decide(heard(quiet[: round(begin * RATE_HZ) + len(words)], 0.4))
    assert decision.command is not None
    assert decision.said is None or decision.said[1] > 100 + begin + 0.3


@pytest.mark.parametrize(
    ("words", "pace"),
    [
        pytest.param("come here", 175, marks=pytest.mark.campaign),
        ("come here", 80),
        pytest.param("stop at 1.5 and 2.5", 175, marks=pytest.mark.campaign),
    ],
)
def test_words_that_fill_their_utterance_and_words_to_nobody_have_its_times(words: str, pace: int) -> None:
    quiet = np.zeros(round(0.3 * RATE_HZ))
    alone = heard(np.concatenate((quiet, said(words, "en-us", pace), quiet)), 0.3)
    decision = whisper().decide(replace(alone, end=alone.end - 0.3))
    assert decision.command is not None
    assert decision.said is None


@pytest.mark.parametrize("longest", [3, pytest.param(MAX_SOUND_S, marks=pytest.mark.campaign)])
def test_words_at_the_end_of_more_sound_than_the_model_knows_are_timed(
    longest: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a bound of 3 s in the place of the model's, which takes ten times as long."""
    monkeypatch.setattr("core.speech.whisper.recognizer.MAX_SOUND_S", longest)
    sound = np.concatenate((np.zeros((longest + 2) * RATE_HZ), said("come here", "en-us"), np.zeros(RATE_HZ)))
    decision = whisper().decide(heard(sound, 0.2))
    assert decision.command is not None
    assert decision.said is not None
    assert decision.said[0] == pytest.approx(102.0 + longest, abs=0.4)
