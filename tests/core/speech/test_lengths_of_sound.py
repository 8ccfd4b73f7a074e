"""Sound of any length, in pieces of any length: nothing that listens breaks, and what it hears stays the same."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.errors import BadInput
from core.perception.sound.array_diagnostics import check
from core.perception.sound.array_orientation import heard_from
from core.perception.sound.doa_stream import DoaStream
from core.pipelines.hear import PIECE_S, RecordingTranscriber
from core.sensors.microphones import MAX_SAMPLE, RESPEAKER_ODAS, MicrophoneArray, Sound
from core.settings import Settings
from core.speech.practice_voice import practice_voice
from core.speech.recognition.endpointing import FRAME_SAMPLES, HOP_SAMPLES, Endpointer, Held
from core.speech.recognition.recognizer import at_16_khz
from core.speech.settings import RATE_HZ
from core.speech.sphinx.decoded_path import NOTHING, decoded
from core.speech.sphinx.keyword_spotting import SphinxKeywordSpotter
from core.speech.transcription.array_transcriber import ArrayTranscriber
from core.speech.transcription.transcriber import Transcriber
from tests.benchmarks.random_sounds import ENTRANCES, ROUND, visit
from tests.core.speech.ears import engine, padded
from tests.sound_files import FORMS, write_sound

BLOCKS = (HOP_SAMPLES, FRAME_SAMPLES, round(PIECE_S * RATE_HZ))
AROUND = sorted({0, 1, *(block + more for block in BLOCKS for more in (-1, 0, 1))})
NUMBERS = (np.nan, np.inf, -np.inf, 1e300)


def murmur(count: int, channels: int = 1, stamp: float = 0.0, rate: int = RATE_HZ) -> Sound:
    samples = 1e-3 * np.random.default_rng(count).normal(size=(count, channels))
    return Sound(stamp=stamp, rate=rate, samples=samples)


def in_a_row(lengths: list[int], channels: int) -> list[Sound]:
    """Pieces of these lengths that follow each other."""
    begins = np.cumsum([0, *lengths])
    return [murmur(count, channels, at / RATE_HZ) for count, at in zip(lengths, begins, strict=False)]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("number", NUMBERS)
def test_what_is_no_number_is_refused_before_it_is_resampled(number: float) -> None:
    samples = murmur(480, 2, rate=48_000).samples.copy()
    samples[7, 1] = number
    with pytest.raises(BadInput):
        at_16_khz(Sound(stamp=0.0, rate=48_000, samples=samples))


@given(st.integers(0, 5_000), st.integers(1, 200_000), st.floats(1e-6, 5.0), st.floats(-1e6, 1e9))
def test_a_sound_in_pieces_is_that_sound(count: int, rate: int, longest: float, stamp: float) -> None:
    whole = Sound(stamp=stamp, rate=rate, samples=np.arange(float(count))[:, None])
    pieces = list(whole.pieces(longest))
    assert all(len(piece.samples) for piece in pieces)
    assert all(len(piece.samples) <= max(round(longest * rate), 1) for piece in pieces)
    again = [piece.samples for piece in pieces] or [np.zeros((0, 1))]
    assert np.array_equal(np.concatenate(again), whole.samples)
    assert all(piece.stamp == stamp + piece.samples[0, 0] / rate for piece in pieces)


def test_the_ears_take_pieces_of_any_length_after_each_other() -> None:
    lengths = np.random.default_rng(5).permutation(2 * AROUND).tolist()
    pieces = in_a_row([0, *lengths, 0], 4)
    for ears in (
        Transcriber(recognizer=engine()),
        Transcriber(recognizer=engine(), held=True),
        SphinxKeywordSpotter(),
    ):
        for piece in pieces:
            assert ears.feed(Sound(stamp=piece.stamp, rate=RATE_HZ, samples=piece.samples[:, :1])) == ()
        assert isinstance(ears, SphinxKeywordSpotter) or ears.finish() == ()
    array, directions = ArrayTranscriber(RESPEAKER_ODAS, recognizer=engine()), DoaStream(RESPEAKER_ODAS)
    for piece in pieces:
        assert array.feed(piece) == () == directions.feed(piece)
    assert array.finish() == ()


def test_where_pieces_are_empty_the_utterances_are_the_same() -> None:
    samples = padded(0.1 * practice_voice(np.random.default_rng(1), 1.2, RATE_HZ))
    whole = Sound(stamp=3.0, rate=RATE_HZ, samples=samples[:, None])
    found = []
    for empties in (0, 2):
        for ears in (Endpointer(), Held()):
            told = []
            for piece in whole.pieces(0.02):
                told += ears.feed(piece)
                for _ in range(empties):
                    told += ears.feed(
                        Sound(stamp=piece.stamp + piece.duration, rate=RATE_HZ, samples=samples[:0, None])
                    )
            told += ears.finish()
            found.append([(one.begin, one.end, one.sound.stamp, len(one.samples)) for one in told])
    assert found[:2] == found[2:] and all(found)


def test_nothing_said_is_nothing_decoded() -> None:
    assert decoded(engine()._quick, np.zeros(0)) == NOTHING


@pytest.mark.parametrize("rate", [8_000, 11_025, 12_345, 16_000, 44_100, 192_000])
@pytest.mark.parametrize("count", [0, 1, 2, 1023])
def test_any_rate_becomes_16_khz(rate: int, count: int) -> None:
    told = at_16_khz(murmur(count, 3, 1.0, rate))
    assert (told.rate, told.channels, told.stamp) == (RATE_HZ, 3, 1.0)
    assert abs(told.duration - count / rate) < 1 / RATE_HZ


@pytest.fixture(scope="module")
def wordy() -> RecordingTranscriber:
    engine()
    return RecordingTranscriber(Settings())


@pytest.mark.parametrize("count", [1, 7_999, 8_000, 8_001, 8_351, 14_720, 16_000])
def test_a_file_of_any_length_is_heard_to_its_end(wordy: RecordingTranscriber, tmp_path: Path, count: int) -> None:
    """Of 8,351 and 14,720 samples the last piece was once empty: the parts' times do not add up to the whole's."""
    write_sound(tmp_path / "a.wav", murmur(count).samples, RATE_HZ, "pcm16")
    assert wordy.hear(tmp_path / "a.wav")["audio_s"] == pytest.approx(count / RATE_HZ)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("rate", [11_025, 96_000])
def test_files_of_every_form_hold_what_was_written(tmp_path: Path, form: str, rate: int) -> None:
    from core.recording.sound_file import read_sound

    samples = np.clip(murmur(777, 5, rate=rate).samples * 300, -1, 1)
    write_sound(tmp_path / "a.sound", samples, rate, form)
    told = read_sound(tmp_path / "a.sound")
    assert (told.rate, told.channels) == (rate, 5)
    assert np.abs(told.samples - samples).max() <= {"pcm8": 2.0**-7, "pcm16": 2.0**-15}.get(form, 2.0**-15)


@pytest.mark.parametrize("number", NUMBERS)
def test_ears_hear_again_after_samples_that_are_no_numbers(number: float) -> None:
    array = RESPEAKER_ODAS
    spoilt = murmur(RATE_HZ // 10, 4).samples.copy()
    spoilt[77, 2] = number
    directions, words = DoaStream(array), ArrayTranscriber(array, recognizer=engine())
    for ears in (directions, words):
        with pytest.raises(BadInput, match="no numbers"):
            ears.feed(Sound(stamp=0.0, rate=RATE_HZ, samples=spoilt))
        assert ears.feed(murmur(RATE_HZ, 4, 0.1)) == ()


@pytest.mark.parametrize("number", NUMBERS)
def test_a_file_with_samples_that_are_no_numbers_is_refused(
    wordy: RecordingTranscriber, tmp_path: Path, number: float
) -> None:
    samples = murmur(RATE_HZ).samples.copy()
    samples[3] = number
    write_sound(tmp_path / "a.wav", samples, RATE_HZ, "float64")
    with pytest.raises(BadInput, match="no numbers"):
        wordy.hear(tmp_path / "a.wav")
    samples[3] = MAX_SAMPLE / 2  # absurd, but a number
    write_sound(tmp_path / "a.wav", samples, RATE_HZ, "float64")
    assert wordy.hear(tmp_path / "a.wav")["directions"] == []


@pytest.mark.parametrize("count", [0, 1, 2, FRAME_SAMPLES, 1023, 1024])
@pytest.mark.parametrize("array", [RESPEAKER_ODAS, MicrophoneArray(positions=0.04 * np.eye(2, 3), name="line")])
def test_the_self_check_of_an_array_takes_the_shortest_sound(array: MicrophoneArray, count: int) -> None:
    kinds = {fault.kind for fault in check(murmur(count, 4), array)}
    assert ("short" in kinds) == (count < 1024)
    with pytest.raises(BadInput, match=r"too short|noise"):
        heard_from(murmur(count, 4), array)


@pytest.mark.campaign
def test_sounds_at_random_break_none_of_the_entrances() -> None:
    """The first of `python -m tests.benchmarks.random_sounds`."""
    engine()
    told = [visit(number) for number in range(len(ENTRANCES))]
    assert [one.crash for one in told if one.crash] == []
    assert sum(one.sounds for one in told) == ROUND
    assert sum(one.refused for one in told) < ROUND / 2
