"""Sound files: WAV by an own strict reader that counts bytes and believes no header, others through libsndfile."""

import struct
from pathlib import Path
from typing import Literal

import numpy as np

from core.errors import BadInput, Unavailable
from core.files import write_atomic
from core.install import install_packages
from core.message import Array
from core.recording.source import open_file
from core.sensors.microphones import Sound, usable

MAX_FILE_BYTES = 2_000_000_000  # of a file
MAX_DURATION_S = 4 * 3600.0  # of one sound
MOST_SAMPLES = 300_000_000  # of all channels together
MOST_CHANNELS = 64
RATE_BOUNDS_HZ = (4_000, 192_000)
UNFINISHED_BYTES = 0x7FFFF000  # from which a size stands for an unknown one, as of what came through a pipe
MIN_NOISE_LEVEL = 0.3  # of full scale, from which on samples may be noise of exchanged bytes
MAX_SWAPPED_STEPS = 0.25  # times the steps from sample to sample when such bytes are put right
PCM_CODE, FLOAT_CODE, EXTENSIBLE_CODE = 1, 3, 0xFFFE
EXTENSION_TAIL = bytes.fromhex("000000001000800000aa00389b71")  # of the identifiers that stand for plain codes


def read_sound(path: str | Path, stamp: float = 0.0) -> Sound:
    """A WAV, FLAC or Ogg file → its sound, as it is: no resampling. Raises BadInput with a sentence."""
    place = Path(path)
    with open_file(place, MAX_FILE_BYTES) as file:
        head = file.read(12)
    if head[:4] == b"RIFF" and head[8:] == b"WAVE":
        rate, samples = _wav(place)
    elif head[:4] == b"fLaC":
        rate, samples = _compressed(place, "FLAC")
    elif head[:4] == b"OggS":
        rate, samples = _compressed(place, "Ogg")
    elif head[:4] in (b"RF64", b"RIFX"):  # larger than 4 GB; big-endian
        rate, samples = _compressed(place, head[:4].decode())
    else:
        raise BadInput(f"{place.name} is neither WAV, FLAC nor Ogg; convert it to one of them.")
    if not usable(samples):
        raise BadInput(f"{place.name} holds samples that are no numbers, or far beyond full scale; it is damaged.")
    return Sound(stamp=stamp, rate=rate, samples=samples)


def write_wav(path: Path, sound: Sound) -> None:
    """Write a sound as 16-bit WAV; what exceeds full scale is cut off."""
    write_atomic(path, wav_bytes(sound))


def wav_bytes(sound: Sound) -> bytes:
    """A sound as the bytes of a 16-bit WAV file; what exceeds full scale is cut off."""
    whole = np.clip(np.round(sound.samples * 32768), -32768, 32767).astype("<i2").tobytes()
    width = 2 * sound.channels
    form = struct.pack("<HHIIHH", PCM_CODE, sound.channels, sound.rate, sound.rate * width, width, 16)
    body = b"WAVEfmt " + struct.pack("<I", len(form)) + form + b"data" + struct.pack("<I", len(whole)) + whole
    return b"RIFF" + struct.pack("<I", len(body)) + body


def missing_share(path: Path) -> float:
    """Return the share of its samples that a WAV file announces and does not hold, as one that was cut; 0: none."""
    with open_file(path, MAX_FILE_BYTES) as file:
        if file.read(4) != b"RIFF":
            return 0.0
    _, _, announced, held = _data_of(path)
    return 0.0 if announced >= UNFINISHED_BYTES else 1 - held / max(announced, held, 1)


def _wav(path: Path) -> tuple[int, Array]:
    """The samples that are there; sizes in headers only ever shorten."""
    form, begin, _, held = _data_of(path)
    with open_file(path, MAX_FILE_BYTES) as file:
        file.seek(begin)
        return _samples(path.name, form, file.read(held))


def _data_of(path: Path) -> tuple[bytes, int, int, int]:
    """Walk the chunks → the format, where the samples begin, how many bytes of them are announced, and are held."""
    with open_file(path, MAX_FILE_BYTES) as file:
        size = file.seek(0, 2)
        form: bytes | None = None
        at = 12
        while at + 8 <= size:
            file.seek(at)
            name, declared = struct.unpack("<4sI", file.read(8))
            there = min(declared, size - at - 8)
            if name == b"fmt ":
                form = file.read(min(there, 64))
            elif name == b"data":
                if form is None:
                    raise BadInput(f"{path.name} has samples before it says what they are; it is damaged.")
                unfinished = declared in (0, 0xFFFFFFFF)  # a recorder that was cut off never wrote the size
                return form, at + 8, 0 if unfinished else declared, size - at - 8 if unfinished else there
            at += 8 + declared + declared % 2
    raise BadInput(f"{path.name} holds no samples; it was cut off, or its header lies about where they are.")


