"""Text to speech: the robot's voice, and the voices of simulated people.

espeak-ng speaks, either its library from the package espeakng-loader (the extra `voice`) or the system's program. It
is under the GPL, so Beckon neither carries nor needs it: without it there is a sentence instead of a voice.
"""

from __future__ import annotations

import _ctypes
import ctypes
import shutil
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Annotated, Any

import numpy as np

from core.errors import BadInput, Unavailable
from core.install import install_extra
from core.sensors.microphones import Sound
from core.setting import Meta, Section

ACCENTS = (
    "en-us",
    "en-gb",
    "en-gb-scotland",
    "en-gb-x-rp",
    "en-gb-x-gbclan",
    "en-gb-x-gbcwmd",
    "en-029",
    "en-us-nyc",
)
TIMBRES = ("m1", "m2", "m3", "m4", "m5", "m6", "m7", "m8", "f1", "f2", "f3", "f4", "f5")
ENGLISH_VOICES = (*ACCENTS, *(f"en-us+{timbre}" for timbre in TIMBRES))
"""Every English accent of espeak-ng that reads Latin letters, and its numbered men and women."""
NATURAL_WORDS_MIN = 175  # [words/min] of espeak-ng by itself
PERSONS_VOICE = "en-us+f5"  # of simulated people: not the robot's own, and the one that is understood best
MAX_CHARACTERS = 500  # characters of a text
PROGRAM_TIMEOUT_S = 10.0  # for the program
NO_VOICE = (
    f"Text cannot be spoken here: install the extra voice ({install_extra('voice')}) "
    "or the program espeak-ng (Debian: apt install espeak-ng)."
)

SYNCHRONOUS_MODE, NO_EXIT = 2, 0x8000  # of espeak_Initialize
BY_CHARACTER, UTF_8 = 1, 1  # of espeak_Synth
SPEED_PARAMETER, PITCH_PARAMETER = 1, 3  # of espeak_SetParameter
HISS_SEED = 1  # of its hiss


@dataclass(frozen=True)
class VoiceSettings(Section):
    """Settings of the robot's voice.

    Watch:
        voice: the next reply
        speed: the next reply; words of the robot in Speech quality
        pitch: the next reply
    """

    voice: Annotated[str, Meta(choices=ENGLISH_VOICES, meaning="voice of espeak-ng", common=True, live=True)] = (
        "en-us"
    )
    speed: Annotated[int, Meta("words/min", 80, 400, "rate of speaking", common=True, live=True)] = 150
    pitch: Annotated[int, Meta("", 0, 99, "pitch of the voice", common=True, live=True)] = 50


def drawn_voice(chance: np.random.Generator) -> VoiceSettings:
    """Any of the English voices, at its natural pace ± 15 %."""
    voice = ENGLISH_VOICES[int(chance.integers(len(ENGLISH_VOICES)))]
    return VoiceSettings(voice=voice, speed=round(NATURAL_WORDS_MIN * float(chance.uniform(0.85, 1.15))))


Speaker = Callable[[str, VoiceSettings], Sound]
"""Text → sound with its own rate, one channel. Raises Unavailable when it cannot speak here."""


def speak(text: str, settings: VoiceSettings | None = None, speakers: Sequence[Speaker] | None = None) -> Sound:
    """A text → how it sounds. `speakers` are tried in turn: the library, then the program.

    The same text with the same settings is the same sound, sample by sample, where the library speaks.

    Raises BadInput for a text that cannot be spoken, and Unavailable with a sentence when nothing here speaks.
    """
    plain = " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())
    if not any(letter.isalnum() for letter in plain):
        raise BadInput("There is nothing to say in that text.")
    if len(plain) > MAX_CHARACTERS:
        raise BadInput(f"Say at most {MAX_CHARACTERS} characters at once.")
    for speaker in (by_library, by_program) if speakers is None else speakers:
        try:
            sound = speaker(plain, settings or VoiceSettings())
        except Unavailable:
            continue
        if len(sound.samples):
            return sound
    raise Unavailable(NO_VOICE)


def pcm(sound: Sound) -> bytes:
    """A sound's first channel → 16-bit samples, little endian."""
    return np.clip(np.round(sound.samples[:, 0] * 32768), -32768, 32767).astype("<i2").tobytes()


def can_speak() -> bool:
    """Return whether this machine can speak text."""
    return _library() is not None or shutil.which("espeak-ng") is not None


