"""A ROS robot's own navigation: its map, where it is on it, and the goal that it was given on request.

While it drives, it and not Beckon's gate steers the robot. Over topics alone a goal is cancelled by giving it the
robot's present pose as the next one.
"""

import math
import threading
from collections import deque
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from core.errors import BadInput, Refused, Unavailable
from core.geometry import Pose
from core.message import Array
from core.recording.odometry_track import heading_of
from core.recording.ros import stamp_of
from core.robots.requests import OwnMap, OwnNavigation, PlanarPose
from core.robots.ros.topics import RosTopics

MOST_CELLS = 16_000_000  # of a map: 200 m by 200 m in cells of 5 cm
LARGEST_SIDE = 1500  # picture elements that are handed on
MAX_COORDINATE_M = 10_000.0  # from its map's origin that anything can be
MIN_CELL_M, MAX_CELL_M = 0.001, 2.0  # of a cell
MAX_MAP_TILT = 0.01  # share by which a map may be tilted
ODOMETRY_READINGS = 200  # readings of odometry, for the one that fits a pose
SAME_TIME_S = 0.3  # between a pose and the odometry that fits it
ARRIVED_DISTANCE_M, STANDING_SPEED_M_S, RESTING_TIME_S = 0.3, 0.02, 3.0  # at which a goal is taken to be reached

SendGoalMessage = Callable[[str, Pose], None]  # frame, goal; raises OSError when the link is lost


class RosNavigation:
    """Filled by the device's thread, asked by the driver's."""

    def __init__(self, topics: RosTopics, send: SendGoalMessage) -> None:
        self._topics, self._send = topics, send
        self._guard = threading.Lock()
        self._map: OwnMap | None = None
        self._number, self._refused = 0, ""
        self._frame = "map"
        self._odometry: deque[tuple[float, Pose]] = deque(maxlen=ODOMETRY_READINGS)  # own stamp, odom_from_robot
        self._odometry_frame = ""
        self._here: tuple[float, Pose] | None = None  # robot clock, odom_from_robot
        self._map_from_odometry: Pose | None = None
        self._known_from = ""
        self._pose: tuple[float, Pose] | None = None  # robot clock, map_from_robot, as the robot said it last
        self._goal: Pose | None = None
        self._cancel_owed = False  # a goal could not be cancelled, for the link was down
        self._resting_since = math.inf  # [s] robot clock

    @property
    def there(self) -> bool:
        """True where the robot has anything of a navigation of its own."""
        return bool(self._topics.map or self._topics.pose or self._topics.goal)

    @property
    def under_way(self) -> bool:
        """True while a goal that was sent from here has neither been cancelled nor reached."""
        return self._goal is not None

    # what the robot says

    def take_map(self, content: Any) -> str:
        """Take a nav_msgs/OccupancyGrid → "", or why it is not shown, a sentence."""
        try:
            shown = own_map(content)
        except BadInput as wrong:
            with self._guard:
                refused, self._refused = self._refused, str(wrong)
            return "" if refused == str(wrong) else str(wrong)
        with self._guard:
            self._map, self._number, self._refused = shown, self._number + 1, ""
            self._frame = shown.frame or self._frame
        return ""

    def take_pose(self, content: Any, stamp: float) -> None:
        """Take a geometry_msgs/PoseWithCovarianceStamped. `stamp` [s] on the robot's clock. Raises BadInput."""
        pose, own = pose_of(content.pose.pose), stamp_of(content.header)
        with self._guard:
            if self._map is None:
                self._frame = content.header.frame_id.strip("/") or self._frame
            self._pose = stamp, pose
            fitting = min(self._odometry, key=lambda entry: abs(entry[0] - own), default=None)
            known_by_frames = self._known_from != "" and self._known_from == self._topics.moving_frames
            if fitting is not None and not known_by_frames and abs(fitting[0] - own) < SAME_TIME_S:
                self._map_from_odometry, self._known_from = pose @ fitting[1].inverse(), self._topics.pose

    def take_frames(self, content: Any) -> None:
        """Take a tf2_msgs/TFMessage, of which the step from the map to the odometry counts."""
        for transform in content.transforms:
            pair = transform.header.frame_id.strip("/"), transform.child_frame_id.strip("/")
            if self._odometry_frame and pair == (self._frame, self._odometry_frame):
                t, q = transform.transform.translation, transform.transform.rotation
                found = planar(t.x, t.y, q)
                with self._guard:
                    self._map_from_odometry, self._known_from = found, self._topics.moving_frames

    def take_odometry(self, header: Any, pose: Pose, speed: float, stamp: float) -> None:
        """Take the robot's own odometry; `stamp` [s] on the robot's clock."""
        with self._guard:
            self._odometry_frame = header.frame_id.strip("/")
            self._odometry.append((stamp_of(header), pose))
            self._here = stamp, pose
            self._look_whether_reached(speed, stamp)

    def _look_whether_reached(self, speed: float, stamp: float) -> None:
        here, goal = self._map_from_robot(), self._goal
        near = here is not None and goal is not None and here[1].distance_to(goal.x, goal.y) < ARRIVED_DISTANCE_M
        if not near or abs(speed) > STANDING_SPEED_M_S:
            self._resting_since = math.inf
        else:
            self._resting_since = min(self._resting_since, stamp)
            if stamp - self._resting_since > RESTING_TIME_S:
                self._goal = None

    # what is asked of it

    def state(self, known_map: int = 0) -> OwnNavigation:
        """All of it; the map only where the asker does not know it."""
        with self._guard:
            here = self._map_from_robot()
            return OwnNavigation(
                map=self._map if self._number != known_map else None,
                map_number=self._number,
                refused=self._refused,
                pose=None if here is None else planar_pose(here[1]),
                stamp_s=0.0 if here is None else here[0],
                known_from=self._known_from or (self._topics.pose if here is not None else ""),
                takes_goals=self._topics.goal,
                goal=None if self._goal is None else planar_pose(self._goal),
            )

    def go(self, goal: Pose) -> None:
        """Send a goal on the robot's map. Raises BadInput, Refused, Unavailable."""
        if not self._topics.goal:
            raise Refused("This robot takes no goals: it has no topic for them (the setting goal names one).")
        if (
            not all(map(math.isfinite, (goal.x, goal.y, goal.heading)))
            or max(abs(goal.x), abs(goal.y)) > MAX_COORDINATE_M
        ):
            raise BadInput("A goal is finite, and no more than 10 km from the map's origin.")
        with self._guard:
            if self._map_from_robot() is None and not self._topics.lock:
                raise Refused(
                    "No goal is sent: STOP could not end it, for the robot does not say where it is on its map, "
                    "and no lock is set."
                )
            try:
                self._send(self._frame, goal)
            except OSError:
                raise Unavailable("The goal was not sent: the link to the robot is lost.") from None
            self._goal, self._cancel_owed, self._resting_since = goal, False, math.inf

    def cancel(self) -> None:
        """Let it stand, if it goes to a goal from here: its present pose becomes the goal."""
        with self._guard:
            if self._goal is None and not self._cancel_owed:
                return
            here, self._goal, self._cancel_owed = self._map_from_robot(), None, True
            if here is None:
                self._cancel_owed = False
                return
            try:
                self._send(self._frame, here[1])
                self._cancel_owed = False
            except OSError:
                return  # the link is lost: it is owed until that is back

    def _map_from_robot(self) -> tuple[float, Pose] | None:
        """When [s] and where on its map; by the odometry since it was last said."""
        if self._map_from_odometry is not None and self._here is not None:
            return self._here[0], self._map_from_odometry @ self._here[1]
        return self._pose


