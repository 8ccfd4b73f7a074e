"""Sound in a box-shaped room by the image-source method, and the noises of a room.

Allen and Berkley, "Image method for efficiently simulating small-room acoustics", 1979. Every image is placed on a
time axis 16 times finer than the sound's and then band-limited, so arrivals fall between samples as they do in air.
"""

import math
from dataclasses import dataclass

import numpy as np

from core.errors import BadInput
from core.message import Array

SPEED_OF_SOUND_M_S = 343.0  # at 20 °C
STEPS_PER_SAMPLE = 16  # steps of the time axis per sample while images are placed
HIGH_PASS_HZ = 60.0  # below, the images' equal signs add up to a pressure that no room holds
MOST_IMAGES = 3_000_000


@dataclass(frozen=True)
class ShoeboxRoom:
    """A box-shaped room with equal walls; one corner at the origin."""

    size: tuple[float, float, float]  # [m]
    rt60: float  # [s] until the sound has fallen by 60 dB; 0: no walls at all
    speed: float = SPEED_OF_SOUND_M_S  # [m/s]

    def __post_init__(self) -> None:
        if not all(math.isfinite(side) and side > 0 for side in self.size):
            raise BadInput("A room needs three positive sides in metres.")
        if not 0 <= self.rt60 <= 10 or not self.speed > 0:
            raise BadInput("A room's reverberation time must lie between 0 and 10 s, and sound needs a speed.")

    @property
    def reflection(self) -> float:
        """Pressure that a wall sends back, of 1 (Eyring's formula)."""
        if self.rt60 == 0:
            return 0.0
        x, y, z = self.size
        surface, volume = 2 * (x * y + y * z + z * x), x * y * z
        return math.exp(-12 * math.log(10) * volume / (self.speed * self.rt60 * surface))

    def holds(self, points: Array) -> bool:
        """Return whether all points (N, 3) [m] lie within the walls."""
        return bool(np.all((points > 0) & (points < np.array(self.size))))


def impulse_responses(
    room: ShoeboxRoom, source: Array, microphones: Array, rate: int, rng: np.random.Generator | None = None
) -> Array:
    """Source (3,) and microphones (M, 3) [m] in the room → responses (M, L) at `rate` [Hz], direct sound 1/distance.

    With `rng` the images are moved by up to 5 cm (De Sena et al. 2015): real walls are not perfect mirrors, and
    perfect mirrors ring. The direct sound stays. Raises BadInput when a point lies outside the room.
    """
    if not room.holds(np.vstack((source, microphones))):
        raise BadInput("The talker and all microphones must stand inside the room.")
    images, gains = _images(room, source, microphones.mean(0))
    if rng is not None:
        images[1:] += rng.uniform(-0.05, 0.05, images[1:].shape)
    distances = np.linalg.norm(images[:, None, :] - microphones, axis=2)
    reach = room.rt60 * room.speed if room.rt60 else 0.0
    length = int((max(reach, float(distances[0].max())) + 1.0) / room.speed * rate) + 64
    return np.stack(
        [
            _placed(distances[:, m] / room.speed * rate, gains / distances[:, m], length, rate)
            for m in range(len(microphones))
        ]
    )


def _images(room: ShoeboxRoom, source: Array, centre: Array) -> tuple[Array, Array]:
    """Mirror images (N, 3) [m] of the source, itself first, and their pressures (N,)."""
    if room.rt60 == 0:
        return source[None].copy(), np.ones(1)
    reach = room.rt60 * room.speed
    along = [images_along(source[axis], side, reach) for axis, side in enumerate(room.size)]
    places, bounces = zip(*along, strict=True)
    if math.prod(map(len, places)) > MOST_IMAGES:
        raise BadInput("The room is too small for so long a reverberation; make it larger or its walls softer.")
    apart = [(place - middle) ** 2 for place, middle in zip(places, centre, strict=True)]
    near = apart[0][:, None, None] + apart[1][:, None] + apart[2] < reach**2
    near |= bounces[0][:, None, None] + bounces[1][:, None] + bounces[2] == 0
    x, y, z = np.nonzero(near)
    count = bounces[0][x] + bounces[1][y] + bounces[2][z]
    order = np.argsort(count, kind="stable")
    images = np.column_stack((places[0][x], places[1][y], places[2][z]))[order]
    return images, room.reflection ** count[order]


