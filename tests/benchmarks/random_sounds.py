"""Sounds at random through every entrance of the ears: `python -m tests.benchmarks.random_sounds [--count 10000]`.

Lengths around the blocks of everything that cuts sound (0, 1, a block less or more a sample), sample rates of sound
cards and odd ones, 1 to 16 channels, silence, noise, voices, clipping, offsets, and numbers that are none; files of
all forms, and live pieces of any size. A refusal is a sentence (BeckonError); anything else that is raised, numpy's
warnings included, is a crash. Told: how many sounds each entrance took, and how many it refused.
"""

import json
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from console.messages.audio import AUDIO_HEADER, AUDIO_RATE_HZ, MOST_BYTES
from console.speech.browser_microphone import TalkTurn
from console.speech.transcription_worker import TranscriptionWorker
from core.errors import BadInput, BeckonError
from core.geometry import Pose
from core.message import Array
from core.perception.sound.array_diagnostics import check
from core.perception.sound.array_orientation import heard_from
from core.perception.sound.settings import DirectionFindingSettings
from core.pilot.sound_perception import SoundPerception
from core.pipelines.hear import RecordingTranscriber
from core.robots import Profile
from core.sensors.microphones import ARRAYS, MicrophoneArray, Sound
from core.sentences import plain
from core.settings import Settings
from core.slam.estimate import Estimate
from core.speech.practice_voice import practice_voice
from core.speech.settings import SpeechSettings
from tests.benchmarks.carried_out import carried_out
from tests.benchmarks.command import print_row, run_command
from tests.sound_files import FORMS, write_sound

RATES = (16_000, 8_000, 11_025, 22_050, 44_100, 48_000, 96_000, 12_345, 4_000, 192_000)
BLOCKS = (0.5, 0.2, 0.1, 0.05, 0.032, 0.02, 0.008)  # [s] in which some entrance or its filters cut sound
PART = 12  # visits of one process, one after the other
MOST_TOLD = 5  # crashes
CLOCKS = (0.0, 1e-3, 12.345678, 86_400.5, 1.7e9)  # [s] at which live sound begins
"""The last is a clock of the day: its steps are coarse."""

Listener = Callable[[], None]
"""Hears one sound at random."""


def line_of(count: int) -> MicrophoneArray:
    """Microphones in a line, 4 cm apart."""
    return MicrophoneArray(positions=np.column_stack((0.04 * np.arange(count), np.zeros((count, 2)))), name="line")


def cloud_of(count: int) -> MicrophoneArray:
    """Microphones at random places within a hand's width."""
    return MicrophoneArray(positions=np.random.default_rng(count).uniform(-0.05, 0.05, (count, 3)), name="cloud")


PROFILES = (*ARRAYS.values(), line_of(2), cloud_of(3), cloud_of(5), cloud_of(16))


def length(chance: np.random.Generator, rate: int) -> int:
    """Samples: mostly around a whole number of blocks, mostly short."""
    if chance.random() < 0.1:
        return int(chance.integers(0, 3))
    block = round(chance.choice(BLOCKS) * rate)
    if chance.random() < 0.25:
        block = 2 ** int(chance.integers(4, 12))
    seconds = float(np.exp(chance.uniform(np.log(0.005), np.log(3.0))))
    return max(max(1, round(seconds * rate / block)) * block + int(chance.integers(-1, 2)), 0)


