"""The sound that walls send back: what comes straight and first exactly, and all later reflections by images.

First: exactly as far away as it is at every instant. Each arrival reads the talker's own sound at the moment when it
left the mouth, so a robot that moves hears lags that change without steps. The sound is kept 16 times finer than its
samples: arrivals fall between samples.

Later: the image-source method, worked out in small pieces while the robot drives; the same images as
`core.simulation.acoustics.shoebox`, without those that are followed exactly.
"""

from collections.abc import Generator

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from core.message import Array
from core.simulation.acoustics.shoebox import (
    HIGH_PASS_HZ,
    SPEED_OF_SOUND_M_S,
    STEPS_PER_SAMPLE,
    ShoeboxRoom,
    images_along,
)
from core.simulation.settings import HardWall

HALF_SAMPLES = 8  # samples on either side that count for a value in between; all sound is late by that much
MAX_PATH_M = 45.0  # that an arrival may have come
HARD_WALL_SHARE = 0.95  # of the pressure, that a hard wall sends back
IMAGE_BEHIND: dict[HardWall, int] = {"west": 1, "south": 2, "east": 4, "north": 5}  # row of `first_images`
FILTER = np.sinc(
    np.arange(-HALF_SAMPLES * STEPS_PER_SAMPLE, HALF_SAMPLES * STEPS_PER_SAMPLE + 1) / STEPS_PER_SAMPLE
) * np.kaiser(2 * HALF_SAMPLES * STEPS_PER_SAMPLE + 1, 7.0)
# (2 HALF_SAMPLES + 1, STEPS_PER_SAMPLE), the last sample first
PHASES = np.append(FILTER, np.zeros(STEPS_PER_SAMPLE - 1)).reshape(-1, STEPS_PER_SAMPLE)[::-1]
AT_ONCE = 6_000  # images of one piece
DECAY_SHARE = 0.75  # of the reverberation time that is followed: 45 dB
MAX_ROOM_RADIUS_M = 12.0  # from the middle of a room to its farthest corner that is allowed for
IMAGE_JITTER_M = 0.05  # by which images are moved: real walls are no perfect mirrors, and perfect mirrors ring


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


def echo_length(rt60: float, rate: int) -> int:
    """Samples of the responses of rooms with that reverberation time [s]; 0 without one."""
    if rt60 == 0:
        return 0
    return cv2.getOptimalDFTSize(int((DECAY_SHARE * rt60 + MAX_ROOM_RADIUS_M / SPEED_OF_SOUND_M_S) * rate) + 64)


def echo_in_pieces(
    room: ShoeboxRoom, source: Array, ears: Array, rate: int, seed: int
) -> Generator[None, None, Array]:
    """Source (3,) and ears (M, 3) [m] in the room → responses (M, L), after as many small pieces of work.

    The same seed moves the same images alike wherever the ears are.
    """
    count, length = len(ears), echo_length(room.rt60, rate)
    axis = np.zeros(count * length * STEPS_PER_SAMPLE)
    starts = np.arange(count) * length * STEPS_PER_SAMPLE
    for images, gains in _batches(room, source, np.random.default_rng(seed)):
        away = np.linalg.norm(images[:, None] - ears, axis=2)
        fine = (away * (rate / room.speed) + HALF_SAMPLES) * STEPS_PER_SAMPLE
        first = fine.astype(np.int64)
        part = fine - first
        inside = first < length * STEPS_PER_SAMPLE - 1
        places = (first + starts)[inside]
        pressure = (gains[:, None] / away)[inside]
        axis += np.bincount(
            np.concatenate((places, places + 1)),
            np.concatenate((pressure * (1 - part[inside]), pressure * part[inside])),
            len(axis),
        )
        yield
    ratio = np.fft.rfftfreq(length, 1 / rate) / HIGH_PASS_HZ
    soft = ratio**2 / (1 + ratio**2)
    responses = np.zeros((count, length))
    for number, one in enumerate(axis.reshape(count, -1)):
        responses[number] = np.fft.irfft(np.fft.rfft(one)[: length // 2 + 1] * soft, length)
        yield
    return responses


def _batches(room: ShoeboxRoom, source: Array, rng: np.random.Generator) -> Generator[tuple[Array, Array]]:
    """Images (N, 3) [m] with more than one bounce, and their pressures (N,), some thousand at a time."""
    reach = DECAY_SHARE * room.rt60 * room.speed
    middle = np.array(room.size) / 2
    along = [images_along(source[axis], side, reach) for axis, side in enumerate(room.size)]
    apart = [(places - centre) ** 2 for (places, _), centre in zip(along, middle, strict=True)]
    beside = apart[1][:, None] + apart[2]
    bounces = along[1][1][:, None] + along[2][1]
    waiting: list[tuple[Array, Array]] = []
    for x, own, away in zip(*along[0], apart[0], strict=True):
        y, z = np.nonzero((beside < reach**2 - away) & (bounces + own > 1))
        if len(y):
            images = np.column_stack((np.full(len(y), x), along[1][0][y], along[2][0][z]))
            images += rng.uniform(-IMAGE_JITTER_M, IMAGE_JITTER_M, images.shape)
            waiting.append((images, room.reflection ** (bounces[y, z] + own)))
        if sum(len(gains) for _, gains in waiting) >= AT_ONCE:
            yield _joined(waiting)
            waiting = []
    if waiting:
        yield _joined(waiting)


def _joined(waiting: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    return np.concatenate([images for images, _ in waiting]), np.concatenate([gains for _, gains in waiting])


class Convolver:
    """Sound that comes in blocks through responses that may change; a change is faded in over one block."""

    def __init__(self, length: int, block: int) -> None:
        self._size = cv2.getOptimalDFTSize(length + block)
        self._past = np.zeros(self._size)
        self._spectra: Array | None = None  # (M, F)
        self._next: Array | None = None

    def change(self, responses: Array) -> None:
        """Use these responses (M, L) from the next block on."""
        self._next = np.fft.rfft(responses, self._size)

    def feed(self, dry: Array) -> Array | None:
        """The next sound (N,) → its echo (N, M); None before there are responses."""
        count = len(dry)
        self._past = np.concatenate((self._past[count:], dry))
        if self._spectra is None and self._next is None:
            return None
        spectrum = np.fft.rfft(self._past)
        new, self._next = self._next, None
        old, self._spectra = self._spectra, new if new is not None else self._spectra
        echo = self._through(spectrum, self._spectra, count)
        if new is None or old is None:
            return echo
        rising = (np.arange(1, count + 1) / count)[:, None]
        return rising * echo + (1 - rising) * self._through(spectrum, old, count)

    def _through(self, spectrum: Array, spectra: Array | None, count: int) -> Array:
        assert spectra is not None
        return np.fft.irfft(spectrum * spectra, self._size)[:, -count:].T
