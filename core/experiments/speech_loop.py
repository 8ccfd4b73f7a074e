"""The loop of Figs. 10 and 11: a text is spoken and recorded on two paths, recognized, and compared.

Its products have the paper's names: orig.wav and stt.txt of the person's path, rev.wav and rev_stt.txt of the
robot's.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from core.files import folder_at, save_all
from core.message import Array, message
from core.recording.sound_file import write_wav
from core.sensors.microphones import Sound
from core.speech.quality.audio_similarity import AudioSimilarity, liken
from core.speech.quality.osqe import SpeechQuality, compare
from core.speech.recognition.recognizer import Dictation, Utterance
from core.speech.settings import RATE_HZ

LEAD_SILENCE_S, TAIL_SILENCE_S = 0.6, 0.3  # of silence around every phrase
MAX_LAG_S = 8.0  # by which a recording may lag behind what was played


@message
class SpokenTrack:
    """Phrases one after the other, with silence around each."""

    phrases: tuple[str, ...]
    samples: Array  # (N,) at RATE
    begins: tuple[int, ...]  # of each, its silence included; they end where the next begins

    def part(self, samples: Array, number: int, late: int = 0) -> Array:
        """A recording of the whole → that of one phrase, where it lags behind by `late` samples."""
        ends = (*self.begins[1:], len(self.samples))
        return samples[max(self.begins[number] + late, 0) : max(ends[number] + late, 0)]


@message
class LoopResult:
    """Result for a text on both paths."""

    original: str
    person: str  # stt.txt
    robot: str  # rev_stt.txt
    person_sound: Sound  # orig.wav
    robot_sound: Sound  # rev.wav
    quality: SpeechQuality
    similarity: AudioSimilarity


def track_of(phrases: Sequence[str], dry: Sequence[Array]) -> SpokenTrack:
    """Phrases and the sound of each (N,) at RATE → one after the other."""
    pieces = [padded(one) for one in dry]
    begins = np.cumsum([0, *(len(one) for one in pieces[:-1])]).tolist()
    return SpokenTrack(phrases=tuple(phrases), samples=np.concatenate(pieces), begins=tuple(begins))


def padded(dry: Array) -> Array:
    """A phrase with silence around it."""
    return np.concatenate((np.zeros(round(LEAD_SILENCE_S * RATE_HZ)), dry, np.zeros(round(TAIL_SILENCE_S * RATE_HZ))))


def read(dictation: Dictation, samples: Array) -> str:
    """A phrase with silence around it → the words that are read in it."""
    sound = Sound(stamp=0.0, rate=RATE_HZ, samples=samples[:, None])
    return dictation.transcribe(
        Utterance(sound=sound, begin=LEAD_SILENCE_S, end=max(sound.duration - TAIL_SILENCE_S, LEAD_SILENCE_S))
    )


def transcribed(dictation: Dictation, track: SpokenTrack, recorded: Array, late: int = 0) -> str:
    """A recording (N,) at RATE of a track → its text, phrase by phrase."""
    parts = (track.part(recorded, number, late) for number in range(len(track.phrases)))
    return "; ".join(read(dictation, part) for part in parts)


def lag_of(track: SpokenTrack, recorded: Array) -> int:
    """By how many samples a recording (N,) at RATE lags behind the track that was played."""
    size = 1 << (len(track.samples) + len(recorded) - 1).bit_length()
    both = np.conj(np.fft.rfft(track.samples, size)) * np.fft.rfft(recorded, size)
    likely = np.fft.irfft(both / np.maximum(np.abs(both), 1e-12) ** 0.5, size)
    return int(np.argmax(likely[: round(MAX_LAG_S * RATE_HZ)]))


def run_loop(dictation: Dictation, track: SpokenTrack, person: Array, robot: Array, late: int = 0) -> LoopResult:
    """The recordings (N,) at RATE of both paths → texts, compared; the robot's lags by `late` samples.

    Raises BadInput where there is nothing to compare.
    """
    original = "; ".join(track.phrases)
    texts = transcribed(dictation, track, person), transcribed(dictation, track, robot, late)
    sounds = [Sound(stamp=0.0, rate=RATE_HZ, samples=samples[:, None]) for samples in (person, robot)]
    return LoopResult(
        original=original,
        person=texts[0],
        robot=texts[1],
        person_sound=sounds[0],
        robot_sound=sounds[1],
        quality=compare(original, *texts),
        similarity=liken(*sounds),
    )


def save_loop(out: Path, result: LoopResult) -> dict[str, str]:
    """Write the products of the loop → what lies where. Raises Unwritable."""
    folder = folder_at(out)
    files: dict[str, str] = {}
    for name, sound in (("orig", result.person_sound), ("rev", result.robot_sound)):
        write_wav(folder / f"{name}.wav", sound)
        files[name] = str(folder / f"{name}.wav")
    texts = {"original": result.original, "stt": result.person, "rev_stt": result.robot}
    return files | save_all(folder, {name: (f"{name}.txt", f"{text}\n") for name, text in texts.items()})
