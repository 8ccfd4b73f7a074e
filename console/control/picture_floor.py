"""The floor in the camera's picture, in the moment of the picture: what is drawn on it, and where it is pressed."""

import numpy as np

from console.broadcast import Broadcaster
from console.part import Part
from console.robot.supervisor import RobotSupervisor
from core.errors import Refused, Unavailable
from core.geometry import Pose
from core.message import Array
from core.perception.picture_floor import floor_at, ring_in_picture, way_in_picture
from core.robots import Profile
from core.sensors import Camera, SensorFrame
from core.sentences import Statement
from core.slam.motion import Increment
from core.slam.motion_history import MotionHistory
from core.snapshot import Snapshot

NO_WAY: tuple[list[Array], Array] = ([], np.zeros((0, 2)))


class PictureFloor(Part):
    """Knows through which camera the pilot looks, and how the robot has moved since a picture was taken."""

    def __init__(self, robot: RobotSupervisor, broadcaster: Broadcaster) -> None:
        self._robot = robot
        self._broadcaster = broadcaster
        self._camera: Camera | None = None
        self._moves = MotionHistory()
        self._newest: Snapshot | None = None

    def calibrated(self, profile: Profile) -> Profile:
        self._camera = profile.camera
        return profile

    def on_snapshot(self, snapshot: Snapshot, frame: SensorFrame) -> None:
        before = snapshot if self._newest is None else self._newest
        self._moves.add(
            snapshot.stamp, Increment(before.dead_reckoning.pose.inverse() @ snapshot.dead_reckoning.pose)
        )
        self._newest = snapshot

    def drawn(self, snapshot: Snapshot) -> tuple[list[Array], Array]:
        """The planned way as the newest picture shows it, as `way_in_picture`, and the ring around its goal (N, 2)
        [pixel]. Nothing is looked for while nobody watches the camera.
        """
        camera, view, way, goal = self._camera, snapshot.view, snapshot.path, snapshot.goal
        if view is None or camera is None or (len(way) < 2 and goal is None):
            return NO_WAY
        if not (camera.is_known and self._broadcaster.watched("camera")):
            return NO_WAY
        here = self._pose_at(view.stamp)
        if here is None:
            return NO_WAY
        back = here.inverse()
        parts = way_in_picture(back.apply(way), camera) if len(way) > 1 else []
        ring = NO_WAY[1] if goal is None else self._ring(back.apply(goal[None, :2])[0], camera)
        return parts, ring

    def floor(self, u: float, v: float, stamp: float) -> tuple[tuple[float, float], float, Array]:
        """A pixel of the picture of `stamp` [s] → the point of the floor there [m], world; its distance [m] from the
        robot; and a ring around it as large as the robot (N, 2) [pixel].

        Raises BadInput where the pixel shows no floor, Refused where the picture is too old, Unavailable without a
        camera.
        """
        if self._camera is None or self._newest is None:
            raise Unavailable(Statement("picture_floor.no_camera"))
        here = self._pose_at(stamp)
        if here is None:
            raise Refused(Statement("picture_floor.old"))
        found = np.array(floor_at(u, v, self._camera, here.inverse().apply(self._newest.scan_points)))
        x, y = here.apply(found[None])[0].tolist()
        return (x, y), float(np.linalg.norm(found)), self._ring(found, self._camera)

    def _pose_at(self, stamp: float) -> Pose | None:
        """Return where the robot was when a picture was taken, on the map as it is now; None: it is too long ago."""
        newest = self._newest
        move = None if newest is None else self._moves.moved(newest.stamp, stamp)
        return None if newest is None or move is None else newest.estimate.pose @ move.pose

    def _ring(self, centre: Array, camera: Camera) -> Array:
        return ring_in_picture(centre, self._robot.profile.radius, camera)