def _samples(name: str, form: bytes, body: bytes) -> tuple[int, Array]:
    """The format chunk and the bytes of the samples → rate [Hz], samples (N, C) of full scale ±1."""
    if len(form) < 16:
        raise BadInput(f"{name} has a format header that is too short; it is damaged.")
    code, channels, rate, pace, block, bits = struct.unpack("<HHIIHH", form[:16])
    if code == EXTENSIBLE_CODE:
        if len(form) < 40 or form[26:40] != EXTENSION_TAIL:
            raise BadInput(f"{name} is coded in a way that is not read here; save it as 16-bit PCM.")
        code = int.from_bytes(form[24:26], "little")
    _check(name, rate, channels)
    if (code, bits) not in (
        (PCM_CODE, 8),
        (PCM_CODE, 16),
        (PCM_CODE, 24),
        (PCM_CODE, 32),
        (FLOAT_CODE, 32),
        (FLOAT_CODE, 64),
    ):
        raise BadInput(f"{name} has samples of code {code} with {bits} bits; save it as 16-bit PCM.")
    width = bits // 8
    if block != channels * width:
        raise BadInput(
            f"{name} says {block} bytes for {channels} channels of {bits} bits, which cannot be; its header is wrong."
        )
    if pace not in (0, rate * block):
        raise BadInput(f"{name} says {rate} Hz but {pace} bytes a second; its header is wrong.")
    count = len(body) // block
    if not count:
        raise BadInput(f"{name} holds no samples.")
    _check_length(name, count, channels, rate)
    kind = "f" if code == FLOAT_CODE else "u" if width == 1 else "i"
    samples = decoded_samples(body[: count * block], kind, width).reshape(count, channels)
    if (kind, width) == ("i", 2) and _is_swapped(samples, body[: count * block]):
        raise BadInput(
            f"{name} holds noise that is sound with its bytes in the other order, or shifted by one: it was written "
            "wrongly. Convert it again, as 16-bit PCM of little-endian order."
        )
    return rate, samples


def _is_swapped(samples: Array, packed: bytes) -> bool:
    """Return whether 16-bit samples are loud noise, and a sound once their bytes are exchanged."""
    level = float(np.sqrt(np.mean(samples**2)))
    if level < MIN_NOISE_LEVEL:
        return False
    exchanged = decoded_samples(packed, "i", 2, ">").reshape(samples.shape)
    steps, noise = (np.abs(np.diff(each, axis=0)).mean() for each in (exchanged, samples))
    return bool(steps < MAX_SWAPPED_STEPS * noise)


def decoded_samples(packed: bytes, kind: Literal["f", "i", "u"], width: int, order: Literal["<", ">"] = "<") -> Array:
    """Bytes of samples, floats or whole numbers of `width` bytes with or without a sign → full scale ±1."""
    if width == 3:  # the upper three of four bytes
        triples = np.frombuffer(packed, np.uint8).reshape(-1, 3)
        wide = np.zeros((len(triples), 4), np.uint8)
        wide[:, 1:] = triples[:, ::-1] if order == ">" else triples
        packed, order, width = wide.tobytes(), "<", 4
    numbers = np.frombuffer(packed, f"{order}{kind}{width}").astype(np.float64)
    half = 2.0 ** (8 * width - 1)
    return numbers if kind == "f" else (numbers - half * (kind == "u")) / half


def _compressed(path: Path, kind: str) -> tuple[int, Array]:
    try:
        import soundfile
    except (ImportError, OSError):
        raise Unavailable(
            f"{kind} files need the package soundfile: {install_packages('soundfile')} (WAV works without)."
        ) from None
    try:
        with soundfile.SoundFile(path) as file:
            _check(path.name, file.samplerate, file.channels)
            _check_length(path.name, file.frames, file.channels, file.samplerate)
            samples = file.read(file.frames, dtype="float64", always_2d=True)
            rate = file.samplerate
    except (soundfile.SoundFileError, RuntimeError, MemoryError):
        raise BadInput(f"{path.name} is a damaged {kind} file.") from None
    if not len(samples):
        raise BadInput(f"{path.name} holds no samples.")
    return rate, samples


def _check(name: str, rate: int, channels: int) -> None:
    if not RATE_BOUNDS_HZ[0] <= rate <= RATE_BOUNDS_HZ[1]:
        raise BadInput(f"{name} says {rate} Hz; {RATE_BOUNDS_HZ[0]} to {RATE_BOUNDS_HZ[1]} Hz can be used.")
    if not 1 <= channels <= MOST_CHANNELS:
        raise BadInput(f"{name} says {channels} channels; 1 to {MOST_CHANNELS} can be used.")


def _check_length(name: str, count: int, channels: int, rate: int) -> None:
    if count / rate > MAX_DURATION_S or count * channels > MOST_SAMPLES:
        raise BadInput(f"{name} is {count / rate / 60:.0f} min long; cut it into parts of at most an hour.")
