"""Visibility of landmarks: line of sight by the scan itself."""

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.perception.landmarks.landmarks import between_picture_edges
from core.sensors import Camera, Scan

WINDOW = np.arange(-3, 4)  # beams around a bearing
BEAM_MARGIN_M = 0.15  # that a beam may end short of a landmark or beyond


class VisibilityCheck:
    """One scan as a witness of what stands in the way."""

    def __init__(self, scan: Scan, mounting: Pose, camera: Camera | None = None) -> None:
        """`mounting`: robot_from_laser. `camera`: only what stands in its picture, too, can be missing."""
        self._scan, self._mounting, self._camera = scan, mounting, camera
        self._ranges = np.where(scan.valid | np.isposinf(scan.ranges), scan.ranges, np.nan)

    def judge(self, places: Array, spreads: Array) -> tuple[Array, Array]:
        """Places (N, 2) [m], robot frame, and their sd (N,) [m] → in plain sight, and seen through (both (N,) bool).

        In plain sight: inside the field of view, nothing nearer in the way, and something stands there. Seen through:
        every beam around has gone on beyond. Neither where no beam has measured anything.
        """
        scan = self._scan
        seen = self._mounting.inverse().apply(places)
        reach = np.hypot(seen[:, 0], seen[:, 1])
        bearing = np.arctan2(seen[:, 1], seen[:, 0])
        turned = np.sign(scan.angle_step) * (bearing - scan.angle_min)  # from the first beam on
        beam = np.round(turned % (2 * np.pi) / abs(scan.angle_step)).astype(int)[:, None] + WINDOW
        inside = ((beam >= 0) & (beam < len(self._ranges))).all(axis=1) & (reach < scan.range_max)
        if self._camera is not None:
            inside &= between_picture_edges(places, self._camera)
        around = self._ranges[np.clip(beam, 0, len(self._ranges) - 1)]
        inside &= (~np.isnan(around)).sum(axis=1) > len(WINDOW) // 2
        nearest = np.where(np.isnan(around), np.inf, around).min(axis=1)
        slack = BEAM_MARGIN_M + 3 * spreads
        return inside & (np.abs(nearest - reach) <= slack), inside & (nearest > reach + slack)
