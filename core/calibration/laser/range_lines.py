"""The board's line in the laser's readings, fitted where the noise is: along the beams.

A plane m·P = s that does not contain the laser is q = m/s, and a beam along the unit vector u meets it at the range
1/(u·q). A flat scan determines q only within its own plane, a single beam only along itself: q lives in a basis E.
"""

import numpy as np

from core.errors import BadInput
from core.message import Array, message

MAX_STEPS = 10
OFFSET_STEP_M = 1e-3  # for the derivative by the range offset
MIN_SINGULAR_SHARE = 1e-3  # singular values of the beams below this share of the largest carry no information


@message
class RangeFit:
    """A plane as far as the beams on it determine it."""

    q: Array  # (3,) [1/m], laser frame
    basis: Array  # (3, k): the directions of q that the beams determine
    covariance: Array  # (k, k) [1/m²], in the basis
    by_offset: Array  # (3,) [1/m²]: derivative of q by an offset b, where measured = true + b
    residuals: Array  # (N,) [m], measured minus fitted


def unit_rays(angles: Array) -> Array:
    """Bearings (N,) [rad] in the scanning plane → unit vectors (N, 3) in the laser frame."""
    return np.column_stack((np.cos(angles), np.sin(angles), np.zeros(len(angles))))


def fit_ranges(rays: Array, ranges: Array, sd: float) -> RangeFit:
    """Unit vectors (N, 3), ranges (N,) [m] and their standard deviation [m] → the plane they lie on.

    Minimises Σ (r - 1/(u·q))² by Gauss-Newton from the weighted linear fit of u·q = 1/r.
    Raises BadInput without beams.
    """
    if len(ranges) == 0 or np.any(ranges <= 0):
        raise BadInput("A line needs beams with positive ranges.")
    _, spread, directions = np.linalg.svd(rays, full_matrices=False)
    basis = directions[spread > MIN_SINGULAR_SHARE * spread[0]].T
    inside = rays @ basis
    line = _fit(inside, ranges)
    slope = -inside / ((inside @ line) ** 2)[:, None]
    shifted = (_fit(inside, ranges - OFFSET_STEP_M) - _fit(inside, ranges + OFFSET_STEP_M)) / (2 * OFFSET_STEP_M)
    return RangeFit(
        q=basis @ line,
        basis=basis,
        covariance=sd**2 * np.linalg.inv(slope.T @ slope),
        by_offset=basis @ shifted,
        residuals=ranges - 1 / (inside @ line),
    )


def _fit(inside: Array, ranges: Array) -> Array:
    """Rays in the basis (N, k), ranges (N,) [m] → q in the basis (k,)."""
    weight = ranges**2
    q = np.linalg.lstsq(inside * weight[:, None], weight / ranges, rcond=None)[0]
    for _ in range(MAX_STEPS):
        inverse = inside @ q
        if np.any(inverse <= 0):
            break
        step = np.linalg.lstsq(inside / (inverse**2)[:, None], 1 / inverse - ranges, rcond=None)[0]
        q = q + step
        if np.abs(step).max() < 1e-12 * np.abs(q).max():
            break
    return q
