"""The order of channels from two utterances, all 24 orders: `python -m tests.benchmarks.direction_order --pairs 40`.

Someone is asked to speak in front of the robot, then to its left, and stands there to five degrees, in rooms with an
RT60 of 0.2-0.6 s and noise 20 dB below the voice.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import sys

import numpy as np

from core.experiments.direction_of_arrival import ARRAYS
from core.experiments.talk_in_rooms import RATE_HZ, make_scene
from core.perception.sound.channel_order import find_order
from core.sensors.microphones import Sound
from core.speech.practice_voice import practice_voice

REVERBERATION = (0.2, 0.3, 0.6)  # [s]


def main() -> None:
    """Measure and say the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=40)
    parser.add_argument("--seed", type=int, default=11)
    chosen = parser.parse_args()
    rng = np.random.default_rng(chosen.seed)
    arrays = list(ARRAYS.values())
    picked = [
        [
            (asked, make_scene(rng, REVERBERATION[number % 3], practice_voice(rng, 1.5, RATE_HZ), arrays, asked))
            for asked in (0.0, math.pi / 2)
        ]
        for number in range(chosen.pairs)
    ]
    for number, (name, array) in enumerate(ARRAYS.items()):
        right, certain, certain_wrong = 0, 0, 0
        for pair, order in itertools.product(picked, itertools.permutations(range(4))):
            sounds = [(scene.sound(number, "diffuse", 20.0), asked) for asked, scene in pair]
            mixed = [
                (Sound(stamp=0.0, rate=RATE_HZ, samples=one.samples[:, order]), azimuth) for one, azimuth in sounds
            ]
            found = find_order(mixed, array)
            good = found.channels == tuple(order.index(channel) for channel in range(4))
            right += good
            certain_wrong += found.certain and not good
            certain += found.certain
        told = {
            "array": name,
            "trials": 24 * len(picked),
            "right": right / (24 * len(picked)),
            "certain": certain / (24 * len(picked)),
            "wrong_but_certain": certain_wrong,
        }
        sys.stdout.write(json.dumps(told) + "\n")


if __name__ == "__main__":
    main()
