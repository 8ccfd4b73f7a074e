"""Straighten pictures and points: Table 1's inverse model on tie-points, and the exact path next to it."""

from typing import NamedTuple, TypedDict

import cv2
import numpy as np
import scipy

from core.calibration.levenberg_marquardt import minimise
from core.message import Array
from core.optics import CameraModel


def all_pixels(model: CameraModel) -> Array:
    """Normalised coordinates (H·W, 2) of every pixel, row by row."""
    pixels = np.stack(np.meshgrid(np.arange(model.width), np.arange(model.height)), axis=-1).reshape(-1, 2)
    return (pixels - (model.cx, model.cy)) / (model.fx, model.fy)


TIE_POINTS = 40  # a side (Table 1)


class MapError(TypedDict):
    """Distance of corrected points from their true places, over every pixel of the picture [pixel]."""

    rms_px: float
    max_px: float


class TiePoints(NamedTuple):
    """A square grid over the picture in normalised coordinates, row by row."""

    distorted: Array  # (N, 2)
    ideal: Array  # (N, 2); NaN where the camera model reaches no ray


def tie_points(model: CameraModel) -> TiePoints:
    """A square grid that covers the entire picture, as seen and as it would be without distortion."""
    pixels = np.stack(np.meshgrid(*_grid_lines(model)), axis=-1).reshape(-1, 2)
    distorted = (pixels - (model.cx, model.cy)) / (model.fx, model.fy)
    return TiePoints(distorted, model.undistort(distorted))


def inverse_parameters(model: CameraModel, grid: TiePoints | None = None) -> Array:
    """The camera → a1..a8 (8,) of eq. 10, fitted to tie-points: linear start, then Levenberg-Marquardt on pixels.

    The printed denominator starts with a3; a3 and a4 already are the tangential terms and five unknowns are left, so
    it has to be a5, and only then does the model fit (0.03 px against 0.3 px for Table 3).
    """
    grid = grid or tie_points(model)
    known = np.isfinite(grid.ideal).all(axis=1)
    grid = TiePoints(grid.distorted[known], grid.ideal[known])
    rows, right = _linear(grid)
    start = np.linalg.lstsq(rows, right, rcond=None)[0]
    focal = np.array([model.fx, model.fy])

    def residuals(a: Array) -> tuple[Array, Array]:
        placed, jacobian = _inverse_with_jacobian(a, grid.distorted)
        return ((placed - grid.ideal) * focal).ravel(), (jacobian * focal[:, None]).reshape(-1, 8)

    return minimise(residuals, start, lambda state, step: state + step, iterations=40).state


def apply_inverse(a: Array, distorted: Array) -> Array:
    """Eq. 10 with a1..a8 (8,): distorted normalised points (N, 2) → ideal ones (N, 2)."""
    above, below = _terms(distorted)
    return (distorted + above @ a[:4]) / (1 + below @ a[4:])[:, None]


def errors(model: CameraModel, a: Array | None = None) -> tuple[MapError, MapError]:
    """Errors of Table 1's inverse a1..a8 (8,) and of the exact path, over the picture's pixels.

    The exact path is measured by distorting its result again and comparing with the pixel itself. Pixels that no ray
    of the camera model reaches are left out.
    """
    distorted, focal = all_pixels(model), np.array([model.fx, model.fy])
    ideal = model.undistort(distorted)
    known = np.isfinite(ideal).all(axis=1)
    distorted, ideal = distorted[known], ideal[known]
    table_1 = apply_inverse(inverse_parameters(model) if a is None else a, distorted) - ideal
    return _summary(table_1 * focal), _summary((model.distort(ideal) - distorted) * focal)


def exact_map(model: CameraModel) -> Array:
    """Source in the picture of every pixel of the straight one: (H, W, 2) [pixel]. Needs no inverse."""
    seen = model.distort(all_pixels(model)) * (model.fx, model.fy) + (model.cx, model.cy)
    limit = model.turning_radius
    seen[np.linalg.norm(all_pixels(model), axis=1) >= limit] = -1e4
    return seen.reshape(model.height, model.width, 2)


