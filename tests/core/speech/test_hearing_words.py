"""The default recognizer, without recordings: what it must not hear, and what competes with the commands."""

from pathlib import Path

import numpy as np
import pytest

from core.recording.sound_file import read_sound
from core.sensors.microphones import Sound
from core.speech.practice_voice import practice_voice
from core.speech.recognition.decision import Decision, RecognizedUtterance, stop
from core.speech.recognition.recognizer import Utterance, at_16_khz
from core.speech.settings import RATE_HZ
from core.speech.sphinx.garbage_model import (
    choose,
    command_words,
    fixed_words,
    grammar,
    openings,
    phones_of,
    read_dictionary,
)
from core.speech.sphinx.jsgf import NUMBER_RULES, words_of
from core.speech.transcription.transcriber import Transcriber
from core.speech.understanding.grammar import OwnPhrases, parse
from tests.core.speech.ears import engine, listened, mono, padded, pieces, sure, unsure

DICTIONARY = {
    "turn": (("T", "ER", "N"),),
    "burn": (("B", "ER", "N"),),
    "turner": (("T", "ER", "N", "ER"),),
    "a": (("AH",), ("EY",)),
    "window": (("W", "IH", "N", "D", "OW"),),
    "garden": (("G", "AA", "R", "D", "AH", "N"),),
    "zebra": (("Z", "IY", "B", "R", "AH"),),
}


def test_words_that_resemble_a_command_and_very_short_ones_do_not_compete():
    often = {"a": 9.0, "burn": 8.0, "turner": 7.0, "turn": 6.0, "garden": 5.0, "window": 5.0, "zebra": 1.0}
    assert choose(DICTIONARY, often.__getitem__, 2) == ("garden", "window")
    assert choose(DICTIONARY, often.__getitem__, 10) == ("garden", "window", "zebra")


def test_the_most_common_words_that_resemble_a_command_compete_too_but_for_those_that_sound_like_it():
    dictionary = DICTIONARY | {"tern": (("T", "ER", "N"),)}
    often = {"a": 9.0, "tern": 8.5, "burn": 8.0, "turner": 7.0, "turn": 6.0, "garden": 5.0, "window": 4.0}
    assert choose(dictionary, lambda word: often.get(word, 0.0), 1, 1) == ("garden", "burn")
    assert choose(dictionary, lambda word: often.get(word, 0.0), 1, 9) == ("garden", "burn", "turner")


def test_words_that_resemble_a_number_only_are_no_rivals():
    """Numbers that are said unclearly would be lost; they are read more than once instead."""
    dictionary = DICTIONARY | {"seven": (("S", "EH", "V", "AH", "N"),), "eleven": (("EH", "V", "AH", "N"),)}
    assert "eleven" not in choose(dictionary | {"heaven": (("HH", "EH", "V", "AH", "N"),)}, len, 0, 9)
    assert "heaven" not in choose(dictionary | {"heaven": (("HH", "EH", "V", "AH", "N"),)}, len, 9, 9)


def test_a_dictionary_is_read_for_the_words_that_are_needed_and_its_phones(tmp_path):
    file = tmp_path / "words.dict"
    file.write_text("a AH\na(2) EY\nturn T ER N\nwindow W IH N D OW\n")
    assert read_dictionary(file, {"a", "turn", "absent"}) == {"a": (("AH",), ("EY",)), "turn": (("T", "ER", "N"),)}
    assert phones_of(file) == ("AH", "D", "ER", "EY", "IH", "N", "OW", "T", "W")


def test_numbers_are_words_of_commands():
    assert {"turn", "meters", "minus", "point", "wall"} <= command_words()
    assert fixed_words() == command_words() - set(words_of(NUMBER_RULES.values()))


def test_the_grammar_holds_all_that_competes_with_its_price():
    text = grammar(("garden", "window"), 30_000)
    assert "/30000/ antidisestablishmentarianism | /1/ garden | /1/ window" in text
    assert "public <heard> = <other>+;" in text


def test_the_first_words_of_commands_compete_with_the_commands():
    """What begins like a command and goes on otherwise is none."""
    text = grammar(("garden",), 30_000)
    (loop,) = (line for line in text.splitlines() if line.startswith("<other>"))
    assert {"turn", "stop", "follow", "come", "go"} <= set(openings()) <= command_words() - {"continue"}
    assert all(f"/1/ {word}" in loop for word in openings()) and "/1/ meters" not in loop


@pytest.mark.parametrize("noise", ["white", "babble without words", "silence", "clicks"])
def test_noise_is_no_command(noise):
    rng = np.random.default_rng(11)
    length = RATE_HZ
    samples = {
        "white": 0.05 * rng.normal(size=length),
        "babble without words": 0.05 * practice_voice(rng, 1.0, RATE_HZ)[:length],
        "silence": np.zeros(length),
        "clicks": np.where(rng.random(length) < 0.001, 0.5, 0.0),
    }[noise]
    told = listened(Transcriber(recognizer=engine()), padded(samples))
    assert [one.decision.words for one in told if one.decision.verdict != "reject"] == []


