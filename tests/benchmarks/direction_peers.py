"""Directions beside pyroomacoustics on the same sounds: `python -m tests.benchmarks.direction_peers --speech FOLDER`.

Needs `pip install pyroomacoustics` (0.10.1 was measured), and OMP_NUM_THREADS=1 in the environment for times on one
core. All know when the speech begins, but for those named `_alone`: peers get the speech without the noise before
it, which they have no use for, or else the whole sound. With the flat array they search azimuths in whole degrees,
with the tetrahedron 2,000 directions of the sphere, as their documentation shows.
`--part 2/8` measures the second of eight parts, `--pool` puts together what the parts have written.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import sys
from pathlib import Path

import numpy as np

from core.experiments.direction_of_arrival import (
    ESTIMATORS,
    DirectionEstimate,
    DirectionTrial,
    Estimator,
    campaign,
    save,
    summary,
)
from core.experiments.talk_in_rooms import PRE_ROLL, RATE_HZ
from core.message import Array
from core.recording.sound_file import read_sound
from core.sensors.microphones import MicrophoneArray, Sound

SIZE = 512  # samples of the peers' frames
SHORTEST = 1.0  # [s] of a recording that is used


def peer(name: str, begin: float) -> Estimator:
    """An algorithm of pyroomacoustics, 200-7000 Hz, for the sound from `begin` [s] on."""
    import pyroomacoustics

    algorithm = pyroomacoustics.doa.algorithms[name]
    azimuths = np.radians(np.arange(360))

    def answer(sound: Sound, array: MicrophoneArray) -> DirectionEstimate:
        samples = array.heard(sound)[int(begin * sound.rate) :]
        frames = pyroomacoustics.transform.stft.analysis(samples, SIZE, SIZE // 2, win=np.hanning(SIZE))
        where = {"dim": 3, "n_grid": 2000} if array.dimensions == 3 else {"azimuth": azimuths}
        finder = algorithm(array.positions.T, sound.rate, SIZE, c=array.speed, num_src=1, **where)
        finder.locate_sources(frames.transpose(2, 1, 0), freq_range=[200, 7000])
        return DirectionEstimate(azimuth=float(np.ravel(finder.azimuth_recon)[0]))

    return answer


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


def written(folder: Path) -> list[DirectionTrial]:
    """All trials that parts have written below a folder."""
    done: list[DirectionTrial] = []
    for path in sorted(folder.glob("part-*/direction.csv")):
        with path.open(newline="") as file:
            done += [
                DirectionTrial(
                    estimator=row["estimator"],
                    array=row["array"],
                    rt60=float(row["rt60_s"]),
                    noise=row["noise"],
                    ratio=float(row["snr_db"]),
                    error=math.radians(float(row["error_deg"])),
                    sd=math.radians(float(row["sd_deg"])) if row["sd_deg"] else None,
                    declared=row["declared"] == "1",
                    took=float(row["real_time_factor"]),
                )
                for row in csv.DictReader(file)
            ]
    return done


def tell(words: str) -> None:
    """How far it is."""
    sys.stderr.write(f"{words}\n")


def main() -> None:
    """Measure, write direction.json and direction.csv, say the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--utterances", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--speech", type=Path, default=None, help="folder of recordings; without: a made-up voice")
    parser.add_argument("--out", type=Path, default=Path("direction"))
    parser.add_argument("--part", default="1/1", help="which of how many parts, as 2/8")
    parser.add_argument("--pool", action="store_true", help="measure nothing: put together the parts in --out")
    chosen = parser.parse_args()
    number, parts = map(int, chosen.part.split("/"))
    spoken = voices(chosen.speech) if chosen.speech else []
    if chosen.pool:
        done, out = written(chosen.out), chosen.out
    else:
        estimators = dict(ESTIMATORS)
        for name in ("SRP", "MUSIC", "NormMUSIC"):
            estimators |= {name: peer(name, PRE_ROLL), f"{name}_alone": peer(name, 0.0)}
        done = campaign(
            chosen.utterances,
            chosen.seed,
            estimators,
            spoken,
            tell=tell,
            part=(number, parts),
        )
        out = chosen.out if parts == 1 else chosen.out / f"part-{number:02d}"
    told = summary(done)
    save(out, {"seed": chosen.seed, "voices": len(spoken), "estimators": told}, done)
    for name, one in told.items():
        sys.stdout.write(f"{name}: {json.dumps(one['all'])}\n")
        for part in ("arrays", "noises"):
            for cell, values in one[part].items():
                sys.stdout.write(f"    {cell}: {json.dumps(values)}\n")


if __name__ == "__main__":
    main()