def table_1_map(model: CameraModel) -> Array:
    """The same as Table 1 makes it: tie-points through eq. 10, interpolation between them (H, W, 2) [pixel].

    Interpolation gives the corrected place of every pixel; Newton's method turns that round.
    """
    grid = tie_points(model)
    focal, centre = np.array([model.fx, model.fy]), np.array([model.cx, model.cy])
    corrected = apply_inverse(inverse_parameters(model, grid), grid.distorted) * focal + centre
    u, v = _grid_lines(model)
    across, down = (
        scipy.interpolate.RectBivariateSpline(v, u, corrected[:, axis].reshape(len(v), len(u))) for axis in (0, 1)
    )
    wanted = all_pixels(model) * focal + centre
    seen = model.distort(all_pixels(model)) * focal + centre
    for _ in range(5):
        missing = np.stack((across.ev(seen[:, 1], seen[:, 0]), down.ev(seen[:, 1], seen[:, 0])), axis=1) - wanted
        (a, b), (c, d) = (
            (of.ev(seen[:, 1], seen[:, 0], dy=1), of.ev(seen[:, 1], seen[:, 0], dx=1)) for of in (across, down)
        )
        steps = np.stack((d * missing[:, 0] - b * missing[:, 1], a * missing[:, 1] - c * missing[:, 0]), axis=1)
        seen = seen - steps / (a * d - b * c)[:, None]
    outside = ~np.all((seen >= -1) & (seen <= (model.width, model.height)), axis=1)
    seen[outside] = -1e4
    return seen.reshape(model.height, model.width, 2)


def straighten(picture: Array, lookup: Array) -> Array:
    """A picture (H, W) or (H, W, 3) and a map (H, W, 2) → the straight picture; black where nothing was seen."""
    places = lookup.astype(np.float32)
    return cv2.remap(picture, places[..., 0], places[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)


def _summary(off: Array) -> MapError:
    """Differences (N, 2) [pixel] → their root mean square and largest length."""
    squares = np.sum(off**2, axis=1)
    return {"rms_px": float(np.sqrt(squares.mean())), "max_px": float(np.sqrt(squares.max()))}


def _grid_lines(model: CameraModel) -> tuple[Array, Array]:
    """Columns u and rows v [pixel] of a grid from rim to rim of the picture."""
    return np.linspace(-0.5, model.width - 0.5, TIE_POINTS), np.linspace(-0.5, model.height - 0.5, TIE_POINTS)


def _inverse_with_jacobian(a: Array, distorted: Array) -> tuple[Array, Array]:
    """Eq. 10 and its derivative by a: (N, 2) and (N, 2, 8)."""
    above, below = _terms(distorted)
    denominator = 1 + below @ a[4:]
    placed = (distorted + above @ a[:4]) / denominator[:, None]
    by_below = -placed[:, :, None] * below[:, None, :]
    return placed, np.concatenate((above, by_below), axis=2) / denominator[:, None, None]


def _terms(distorted: Array) -> tuple[Array, Array]:
    """The factors of a1..a4 above the line (N, 2, 4) and of a5..a8 below it (N, 4)."""
    u, v = distorted[:, 0], distorted[:, 1]
    r2 = u * u + v * v
    across = np.stack((u * r2, u * r2 * r2, 2 * u * v, r2 + 2 * u * u), axis=1)
    down = np.stack((v * r2, v * r2 * r2, r2 + 2 * v * v, 2 * u * v), axis=1)
    return np.stack((across, down), axis=1), np.stack((r2 * r2, u * r2, v * r2, r2), axis=1)


def _linear(grid: TiePoints) -> tuple[Array, Array]:
    """Eq. 10 times its denominator is linear in the a's: rows (2N, 8) and right side (2N,)."""
    above, below = _terms(grid.distorted)
    rows = np.concatenate((above, -grid.ideal[:, :, None] * below[:, None, :]), axis=2)
    return rows.reshape(-1, 8), (grid.ideal - grid.distorted).ravel()