def by_library(text: str, settings: VoiceSettings) -> Sound:
    """The library of the package espeakng-loader, in this process: some milliseconds for a sentence."""
    library = _library()
    if library is None:
        raise Unavailable(NO_VOICE)
    return library.speak(text, settings)


def by_program(text: str, settings: VoiceSettings) -> Sound:
    """The system's program espeak-ng."""
    program = shutil.which("espeak-ng")
    if program is None:
        raise Unavailable(NO_VOICE)
    chosen = ["-v", settings.voice, "-s", str(settings.speed), "-p", str(settings.pitch)]
    try:
        done = subprocess.run(
            [program, "--stdin", "--stdout", *chosen],
            input=text.encode(),
            capture_output=True,
            timeout=PROGRAM_TIMEOUT_S,
        )
    except (OSError, subprocess.TimeoutExpired):
        raise Unavailable("The program espeak-ng does not answer.") from None
    begin = done.stdout.find(b"data")
    if done.returncode or begin < 28:
        raise Unavailable("The program espeak-ng could not speak this text.")
    (rate,) = struct.unpack_from("<I", done.stdout, 24)
    body = done.stdout[begin + 8 :]
    return _sound(np.frombuffer(body[: len(body) // 2 * 2], "<i2"), rate)


class SpeechLibrary:
    """espeak-ng in this process. It speaks one text at a time.

    The library is loaded for every text and unloaded after it: its pitch flutters on, and its hiss is drawn on, from
    text to text, so what a text sounds like would depend on all that was said before. Loading takes a millisecond.
    """

    def __init__(self, path: str, data: str) -> None:
        """Raises OSError when it cannot be loaded."""
        self._path, self._data = path, data.encode()
        self._turn = threading.Lock()
        self._pieces: list[bytes] = []
        kind = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
        self._callback = kind(self._take)  # kept: the library calls it as long as it is loaded
        with self._loaded():
            pass

    def _take(self, samples: int | None, count: int, _events: int | None) -> int:
        if samples and count > 0:
            self._pieces.append(ctypes.string_at(samples, 2 * count))
        return 0

    @contextmanager
    def _loaded(self) -> Generator[tuple[Any, int]]:
        """The library as after its start, and the rate [Hz] of its sound. Raises OSError."""
        calls: Any = ctypes.CDLL(self._path)
        try:
            rate = int(calls.espeak_Initialize(SYNCHRONOUS_MODE, 0, self._data, NO_EXIT))
            if rate <= 0:
                raise OSError("espeak-ng found no data")
            calls.espeak_ng_SetRandSeed(ctypes.c_long(HISS_SEED))
            calls.espeak_SetSynthCallback(self._callback)
            yield calls, rate
            calls.espeak_Terminate()
        finally:
            _unload(calls)

    def speak(self, text: str, settings: VoiceSettings) -> Sound:
        """A text → its sound. Raises Unavailable when the library refuses."""
        raw = text.encode()
        with self._turn, self._loaded() as (calls, rate):
            self._pieces.clear()
            calls.espeak_SetVoiceByName(settings.voice.encode())
            calls.espeak_SetParameter(SPEED_PARAMETER, settings.speed, 0)
            calls.espeak_SetParameter(PITCH_PARAMETER, settings.pitch, 0)
            trouble = calls.espeak_Synth(raw, ctypes.c_size_t(len(raw) + 1), 0, BY_CHARACTER, 0, UTF_8, None, None)
            whole = b"".join(self._pieces)
        if trouble:
            raise Unavailable("The library espeak-ng could not speak this text.")
        return _sound(np.frombuffer(whole, np.int16), rate)


def _unload(library: Any) -> None:
    """Let go of a library, so that the next one to load it finds nothing of what it did."""
    if sys.platform == "win32":
        _ctypes.FreeLibrary(library._handle)
    else:
        _ctypes.dlclose(library._handle)


@cache
def _library() -> SpeechLibrary | None:
    try:
        loader = import_module("espeakng_loader")
    except ImportError:
        return None
    try:
        return SpeechLibrary(str(loader.get_library_path()), str(loader.get_data_path()))
    except (OSError, RuntimeError, AttributeError):  # an old one cannot be seeded; the program speaks then
        return None


def _sound(whole: np.ndarray[Any, np.dtype[np.int16]], rate: int) -> Sound:
    return Sound(stamp=0.0, rate=rate, samples=whole[:, None] / 32768)
