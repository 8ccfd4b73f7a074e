"""The exact way back through the distortion, and how far it goes."""

from __future__ import annotations

import numpy as np

from core.message import Array
from core.optics import CameraModel

NEWTON = 25  # steps at most
CLOSE = 1e-13  # normalised error at which a point is done
NOTHING = 1e-12  # coefficients below this bend nothing anywhere
FLAT = 1e-9  # determinant of the distortion's slope below which there is no step


def undistort(model: CameraModel, distorted: Array) -> Array:
    """Distorted normalised points (N, 2) → ideal ones (N, 2), exactly, by Newton's method.

    NaN beyond the radius where the distortion folds back: no ray of this model reaches there.
    """
    limit = turning_radius(model)
    ideal = distorted.astype(float)
    open_points = np.arange(len(ideal))
    for _ in range(NEWTON):
        place = ideal[open_points]
        error = model.distort(place) - distorted[open_points]
        moving = np.abs(error).max(axis=1, initial=0.0) > CLOSE
        open_points, place, error = open_points[moving], place[moving], error[moving]
        if not len(open_points):
            return ideal
        a, b, c = _slopes(model, place)
        determinant = a * c - b * b
        determinant = np.where(np.abs(determinant) < FLAT, np.nan, determinant)
        step = np.column_stack((c * error[:, 0] - b * error[:, 1], a * error[:, 1] - b * error[:, 0]))
        place = place - step / determinant[:, None]
        radius = np.maximum(np.linalg.norm(place, axis=1), 1e-12)
        ideal[open_points] = place * np.minimum(1.0, 0.999 * limit / radius)[:, None]
    ideal[open_points] = np.nan
    return ideal


def turning_radius(model: CameraModel) -> float:
    """Radius in ideal normalised coordinates beyond which the distortion folds back; inf where it never does."""
    slope = np.array([7 * model.k3, 5 * model.k2, 3 * model.k1, 1.0])  # of the distorted radius, by powers of r²
    roots = np.roots(np.where(np.abs(slope) < NOTHING, 0.0, slope))
    squares = [root.real for root in roots if abs(root.imag) < 1e-9 and root.real > 0]
    return float(np.sqrt(min(squares))) if squares else float("inf")


def all_pixels(model: CameraModel) -> Array:
    """Normalised coordinates (H·W, 2) of every pixel, row by row."""
    pixels = np.stack(np.meshgrid(np.arange(model.width), np.arange(model.height)), axis=-1).reshape(-1, 2)
    return (pixels - (model.cx, model.cy)) / (model.fx, model.fy)


def _slopes(model: CameraModel, ideal: Array) -> tuple[Array, Array, Array]:
    """Derivative of the distortion at (N, 2): the symmetric matrix [[a, b], [b, c]], three arrays (N,)."""
    x, y = ideal[:, 0], ideal[:, 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (model.k1 + r2 * (model.k2 + r2 * model.k3))
    slope = 2 * (model.k1 + r2 * (2 * model.k2 + r2 * 3 * model.k3))
    along_x = radial + x * x * slope + 2 * model.p1 * y + 6 * model.p2 * x
    along_y = radial + y * y * slope + 6 * model.p1 * y + 2 * model.p2 * x
    return along_x, x * y * slope + 2 * model.p1 * x + 2 * model.p2 * y, along_y
