"""Sound files of every form that is read, as strangers' programs write them."""

import struct
from pathlib import Path

import numpy as np

from core.message import Array

FORMS = ("pcm8", "pcm16", "pcm24", "pcm32", "float32", "float64", "flac")


def write_sound(path: Path, samples: Array, rate: int, form: str) -> None:
    """Samples (N, C) of full scale ±1 in one of FORMS; whole numbers clip, floats stay as they are."""
    if form == "flac":
        import soundfile

        soundfile.write(path, np.clip(samples, -1, 1), rate, format="FLAC")
        return
    bits = int(form.lstrip("pcmfloat"))
    body, channels = body_of(samples, form, bits), samples.shape[1]
    block = channels * bits // 8
    code = 3 if form.startswith("float") else 1
    head = b"WAVEfmt " + struct.pack("<IHHIIHH", 16, code, channels, rate, rate * block, block, bits)
    whole = head + b"data" + struct.pack("<I", len(body)) + body
    path.write_bytes(b"RIFF" + struct.pack("<I", len(whole)) + whole)


def body_of(samples: Array, form: str, bits: int) -> bytes:
    if form.startswith("float"):
        with np.errstate(over="ignore"):
            return samples.astype(f"<f{bits // 8}").tobytes()
    full = 2.0 ** (bits - 1)
    whole = np.clip(np.round(samples * full), -full, full - 1).astype("<i4")
    if bits == 8:
        return (whole + 128).astype(np.uint8).tobytes()
    width = bits // 8
    return whole.reshape(-1, 1).view(np.uint8)[:, :width].tobytes()
