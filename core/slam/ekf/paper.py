"""The paper's form of the filter (eq. 17-33, corrected): errors as plain differences."""

import numpy as np

from core.geometry import Pose, rotation, wrap
from core.message import Array
from core.slam.ekf.filter import POSE_SIZE, Filter, perpendicular
from core.slam.motion import Increment


class PaperFilter(Filter):
    """Standard EKF, for teaching and comparison: over long ways it grows too sure of itself."""

    def lever(self, places: Array) -> Array:
        """-J δ: a heading error swings the expected sighting about the robot."""
        return -perpendicular(places - (self.pose.x, self.pose.y))

    def turning(self, places: Array) -> Array:
        """None: errors are kept in the world's axes already."""
        return np.zeros_like(places)

    def error(self, truth: Pose) -> Array:
        """True minus estimated x, y, heading (3,)."""
        return np.array([truth.x - self.pose.x, truth.y - self.pose.y, wrap(truth.heading - self.pose.heading)])

    def _spread(self, base: Pose, move: Increment) -> None:
        """F_x P F_xᵀ touches two rows (eq. 21, 22), then the robot's own noise is added."""
        for row, change in ((0, -(self.pose.y - base.y)), (1, self.pose.x - base.x)):
            heading = self.covariance.row(2)
            added = change * heading
            added[row] += change * (heading[row] + change * heading[2])
            self.covariance.add_to_row(row, added)
        onto = np.eye(POSE_SIZE)
        onto[:2, :2] = rotation(base.heading)
        self.covariance.add_to_block(0, onto @ move.covariance @ onto.T)

    def _move(self, correction: Array) -> None:
        self.pose = Pose(
            self.pose.x + float(correction[0]),
            self.pose.y + float(correction[1]),
            wrap(self.pose.heading + float(correction[2])),
        )
        self.points = self.points + correction[POSE_SIZE:].reshape(-1, 2)
