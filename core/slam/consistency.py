"""Consistency of an estimator: its errors against its covariance (NEES, NIS)."""

import math
from functools import cache

import numpy as np
import scipy

from core.geometry import Pose, wrap
from core.message import Array
from core.slam.estimate import Estimate


def squared_error(error: Array, covariance: Array) -> float:
    """Error (k,) and covariance (k, k) → normalised squared error, on average k; NaN for a singular covariance."""
    values, vectors = np.linalg.eigh(covariance)
    if values[0] <= 1e-14 * max(values[-1], 1e-9):
        return math.nan
    return float(((vectors.T @ error) ** 2 / values).sum())


@cache
def faded_band(memory: float) -> tuple[float, float]:
    """Return the band in which a fading mean of 2-D normalised innovations lies for 95 % of the time; ideal 1.

    Each, divided by its two degrees of freedom, is exponentially distributed. The mean that keeps `memory` (0..1) of
    itself with every new one weighs (1 + memory) / (1 - memory) of them, and is close to a gamma distribution.
    """
    count = (1 + memory) / (1 - memory)
    low, high = (float(scipy.special.gammaincinv(count, tail)) / count for tail in (0.025, 0.975))
    return low, high


def nees(estimate: Estimate, truth: Pose) -> float:
    """Normalised estimation error squared of a pose in the world's axes; ideal mean 3.

    The filter's own `EkfSlam.nees` measures the error as its covariance does, which is fairer to the invariant form.
    """
    pose = estimate.pose
    error = np.array([truth.x - pose.x, truth.y - pose.y, wrap(truth.heading - pose.heading)])
    return squared_error(error, estimate.covariance)
