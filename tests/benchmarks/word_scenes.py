"""Commands as an array hears them: two metres away, in noise and in rooms, always the same for the same seed."""

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from core.message import Array
from core.recording.sound_file import read_sound
from core.sensors.microphones import RESPEAKER_ODAS, MicrophoneArray, Sound
from core.simulation.acoustics.shoebox import ShoeboxRoom, heard, impulse_responses, plane_waves
from core.simulation.microphones import Motors
from core.speech.recognition.recognizer import for_words
from core.speech.settings import RATE_HZ

ARRAY = RESPEAKER_ODAS
LEAD, TAIL = 0.7, 0.8  # [s] without a voice around every clip
FAINT = 40.0  # [dB] of noise below the voice where no noise is asked for
TALKERS = 12  # of the babble
DISTANCE = 2.0  # [m]
DRIVING = (0.1, 0.09)  # [m/s] of the left and the right wheel where motors are heard


@dataclass(frozen=True)
class Clip:
    """One recording and what was said in it."""

    name: str
    text: str  # "": nobody wrote it down
    samples: Array  # (N,) at 16 kHz


@dataclass(frozen=True)
class Condition:
    """How a clip is heard."""

    name: str
    noise: str = "none"  # "white" | "babble" | "recorded" | "motors"
    ratio: float = FAINT  # [dB] of the voice over it
    rt60: float = 0.0  # [s]


CONDITIONS = (
    Condition("clean"),
    *(Condition(f"{noise} {ratio} dB", noise, ratio) for noise in ("white", "babble") for ratio in (20, 10, 5)),
    Condition("room RT60 0.3", rt60=0.3),
    Condition("room RT60 0.6", rt60=0.6),
)


def synthetic(data: Path, kind: str) -> list[Clip]:
    """Clips of speech_commands_tts whose kind begins so: "command" or "near-miss"."""
    return [
        Clip(row["file"], row["text"], _samples(data / "speech_commands_tts" / row["file"]))
        for row in _rows(data / "speech_commands_tts")
        if row["kind"].startswith(kind)
    ]


def clips_of(folder: Path) -> Iterator[tuple[str, Clip]]:
    """(kind, clip) of a folder whose index has the columns file, kind and text."""
    for row in _rows(folder):
        yield row["kind"], Clip(row["file"], row["text"], _samples(folder / row["file"]))


def real(data: Path) -> Iterator[tuple[str, Clip]]:
    """(kind, clip) of speech_real, and its noises as kind "noise"."""
    for row in _rows(data / "speech_real"):
        yield row["kind"], Clip(row["file"], row["transcript"], _samples(data / "speech_real" / row["file"]))
    for path in sorted((data / "speech_real" / "noise").glob("*.flac")):
        yield "noise", Clip(path.name, "", _samples(path))


def _rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "index.tsv").open(newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def _samples(path: Path) -> Array:
    return for_words(read_sound(path)).samples[:, 0]


def scene(
    clip: Clip, condition: Condition, babble: list[Array], seed: int, recorded: tuple[Array, ...] = ()
) -> Sound:
    """What all microphones of ARRAY hear of the clip, after LEAD and before TAIL seconds of noise alone; `recorded`:
    noises that come from one side.
    """
    rng = np.random.default_rng(seed)
    room = ShoeboxRoom((6.0, 5.0, 2.8), condition.rt60)
    centre = np.array([rng.uniform(1.5, 3.0), rng.uniform(1.5, 3.0), 0.6])
    azimuth = rng.uniform(-0.2, math.pi / 2 + 0.2)
    mouth = centre + np.array([DISTANCE * math.cos(azimuth), DISTANCE * math.sin(azimuth), 0.8])
    mouth[:2] = np.clip(mouth[:2], 0.4, (5.6, 4.6))
    dry = np.concatenate((np.zeros(int(LEAD * RATE_HZ)), clip.samples, np.zeros(int(TAIL * RATE_HZ))))
    voice = heard(dry, impulse_responses(room, mouth, centre + ARRAY.positions, RATE_HZ, rng))
    loud = np.sqrt(np.mean(voice[int(LEAD * RATE_HZ) : -int(TAIL * RATE_HZ)] ** 2))
    if condition.noise == "babble":
        noise = _babble(rng, babble, len(dry), ARRAY)
    elif condition.noise == "recorded":
        noise = _from_one_side(rng, np.resize(recorded[seed % len(recorded)], len(dry)))
    elif condition.noise == "motors":
        motors = Motors(rng, ARRAY.positions, RATE_HZ)
        motors.take(1, *DRIVING)  # it drives already
        noise = motors.take(len(dry), *DRIVING)
    else:
        noise = rng.normal(size=voice.shape)
    noise /= np.sqrt(np.mean(noise**2))
    return Sound(stamp=0.0, rate=RATE_HZ, samples=0.05 * (voice / loud + 10 ** (-condition.ratio / 20) * noise))


def _from_one_side(rng: np.random.Generator, noise: Array) -> Array:
    """A noise (N,) far away on one side, (N, M)."""
    towards = rng.normal(size=(1, 3)) * (1, 1, 0.2)
    return plane_waves(noise[None], towards / np.linalg.norm(towards), ARRAY.positions, RATE_HZ)


def _babble(rng: np.random.Generator, voices: list[Array], length: int, array: MicrophoneArray) -> Array:
    """TALKERS far voices from all sides at once, (length, M)."""
    towards = rng.normal(size=(TALKERS, 3)) * (1, 1, 0.2)
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    spoken = [np.roll(np.resize(voices[n % len(voices)], length), rng.integers(length)) for n in range(TALKERS)]
    return plane_waves(np.array([one / one.std() for one in spoken]), towards, array.positions, RATE_HZ)
