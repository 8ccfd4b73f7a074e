"""`audio://DEVICE`: microphones of this computer, `audio:///talk.wav`: a recording in their place."""

import importlib
import math
import os
import threading
from collections import deque
from dataclasses import replace
from typing import Any
from urllib.parse import parse_qsl, unquote

import numpy as np

from core.errors import BadInput, Unavailable
from core.install import install_extra
from core.message import Array
from core.recording.sound_file import read_sound
from core.robots.device import Device, Equipment
from core.robots.readings import Readings
from core.sensors.microphones import MicrophoneArray, Sound, load_array

EXAMPLE = "audio://ReSpeaker?array=respeaker-odas, audio://default, audio:///talk.wav"
KEYS = ("array", "channels", "rate", "first")
BLOCK_S = 0.02  # of sound that are handed on at once
MAX_WAITING_BLOCKS = 100  # blocks that may wait
MAX_SILENCE_S = 2.0  # without a block after which the device is lost
CLOCK_WINDOW_S = 10.0  # of whose blocks the quickest says how far the stamps have left the robot's clock
MAX_CLOCK_ERROR_S = 0.05  # by which the stamps may leave it before they step
RESPEAKER = {"channels": 6, "rate": 16_000, "first": 1}  # 6-channel firmware: processed, four raw, playback
NEEDS = f"Microphones of this computer need the extra hardware: {install_extra('hardware')}"


class SampleClock:
    """Stamps of blocks that follow each other: what was recorded says when, not when it came.

    A card's clock leaves the robot's by some 50 ms in a quarter of an hour, or at once where blocks were lost. Then
    the stamps step, which ends what is being heard, instead of dating all that follows wrongly.
    """

    def __init__(self) -> None:
        self._next = -math.inf  # [s] when the next block begins
        self._quickest, self._since = math.inf, 0.0  # [s] least delay of the blocks since then

    def stamp(self, length: float, now: float) -> float:
        """A block of `length` [s] that came at `now` → when it began [s]."""
        came, begin = now - length, self._next
        self._quickest = min(self._quickest, came - self._next)
        is_over = now - self._since > CLOCK_WINDOW_S
        if abs(came - self._next) >= MAX_SILENCE_S:
            begin, is_over = came, True
        elif is_over and abs(self._quickest) > MAX_CLOCK_ERROR_S:
            begin += self._quickest
        if is_over:
            self._quickest, self._since = math.inf, now
        self._next = begin + length
        return begin


class SoundDevice(Device):
    """A sound card, by a part of its name or its number."""

    def __init__(self, arguments: str = "") -> None:
        """`arguments`: what follows `audio:`. Raises BadInput."""
        place, _, query = arguments.removeprefix("//").partition("?")
        self._name = unquote(place)
        if not self._name:
            raise BadInput(f"Microphones need the name of a sound card, or a file: {EXAMPLE}.")
        self._numbers: dict[str, int] = dict(RESPEAKER) if "respeaker" in self._name.lower() else {}
        self._array = "respeaker-odas" if self._numbers else ""
        for key, value in parse_qsl(query, keep_blank_values=True):
            if key not in KEYS:
                raise BadInput(f"Microphones have no setting {key[:40]!r}; known are {', '.join(KEYS)}.")
            if key == "array":
                self._array = value
            elif value.isdigit() and int(value) <= 192_000:
                self._numbers[key] = int(value)
            else:
                raise BadInput(f"{key} of microphones is a whole number, not {value[:20]!r}.")
        self._profile = load_array(self._array) if self._array else None
        self._blocks: deque[np.ndarray] = deque(maxlen=MAX_WAITING_BLOCKS)
        self._came, self._over = threading.Event(), threading.Event()
        self._stream: Any = None

    def open(self) -> Equipment:
        """Begin to record. Raises Unavailable with what is missing, OSError while the card is not there."""
        sound = imported()
        self._over.clear()
        self._blocks.clear()
        self._rate = self._numbers.get("rate", 16_000)
        device = int(self._name) if self._name.isdigit() else None if self._name == "default" else self._name
        try:
            self._stream = sound.InputStream(
                device=device,
                channels=self._numbers.get("channels", 1 if self._profile is None else len(self._profile.channels)),
                samplerate=self._rate,
                blocksize=round(BLOCK_S * self._rate),
                dtype="int16",
                callback=self._came_in,
            )
            self._stream.start()
        except (sound.PortAudioError, ValueError) as trouble:
            raise OSError(f"the sound card {self._name} cannot be used: {trouble}") from None
        return Equipment(name="microphones", microphones=arrays(self._profile, self._numbers.get("first", 0)))

    def run(self, readings: Readings) -> None:
        """Hand on block by block; their stamps follow each other, whenever they come (`SampleClock`)."""
        clock = SampleClock()
        while not self._over.is_set():
            if not self._came.wait(MAX_SILENCE_S):
                return
            self._came.clear()
            while self._blocks and not self._over.is_set():
                samples = self._blocks.popleft().astype(np.float32) / 32768
                stamp = clock.stamp(len(samples) / self._rate, readings.now())
                readings.sound(Sound(stamp=stamp, rate=self._rate, samples=samples))

    def close(self) -> None:
        """Stop recording."""
        self._over.set()
        self._came.set()
        stream, self._stream = self._stream, None
        if stream is not None:
            stream.abort()
            stream.close()

    def _came_in(self, block: Any, _frames: int, _time: Any, _status: Any) -> None:
        self._blocks.append(np.array(block))
        self._came.set()


