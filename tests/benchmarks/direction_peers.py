"""Directions beside pyroomacoustics on the same sounds: `python -m tests.benchmarks.direction_peers --speech FOLDER`.

Needs `pip install pyroomacoustics` (0.10.1 was measured), and OMP_NUM_THREADS=1 in the environment for times on one
core. All know when the speech begins, but for those named `_alone`: peers get the speech without the noise before
it, which they have no use for, or else the whole sound. With the flat array they search azimuths in whole degrees,
with the tetrahedron 2,000 directions of the sphere, as their documentation shows.
"""

import json
from functools import partial
from pathlib import Path

import numpy as np

from core.experiments.direction_of_arrival import (
    DEFAULT,
    DirectionEstimate,
    estimators_with,
    in_room,
    rows_of,
    scenes_for,
    summary,
)
from core.experiments.result import as_csv
from core.experiments.talk_in_rooms import PRE_ROLL_S, RATE_HZ
from core.files import save_all
from core.message import Array
from core.recording.sound_file import read_sound
from core.sensors.microphones import MicrophoneArray, Sound
from tests.benchmarks.carried_out import carried_out
from tests.benchmarks.command import print_row, run_command

SIZE = 512  # samples of the peers' frames
SHORTEST = 1.0  # [s] of a recording that is used


def peer(name: str, begin: float, sound: Sound, array: MicrophoneArray) -> DirectionEstimate:
    """An algorithm of pyroomacoustics, 200-7000 Hz, for the sound from `begin` [s] on."""
    import pyroomacoustics

    samples = array.heard(sound)[int(begin * sound.rate) :]
    frames = pyroomacoustics.transform.stft.analysis(samples, SIZE, SIZE // 2, win=np.hanning(SIZE))
    where = {"dim": 3, "n_grid": 2000} if array.dimensions == 3 else {"azimuth": np.radians(np.arange(360))}
    algorithm = pyroomacoustics.doa.algorithms[name]
    finder = algorithm(array.positions.T, sound.rate, SIZE, c=array.speed, num_src=1, **where)
    finder.locate_sources(frames.transpose(2, 1, 0), freq_range=[200, 7000])
    return DirectionEstimate(azimuth=float(np.ravel(finder.azimuth_recon)[0]))


def voices(folder: Path) -> list[Array]:
    """Recordings of one voice at 16 kHz in a folder, from their first loud moment on, power 1."""
    found: list[Array] = []
    for path in sorted(folder.glob("*.flac")):
        sound = read_sound(path)
        if sound.rate != RATE_HZ or sound.channels > 1 or sound.duration < SHORTEST:
            continue
        samples = sound.samples[:, 0]
        begin = int(np.argmax(np.abs(samples) > 0.05 * np.abs(samples).max()))
        found.append(samples[max(begin - 160, 0) :] / np.std(samples))
    return found


def main(
    *,
    utterances: int = 2000,
    seed: int = 7,
    speech: Path | None = None,  # folder of recordings; without: a made-up voice
    out: Path = Path("direction"),
    workers: int = 2,
) -> None:
    spoken = voices(speech) if speech else []
    estimators = estimators_with(DEFAULT)
    for name in ("SRP", "MUSIC", "NormMUSIC"):
        estimators |= {name: partial(peer, name, PRE_ROLL_S), f"{name}_alone": partial(peer, name, 0.0)}
    work = partial(in_room, seed, estimators=estimators, voices=spoken)
    rooms = carried_out(work, scenes_for(utterances), workers)
    done = [one for room in rooms for one in room["trials"]]
    told = summary(done)
    whole = json.dumps({"seed": seed, "voices": len(spoken), "estimators": told}, indent=1)
    save_all(out, {"json": ("direction.json", whole), "csv": ("direction.csv", as_csv(rows_of(done)))})
    for name, one in told.items():
        print_row(f"{name}: {json.dumps(one['all'])}")
        for part in ("arrays", "noises"):
            for cell, values in one[part].items():
                print_row(f"    {cell}: {json.dumps(values)}")


if __name__ == "__main__":
    run_command(main)
