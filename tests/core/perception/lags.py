"""Lags of a far source, and the direction with its covariance that lags alone give."""

import numpy as np

from core.message import Array
from core.perception.sound.direction import Direction
from core.perception.sound.least_squares import axes_of, fit_lags, mirrored, on_sphere, placement
from core.sensors.microphones import MicrophoneArray

LAG_SD = 3e-6  # [s] no lag is better known than this


def lags_of(array: MicrophoneArray, towards: Array) -> Array:
    """Directions (N, 3) towards far sources → by how much [s] each pair's j hears before i, (N, P) (eq. 40)."""
    return towards @ array.baselines.T / array.speed


def direction_from_lags(array: MicrophoneArray, pairs: Array, lags: Array, stamp: float = 0.0) -> Direction:
    """Lags (L,) [s] of pairs (L, 2) → a direction with its covariance; strength is the share of lags that agree."""
    fit = fit_lags(array, pairs, lags)
    axes = axes_of(array)
    baselines = (array.positions[pairs[:, 1]] - array.positions[pairs[:, 0]]) @ axes.T
    weighted = baselines * np.sqrt(fit.weights)[:, None]
    within = (fit.residual_sd**2 + (LAG_SD * array.speed) ** 2) * np.linalg.pinv(weighted.T @ weighted)
    return Direction(
        stamp=stamp,
        towards=fit.towards,
        covariance=on_sphere(array, axes, fit.towards, within + placement(array, axes)),
        strength=float(fit.weights.mean()),
        mirror=mirrored(array, fit.towards),
    )
