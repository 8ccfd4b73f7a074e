"""Steered response power (SRP-PHAT): how well the correlations of all pairs agree with a direction.

DiBiase, "A high-accuracy, low-latency technique for talker localization in reverberant environments", 2000. The grid
reads interpolated lag tables; the refinement works on the spectra themselves, so it ends between all grids.
"""

from functools import lru_cache

import numpy as np

from core.message import Array, message
from core.perception.sound.direction import sphere
from core.perception.sound.least_squares import axes_of
from core.sensors.microphones import MicrophoneArray

STEPS_PER_SAMPLE = 4  # steps of a lag table per sample
MAX_ROUNDS = 12
CONVERGED_STEP_RAD = 1e-5  # a refinement step that is no longer worth making


@message
class Correlation:
    """Whitened cross spectra of every pair (eq. 39), X_i · X_j*."""

    values: Array  # (K, P) complex
    omega: Array  # (K,) [rad/s]
    size: int  # samples of a frame
    rate: int  # [Hz]

    @property
    def total(self) -> float:
        """The steered power of a direction with which everything agrees."""
        return float(np.abs(self.values).sum())

    def tables(self) -> Array:
        """Correlation over lags (FINER · size, P), lag 0 first, FINER steps a sample."""
        full = np.zeros((self.size * STEPS_PER_SAMPLE // 2 + 1, self.values.shape[1]), complex)
        first = round(self.omega[0] / (2 * np.pi) * self.size / self.rate)
        full[first : first + len(self.omega)] = self.values
        return np.fft.irfft(full, axis=0) * (self.size * STEPS_PER_SAMPLE / 2)


@message
class DirectionGrid:
    """Directions that are tried, and where each looks into the lag tables."""

    within: Array  # (G, D) along the array's axes
    places: Array  # (G, P) rows of the tables
    parts: Array  # (G, P) 0..1 of the way to the next row

    def powers(self, tables: Array) -> Array:
        """(G,) steered power of every direction."""
        pair = np.arange(tables.shape[1])
        here, following = tables[self.places, pair], tables[(self.places + 1) % len(tables), pair]
        return np.sum(here + self.parts * (following - here), axis=1)


@message
class Peak:
    """The direction of most steered power."""

    within: Array  # (D,) along the array's axes
    covariance: Array  # (D, D) of `within`, from the disagreement of the bands of the spectrum
    power: float  # of the total, -1..1


@lru_cache(maxsize=16)
def grid_of(array: MicrophoneArray, rate: int, size: int, count: int) -> DirectionGrid:
    """`count` directions over the sphere; of a flat array's, the half above its plane."""
    points = sphere(count)
    dimensions = len(axes_of(array))
    within = points if dimensions == 3 else points[points[:, 2] >= 0][:, :2]
    return DirectionGrid(**_looked_up(array, within, rate, size))


def _looked_up(array: MicrophoneArray, within: Array, rate: int, size: int) -> dict[str, Array]:
    steps = within @ (array.baselines @ axes_of(array).T).T / array.speed * rate * STEPS_PER_SAMPLE
    below = np.floor(steps).astype(int)
    return {"within": within, "places": below % (size * STEPS_PER_SAMPLE), "parts": steps - below}


def find_peak(
    correlation: Correlation, array: MicrophoneArray, grid: DirectionGrid, seeds: Array, bands: int
) -> Peak:
    """The best of the grid and of the seeds (S, D), refined."""
    tables = correlation.tables()
    powers = grid.powers(tables)
    tried = DirectionGrid(**_looked_up(array, seeds, correlation.rate, correlation.size)).powers(tables)
    best = int(np.argmax(powers))
    within = grid.within[best] if not len(tried) or powers[best] >= tried.max() else seeds[int(np.argmax(tried))]
    slant = array.baselines @ axes_of(array).T / array.speed
    within, power = _climb(correlation, slant, within)
    return Peak(
        within=within,
        covariance=_covariance(correlation, slant, within, bands),
        power=power / max(correlation.total, 1e-300),
    )


def steered_power(correlation: Correlation, slant: Array, within: Array) -> float:
    """Power in direction `within` (D,); `slant` (P, D) [s] gives the pairs' lags by slant · within."""
    turned = correlation.values * np.exp(1j * np.outer(correlation.omega, slant @ within))
    return float(np.sum(np.real(turned)))


def slopes(correlation: Correlation, slant: Array, within: Array) -> tuple[Array, Array]:
    """Gradient of every bin's steered power (K, D), and the Hessian (D, D) of them all."""
    omega = correlation.omega
    turned = correlation.values * np.exp(1j * np.outer(omega, slant @ within))
    gradient = -(omega[:, None] * np.imag(turned)) @ slant
    bend = -np.sum(omega[:, None] ** 2 * np.real(turned), axis=0)
    return gradient, (slant * bend[:, None]).T @ slant


def _frame(within: Array) -> Array:
    """Directions (2, D) in which a solution may move: the plane itself, or the sphere's tangent plane."""
    if len(within) == 2:
        return np.eye(2)
    return np.linalg.svd(within[None])[2][1:]


def _onto(within: Array) -> Array:
    length = float(np.linalg.norm(within))
    return within / length if len(within) == 3 or length > 1 else within


def _curvature(gradient: Array, hessian: Array, within: Array, sides: Array) -> Array:
    """Hessian along `sides` (2, 2), with the sphere's own bend, made negative definite."""
    bend = sides @ hessian @ sides.T
    if len(within) == 3:
        bend = bend - float(gradient @ within) * np.eye(2)
    values, vectors = np.linalg.eigh((bend + bend.T) / 2)
    return -(vectors * np.maximum(np.abs(values), 1e-9 + 1e-3 * np.abs(values).max())) @ vectors.T


def _climb(correlation: Correlation, slant: Array, within: Array) -> tuple[Array, float]:
    """Newton's steps uphill, halved until they climb → where they end (D,), and the power there."""
    power = steered_power(correlation, slant, within)
    for _ in range(MAX_ROUNDS):
        gradients, hessian = slopes(correlation, slant, within)
        gradient, sides = gradients.sum(0), _frame(within)
        step = -np.linalg.solve(_curvature(gradient, hessian, within, sides), sides @ gradient) @ sides
        step *= min(1.0, 0.1 / max(float(np.linalg.norm(step)), 1e-12))
        while np.linalg.norm(step) > CONVERGED_STEP_RAD:
            there = _onto(within + step)
            higher = steered_power(correlation, slant, there)
            if higher > power:
                break
            step = step / 2
        else:
            break
        within, power = there, higher
    return within, power


def _covariance(correlation: Correlation, slant: Array, within: Array, bands: int) -> Array:
    """Covariance (D, D) of the peak from the disagreement of the spectrum's bands (sandwich estimate)."""
    gradients, hessian = slopes(correlation, slant, within)
    sides = _frame(within)
    count = max(2, min(bands, len(gradients) // 2))
    votes = np.stack([band.sum(0) for band in np.array_split(gradients, count)]) @ sides.T
    votes -= votes.mean(0)
    bend = np.linalg.inv(_curvature(gradients.sum(0), hessian, within, sides))
    spread = bend @ (votes.T @ votes) @ bend * count / (count - 1)
    return sides.T @ spread @ sides
