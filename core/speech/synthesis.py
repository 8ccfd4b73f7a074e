"""Text to speech: the robot's voice, and the voices of simulated people.

espeak-ng speaks, either the library of the package espeakng-loader (the extra `voice`) or the system's program, each
in a process of its own. It is under the GPL, so Beckon neither carries, loads nor needs it: without it there is a
sentence instead of a voice.
"""

import shutil
import struct
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Annotated

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
PROGRAM_TIMEOUT_S = 30.0  # for the program, which takes 0.03 s: only a very busy computer is slower
NO_VOICE = (
    f"Text cannot be spoken here: install the extra voice ({install_extra('voice')}) "
    "or the program espeak-ng (Debian: apt install espeak-ng)."
)
NO_ANSWER = f"The program espeak-ng does not answer within {PROGRAM_TIMEOUT_S:.0f} s; the computer is very busy."


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
    why = Unavailable(NO_VOICE)
    for speaker in (by_library, by_program) if speakers is None else speakers:
        try:
            sound = speaker(plain, settings or VoiceSettings())
        except Unavailable as trouble:
            why = why if str(trouble) == NO_VOICE else trouble
            continue
        if len(sound.samples):
            return sound
    raise why


def pcm(sound: Sound) -> bytes:
    """A sound's first channel → 16-bit samples, little endian."""
    return np.clip(np.round(sound.samples[:, 0] * 32768), -32768, 32767).astype("<i2").tobytes()


def can_speak() -> bool:
    """Return whether this machine can speak text."""
    return bool(_bundled()) or shutil.which("espeak-ng") is not None


def by_library(text: str, settings: VoiceSettings) -> Sound:
    """The library of the package espeakng-loader, in a program of its own: some 30 ms for a sentence."""
    command = _bundled()
    if not command:
        raise Unavailable(NO_VOICE)
    return _said([*command, settings.voice, str(settings.speed), str(settings.pitch)], text)


def by_program(text: str, settings: VoiceSettings) -> Sound:
    """The system's program espeak-ng."""
    program = shutil.which("espeak-ng")
    if program is None:
        raise Unavailable(NO_VOICE)
    chosen = ["-v", settings.voice, "-s", str(settings.speed), "-p", str(settings.pitch)]
    return _said([program, "--stdin", "--stdout", *chosen], text)


def _said(command: list[str], text: str) -> Sound:
    """Run a program that makes a WAV file of a text; its length may be missing. Raises Unavailable."""
    try:
        done = subprocess.run(command, input=text.encode(), capture_output=True, timeout=PROGRAM_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        raise Unavailable(NO_ANSWER) from None
    except OSError as trouble:
        raise Unavailable(f"The program espeak-ng cannot be run: {trouble.strerror}.") from None
    begin = done.stdout.find(b"data")
    if done.returncode or begin < 28:
        raise Unavailable("The program espeak-ng could not speak this text.")
    (rate,) = struct.unpack_from("<I", done.stdout, 24)
    body = done.stdout[begin + 8 :]
    samples = np.frombuffer(body[: len(body) // 2 * 2], "<i2")
    return Sound(stamp=0.0, rate=rate, samples=samples[:, None] / 32768)


@cache
def _bundled() -> list[str]:
    """The command that speaks with the package's library; empty where there is none, or one too old to be seeded."""
    try:
        loader = import_module("espeakng_loader")
        found = [str(loader.get_library_path()), str(loader.get_data_path())]
    except (ImportError, OSError, RuntimeError, AttributeError):
        return []
    command = [sys.executable, "-I", "-S", str(Path(__file__).with_name("espeak.py")), *found]
    try:
        _said([*command, "en-us", "150", "50"], "a")
    except Unavailable as why:
        return command if str(why) == NO_ANSWER else []  # it is there, if slow: what is found here is kept
    return command
