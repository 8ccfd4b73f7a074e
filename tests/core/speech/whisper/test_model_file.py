"""Model files come from elsewhere: whatever is in them, there is a sentence."""

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.errors import BadInput
from core.speech.whisper.model_file import ModelFile
from core.speech.whisper.recognizer import WhisperRecognizer
from core.speech.whisper.tokenizer import Tokenizer


def text(words: str) -> bytes:
    return struct.pack("<H", len(words) + 1) + words.encode() + b"\0"


def variable(name: str, values: np.ndarray, kind: int, size: int | None = None) -> bytes:
    shape = b"".join(struct.pack("<I", length) for length in values.shape)
    raw = values.tobytes()
    return (
        text(name) + bytes([values.ndim]) + shape + struct.pack("<BI", kind, len(raw) if size is None else size) + raw
    )


HEAD = struct.pack("<I", 6) + text("WhisperSpec") + struct.pack("<II", 3, 1)
WEIGHT = np.arange(6, dtype=np.float16).reshape(2, 3)
GOOD = HEAD + variable("w", WEIGHT, 4) + struct.pack("<I", 0)


def model(folder: Path, raw: bytes) -> ModelFile:
    (folder / "model.bin").write_bytes(raw)
    return ModelFile(folder / "model.bin")


def test_a_variable_is_read_as_32_bit_floats_and_checked_for_its_shape(tmp_path):
    read = model(tmp_path, GOOD)
    assert np.array_equal(read.get("w", 2, None), WEIGHT.astype(np.float32))
    for wrong in (("w", 3, 2), ("w", 6), ("absent", 2, 3)):
        with pytest.raises(BadInput, match="English-only Whisper model"):
            read.get(*wrong)


@pytest.mark.parametrize(
    "raw",
    [
        b"",
        b"\0" * 100,
        struct.pack("<I", 6) + text("OtherSpec") + GOOD[20:],
        struct.pack("<I", 6) + text("WhisperSpec") + struct.pack("<II", 3, 2**32 - 1),
        HEAD + text("w") + b"\xff" + b"\xff" * 1020,
        HEAD + text("w") + b"\x03" + struct.pack("<III", *3 * (2**32 - 1,)) + struct.pack("<BI", 4, 2**32 - 1),
        HEAD + variable("w", WEIGHT, 9),
        HEAD + variable("w", WEIGHT, 4, size=2**31),
        HEAD + b"\x03\x00\xff\xfe\x00",
    ],
)
def test_a_file_that_is_no_model_is_refused_with_a_sentence(tmp_path, raw):
    with pytest.raises(BadInput, match=r"model.bin.*Get the model again\.$"):
        model(tmp_path, raw)


@given(length=st.integers(0, len(GOOD) - 5))
def test_a_cut_file_is_refused_wherever_it_ends(tmp_path_factory, length):
    with pytest.raises(BadInput):
        model(tmp_path_factory.mktemp("cut"), GOOD[:length])


@given(at=st.integers(0, len(HEAD) + 15), byte=st.integers(0, 255))
def test_a_changed_byte_of_the_head_is_read_or_refused_and_never_an_accident(tmp_path_factory, at, byte):
    raw = bytearray(GOOD)
    raw[at] = byte
    try:
        model(tmp_path_factory.mktemp("changed"), bytes(raw)).get("w", 2, 3)
    except BadInput as refusal:
        assert str(refusal).endswith((".", '"'))


def test_numbers_that_are_not_finite_are_refused(tmp_path):
    bad = HEAD + variable("w", np.full((2, 3), np.nan, np.float16), 4) + struct.pack("<I", 0)
    with pytest.raises(BadInput, match="not finite"):
        model(tmp_path, bad).get("w", 2, 3)


@pytest.mark.parametrize(
    "raw",
    [
        b"",
        b"{}",
        b"[" * 100_000,
        b'{"model": {"vocab": {"a": 0}, "merges": []}}',
        b"\xff",
        b'{"model": {"vocab": 1}}',
    ],
)
def test_a_tokenizer_that_is_none_is_refused_with_a_sentence(tmp_path, raw):
    (tmp_path / "tokenizer.json").write_bytes(raw)
    with pytest.raises(BadInput, match="no usable tokenizer"):
        Tokenizer(tmp_path / "tokenizer.json")


def test_a_folder_without_files_is_refused_with_a_sentence(tmp_path):
    with pytest.raises(BadInput):
        WhisperRecognizer(tmp_path)
