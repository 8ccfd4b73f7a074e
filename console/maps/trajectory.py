"""The robot's trajectory, stored in the frames of its submaps: a closure that moves a submap moves these poses."""

import math
import time
from array import array

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.slam.map.status import MapStatus, SubmapView
from core.snapshot import Snapshot

POSE_GAP_S = 0.1  # between two poses, until there are too many
MAX_POSES = 100_000
ROW_FIELDS = 5  # stamp [s], submap, x, y [m], heading [rad] in the submap
NOWHERE = -1  # no room: the pose is the world's


class Trajectory:
    """Grows with every snapshot; when it is full every second pose goes, and the gap doubles."""

    def __init__(self) -> None:
        self._rows = array("d")
        self._gap = POSE_GAP_S
        self._newest = -np.inf
        self.begun = math.inf  # Unix time [s] of its first pose

    def __len__(self) -> int:
        return len(self._rows) // ROW_FIELDS

    def forget(self) -> None:
        self._rows, self._gap, self._newest, self.begun = array("d"), POSE_GAP_S, -np.inf, math.inf

    def add(self, snapshot: Snapshot) -> None:
        """Add the pose of a snapshot. A robot whose clock began again begins another trajectory."""
        if snapshot.stamp < self._newest - 1e-6:
            self.forget()
        if snapshot.stamp - self._newest < self._gap - 1e-6:
            return
        self._newest = snapshot.stamp
        self.begun = min(self.begun, time.time())
        room, pose = active(snapshot.floor), snapshot.estimate.pose
        local = pose if room is None else room.pose.inverse() @ pose
        number = NOWHERE if room is None else room.id
        self._rows.extend((snapshot.stamp, number, local.x, local.y, local.heading))
        if len(self) > MAX_POSES:
            self._rows, self._gap = array("d", self.rows()[::2].tobytes()), 2 * self._gap

    def rows(self) -> Array:
        """A copy of all that is kept (K, 5): stamp [s], room, pose in it; from any thread.

        It is taken in one step: an array that lends its memory cannot grow meanwhile.
        """
        return np.frombuffer(self._rows[:]).reshape(-1, ROW_FIELDS)


def laid_out(rows: Array, floor: MapStatus) -> tuple[list[float], list[Pose]]:
    """A trajectory's rows (K, 5) → stamps [s] and poses in the world frame, as the submaps lie now.

    What was in a room that is no more is left out.
    """
    rooms = {room.id: room.pose for room in floor.submaps} | {NOWHERE: Pose()}
    known = [row for row in rows.tolist() if int(row[1]) in rooms]
    poses = [rooms[int(number)] @ Pose(x, y, heading) for _, number, x, y, heading in known]
    return [row[0] for row in known], poses


def active(floor: MapStatus) -> SubmapView | None:
    return next((room for room in floor.submaps if room.active), None)