def samples(chance: np.random.Generator, count: int, channels: int, rate: int, *, broken: bool) -> Array:
    """Samples (`count`, `channels`); `broken`: perhaps with numbers that are none or absurd."""
    kind = chance.choice(("silence", "noise", "voice", "voice", "click", "constant", "tone"))
    time = np.arange(count)[:, None] / rate
    level = 10 ** chance.uniform(-4, 0)
    made = np.zeros((count, channels))
    if kind == "noise":
        made = level * chance.normal(size=(count, channels))
    elif kind == "voice" and count:
        begin = min(round(0.6 * rate), count // 2)
        voice = practice_voice(chance, (count - begin) / rate, rate) if count - begin > rate // 10 else np.zeros(0)
        for channel in range(channels):
            part = voice[: count - begin - channel]
            made[begin + channel :][: len(part), channel] = level / 10 * part
        made += 1e-4 * chance.normal(size=(count, channels))
    elif kind == "click" and count:
        made[chance.integers(count)] = level
    elif kind == "constant":
        made += level
    elif kind == "tone":
        made = level * np.sin(2 * np.pi * chance.uniform(20, rate / 2) * time + np.arange(channels))
    if broken and count and chance.random() < 0.2:
        made[chance.integers(count), chance.integers(channels)] = chance.choice(
            (np.nan, np.inf, -np.inf, 1e30, 1e300)
        )
    return made


@cache
def hearer() -> RecordingTranscriber:
    """The ears of `beckon hear`, whose recognizer takes a second to make."""
    return RecordingTranscriber(Settings())


@cache
def worker() -> TranscriptionWorker:
    """One for all, as in the console."""
    return TranscriptionWorker()


def recordings(chance: np.random.Generator) -> Listener:
    """Files through `beckon hear`."""

    def hear() -> None:
        form = str(chance.choice(FORMS))
        rate, channels = int(chance.choice(RATES)), int(chance.integers(1, 9 if form == "flac" else 17))
        made = samples(chance, length(chance, rate), channels, rate, broken=form in ("float32", "float64"))
        ears = copy(hearer())
        ears._array = (None, *PROFILES)[int(chance.integers(len(PROFILES) + 1))]
        channel = int(chance.integers(-1, channels + 1)) if chance.random() < 0.5 else None
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "random.sound"
            write_sound(path, made, rate, form)
            json.dumps(ears.hear(path, channel), allow_nan=False)

    return hear


def pieces(chance: np.random.Generator, whole: Array, rate: int, usual: float) -> Iterator[tuple[Array, float]]:
    """Samples (N, M) as they come live: in pieces about `usual` [s] long or of any length, sometimes with a gap."""
    clock = float(chance.choice(CLOCKS))
    at = 0
    regular = chance.random() < 0.5
    while at < len(whole):
        count = round(usual * rate) if regular else int(chance.integers(0, round(2 * usual * rate) + 1))
        if chance.random() < 0.03:
            clock += chance.uniform(-1, 1)
        yield whole[at : at + count], clock + at / rate
        at += count
    if chance.random() < 0.3:
        yield whole[:0], clock + at / rate


def spoken(chance: np.random.Generator, *, held: bool) -> Listener:
    """A browser's microphone: its pieces wait for the worker, which reads them."""
    work = worker()
    work.begin(SpeechSettings(), held=held, speaker=int(chance.integers(3)))
    longest = (MOST_BYTES - AUDIO_HEADER.size) // 2

    def hear() -> None:
        turn = TalkTurn("held" if held else "open", lambda _told, _delay: None, lambda _why, _on: None)
        whole = samples(chance, length(chance, AUDIO_RATE_HZ), 1, AUDIO_RATE_HZ, broken=False)
        sixteen = np.clip(np.round(whole[:, 0] * 32767), -32768, 32767).astype("<i2")
        for piece, stamp in pieces(chance, sixteen, AUDIO_RATE_HZ, 0.02):
            turn.add(piece[:longest].astype(float) / 32768, stamp)
            if chance.random() < 0.3:
                feed_waiting(work, turn)
        feed_waiting(work, turn, empty=chance.random() < 0.3)
        json.dumps(msgspec.to_builtins(work.finish(), enc_hook=plain), allow_nan=False)

    return hear


def feed_waiting(work: TranscriptionWorker, turn: TalkTurn, *, empty: bool = False) -> None:
    """What waits goes to the worker, as `browser_microphone` sends it; `empty`: even where nothing waits."""
    waiting, start = turn.take()
    if len(waiting) or empty:
        heard = work.hear(waiting.astype(np.float32).tobytes(), AUDIO_RATE_HZ, start)
        json.dumps(msgspec.to_builtins(heard, enc_hook=plain), allow_nan=False)


def room(chance: np.random.Generator) -> Listener:
    """The robot's own sound to the worker that reads words from the beam, or from one microphone."""
    array = PROFILES[int(chance.integers(len(PROFILES)))]
    beam = array.dimensions >= 2 and chance.random() < 0.8
    count = len(array.positions) if beam else 1
    work = worker()
    work.begin(SpeechSettings(), array=array if beam else None)

    def hear() -> None:
        rate = int(chance.choice(RATES))
        whole = samples(chance, length(chance, rate), count, rate, broken=True)
        for piece, stamp in pieces(chance, whole, rate, 0.2):
            with np.errstate(over="ignore"):
                raw = piece.astype(np.float32).tobytes()
            json.dumps(msgspec.to_builtins(work.hear(raw, rate, stamp, count), enc_hook=plain), allow_nan=False)
        json.dumps(msgspec.to_builtins(work.finish(), enc_hook=plain), allow_nan=False)

    return hear


def directions_live(chance: np.random.Generator) -> Listener:
    """The pilot's ears, frame by frame: what is wrong with the sound is told beside what was heard."""
    array = PROFILES[int(chance.integers(len(PROFILES)))]
    ears = SoundPerception(Profile(name="ears", url="sim:ears", arrays=(array,)), DirectionFindingSettings())

    def hear() -> None:
        rate, channels = int(chance.choice(RATES)), int(chance.integers(1, 17))
        whole = samples(chance, length(chance, rate), channels, rate, broken=True)
        for piece, stamp in pieces(chance, whole, rate, 0.05):
            sound = Sound(stamp=stamp, rate=rate, samples=piece)
            here = Estimate(pose=Pose(heading=stamp), covariance=1e-6 * np.eye(3))
            ears.listen(sound, stamp + sound.duration)
            told = ears.hear(stamp + sound.duration, here)
            assert told is not None and told.level_db is not None and np.isfinite(told.level_db)
        if ears.trouble:
            raise BadInput(ears.trouble)

    return hear


def bench(chance: np.random.Generator) -> Listener:
    """The self-check of an array and its claps."""

    def hear() -> None:
        array = PROFILES[int(chance.integers(len(PROFILES)))]
        rate = int(chance.choice(RATES))
        whole = samples(chance, length(chance, rate), 16, rate, broken=True)
        sound = Sound(stamp=float(chance.choice(CLOCKS)), rate=rate, samples=whole)
        work: Callable[..., Any] = check if chance.random() < 0.5 else heard_from
        work(sound, array)

    return hear


ENTRANCES: dict[str, tuple[Callable[[np.random.Generator], Listener], int]] = {
    "hear": (recordings, 6),
    "push-to-talk": (partial(spoken, held=True), 8),
    "open microphone": (partial(spoken, held=False), 8),
    "words of the room": (room, 8),
    "directions, live": (directions_live, 4),
    "array's bench": (bench, 4),
}
"""Name → how it is opened, and how many sounds go through it before it is opened anew."""
ROUND = sum(count for _, count in ENTRANCES.values())  # sounds of one visit to every entrance


@dataclass
class Visit:
    """Some sounds through one entrance."""

    name: str
    sounds: int = 0
    refused: int = 0
    crash: str = ""  # the trace


def visit(number: int, seed: int = 0) -> Visit:
    """The visit of that number: to the entrances in turn."""
    name = tuple(ENTRANCES)[number % len(ENTRANCES)]
    opened, count = ENTRANCES[name]
    told = Visit(name)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            listener = opened(np.random.default_rng((seed, number)))
            for _ in range(count):
                told.sounds += 1
                try:
                    listener()
                except BeckonError:
                    told.refused += 1
    except Exception:
        told.crash = f"visit {number}, sound {told.sounds}\n{traceback.format_exc()}"
    return told


def part(number: int) -> list[Visit]:
    return [visit(one) for one in range(number * PART, (number + 1) * PART)]


def main(
    *,
    count: int = 10_000,  # sounds, at least
    workers: int = 2,
) -> int:
    parts = -(-count * len(ENTRANCES) // (ROUND * PART))
    visits = [one for some in carried_out(part, parts, workers) for one in some]
    for name in ENTRANCES:
        these = [one for one in visits if one.name == name]
        line = {"entrance": name, "sounds": sum(one.sounds for one in these)}
        line |= {"refused": sum(one.refused for one in these), "crashes": sum(bool(one.crash) for one in these)}
        print_row(line)
    crashes = [one.crash for one in visits if one.crash]
    for crash in crashes[:MOST_TOLD]:
        sys.stderr.write(f"{crash}\n")
    return 1 if crashes else 0


if __name__ == "__main__":
    run_command(main)
