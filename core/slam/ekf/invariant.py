"""The right-invariant form of the filter: errors as an element of SE(2) with landmarks (the default).

The true state is the estimate, turned and shifted as a whole by the error ξ: θ = θ̂ + ξθ, p = rot(ξθ) p̂ + V(ξθ) ξp,
and so for every landmark. The sighting's derivative then does not depend on the estimated heading, so the filter
cannot learn a heading from landmarks that it placed by that same heading: it stays honest where the plain form
grows too sure of itself.
"""

import math

import numpy as np

from core.geometry import Pose, rotation, wrap
from core.message import Array
from core.slam.ekf.filter import POSE_SIZE, Filter, perpendicular
from core.slam.motion import Increment


def shift_matrix(angle: float) -> Array:
    """V (2, 2): a shift made while turning by `angle` [rad]."""
    if abs(angle) < 1e-9:
        return np.eye(2)
    s, c = math.sin(angle) / angle, (1 - math.cos(angle)) / angle
    return np.array([[s, -c], [c, s]])


class InvariantFilter(Filter):
    """Right-invariant EKF."""

    def lever(self, places: Array) -> Array:
        """None: the relative error does not depend on the heading's."""
        return np.zeros_like(places)

    def turning(self, places: Array) -> Array:
        """The heading's error turns the whole plane about the origin: δl = ξl + J l ξθ."""
        return perpendicular(places)

    def error(self, truth: Pose) -> Array:
        """ξ of the pose (3,): place, then heading."""
        turn = wrap(truth.heading - self.pose.heading)
        off = np.array([truth.x, truth.y]) - rotation(turn) @ (self.pose.x, self.pose.y)
        return np.array([*np.linalg.solve(shift_matrix(turn), off), turn])

    def _spread(self, base: Pose, move: Increment) -> None:
        values, vectors = np.linalg.eigh(move.covariance)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        factor = np.empty((3, self.covariance.size))
        here = np.array([self.pose.x, self.pose.y])
        factor[:, :2] = (rotation(base.heading) @ root[:2] - np.outer(perpendicular(here), root[2])).T
        factor[:, 2] = root[2]
        factor[:, POSE_SIZE:] = np.outer(root[2], -perpendicular(self.points).ravel())
        self.covariance.lift(factor)

    def _move(self, correction: Array) -> None:
        angle = float(correction[2])
        turn, shift = rotation(angle), shift_matrix(angle)
        x, y = (turn @ (self.pose.x, self.pose.y) + shift @ correction[:2]).tolist()
        self.pose = Pose(x, y, wrap(self.pose.heading + angle))
        self.points = self.points @ turn.T + correction[POSE_SIZE:].reshape(-1, 2) @ shift.T
