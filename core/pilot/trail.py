"""The way so far, thinned."""

import numpy as np

from core.message import Array
from core.slam.mapper import AnchoredPose, Mapper


def frozen(points: Array) -> Array:
    """Points (N, 2) of which no other code has a writable view → the same, read-only; messages need not copy them."""
    owned = points if points.base is None else points.copy()
    owned.setflags(write=False)
    return owned


NO_POINTS = frozen(np.zeros((0, 2)))


class Trail:
    """Points at least `step` [m] apart; when there are too many, every second one goes and the step doubles."""

    def __init__(self, step: float = 0.02, most: int = 2000) -> None:
        self._step = step
        self._most = most
        self._points: list[tuple[float, float]] = []
        self.points = NO_POINTS  # all of it (K, 2) [m], read-only

    def follow(self, way: Array) -> None:
        """Begin with a way (N, 2) [m] whose points are far enough apart already."""
        while len(way) > self._most:
            way, self._step = way[::2], 2 * self._step
        self._points, self.points = [(x, y) for x, y in way.tolist()], frozen(way.copy())

    def add(self, x: float, y: float) -> Array:
        """Go on to (x, y) [m] → the trail (K, 2) [m], read-only."""
        if self._points and np.hypot(x - self._points[-1][0], y - self._points[-1][1]) < self._step:
            return self.points
        self._points.append((x, y))
        if len(self._points) > self._most:
            self._points = self._points[::2]
            self._step *= 2
        self.points = frozen(np.array(self._points))
        return self.points


class MapTrail:
    """The same along the estimated way: its points move with the map when that is straightened."""

    def __init__(self) -> None:
        self._trail = Trail()
        self._stands: list[AnchoredPose] = []  # of its points
        self._revision = 0  # of the map

    def add(self, floor: Mapper) -> Array:
        """Go on to where the robot is now → the trail (K, 2) [m], world, read-only."""
        if self._revision != floor.graph.revision:
            self._revision = floor.graph.revision
            poses = [floor.where(stand) for stand in self._stands]
            self._trail.follow(np.array([(pose.x, pose.y) for pose in poses]).reshape(-1, 2))
        before, pose = self._trail.points, floor.estimate.pose
        points = self._trail.add(pose.x, pose.y)
        if points is not before:
            self._stands.append(floor.anchored_pose)
            self._stands = self._stands[:: 1 if len(points) == len(self._stands) else 2]
        return points
