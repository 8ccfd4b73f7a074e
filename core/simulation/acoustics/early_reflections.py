"""The straight sound and the first reflections, exactly as far away as they are at every instant.

Each arrival reads the talker's own sound at the moment when it left the mouth, so a robot that moves hears lags that
change without steps. The sound is kept 16 times finer than its samples: arrivals fall between samples.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from core.message import Array
from core.simulation.acoustics.shoebox import STEPS_PER_SAMPLE
from core.simulation.settings import HardWall

HALF_SAMPLES = 8  # samples on either side that count for a value in between; all sound is late by that much
MAX_PATH_M = 45.0  # that an arrival may have come
HARD_WALL_SHARE = 0.95  # of the pressure, that a hard wall sends back
IMAGE_BEHIND: dict[HardWall, int] = {"west": 1, "south": 2, "east": 4, "north": 5}  # row of `first_images`
FILTER = np.sinc(
    np.arange(-HALF_SAMPLES * STEPS_PER_SAMPLE, HALF_SAMPLES * STEPS_PER_SAMPLE + 1) / STEPS_PER_SAMPLE
) * np.kaiser(2 * HALF_SAMPLES * STEPS_PER_SAMPLE + 1, 7.0)
PHASES = np.append(FILTER, np.zeros(STEPS_PER_SAMPLE - 1)).reshape(-1, STEPS_PER_SAMPLE)[
    ::-1
]  # (2 HALF_SAMPLES + 1, STEPS_PER_SAMPLE), the last sample first


class Arrivals:
    """One source's sound along several ways to several ears."""

    def __init__(self, rate: int, speed: float) -> None:
        self._per_metre = rate / speed  # samples that sound takes for a metre
        self._recent = np.zeros(2 * HALF_SAMPLES)
        self._fine = np.zeros(int(MAX_PATH_M * self._per_metre + 2) * STEPS_PER_SAMPLE)

    def feed(self, dry: Array, before: Array, now: Array, gains: Array) -> Array:
        """The next sound (N,) of the source → what the ears hear of it, (N, M).

        The ways are `before` and `now` (K, M) [m] long at the begin and the end of it; each brings `gains` (K, M)
        over the distance.
        """
        count = len(dry)
        context = np.concatenate((self._recent, dry))
        self._recent = context[-2 * HALF_SAMPLES :]
        finer = (sliding_window_view(context, len(PHASES)) @ PHASES).ravel()
        kept = np.concatenate((self._fine, finer))
        self._fine = kept[count * STEPS_PER_SAMPLE :]
        share = np.arange(1, count + 1) / count
        away = np.minimum(before[..., None] + (now - before)[..., None] * share, MAX_PATH_M)  # (K, M, N) [m]
        place = len(self._fine) + STEPS_PER_SAMPLE * (np.arange(count) - self._per_metre * away)
        first = place.astype(np.int64)
        part = place - first
        heard = kept[first] * (1 - part) + kept[np.minimum(first + 1, len(kept) - 1)] * part
        return np.einsum("km,kmn->nm", gains / np.maximum(now, 0.1), heard)


def first_images(
    size: tuple[float, float, float], source: Array, reflection: float, hard: HardWall = "none"
) -> tuple[Array, Array]:
    """A source (3,) [m] in a box → itself and its six mirror images (7, 3), and the pressure of each (7,).

    `hard`: the wall that sends back GLASS of the pressure, whatever the others do.
    """
    if reflection == 0 and hard == "none":
        return source[None].copy(), np.ones(1)
    images = np.repeat(source[None], 7, axis=0)
    for axis, side in enumerate(size):
        images[1 + axis, axis] *= -1
        images[4 + axis, axis] = 2 * side - source[axis]
    pressures = np.array([1.0] + 6 * [reflection])
    if hard != "none":
        pressures[IMAGE_BEHIND[hard]] = HARD_WALL_SHARE
    return images, pressures
