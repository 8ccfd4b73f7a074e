"""Frames and the transforms between them (tf): how the laser is mounted, and odometry where only tf has it."""

import math
from array import array
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np

from core.geometry import Pose, Transform
from core.message import Array
from core.recording.odometry_track import heading_of
from core.recording.read_report import BadRecord
from core.recording.robot_names import BASES, ODOMETRIES, known_frame
from core.sensors.laser import Placed, flat

MOST_PAIRS = 1000
MOST_ROWS = 4_000_000  # numbers held per moving pair
MAX_TREMBLE = 0.002  # [m, rad] of a fixed transform that is published again and again

Pair = tuple[str, str]  # parent, child


class FrameTree:
    """Every transform in a log: the fixed ones once, the moving ones as rows over time."""

    def __init__(self) -> None:
        self._fixed: dict[Pair, Transform] = {}
        self._moving: dict[Pair, array[float]] = {}  # own stamp, logged, x, y, heading …

    @property
    def moving_frames(self) -> set[str]:
        """The frames that move in another one."""
        return {child for _, child in self._moving}

    @property
    def frames(self) -> set[str]:
        """The names of all frames."""
        return {frame for pair in (*self._fixed, *self._moving) for frame in pair}

    def add(self, transform: Any, stamp: float, logged: float, fixed: bool) -> int:
        """Take in a TransformStamped; how many bytes it holds on to. Raises BadRecord."""
        pair = transform.header.frame_id.strip("/"), transform.child_frame_id.strip("/")
        t, q = transform.transform.translation, transform.transform.rotation
        numbers = (t.x, t.y, t.z, q.x, q.y, q.z, q.w)
        if not all(math.isfinite(number) for number in numbers):
            raise BadRecord("a transform is not finite")
        if len(self._fixed) + len(self._moving) >= MOST_PAIRS and pair not in self._moving:
            return 0
        if fixed or pair not in self._moving:
            self._fixed[pair] = Transform(rotation=_matrix(q.x, q.y, q.z, q.w), translation=np.array([t.x, t.y, t.z]))
        if fixed:
            return 200
        rows = self._moving.setdefault(pair, array("d"))
        if len(rows) >= MOST_ROWS:
            return 0
        rows.extend((stamp, logged, t.x, t.y, float(heading_of(q.x, q.y, q.z, q.w))))
        return 40

    def moving(self, odometry: str, base: str, belongs: Callable[[str], bool]) -> tuple[Pair, Array]:
        """The pair that is the odometry and its rows (N, 5): own stamp, logged [s], x, y [m], heading [rad].

        Named frames are taken at their word, "" is a guess among those that `belongs` takes; nothing fits: no rows.
        """
        fits = [
            pair
            for pair in self._moving
            if (pair[0] == odometry if odometry else known_frame(pair[0], ODOMETRIES))
            and (pair[1] == base if base else known_frame(pair[1], BASES) and belongs(pair[1]))
        ]
        if not fits:
            return ("", base), np.zeros((0, 5))
        pair = max(fits, key=lambda pair: len(self._moving[pair]))
        return pair, np.array(self._moving[pair]).reshape(-1, 5)

    def mounting(self, base: str, laser: str) -> Placed | None:
        """Return the mounting of frame `laser` in frame `base`, or else in the robot's frame by its usual names.

        None when no chain of transforms leads there.
        """
        found = self.transform(base, laser)
        return None if found is None else flat(found)

    def transform(self, base: str, frame: str) -> Transform | None:
        """base_from_frame, where `base` is the robot's frame, or else one of its usual names; None: no chain."""
        if not frame:
            return None
        usual = sorted(known for known in self.frames if known_frame(known, BASES))
        chains = (self._chain(name, frame) for name in [base, *usual])
        return next((found for found in chains if found is not None), None)

    def _chain(self, start: str, goal: str) -> Transform | None:
        """start_from_goal through transforms that do not move, by the shortest chain."""
        if start == goal:
            return Transform.of_pose(Pose())
        steps: dict[str, list[tuple[str, Transform]]] = {}
        for (parent, child), transform in self._fixed.items():
            if self._still((parent, child)):
                steps.setdefault(parent, []).append((child, transform))
                steps.setdefault(child, []).append((parent, transform.inverse()))
        reached = {start: Transform.of_pose(Pose())}
        queue = deque([start])
        while queue and goal not in reached:
            frame = queue.popleft()
            for neighbour, transform in steps.get(frame, []):
                if neighbour not in reached:
                    reached[neighbour] = reached[frame] @ transform
                    queue.append(neighbour)
        return reached.get(goal)

    def _still(self, pair: Pair) -> bool:
        """Return whether a pair is fixed; older robots repeat fixed transforms on /tf."""
        rows = self._moving.get(pair)
        return rows is None or bool(np.ptp(np.array(rows).reshape(-1, 5)[:, 2:], axis=0).max() < MAX_TREMBLE)


def _matrix(x: float, y: float, z: float, w: float) -> Array:
    """Quaternion → rotation (3, 3). Raises BadRecord when it is none."""
    norm = math.hypot(x, y, z, w)
    if not 0.5 < norm < 2.0:
        raise BadRecord("a transform has no rotation")
    along, turned = np.array((x, y, z)) / norm, w / norm
    cross = np.cross(np.eye(3), along)
    return np.eye(3) + 2 * turned * cross + 2 * cross @ cross