class SoundFile(Device):
    """A recording that plays in real time, over and over."""

    def __init__(self, path: str, array: str = "") -> None:
        """Raises BadInput for what is no recording."""
        self._sound = read_sound(path)
        self._profile = load_array(array) if array else None
        self._over = threading.Event()

    def open(self) -> Equipment:
        """It is there already."""
        self._over.clear()
        return Equipment(name="microphones", microphones=arrays(self._profile, 0))

    def run(self, readings: Readings) -> None:
        """Hand on what is due."""
        start, number = readings.now(), 0
        size = max(1, round(BLOCK_S * self._sound.rate))
        while not self._over.wait(max(0.0, start + (number + 1) * size / self._sound.rate - readings.now())):
            first = number * size % max(len(self._sound.samples) - size, 1)
            samples = self._sound.samples[first : first + size]
            readings.sound(
                Sound(stamp=start + number * size / self._sound.rate, rate=self._sound.rate, samples=samples)
            )
            number += 1

    def close(self) -> None:
        """End `run`."""
        self._over.set()


def arrays(profile: MicrophoneArray | None, first: int) -> tuple[MicrophoneArray, ...]:
    """The array of a card whose microphones begin at channel `first`; none without a profile: words only."""
    if profile is None:
        return ()
    return (replace(profile, channels=tuple(first + channel for channel in profile.channels)),)


def play_and_record(samples: Array, rate: int, microphone: str = "", loudspeaker: str = "") -> Array:
    """Play a sound (N,) at a loudspeaker → what a microphone heard meanwhile (N,). "": this computer's usual ones.

    Raises Unavailable where there is none of them.
    """
    sound = imported()
    devices = tuple(int(name) if name.isdigit() else name or None for name in (microphone, loudspeaker))
    try:
        heard = sound.playrec(samples.astype(np.float32)[:, None], rate, channels=1, device=devices, blocking=True)
    except (sound.PortAudioError, ValueError) as trouble:
        raise Unavailable(f"The loudspeaker or the microphone cannot be used: {trouble}") from None
    return np.asarray(heard, float)[:, 0]


def imported() -> Any:
    """The package sounddevice. Raises Unavailable with what is missing."""
    try:
        return importlib.import_module("sounddevice")
    except ModuleNotFoundError:
        raise Unavailable(NEEDS) from None
    except OSError:
        raise Unavailable("sounddevice finds no PortAudio; on Debian: sudo apt install libportaudio2.") from None


def open_device(rest: str) -> Device:
    """`audio:<rest>` → the microphones. Raises BadInput."""
    place, _, query = rest.removeprefix("//").partition("?")
    if place.startswith("/"):
        if not os.path.isfile(place):
            raise BadInput(f"There is no recording {place[:100]}; microphones are {EXAMPLE}.")
        return SoundFile(place, dict(parse_qsl(query)).get("array", ""))
    return SoundDevice(rest)
