"""WAV, FLAC and Ogg: what is there is read, what is claimed is checked."""

import struct

import numpy as np
import pytest
import soundfile
from hypothesis import given
from hypothesis import strategies as st

from core.errors import BadInput
from core.recording.sound_file import missing_share, read_sound, write_wav
from core.sensors.microphones import Sound

RNG = np.random.default_rng(0)
SAMPLES = np.round(RNG.uniform(-1, 0.999, (400, 3)) * 32768) / 32768


def wav(form: bytes, body: bytes, told: int | None = None) -> bytes:
    told = len(body) if told is None else told
    return (
        b"RIFF"
        + struct.pack("<I", 9)
        + b"WAVEfmt "
        + struct.pack("<I", len(form))
        + form
        + b"data"
        + struct.pack("<I", told)
        + body
    )


def form(code: int = 1, channels: int = 2, rate: int = 16000, bits: int = 16, block: int | None = None) -> bytes:
    block = channels * bits // 8 if block is None else block
    return struct.pack("<HHIIHH", code, channels, rate, rate * block, block, bits)


def test_what_is_written_is_read_back_exactly(tmp_path):
    path = tmp_path / "a.wav"
    write_wav(path, Sound(stamp=0.0, rate=48000, samples=SAMPLES))
    sound = read_sound(path, stamp=3.0)
    assert sound.rate == 48000 and sound.stamp == 3.0 and np.array_equal(sound.samples, SAMPLES)


@pytest.mark.parametrize("kind", ["WAV", "WAVEX"])
@pytest.mark.parametrize("width", ["PCM_U8", "PCM_16", "PCM_24", "PCM_32", "FLOAT", "DOUBLE"])
def test_every_plain_width_agrees_with_libsndfile(tmp_path, kind, width):
    path = tmp_path / "a.wav"
    soundfile.write(path, SAMPLES, 16000, subtype=width, format=kind)
    theirs, rate = soundfile.read(path, always_2d=True)
    ours = read_sound(path)
    assert ours.rate == rate and ours.samples == pytest.approx(theirs, abs=1e-12)


def test_flac_is_read(tmp_path):
    path = tmp_path / "a.flac"
    soundfile.write(path, SAMPLES, 16000)
    assert np.array_equal(read_sound(path).samples, SAMPLES)


