"""STOP, spoken to a robot that drives: `python -m tests.benchmarks.spoken_stop --data FOLDER [--trials 20]`.

The robot goes straight on in `sim:lab`, its ears open from before it set out. 1 to 8 seconds later someone 1 to 3 m
away says "stop moving", once, and the sound goes through the room, past the noise of the robot's own motors, to its
microphones and its recognizer. Three voices (two of the recordings in FOLDER/speech_commands_tts, one of espeak) at
two levels of the room's noise. Told: how often it was heard, and from the last phoneme of "stop" to the wheels at
rest how long it took and how far the robot went.
"""

import dataclasses
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from core.experiments.spoken_room import SpokenRoom
from core.experiments.table_2 import TRIALS
from core.experiments.table_2_trials import along
from core.settings import Settings
from core.simulation.settings import SimulationSettings
from core.simulation.world import world_named
from core.snapshot import Snapshot
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import Recognizer, at_16_khz
from core.speech.settings import SpeechSettings
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, speak
from tests.benchmarks.carried_out import carried_out
from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.word_scenes import Clip, synthetic
from tests.benchmarks.words import end_of_stop

WORDS = "stop moving"
RECORDED = ("slt", "kal16")
SPEED = 140  # [words/min] of espeak
MURMURS = {"quiet": -30.0, "noisy": -12.0}  # [dB] of the room's noise against a voice at 1 m
STANDS = 0.001  # [m] before its last place where the robot counts as arrived


def clips(data: Path) -> dict[str, Clip]:
    """The same words by every voice."""
    found = {clip.name: clip for clip in synthetic(data, "command") if clip.text == WORDS}
    told = {voice: next(clip for name, clip in found.items() if voice in name) for voice in RECORDED}
    sound = at_16_khz(speak(WORDS, VoiceSettings(voice=PERSONS_VOICE, speed=SPEED)))
    return {**told, PERSONS_VOICE: Clip(PERSONS_VOICE, WORDS, sound.samples[:, 0])}


def trial(case: tuple[str, Clip, str, int]) -> dict[str, Any]:
    """One STOP: whether it was heard, and how long [s] and how far [m] the robot still went."""
    voice, clip, noise, number = case
    chance = np.random.default_rng(number)
    start, _ = TRIALS["stop_moving"].start(world_named("lab"), chance)
    simulation = SimulationSettings(camera=False, murmur=MURMURS[noise])
    room = SpokenRoom(
        "lab",
        number,
        start=start,
        settings=dataclasses.replace(Settings(), simulation=simulation),
        recognizer=recognizer(),
    )
    room.place(1.0, 3.0, off=along(start, 3.0))
    going = room.robot.tell("continue 3 meters")
    for _ in room.overheard(float(chance.uniform(1.0, 8.0))):
        pass
    over = room.robot.snapshot.stamp + end_of_stop(clip)
    went: list[tuple[float, float]] = []

    def watch(snapshot: Snapshot) -> None:
        went.append((snapshot.stamp, start.distance_to(room.robot.truth.x, room.robot.truth.y)))

    loud = clip.samples / np.abs(clip.samples).max() * 32000
    heard = room.command(WORDS, watch=watch, pcm=loud.astype("<i2").tobytes())
    if heard.number is not None:
        room.robot.wait(going, 1.0, watch)
        for snapshot in room.robot.frames(1.0):
            watch(snapshot)
    stamps, places = np.array(went).T
    told = {"voice": voice, "noise": noise, "number": number, "heard": heard.number is not None}
    if heard.number is None:
        return told
    rest = float(stamps[np.flatnonzero(places < places[-1] - STANDS)[-1]])
    after = float(places[-1] - np.interp(over, stamps, places))
    return told | {"seconds": rest - over, "way_m": after, "understood_s": heard.understood - over}


@cache
def recognizer() -> Recognizer:
    """One for all trials of a process."""
    return open_engine(SpeechSettings()).recognizer


FIGURES = ("seconds", "way_m", "understood_s")


def spread(values: list[float]) -> dict[str, float]:
    p50, p95 = np.percentile(values, (50, 95))
    return {"p50": round(float(p50), 3), "p95": round(float(p95), 3), "worst": round(max(values), 3)}


def main(*, data: Path, trials: int = 20, workers: int = 2) -> None:
    spoken = clips(data)
    cases = [(v, c, noise, n) for v, c in spoken.items() for noise in MURMURS for n in range(trials)]
    rows = carried_out(partial(_nth, cases), len(cases), workers)
    for voice in spoken:
        for noise in MURMURS:
            these = [row for row in rows if (row["voice"], row["noise"]) == (voice, noise)]
            heard = [row for row in these if row["heard"]]
            figures = {
                key: spread([row[key] for row in heard]) for key in ("seconds", "way_m", "understood_s") if heard
            }
            line = {"voice": voice, "noise": noise, "trials": len(these), "heard": len(heard), **figures}
            print_row(line)


def _nth(cases: list[tuple[str, Clip, str, int]], index: int) -> dict[str, Any]:
    return trial(cases[index])


if __name__ == "__main__":
    run_command(main)
