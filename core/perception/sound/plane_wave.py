"""One plane wave against the times at which all microphones heard a sound.

Every microphone has a time of its own, with which the correlations of all pairs agree best (`tdoa.fit_plane_wave`);
the best direction of a plane wave (eq. 40) explains a part of these times. The rest is the misfit: in air it is as
small as the microphones' places are known and echoes allow, unless a channel is late, processed or exchanged.

Channels that are late together may fit another plane wave just as well. Noise that comes from everywhere alike
reaches all microphones at the same time on the average, so that its times show them.
"""

import math

import numpy as np

from core.message import Array, message

LAG_SD_M = 0.0007  # of a microphone's time, in a sound that comes from one direction alone
ECHO_SD_M = 0.008  # added to it for a sound without a direct path; less with more strength
MAX_SPEED_RATIO = 1.02  # of the speed of sound along the array: warmer air, a profile that is a little too large
NOISE_LEAN = 0.08  # of an array's radius: noise from everywhere is never quite even (48 waves: 1 / sqrt(3 · 48))
CHANCE_SDS = 1.645  # a misfit that one sound in twenty has by chance adds nothing to a direction's deviation
FOREIGN_SHARE = 0.35  # of what the others share; a channel that shares less hears something else


@message
class PlaneWaveFit:
    """Times at the microphones, and the best plane wave through them."""

    times: Array  # (M,) [m] by which each hears before the array's middle, times the speed of sound
    within: Array  # (D,) of the best direction along the array's axes
    residuals: Array  # (M,) [m] by which each hears later than that direction explains
    freedom: int  # of the residuals; 0: any times fit some direction
    expected_sd: float  # [m] of one residual on an array without a fault, in this sound
    expected_noise_sd: float  # [m] of one of `noise_times` on an array without a fault
    shared: Array  # (M,) -1..1, agreement of each channel with the one that it agrees with best
    noise_times: Array | None = None  # (M,) [m] the same of noise from everywhere; None: there is no such noise
    sharing: tuple[int, ...] = ()  # two microphones that share noise which others do not; (): none do

    @property
    def residual_sd(self) -> float:
        """[m] of one microphone's time; 0 where there are as few microphones as unknowns."""
        return math.sqrt(float(self.residuals @ self.residuals) / self.freedom) if self.freedom else 0.0

    @property
    def noise_sd(self) -> float:
        """[m] of one microphone's time in noise from everywhere; 0 where there is none."""
        if self.noise_times is None:
            return 0.0
        return math.sqrt(float(self.noise_times @ self.noise_times) / (len(self.noise_times) - 1))

    @property
    def foreign(self) -> Array:
        """Which channels share too little with all others, (M,) bool."""
        return self.shared < FOREIGN_SHARE * float(np.median(self.shared))

    @property
    def misfit(self) -> float:
        """The part that no plane wave or no noise from everywhere explains, of what is expected; infinite with a
        foreign channel, and with two that hear each other.
        """
        if self.foreign.any() or self.sharing:
            return math.inf
        return max(self.residual_sd / self.expected_sd, self.noise_sd / self.expected_noise_sd)

    @property
    def excess(self) -> float:
        """Variance [m²] of one microphone's time beyond what it is by chance."""
        in_noise = _beyond_chance(self.noise_sd, self.expected_noise_sd, len(self.times) - 1)
        return in_noise + _beyond_chance(self.residual_sd, self.expected_sd, self.freedom)


def _beyond_chance(sd: float, expected: float, freedom: int) -> float:
    """Variance beyond the one that squares of so many normal numbers reach by chance (Wilson and Hilferty, 1931)."""
    if not freedom:
        return 0.0
    spread = 2 / (9 * freedom)
    return max(0.0, sd**2 - (1 - spread + CHANCE_SDS * math.sqrt(spread)) ** 3 * expected**2)


def noise_sd_of(positions: Array) -> float:
    """Positions (M, D) [m] → deviation [m] of one microphone's time in noise from everywhere."""
    return math.hypot(LAG_SD_M, NOISE_LEAN * math.sqrt(float(np.sum(np.var(positions, axis=0)))))


def explain(positions: Array, times: Array) -> tuple[Array, Array, Array]:
    """Positions (M, D) [m] along the axes, times (M, N) [m] of N sounds → directions (D, N), residuals (M, N),
    and the freedom (N,) of each sound's.

    A direction is a unit vector in a volume; a flat array sees of one what sound's speed in air allows.
    """
    matrix, times = positions - positions.mean(0), times - times.mean(0)
    within = np.linalg.lstsq(matrix, times, rcond=None)[0]
    length, dimensions = np.linalg.norm(within, axis=0), matrix.shape[1]
    bound = (length > MAX_SPEED_RATIO) | (dimensions == 3)
    longest = 1.0 if dimensions == 3 else MAX_SPEED_RATIO
    within = np.where(bound, within * longest / np.maximum(length, 1e-12), within)
    freedom = len(matrix) - 1 - dimensions + bound
    return within, np.where(freedom > 0, matrix @ within - times, 0.0), freedom
