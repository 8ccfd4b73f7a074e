"""A direction from lags (eq. 40), robust against lags that are wrong.

A plain least squares is thrown by one bad lag in 47 to the other side of the sphere. Here the first guess has the
smallest sum of absolute residuals; then lags count fully up to four standard deviations, and not at all past eight.
"""

import math

import numpy as np

from core.errors import BadInput
from core.message import Array, message
from core.perception.sound.direction import tangents
from core.sensors.microphones import MicrophoneArray

MAX_ROUNDS = 30
FULL_WEIGHT_SDS, NO_WEIGHT_SDS = 4.0, 8.0  # standard deviations up to which a lag counts, and from which it does not


@message
class DirectionFit:
    """A solution of eq. 40."""

    towards: Array  # (3,) unit vector
    weights: Array  # (L,) 0..1 of every lag
    residuals: Array  # (L,) [m]
    residual_sd: float  # [m] of the lags that count


def axes_of(array: MicrophoneArray) -> Array:
    """The directions (D, 3) in which the array has extent. Raises BadInput for a line or a point."""
    dimensions = array.dimensions
    if dimensions < 2:
        raise BadInput("All microphones lie in a line; a direction needs at least three that do not.")
    return array.axes[0][:dimensions]


def lift(array: MicrophoneArray, axes: Array, within: Array) -> Array:
    """Coordinates (…, D) along the array's axes → unit vectors (…, 3); on a flat array above its plane."""
    length = np.linalg.norm(within, axis=-1, keepdims=True)
    if len(axes) == 3:
        return within / np.maximum(length, 1e-12) @ axes
    inside = within / np.maximum(length, 1.0)
    up = np.sqrt(np.maximum(0.0, 1 - np.sum(inside**2, axis=-1, keepdims=True)))
    return inside @ axes + up * array.normal


def mirrored(array: MicrophoneArray, towards: Array) -> Array | None:
    """The direction that a flat array cannot tell from `towards` (3,)."""
    if array.dimensions > 2:
        return None
    return towards - 2 * (towards @ array.normal) * array.normal


def fit_lags(array: MicrophoneArray, pairs: Array, lags: Array, robust: bool = True) -> DirectionFit:
    """Pairs (L, 2) of microphones i, j and lags (L,) [s] by which j hears before i → the direction (eq. 40).

    Lags longer than the way between the two microphones are left out. Raises BadInput when too few remain.
    """
    axes = axes_of(array)
    baselines = array.positions[pairs[:, 1]] - array.positions[pairs[:, 0]]
    matrix, ahead = baselines @ axes.T, lags * array.speed
    possible = np.isfinite(ahead) & (np.abs(ahead) <= 1.02 * np.linalg.norm(baselines, axis=1) + 1e-4)
    matrix, ahead = matrix[possible], ahead[possible]
    if len(ahead) < len(axes) or np.linalg.matrix_rank(matrix, tol=1e-6) < len(axes):
        raise BadInput("Too few lags fit the array's size; are its positions and channels right?")
    within, weights = _weighted(matrix, ahead, robust)
    residuals = np.full(len(lags), np.nan)
    residuals[possible] = matrix @ within - ahead
    counted = np.zeros(len(lags))
    counted[possible] = weights
    freedom = max(weights.sum() - len(axes), 1.0)
    spread = math.sqrt(float(np.sum(weights * (matrix @ within - ahead) ** 2)) / freedom)
    return DirectionFit(towards=lift(array, axes, within), weights=counted, residuals=residuals, residual_sd=spread)


def _weighted(matrix: Array, ahead: Array, robust: bool) -> tuple[Array, Array]:
    """Iterated weighted least squares → solution (D,), weights (L,)."""
    weights = np.ones(len(ahead))
    within = np.linalg.lstsq(matrix, ahead, rcond=None)[0]
    if not robust or len(ahead) <= matrix.shape[1] + 1:
        return within, weights
    for turn in range(2 * MAX_ROUNDS):
        residuals = np.abs(matrix @ within - ahead)
        if turn < MAX_ROUNDS:  # smallest sum of absolute residuals
            weights = 1 / np.maximum(residuals, 1e-5)
        else:
            scale = max(1.4826 * float(np.median(residuals)), 1e-6)
            weights = np.clip((NO_WEIGHT_SDS - residuals / scale) / (NO_WEIGHT_SDS - FULL_WEIGHT_SDS), 0.0, 1.0)
        root = np.sqrt(weights)
        within = np.linalg.lstsq(matrix * root[:, None], ahead * root, rcond=None)[0]
    return within, weights


def placement(array: MicrophoneArray, axes: Array) -> Array:
    """Covariance (D, D) of a direction because the microphones' places are not exactly known.

    As if the errors of all microphones leant the same way: a ruler held askew turns the array as a whole, and that
    no residual shows.
    """
    extent = array.axes[1][: len(axes)] / math.sqrt(len(array.positions))
    return np.diag((array.position_sd / extent) ** 2)


def on_sphere(
    array: MicrophoneArray, axes: Array, towards: Array, covariance: Array, cosine_sd: float = 0.0
) -> Array:
    """Covariance (D, D) along the array's axes → (2, 2) [rad²] along (counter-clockwise, up) at `towards` (3,).

    A flat array measures how far a direction leans out of its plane by the cosine: near the plane that says little,
    and `cosine_sd` (of the cosine, of itself: the speed of sound, echoes) adds to it.
    """
    sides = tangents(towards)
    if len(axes) == 3:
        turned = sides @ axes.T
        return turned @ covariance @ turned.T
    within = axes @ towards
    covariance = covariance + cosine_sd**2 * np.outer(within, within)
    radius = max(float(np.linalg.norm(within)), 1e-9)
    radial_sd = math.sqrt(float(within @ covariance @ within)) / radius
    up = max(float(towards @ array.normal), math.sqrt(radial_sd / 2))
    slope = axes - np.outer(within, array.normal) / up  # d towards / d within, (2, 3)
    moved = slope @ sides.T
    return moved.T @ covariance @ moved + 1e-12 * np.eye(2)
