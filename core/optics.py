"""The camera's optics: pinhole and distortion, both ways (eq. 1-6).

Pixel (0, 0) is the centre of the top-left pixel; u runs right, v down.
"""

from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from core.errors import BadInput
from core.message import Array, message

MAX_NEWTON_STEPS = 25  # steps at most
MAX_ERROR = 1e-13  # normalised error at which a point is done
MIN_COEFFICIENT = 1e-12  # coefficients below this bend nothing anywhere
MIN_DETERMINANT = 1e-9  # determinant of the distortion's slope below which there is no step


@message
class CameraModel:
    """Intrinsic parameters as in Table 3, the coefficients of normalised coordinates (OpenCV's order)."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0  # beyond the paper's four: only where a hold-out asks for it

    def __post_init__(self) -> None:
        if not (self.width > 0 and self.height > 0 and self.fx > 0 and self.fy > 0):
            raise BadInput("A camera needs a positive size and focal length; check its calibration file.")

    @property
    def matrix(self) -> Array:
        """Camera matrix (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def distortion(self) -> Array:
        """(5,): k1 k2 p1 p2 k3, in OpenCV's order."""
        return np.array([self.k1, self.k2, self.p1, self.p2, self.k3])

    def scaled(self, factor: float) -> Self:
        """The same camera with so many times the pixels in a row."""
        return replace(
            self,
            width=round(self.width * factor),
            height=round(self.height * factor),
            fx=self.fx * factor,
            fy=self.fy * factor,
            cx=(self.cx + 0.5) * factor - 0.5,
            cy=(self.cy + 0.5) * factor - 0.5,
        )

    def distort(self, rays: Array) -> Array:
        """Ideal normalised points (N, 2) → distorted normalised points (N, 2) (eq. 4-6)."""
        x, y = rays[:, 0], rays[:, 1]
        r2 = x * x + y * y
        radial = 1 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        return np.column_stack(
            (
                x * radial + 2 * self.p1 * x * y + self.p2 * (r2 + 2 * x * x),
                y * radial + self.p1 * (r2 + 2 * y * y) + 2 * self.p2 * x * y,
            )
        )

    def undistort(self, points: Array) -> Array:
        """Distorted normalised points (N, 2) → ideal ones (N, 2), exactly, by Newton's method.

        NaN beyond the radius where the distortion folds back: no ray of this model reaches there.
        """
        limit = self.turning_radius
        ideal = points.astype(float)
        open_points = np.arange(len(ideal))
        for _ in range(MAX_NEWTON_STEPS):
            place = ideal[open_points]
            error = self.distort(place) - points[open_points]
            moving = np.abs(error).max(axis=1, initial=0.0) > MAX_ERROR
            open_points, place, error = open_points[moving], place[moving], error[moving]
            if not len(open_points):
                return ideal
            a, b, c = self._slopes(place)
            determinant = a * c - b * b
            determinant = np.where(np.abs(determinant) < MIN_DETERMINANT, np.nan, determinant)
            step = np.column_stack((c * error[:, 0] - b * error[:, 1], a * error[:, 1] - b * error[:, 0]))
            place = place - step / determinant[:, None]
            radius = np.maximum(np.linalg.norm(place, axis=1), 1e-12)
            ideal[open_points] = place * np.minimum(1.0, 0.999 * limit / radius)[:, None]
        ideal[open_points] = np.nan
        return ideal

    @cached_property
    def turning_radius(self) -> float:
        """Radius in ideal normalised coordinates beyond which the distortion folds back; inf where it never does."""
        slope = np.array([7 * self.k3, 5 * self.k2, 3 * self.k1, 1.0])  # of the distorted radius, by powers of r²
        roots = np.roots(np.where(np.abs(slope) < MIN_COEFFICIENT, 0.0, slope))
        squares = [root.real for root in roots if abs(root.imag) < 1e-9 and root.real > 0]
        return float(np.sqrt(min(squares))) if squares else float("inf")

    def project(self, points: Array) -> Array:
        """Points (N, 3) [m] in the camera frame → pixels (N, 2); NaN for points not in front of the camera."""
        z = np.where(points[:, 2] > 1e-6, points[:, 2], np.nan)
        distorted = self.distort(points[:, :2] / z[:, None])
        return distorted * (self.fx, self.fy) + (self.cx, self.cy)

    def unproject(self, pixels: Array) -> Array:
        """Pixels (N, 2) → ideal normalised points (N, 2): x/z, y/z of the rays; NaN where no ray reaches."""
        return self.undistort((pixels - (self.cx, self.cy)) / (self.fx, self.fy))

    @cached_property
    def widest_ray(self) -> float:
        """Distance from the axis, in ideal normalised coordinates, of the farthest ray that the picture shows."""
        corners = np.array([[0.0, 0.0], [self.width, 0.0], [0.0, self.height], [self.width, self.height]])
        reach = np.linalg.norm(self.unproject(corners), axis=1)
        if np.isnan(reach).any() and np.isfinite(self.turning_radius):
            return self.turning_radius
        return float(np.nanmax(reach, initial=0.0))

    def _slopes(self, ideal: Array) -> tuple[Array, Array, Array]:
        """Derivative of the distortion at (N, 2): the symmetric matrix [[a, b], [b, c]], three arrays (N,)."""
        x, y = ideal[:, 0], ideal[:, 1]
        r2 = x * x + y * y
        radial = 1 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        slope = 2 * (self.k1 + r2 * (2 * self.k2 + r2 * 3 * self.k3))
        along_x = radial + x * x * slope + 2 * self.p1 * y + 6 * self.p2 * x
        along_y = radial + y * y * slope + 6 * self.p1 * y + 2 * self.p2 * x
        return along_x, x * y * slope + 2 * self.p1 * x + 2 * self.p2 * y, along_y


TABLE_3 = CameraModel(
    width=320,
    height=256,
    fx=301.49221,
    fy=303.21885,
    cx=155.45581,
    cy=139.29446,
    k1=-0.43039,
    k2=0.24063,
    p1=-0.00382,
    p2=-0.00297,
)
"""The paper's camera (Table 3)."""
