"""The camera's optics: pinhole and distortion, both ways (eq. 1-6).

Pixel (0, 0) is the centre of the top-left pixel; u runs right, v down.
"""

from __future__ import annotations

import numpy as np

from core.errors import BadInput
from core.message import Array, message


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
        """Distorted normalised points (N, 2) → ideal ones (N, 2), by fixed-point iteration."""
        ideal = points.copy()
        for _ in range(12):
            ideal = ideal - (self.distort(ideal) - points)
        return ideal

    def project(self, points: Array) -> Array:
        """Points (N, 3) [m] in the camera frame → pixels (N, 2); NaN for points not in front of the camera."""
        z = np.where(points[:, 2] > 1e-6, points[:, 2], np.nan)
        distorted = self.distort(points[:, :2] / z[:, None])
        return distorted * (self.fx, self.fy) + (self.cx, self.cy)

    def unproject(self, pixels: Array) -> Array:
        """Pixels (N, 2) → ideal normalised points (N, 2): x/z, y/z of the rays."""
        return self.undistort((pixels - (self.cx, self.cy)) / (self.fx, self.fy))


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
