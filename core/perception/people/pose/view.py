"""Bearings and distances as places in a picture, and back."""

import math

import numpy as np

from core.message import Array
from core.sensors import Camera

STATURE_M = 1.70  # of the people who are expected
TORSO_SHARE = 0.29  # of the stature: from the hips to the shoulders
HIPS_HEIGHT_M = 0.93  # of the middle of the hips above the floor
MAX_OFF_AXIS_RAD = 1.3  # off the camera's axis up to which a direction is looked for


class Viewpoint:
    """A camera with its mounting."""

    def __init__(self, camera: Camera) -> None:
        self.camera = camera
        self._to_camera = camera.mounting.inverse()

    def pixel(self, bearing: float, distance: float, height: float) -> tuple[Array, float]:
        """A point at a bearing [rad] and distance [m] from the camera, `height` [m] above the floor → its pixel (2,),
        NaN where it is not in front of the camera, and the pixels of a metre there.
        """
        eye = self.camera.mounting.translation
        point = np.array([[eye[0] + distance * math.cos(bearing), eye[1] + distance * math.sin(bearing), height]])
        seen = self._to_camera.apply(point)
        depth = float(seen[0, 2])
        if depth < 0.05 or math.hypot(*seen[0, :2]) > math.tan(MAX_OFF_AXIS_RAD) * depth:
            return np.full(2, np.nan), 0.0
        return self.camera.model.project(seen)[0], self.camera.model.fx / depth

    def column(self, bearing: float) -> float:
        """The column [pixel] of a bearing at the camera's own height; NaN out of view."""
        return float(self.pixel(bearing, 1.0, float(self.camera.mounting.translation[2]))[0][0])

    def columns_of(self, bearing: float, half: float) -> tuple[float, float]:
        """The columns [pixel] from `half` [rad] left of a bearing to `half` right; ±inf where it is out of view."""
        left, right = self.column(bearing + half), self.column(bearing - half)
        return (-math.inf if math.isnan(left) else left), (math.inf if math.isnan(right) else right)

    def bearing(self, column: float, row: float) -> float:
        """A pixel → its bearing [rad] in the robot's frame; NaN where no ray reaches."""
        x, y = self.camera.model.unproject(np.array([[column, row]], float))[0]
        ray = self.camera.mounting.rotation @ np.array([x, y, 1.0])
        return math.atan2(float(ray[1]), float(ray[0]))

    def elevation(self, column: float, row: float) -> float:
        """A pixel → the slope of its ray: metres up for each metre along the floor."""
        x, y = self.camera.model.unproject(np.array([[column, row]], float))[0]
        ray = self.camera.mounting.rotation @ np.array([x, y, 1.0])
        return float(ray[2]) / max(math.hypot(float(ray[0]), float(ray[1])), 1e-6)

    def stature(self, distance: float) -> float:
        """[pixel] of an upright person at a distance [m]."""
        return self.camera.model.fy * STATURE_M / distance

    def distance(self, torso: float) -> float:
        """The distance [m] of a person whose torso is so long [pixel]."""
        return self.camera.model.fy * TORSO_SHARE * STATURE_M / max(torso, 1e-3)