class HearsStop:
    """Tells one STOP, as if it ended at `END`."""

    END = 4.0  # [s]

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        return (RecognizedUtterance(begin=self.END - 0.3, end=self.END, decision=stop(), final=False),)


class HearsCommand:
    """Decides about every utterance alike."""

    def __init__(self, decision: Decision) -> None:
        self._decision = decision

    def decide(self, utterance: Utterance) -> Decision:
        return self._decision


def test_a_stop_does_not_overtake_what_was_said_before_it():
    """A slow reader gets seconds of sound at once; the robot must not set off after the stop."""
    sentence = 0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)
    transcriber = Transcriber(recognizer=HearsCommand(sure("turn left")), spotter=HearsStop())
    told = transcriber.feed(mono(padded(sentence, tail=3.0)))
    assert [one.decision.words for one in told] == ["turn left", "stop"]


class HearsNothing:
    """Spots no STOP."""

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        return ()


@pytest.mark.parametrize(
    ("decision", "early"),
    [
        (sure("stop moving"), True),
        (unsure("stop"), True),
        (unsure("stop at one and two"), True),
        (sure("stop at one and two"), False),
        (sure("turn left"), False),
        (sure(""), False),
    ],
)
def test_a_stop_that_is_read_in_a_pause_is_told_at_once(decision, early):
    """Not only when the sentence is over; what else was read waits for that."""
    transcriber = Transcriber(recognizer=HearsCommand(decision), spotter=HearsNothing())
    told, spoken = [], 0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)
    for piece in pieces(padded(spoken, tail=1.5)):
        told += [(one, piece.stamp) for one in transcriber.feed(piece)]
    assert [one.final for one, _ in told] == [False] * (len(told) - 1) + [True]  # the voice may pause in between, too
    assert (len(told) > 1) == early
    if early:
        (first, when), (_, over) = told[-2:]
        assert first.decision.stops
        assert when - first.end < 0.35 < over - first.end


@pytest.mark.parametrize(
    ("words", "silence"),
    [
        ("turn left", 0.3),
        ("continue 2 meters", 0.3),
        ("stop at 1 and 2", 0.45),  # point five
        ("stop", 0.45),  # at one and two
        ("start", 0.8),  # the first half of "stop moving" beside motors
        ("", 0.8),
    ],
)
def test_a_sentence_that_cannot_go_on_is_over_sooner(words, silence):
    transcriber = Transcriber(recognizer=HearsCommand(sure(words)), spotter=HearsNothing())
    spoken = 0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)
    told = [
        (one, piece.stamp + piece.duration)
        for piece in mono(padded(spoken, tail=1.5)).pieces(0.05)
        for one in transcriber.feed(piece)
        if one.final
    ]
    (one, when) = told[0]
    assert silence < when - one.end < silence + 0.1


class HearsLater(HearsCommand):
    """Reads another command where less than `silence` [s] follows the voice."""

    def __init__(self, decision: Decision, before: Decision, silence: float) -> None:
        super().__init__(decision)
        self._before, self._silence = before, silence

    def decide(self, utterance: Utterance) -> Decision:
        left = utterance.sound.stamp + utterance.sound.duration - utterance.end
        return self._before if left < self._silence else self._decision


@pytest.mark.parametrize(("first", "last"), [("start", "stop moving"), ("turn left", "turn left")])
def test_start_is_read_again_with_all_that_follows(first, last):
    """Beside motors "start" is often the first half of "stop moving"; of other words the first reading counts."""
    reads = HearsLater(sure("stop moving"), sure(first), 0.25)
    spoken = 0.1 * practice_voice(np.random.default_rng(3), 1.0, RATE_HZ)
    told = listened(Transcriber(recognizer=reads, spotter=HearsNothing()), padded(spoken, tail=1.5))
    assert [one.decision.words for one in told if one.final] == [last]


@pytest.mark.real_data
@pytest.mark.parametrize("name", ["flite_slt_00.flac", "flite_slt_02.flac"])
def test_every_sentence_that_was_heard_is_parsed_once(
    name: str, shared_data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However many views of the sound were read, and whatever was weighed against it."""
    calls: list[str] = []

    def counted(words: str, own: OwnPhrases = ()) -> object:
        calls.append(words)
        return parse(words, own)

    monkeypatch.setattr("core.speech.recognition.decision.parse", counted)
    samples = at_16_khz(read_sound(shared_data / "speech_commands_tts" / name)).samples[:, 0]
    told = listened(Transcriber(recognizer=engine()), padded(samples))
    assert [one.decision.verdict for one in told if one.final] != ["reject"]
    assert calls and len(calls) == len(set(calls))