def images_along(place: float, side: float, reach: float) -> tuple[Array, Array]:
    """One axis: where the images are (N,) [m] and how often each bounced (N,)."""
    most = math.ceil(reach / (2 * side)) + 1
    cells = np.arange(-most, most + 1)
    places = np.concatenate((place + 2 * cells * side, -place + 2 * cells * side))
    return places, np.concatenate((2 * abs(cells), abs(cells - 1) + abs(cells)))


def _placed(delays: Array, gains: Array, length: int, rate: int) -> Array:
    """Arrivals at `delays` (N,) [samples] with `gains` (N,) → band-limited response (length,)."""
    fine = delays * STEPS_PER_SAMPLE
    first = fine.astype(int)
    part = fine - first
    inside = first < length * STEPS_PER_SAMPLE - 1
    axis = np.bincount(first[inside], (gains * (1 - part))[inside], length * STEPS_PER_SAMPLE)
    axis += np.bincount(first[inside] + 1, (gains * part)[inside], length * STEPS_PER_SAMPLE)
    spectrum = np.fft.rfft(axis)[: length // 2 + 1]
    ratio = np.fft.rfftfreq(length, 1 / rate) / HIGH_PASS_HZ
    return np.fft.irfft(spectrum * ratio**2 / (1 + ratio**2), length)


def heard(signal: Array, responses: Array) -> Array:
    """A dry signal (N,) and responses (M, L) → what the microphones hear, (N, M); the tail is cut."""
    from scipy.signal import oaconvolve  # takes a second, and a robot in its room hears in real time without it

    return oaconvolve(signal[None], responses, axes=1)[:, : len(signal)].T


def plane_waves(
    signals: Array, towards: Array, positions: Array, rate: int, speed: float = SPEED_OF_SOUND_M_S
) -> Array:
    """Signals (K, N) from far sources in directions `towards` (K, 3) → what microphones (M, 3) [m] hear, (N, M)."""
    length = signals.shape[1]
    padded = length + 2 * math.ceil(float(np.abs(positions).max()) / speed * rate) + 64
    omega = 2j * np.pi * np.fft.rfftfreq(padded, 1 / rate)
    spectra = np.fft.rfft(signals, padded)
    ahead = towards @ positions.T / speed  # (K, M) [s]: the nearer a microphone, the earlier it hears
    total = np.zeros((len(positions), len(omega)), complex)
    for spectrum, lead in zip(spectra, ahead, strict=True):
        total += spectrum * np.exp(np.outer(lead, omega))
    return np.fft.irfft(total, padded)[:, :length].T


def pink_noise(rng: np.random.Generator, count: int, length: int, rate: int) -> Array:
    """`count` independent noises (count, length) whose power falls as 1/frequency above 50 Hz."""
    padded = length + 1024
    frequency = np.fft.rfftfreq(padded, 1 / rate)
    shape = rng.normal(size=(count, len(frequency))) + 1j * rng.normal(size=(count, len(frequency)))
    noise = np.fft.irfft(shape / np.sqrt(np.maximum(frequency, 50.0)), padded)[:, :length]
    return noise / noise.std(axis=1, keepdims=True)


def diffuse_noise(
    rng: np.random.Generator, positions: Array, length: int, rate: int, speed: float = SPEED_OF_SOUND_M_S
) -> Array:
    """Pink noise from everywhere at microphones (M, 3) [m] → (length, M), power about 1."""
    towards = rng.normal(size=(48, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    return plane_waves(pink_noise(rng, 48, length, rate), towards, positions, rate, speed) / math.sqrt(48)
