"""The measurement model: the expected sighting of a landmark and its Jacobians (eq. 24-27, 32-33, corrected)."""

import math

import numpy as np

from core.geometry import Pose, wrap_all
from core.message import Array

MIN_RANGE_M = 1e-6  # closer, a bearing means nothing


def expected(pose: Pose, places: Array) -> tuple[Array, Array]:
    """Landmarks (N, 2) [m] seen from a pose → range and bearing (N, 2), and their change with the landmark (N, 2, 2).

    The print has δ = robot - landmark and arctan (eq. 24, 26). Here δ = landmark - robot and atan2: eq. 27 is
    the derivative of this form. The change with the robot's place is the negative of that with the landmark.
    """
    dx, dy = places[:, 0] - pose.x, places[:, 1] - pose.y
    reach = np.maximum(np.hypot(dx, dy), MIN_RANGE_M)
    sightings = np.column_stack((reach, wrap_all(np.arctan2(dy, dx) - pose.heading)))
    slopes = np.empty((len(places), 2, 2))
    slopes[:, 0, 0], slopes[:, 0, 1] = dx / reach, dy / reach
    slopes[:, 1, 0], slopes[:, 1, 1] = -dy / reach**2, dx / reach**2
    return sightings, slopes


def carried(slopes: Array, spreads: Array) -> Array:
    """Slopes J (N, 2, 2), covariances P (N, 2, 2) → J P Jᵀ (N, 2, 2), element by element as they are so small."""
    a, b, c, d = slopes.reshape(-1, 4).T
    p, q, r = spreads[:, 0, 0], spreads[:, 0, 1], spreads[:, 1, 1]
    first, second, third, fourth = a * p + b * q, a * q + b * r, c * p + d * q, c * q + d * r
    result = np.empty(spreads.shape)
    result[:, 0, 0], result[:, 1, 1] = first * a + second * b, third * c + fourth * d
    result[:, 0, 1] = result[:, 1, 0] = first * c + second * d
    return result


def place_of(pose: Pose, sighting: Array) -> tuple[Array, Array]:
    """Range and bearing (2,) seen from a pose → the landmark (2,) [m], and its change with them (2, 2) (eq. 33).

    The measured range and bearing take the place of the odometry's symbols in the print.
    """
    reach, angle = float(sighting[0]), pose.heading + float(sighting[1])
    c, s = math.cos(angle), math.sin(angle)
    return np.array([pose.x + reach * c, pose.y + reach * s]), np.array([[c, -reach * s], [s, reach * c]])


def residual(sightings: Array, expectations: Array) -> Array:
    """Sightings (..., 2) minus what was expected (..., 2), the bearing wrapped (eq. 29)."""
    difference = sightings - expectations
    difference[..., 1] = wrap_all(difference[..., 1])
    return difference


def squared_distance(residuals: Array, spreads: Array) -> tuple[Array, Array]:
    """Residuals (..., 2), covariances (..., 2, 2) → squared Mahalanobis distance (...) and log determinant (...)."""
    a, b, c = spreads[..., 0, 0], spreads[..., 0, 1], spreads[..., 1, 1]
    determinant = np.maximum(a * c - b * b, 1e-300)
    u, v = residuals[..., 0], residuals[..., 1]
    return (c * u * u - 2 * b * u * v + a * v * v) / determinant, np.log(determinant)
