"""How sure the robot is of where it is: two standard deviations of place, and of heading."""

from __future__ import annotations

import math

import numpy as np
from viser import SceneApi

from console.scene.palette import POSE
from console.scene.strokes import Strokes, ellipses
from core.robots import Profile
from core.snapshot import Snapshot

SIGMAS = 2.0
HEIGHT = 0.010  # [m]
WIDEST = math.pi  # [rad] to either side that the wedge of headings can show


class PoseEllipse:
    """An ellipse under the robot, and a wedge of headings before it."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._reach = 2.6 * robot.radius
        self._ellipse = Strokes(scene, "/pose_ellipse", POSE, 2.4)
        self._wedge = Strokes(scene, "/heading_wedge", POSE, 1.4)

    def show(self, snapshot: Snapshot) -> None:
        """Draw the newest covariance."""
        pose, covariance = snapshot.estimate.pose, snapshot.estimate.covariance
        centre = np.array([[pose.x, pose.y]])
        self._ellipse.draw(ellipses(centre, covariance[None, :2, :2], SIGMAS, HEIGHT))
        half = min(SIGMAS * math.sqrt(max(float(covariance[2, 2]), 0.0)), WIDEST)
        angles = pose.heading + np.linspace(-half, half, 13)
        arc = centre + self._reach * np.column_stack((np.cos(angles), np.sin(angles)))
        outline = np.vstack((centre, arc, centre))
        lifted = np.column_stack((outline, np.full(len(outline), HEIGHT)))
        self._wedge.draw(np.stack((lifted[:-1], lifted[1:]), axis=1))
