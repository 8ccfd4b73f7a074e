"""One plane wave against the times at which all microphones heard a sound.

Every microphone has a time of its own, with which the correlations of all pairs agree best (`tdoa.fit_plane_wave`);
the best direction of a plane wave (eq. 40) explains a part of these times. The rest is the misfit: in air it is as
small as the microphones' places are known and echoes allow, unless a channel is late, processed or exchanged.

Channels that are late together may fit another plane wave just as well. Noise that comes from everywhere alike
reaches all microphones at the same time on the average, so that its times show them.
"""

from __future__ import annotations

import math

import numpy as np

from core.message import Array, message

LAG_SD = 0.0007  # [m] of a microphone's time, in a sound that comes from one direction alone
ECHO_SD = 0.008  # [m] added to it for a sound without a direct path; less with more strength
FASTEST = 1.02  # of the speed of sound along the array: warmer air, a profile that is a little too large
NOISE_LAG_SD = 0.003  # [m] of a microphone's time in half a second of noise from everywhere
FOREIGN = 0.35  # of what the others share; a channel that shares less hears something else


@message
class PlaneWaveFit:
    """Times at the microphones, and the best plane wave through them."""

    times: Array  # (M,) [m] by which each hears before the array's middle, times the speed of sound
    within: Array  # (D,) of the best direction along the array's axes
    residuals: Array  # (M,) [m] by which each hears later than that direction explains
    freedom: int  # of the residuals; 0: any times fit some direction
    expected_sd: float  # [m] of one residual on an array without a fault
    shared: Array  # (M,) -1..1, agreement of each channel with the one that it agrees with best
    noise_times: Array | None = None  # (M,) [m] the same of noise from everywhere; None: there is no such noise

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
        return self.shared < FOREIGN * float(np.median(self.shared))

    @property
    def misfit(self) -> float:
        """The part that no plane wave or no noise from everywhere explains, of what is expected; infinite with a
        foreign channel.
        """
        if self.foreign.any():
            return math.inf
        return max(self.residual_sd / self.expected_sd, self.noise_sd / NOISE_LAG_SD)

    @property
    def excess(self) -> float:
        """Variance [m²] of one microphone's time beyond what is expected."""
        in_noise = max(0.0, self.noise_sd**2 - NOISE_LAG_SD**2)
        return max(0.0, self.residual_sd**2 - self.expected_sd**2) + in_noise


def explain(positions: Array, times: Array) -> tuple[Array, Array, Array]:
    """Positions (M, D) [m] along the axes, times (M, N) [m] of N sounds → directions (D, N), residuals (M, N),
    and the freedom (N,) of each sound's.

    A direction is a unit vector in a volume; a flat array sees of one what sound's speed in air allows.
    """
    matrix, times = positions - positions.mean(0), times - times.mean(0)
    within = np.linalg.lstsq(matrix, times, rcond=None)[0]
    length, dimensions = np.linalg.norm(within, axis=0), matrix.shape[1]
    bound = (length > FASTEST) | (dimensions == 3)
    longest = 1.0 if dimensions == 3 else FASTEST
    within = np.where(bound, within * longest / np.maximum(length, 1e-12), within)
    freedom = len(matrix) - 1 - dimensions + bound
    return within, np.where(freedom > 0, matrix @ within - times, 0.0), freedom