@pytest.mark.parametrize(("width", "rate"), [("VORBIS", 16_000), ("OPUS", 48_000)])
def test_ogg_is_read_as_it_sounds(tmp_path, width, rate):
    path = tmp_path / "a.ogg"
    tone = 0.3 * np.sin(2 * np.pi * 300 * np.arange(rate) / rate)
    soundfile.write(path, np.column_stack((tone, -tone)), rate, format="OGG", subtype=width)
    heard = read_sound(path)
    middle = slice(rate // 4, 3 * rate // 4)
    assert (heard.rate, heard.channels) == (rate, 2)
    assert np.corrcoef(heard.samples[middle, 0], tone[middle])[0, 1] > 0.99


@pytest.mark.parametrize("told", [0, 0xFFFFFFFF, 10**6])
def test_a_recording_that_was_cut_off_gives_the_bytes_that_are_there(tmp_path, told):
    path = tmp_path / "cut.wav"
    path.write_bytes(wav(form(), b"\x01\x00\x02\x00\x03\x00\x04\x00\x05", told))
    assert (read_sound(path).samples * 32768).tolist() == [[1, 2], [3, 4]]


def test_chunks_of_others_are_passed_over(tmp_path):
    path = tmp_path / "list.wav"
    whole = wav(form(channels=1), b"\x01\x00")
    path.write_bytes(whole[:12] + b"LIST" + struct.pack("<I", 3) + b"abc\x00" + whole[12:])
    assert read_sound(path).samples[0, 0] == 1 / 32768


@pytest.mark.parametrize(("kind", "order"), [("RF64", "LITTLE"), ("WAV", "BIG")])
def test_wav_files_beyond_4_gb_and_big_endian_ones_are_read(tmp_path, kind, order):
    path, samples = tmp_path / "other.wav", np.arange(24).reshape(12, 2) / 32768
    soundfile.write(path, samples, 16_000, subtype="PCM_16", format=kind, endian=order)
    assert path.read_bytes()[:4] in (b"RF64", b"RIFX")
    sound = read_sound(path)
    assert sound.rate == 16_000 and np.array_equal(sound.samples, samples)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "empty"),
        (b"RIFF", "neither WAV, FLAC nor Ogg"),
        (b"ID3\x04" + bytes(100), "neither WAV, FLAC nor Ogg"),
        (b"RF64" + bytes(4) + b"WAVE" + bytes(50), "damaged RF64"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 9\n", "git lfs pull"),
        (b"fLaC" + bytes(100), "damaged FLAC"),
        (b"OggS" + bytes(100), "damaged Ogg"),
        (b"RIFF" + bytes(4) + b"WAVE", "no samples"),
        (wav(form(), b""), "no samples"),
        (wav(b"\x01\x00", b"\x00" * 8), "too short"),
        (wav(form(code=2), b"\x00" * 8), "code 2"),
        (wav(form(code=3, bits=16), b"\x00" * 8), "code 3 with 16 bits"),
        (wav(form(channels=0, block=2), b"\x00" * 8), "0 channels"),
        (wav(form(channels=1000), b"\x00" * 8000), "1000 channels"),
        (wav(form(rate=0), b"\x00" * 8), "0 Hz"),
        (wav(form(rate=4_000_000), b"\x00" * 8), "4000000 Hz"),
        (wav(form(block=3), b"\x00" * 12), "cannot be"),
        (wav(struct.pack("<HHIIHH", 1, 2, 16000, 99, 4, 16), b"\x00" * 8), "header is wrong"),
        (wav(form(code=0xFFFE), b"\x00" * 8), "coded in a way"),
        (wav(form(code=3, bits=32, channels=1), struct.pack("<f", float("nan"))), "no numbers"),
        (b"RIFF" + bytes(4) + b"WAVEdata" + struct.pack("<I", 4) + bytes(4), "before it says"),
    ],
)
def test_files_that_lie_or_are_damaged_are_refused_in_a_sentence(tmp_path, content, words):
    path = tmp_path / "bad.wav"
    path.write_bytes(content)
    with pytest.raises(BadInput, match=words):
        read_sound(path)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(BadInput, match="no file"):
        read_sound(tmp_path / "none.wav")


@pytest.mark.parametrize(("kept", "missing"), [(1.0, 0.0), (0.6, 0.4)])
def test_how_much_of_a_cut_file_is_missing_is_known(tmp_path, kept, missing):
    path = tmp_path / "a.wav"
    write_wav(path, Sound(stamp=0.0, rate=16000, samples=np.zeros((16000, 2))))
    whole = path.read_bytes()
    path.write_bytes(whole[: round(kept * len(whole))])
    assert missing_share(path) == pytest.approx(missing, abs=1e-3)
    path.write_bytes(whole.replace(b"data" + struct.pack("<I", 64000), b"data\xff\xff\xff\xff"))
    assert missing_share(path) == 0.0


@given(place=st.integers(0, 43), value=st.integers(0, 255))
def test_no_byte_of_a_header_makes_the_reader_stumble(tmp_path_factory, place, value):
    whole = bytearray(wav(form(), b"\x01\x00" * 40))
    whole[place] = value
    path = tmp_path_factory.mktemp("fuzz") / "a.wav"
    path.write_bytes(bytes(whole))
    try:
        assert len(read_sound(path).samples) <= 80
    except BadInput as trouble:
        assert str(trouble).endswith((".", "?"))


@pytest.mark.parametrize("shift", [0, 1])
def test_sound_whose_bytes_are_in_the_other_order_is_refused_and_noise_is_not(tmp_path, shift):
    path = tmp_path / "a.wav"
    tone = 0.2 * np.sin(2 * np.pi * 300 * np.arange(16000) / 16000)
    whole = np.round(np.column_stack((tone, -tone)) * 32768).astype(">i2" if shift == 0 else "<i2").tobytes()
    path.write_bytes(wav(form(), b"\0" * shift + whole[: len(whole) - 4 * shift]))
    with pytest.raises(BadInput, match="bytes in the other order"):
        read_sound(path)
    path.write_bytes(wav(form(), np.round(RNG.uniform(-1, 0.999, (16000, 2)) * 32768).astype("<i2").tobytes()))
    assert read_sound(path).channels == 2
