"""Words in recordings: commands kept, ordinary speech refused, STOP before the sentence is over."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from core.message import Array
from core.recording.sound_file import read_sound
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.recognition.recognizer import for_words
from core.speech.settings import RATE_HZ
from core.speech.synthesis import PERSONS_VOICE
from core.speech.transcription.transcriber import Transcriber
from tests.benchmarks.spoken_stop import clips
from tests.benchmarks.words import end_of_stop
from tests.core.speech.ears import engine, listened, padded

pytestmark = pytest.mark.real_data


def clip(shared_data: Path, name: str) -> Array:
    return for_words(read_sound(shared_data / name)).samples[:, 0]


@cache
def heard(path: Path, *, held: bool = False) -> tuple[RecognizedUtterance, ...]:
    samples = for_words(read_sound(path)).samples[:, 0]
    return tuple(listened(Transcriber(recognizer=engine(), held=held), padded(samples)))


def finals(told: tuple[RecognizedUtterance, ...]) -> list[RecognizedUtterance]:
    return [one for one in told if one.final]


@pytest.mark.parametrize(
    ("name", "echo"),
    [pytest.param("flite_slt_00", "turn left", marks=pytest.mark.campaign), ("flite_slt_20", "stop at 3.2 and -0.8")],
)
def test_a_synthetic_command_is_heard_with_its_numbers(shared_data, name, echo):
    (final,) = finals(heard(shared_data / "speech_commands_tts" / f"{name}.flac"))
    assert final.decision.echo == echo


def test_stop_is_told_before_the_sentence_that_begins_with_it_is_over(shared_data):
    told = heard(shared_data / "speech_commands_tts" / "flite_slt_20.flac")
    assert not told[0].final
    assert told[0].decision.stops
    assert told[0].end < told[-1].end - 1.5


def test_hold_to_talk_needs_no_pause_before_and_after(shared_data):
    path = shared_data / "speech_commands_tts" / "flite_slt_01.flac"
    told = [*listened(Transcriber(recognizer=engine(), held=True), for_words(read_sound(path)).samples[:, 0])]
    assert finals(tuple(told))[0].decision.echo == "turn right"


@pytest.mark.parametrize("name", ["goforward"])
def test_ordinary_speech_moves_nothing(shared_data, name):
    for one in finals(heard(shared_data / "speech_real" / f"{name}.flac")):
        assert one.decision.verdict == "reject"


def test_more_than_a_command_is_no_command(shared_data):
    index = (shared_data / "speech_commands_tts" / "index.tsv").read_text().splitlines()
    name = next(line.split("\t")[0] for line in index if "\tfollow my instructions\t" in line)
    (final,) = finals(heard(shared_data / "speech_commands_tts" / name))
    assert final.decision.verdict == "reject"


def test_a_sentence_cut_off_by_the_button_is_not_obeyed(shared_data):
    samples = clip(shared_data, "speech_commands_tts/flite_slt_09.flac")
    cut = samples[: int(0.62 * len(samples))]
    told = listened(Transcriber(recognizer=engine(), held=True), np.concatenate((np.zeros(8000), cut)))
    assert all(one.decision.verdict == "reject" for one in told)


@pytest.mark.parametrize("voice", ["slt", "kal16", PERSONS_VOICE])
def test_the_benchmark_of_stop_knows_when_its_word_is_over(shared_data, voice):
    pytest.importorskip("pocketsphinx", reason="Recognising words needs pocketsphinx: pip install pocketsphinx")
    spoken = clips(shared_data)[voice]
    assert 0.2 < end_of_stop(spoken) < 0.7 * len(spoken.samples) / RATE_HZ