def own_map(content: Any) -> OwnMap:
    """A nav_msgs/OccupancyGrid → the picture of it. Raises BadInput with a sentence for one that cannot be shown."""
    info = content.info
    width, height, cell = int(info.width), int(info.height), float(info.resolution)
    if width <= 0 or height <= 0 or width * height > MOST_CELLS:
        raise BadInput(
            f"The robot's own map is not shown: it has {width} by {height} cells, "
            f"and those with 1 to {MOST_CELLS // 10**6} million are."
        )
    if not MIN_CELL_M <= cell <= MAX_CELL_M:
        raise BadInput(f"The robot's own map is not shown: a side of {cell:g} m is no cell of a map.")
    cells = cells_of(content.data)
    if cells.size != width * height:
        raise BadInput(f"The robot's own map is not shown: it says {width} by {height} cells, and {cells.size} came.")
    try:
        origin = pose_of(info.origin)
    except BadInput:
        raise BadInput("The robot's own map is not shown: its origin is no pose on the floor.") from None
    step = math.ceil(max(width, height) / LARGEST_SIDE)
    picture = coarser(np.clip(cells.reshape(height, width), -1, 100), step)
    done, png = cv2.imencode(".png", (picture[::-1] + 1).astype(np.uint8))
    if not done:
        raise BadInput("The robot's own map is not shown: it cannot be packed.")
    rows, columns = picture.shape
    return OwnMap(
        png=png.tobytes(),
        cell_m=cell * step,
        width_m=columns * step * cell,
        height_m=rows * step * cell,
        origin=planar_pose(origin),
        frame=str(content.header.frame_id).strip("/")[:200],
    )


def cells_of(data: Any) -> Array:
    """Cells of a grid as the links hand them on → (N,) int8. Raises BadInput."""
    if isinstance(data, bytes):
        return np.frombuffer(data, np.int8)
    try:
        return np.asarray(data, np.int8)
    except (TypeError, ValueError, OverflowError):
        raise BadInput("The robot's own map is not shown: its cells are no numbers from -1 to 100.") from None


def coarser(cells: Array, step: int) -> Array:
    """Cells (H, W) → blocks of `step` by `step`, each as its most occupied cell."""
    if step == 1:
        return cells
    height, width = cells.shape
    padded = np.pad(cells, ((0, -height % step), (0, -width % step)), constant_values=-1)
    rows, columns = padded.shape
    return padded.reshape(rows // step, step, columns // step, step).max(axis=(1, 3))


def pose_of(pose: Any) -> Pose:
    """A geometry_msgs/Pose → the pose in the plane. Raises BadInput."""
    return planar(pose.position.x, pose.position.y, pose.orientation)


def planar(x: float, y: float, q: Any) -> Pose:
    """A place [m] and a quaternion → the pose in the plane. Raises BadInput where it is none."""
    numbers = (x, y, q.x, q.y, q.z, q.w)
    if not all(isinstance(number, int | float) and math.isfinite(number) for number in numbers):
        raise BadInput("a pose is not finite")
    norm = q.x**2 + q.y**2 + q.z**2 + q.w**2
    if max(abs(x), abs(y)) > MAX_COORDINATE_M or not 0.5 < norm < 2.0 or q.x**2 + q.y**2 > MAX_MAP_TILT:
        raise BadInput("a pose does not lie in the plane")
    return Pose(float(x), float(y), float(heading_of(q.x, q.y, q.z, q.w)))


def planar_pose(pose: Pose) -> PlanarPose:
    """A pose as it is handed on."""
    return PlanarPose(x_m=pose.x, y_m=pose.y, heading_rad=pose.heading)
