"""Background noise: the room's murmur from everywhere, the microphones' own hiss, and the robot's motors."""

import math

import numpy as np

from core.message import Array
from core.simulation.acoustics.reverberation import Arrivals
from core.simulation.acoustics.shoebox import SPEED_OF_SOUND

SPECTRUM_SAMPLES = 512  # samples of a spectrum of the murmur
FLAT_BELOW = 50.0  # [Hz]
HISS_SHARE = 0.05  # of a microphone, of the murmur's pressure
MOTORS = np.array([[0.0, 0.045, 0.03], [0.0, -0.045, 0.03]])  # [m] in the robot's frame, left and right
FULL_SPEED = 0.1  # [m/s] of a wheel at which its motor is at its nominal level
WHINE_HZ_PER_M_S = 2600.0  # [Hz per m/s] of the gears' teeth
OVERTONES = np.array([1.0, 0.5, 0.6, 0.25, 0.3, 0.15])


class Murmur:
    """Pink noise that comes from everywhere alike, for microphones (M, 3) [m]; power 1."""

    def __init__(self, rng: np.random.Generator, positions: Array, rate: int, speed: float = SPEED_OF_SOUND) -> None:
        self._rng, self._count = rng, len(positions)
        frequency = np.fft.rfftfreq(SPECTRUM_SAMPLES, 1 / rate)
        away = np.linalg.norm(positions[:, None] - positions, axis=2)
        alike = np.sinc(2 * frequency[:, None, None] * away / speed)  # coherence of a diffuse field
        mixing = np.linalg.cholesky(alike + 1e-6 * np.eye(self._count))
        colour = 1 / np.sqrt(np.maximum(frequency, FLAT_BELOW))
        colour[0] = colour[-1] = 0.0
        power = 4 * float(np.sum(colour**2)) / SPECTRUM_SAMPLES**2
        self._mixing = mixing * colour[:, None, None] / math.sqrt(power)
        self._window = np.sin(np.pi * (np.arange(SPECTRUM_SAMPLES) + 0.5) / SPECTRUM_SAMPLES)[:, None]
        self._ready = np.zeros((0, self._count))
        self._open = np.zeros((SPECTRUM_SAMPLES // 2, self._count))

    def take(self, count: int) -> Array:
        """The next (count, M)."""
        while len(self._ready) < count:
            shape = (SPECTRUM_SAMPLES // 2 + 1, self._count, 1)
            drawn = self._rng.normal(size=shape) + 1j * self._rng.normal(size=shape)
            block = np.fft.irfft((self._mixing @ drawn)[..., 0], SPECTRUM_SAMPLES, axis=0) * self._window
            self._ready = np.concatenate((self._ready, self._open + block[: SPECTRUM_SAMPLES // 2]))
            self._open = block[SPECTRUM_SAMPLES // 2 :]
        murmur, self._ready = self._ready[:count], self._ready[count:]
        return murmur + HISS_SHARE * self._rng.normal(size=murmur.shape)


class Motors:
    """Two geared motors under the microphones, silent at rest."""

    def __init__(self, rng: np.random.Generator, positions: Array, rate: int, speed: float = SPEED_OF_SOUND) -> None:
        """`positions` (M, 3) [m] of the microphones in the robot's frame."""
        self._rng, self._rate = rng, rate
        self._away = np.linalg.norm(MOTORS[:, None] - positions, axis=2)  # (2, M)
        self._ways = [Arrivals(rate, speed) for _ in MOTORS]
        self._phases = [0.0, 0.0]
        self._speeds = [0.0, 0.0]

    def take(self, count: int, left: float, right: float) -> Array:
        """The next (count, M) with the wheels at these speeds [m/s]; power about 1 at FULL_SPEED."""
        total = np.zeros((count, self._away.shape[1]))
        if not (left or right or any(self._speeds)):
            return total
        for number, speed in enumerate((left, right)):
            away = self._away[number][None]
            total += self._ways[number].feed(self._motor(number, abs(speed), count), away, away, away)
        return total / math.sqrt(2)

    def _motor(self, number: int, speed: float, count: int) -> Array:
        """One motor's own sound (count,): whine of the gears and rush, both as loud as it is fast."""
        speeds = np.linspace(self._speeds[number], speed, count)
        phase = self._phases[number] + 2 * math.pi * WHINE_HZ_PER_M_S / self._rate * np.cumsum(speeds)
        self._speeds[number], self._phases[number] = speed, float(phase[-1] % (2 * math.pi))
        whine = OVERTONES @ np.sin(np.arange(1, len(OVERTONES) + 1)[:, None] * phase)
        rush = self._rng.normal(size=count)
        return speeds / FULL_SPEED * (0.6 * whine / math.sqrt(float(OVERTONES @ OVERTONES) / 2) + 0.8 * rush)
