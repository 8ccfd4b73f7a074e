"""A view that is kept: a scan, and where in its submap it was taken."""

from functools import cached_property

import numpy as np

from core.geometry import Pose
from core.message import Array, message
from core.perception.landmarks.frame_perception import Beams

MAX_POINTS = 240  # of a scan that are matched, at most
TOLERANCE_M = 0.2  # within which a point lies on what a beam met
TOLERANCE_SHARE = 0.03  # the same as a share of its distance
BEAMS_BESIDE = 2  # beams to either side whose shortest counts: poses are not exact


@message
class Keyframe:
    """One scan as seen from the robot frame at its stamp."""

    id: int
    submap: int
    stamp: float  # [s]
    local: Pose  # submap_from_robot
    ends: Array  # (N, 2) [m], robot frame, right to left: ends of the beams, NaN where nothing was measured
    hits: Array  # (N,) bool: ends that are something
    eye: Array  # (2,) [m], robot frame: where the beams start

    @cached_property
    def points(self) -> Array:
        """The points that were hit, thinned: (M, 2) [m], robot frame, in the order of the beams."""
        return thinned(self.ends[self.hits])

    @cached_property
    def _view(self) -> tuple[Array, Array]:
        """Bearing (N,) [rad], rising, and length (N,) [m] of the beams that measured something, seen from the eye."""
        beams = self.ends[~np.isnan(self.ends[:, 0])] - self.eye
        bearings = np.arctan2(beams[:, 1], beams[:, 0])
        order = np.argsort(bearings, kind="stable")
        return bearings[order], np.hypot(beams[:, 0], beams[:, 1])[order]

    def judge(self, points: Array) -> tuple[Array, Array]:
        """Points (K, 2) [m] in this robot frame → which lie on what was seen, which were looked through (K,) bool.

        What lies behind, or where no beam went, is neither.
        """
        bearings, lengths = self._view
        if len(bearings) < 2:
            return np.zeros(len(points), bool), np.zeros(len(points), bool)
        away = points - self.eye
        bearing, distance = np.arctan2(away[:, 1], away[:, 0]), np.hypot(away[:, 0], away[:, 1])
        after = np.clip(np.searchsorted(bearings, bearing), 1, len(bearings) - 1)
        gap = bearings[after] - bearings[after - 1]
        step = 3.0 * float(np.median(np.diff(bearings)))
        looked = (bearing >= bearings[0]) & (bearing <= bearings[-1]) & (gap < step)
        around = np.clip(after[:, None] + np.arange(-BEAMS_BESIDE - 1, BEAMS_BESIDE + 1), 0, len(bearings) - 1)
        nearest, farthest = lengths[around].min(axis=1), lengths[around].max(axis=1)
        slack = np.maximum(TOLERANCE_M, TOLERANCE_SHARE * distance)
        on = looked & (distance > nearest - slack) & (distance < farthest + slack)
        return on, looked & (distance < nearest - slack)


def keyframe(number: int, submap: int, stamp: float, local: Pose, beams: Beams) -> Keyframe:
    """A scan as a view."""
    eye = np.array([beams.viewpoint.x, beams.viewpoint.y])
    ends = beams.ends.astype(np.float32)
    return Keyframe(id=number, submap=submap, stamp=stamp, local=local, ends=ends, hits=beams.hits, eye=eye)


def thinned(points: Array, most: int = MAX_POINTS) -> Array:
    """Points (N, 2) → at most `most` of them, evenly."""
    return points[:: max(1, -(-len(points) // most))]
