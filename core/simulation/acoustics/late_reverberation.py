"""All reflections after the first, by the image-source method, worked out in small pieces while the robot drives.

The same images as `core.simulation.acoustics.shoebox`, without those that `early_reflections` follows exactly.
"""

import math
from collections.abc import Generator

import cv2
import numpy as np

from core.message import Array
from core.simulation.acoustics.early_reflections import HALF_SAMPLES
from core.simulation.acoustics.shoebox import HIGH_PASS, SPEED_OF_SOUND, STEPS_PER_SAMPLE, ShoeboxRoom

AT_ONCE = 6_000  # images of one piece
DECAY_SHARE = 0.75  # of the reverberation time that is followed: 45 dB
MAX_ROOM_RADIUS_M = 12.0  # from the middle of a room to its farthest corner that is allowed for
IMAGE_JITTER = 0.05  # [m] by which images are moved: real walls are no perfect mirrors, and perfect mirrors ring


def echo_length(rt60: float, rate: int) -> int:
    """Samples of the responses of rooms with that reverberation time [s]; 0 without one."""
    if rt60 == 0:
        return 0
    return cv2.getOptimalDFTSize(int((DECAY_SHARE * rt60 + MAX_ROOM_RADIUS_M / SPEED_OF_SOUND) * rate) + 64)


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
    ratio = np.fft.rfftfreq(length, 1 / rate) / HIGH_PASS
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
    along = [_along(source[axis], side, reach) for axis, side in enumerate(room.size)]
    apart = [(places - centre) ** 2 for (places, _), centre in zip(along, middle, strict=True)]
    beside = apart[1][:, None] + apart[2]
    bounces = along[1][1][:, None] + along[2][1]
    waiting: list[tuple[Array, Array]] = []
    for x, own, away in zip(*along[0], apart[0], strict=True):
        y, z = np.nonzero((beside < reach**2 - away) & (bounces + own > 1))
        if len(y):
            images = np.column_stack((np.full(len(y), x), along[1][0][y], along[2][0][z]))
            images += rng.uniform(-IMAGE_JITTER, IMAGE_JITTER, images.shape)
            waiting.append((images, room.reflection ** (bounces[y, z] + own)))
        if sum(len(gains) for _, gains in waiting) >= AT_ONCE:
            yield _joined(waiting)
            waiting = []
    if waiting:
        yield _joined(waiting)


def _joined(waiting: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    return np.concatenate([images for images, _ in waiting]), np.concatenate([gains for _, gains in waiting])


def _along(place: float, side: float, reach: float) -> tuple[Array, Array]:
    """One axis: where the images are (N,) [m] and how often each bounced (N,)."""
    most = math.ceil(reach / (2 * side)) + 1
    cells = np.arange(-most, most + 1)
    places = np.concatenate((place + 2 * cells * side, -place + 2 * cells * side))
    return places, np.concatenate((2 * abs(cells), abs(cells - 1) + abs(cells)))


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
