"""The robot's own navigation, as Nav2 looks from outside: a map, where the robot is on it, goals that it drives to.

Its map is the true floor plan, turned and moved. It drives straight, behind a twist_mux whose lock stops it.
"""

import math
import time
from typing import Any

import cv2
import numpy as np

from core.geometry import Pose
from core.recording.odometry_track import heading_of
from core.robots.requests import ReadPlan
from core.robots.ros.topics import GRID, POSE
from core.robots.ros.typestore import GOAL, TF
from core.sensors import Wheels
from tests.emulators.ros_messages import ODOMETRY_START, RosMessageMaker
from tests.emulators.world import World

CELL = 0.05  # [m]
MAP_FROM_WORLD = Pose(4.0, 2.0, 0.6)  # its frame is its own
SPEED, TURN_RATE, NEAR = 0.2, 1.0, 0.1  # [m/s], [rad/s], [m]
LOCK_TIMEOUT = 0.5  # [s] after which twist_mux closes a lock that was not repeated
EVERY = 8  # readings of the wheels for one transform: 5 Hz


class EmulatedNavigation:
    """Nodes of one robot; an emulator puts on the wire what they say."""

    def __init__(self, world: World, maker: RosMessageMaker, *, frames: bool = True, lock: bool = False) -> None:
        """`frames`: it says where it is by /tf, else by /amcl_pose. `lock`: its twist_mux has one."""
        self.world, self.maker, self.frames, self.has_lock = world, maker, frames, lock
        self.topics = {"/map": GRID, **({"/tf": TF} if frames else {"/amcl_pose": POSE})}
        self.goals: list[tuple[str, Pose]] = []  # frame, goal, of every message
        self.locked: tuple[float, bool] | None = None  # time.monotonic() and value of the newest beat
        self.map_from_odometry: Pose | None = None
        self._goal: Pose | None = None
        self._count = 0

    @property
    def pose(self) -> Pose:
        """The true pose on its map."""
        return MAP_FROM_WORLD @ self.world.truth

    def take_goal(self, frame: str, goal: Pose) -> None:
        self.goals.append((frame, goal))
        self._goal = goal

    def take_cdr(self, payload: bytes) -> None:
        content: Any = self.maker.store.deserialize_cdr(payload, GOAL)
        assert (content.header.stamp.sec, content.header.stamp.nanosec) == (0, 0)
        q = content.pose.orientation
        place = content.pose.position
        self.take_goal(content.header.frame_id, Pose(place.x, place.y, float(heading_of(q.x, q.y, q.z, q.w))))

    def step(self, wheels: Wheels, stamp: float) -> list[tuple[str, bytes]]:
        """A reading of the wheels → topics and messages to publish; drives where a goal is given."""
        self._drive()
        odometry = ODOMETRY_START @ wheels.odometry
        self.map_from_odometry = self.pose @ odometry.inverse()
        self._count += 1
        if self._count % EVERY:
            return []
        return [("/tf", self.transform(stamp))] if self.frames else [("/amcl_pose", self.amcl_pose(stamp))]

    def _drive(self) -> None:
        goal, here = self._goal, self.pose
        if goal is None or (self.has_lock and self._is_locked()):
            return
        if here.distance_to(goal.x, goal.y) < NEAR:
            self._goal = None
            self.world.drive(0.0, 0.0)
            return
        aside = math.remainder(math.atan2(goal.y - here.y, goal.x - here.x) - here.heading, math.tau)
        ahead = SPEED if abs(aside) < 0.3 else 0.0
        self.world.drive(ahead, max(-TURN_RATE, min(TURN_RATE, 2 * aside)))

    def _is_locked(self) -> bool:
        return self.locked is None or self.locked[1] or time.monotonic() - self.locked[0] > LOCK_TIMEOUT

    def grid(self) -> bytes:
        """/map: the true floor plan."""
        assert self.world.robot is not None
        walls = np.array([segment[:4] for segment in self.world.robot.ask(ReadPlan()).segments]).reshape(-1, 2)
        low = walls.min(axis=0) - 0.5
        columns, rows = np.ceil((walls.max(axis=0) + 0.5 - low) / CELL).astype(int).tolist()
        cells = np.full((rows, columns), -1, np.int8)
        inside = np.round((walls - low) / CELL).astype(np.int32).reshape(-1, 2, 2)
        outer = ((walls.min(axis=0) - low) / CELL).astype(int), ((walls.max(axis=0) - low) / CELL).astype(int)
        cells[outer[0][1] : outer[1][1], outer[0][0] : outer[1][0]] = 0
        drawn = np.zeros((rows, columns), np.uint8)
        for start, end in inside:
            cv2.line(drawn, start.tolist(), end.tolist(), 1)
        cells[drawn > 0] = 100
        corner = MAP_FROM_WORLD @ Pose(float(low[0]), float(low[1]), 0.0)
        return self.grid_message(cells, corner)

    def grid_message(self, cells: Any, corner: Pose, cell: float = CELL, **sizes: int) -> bytes:
        make, (rows, columns) = self.maker.make, cells.shape
        info = make["nav_msgs/msg/MapMetaData"](
            map_load_time=self.maker.time(0.0),
            resolution=cell,
            width=sizes.get("width", columns),
            height=sizes.get("height", rows),
            origin=self._pose(corner),
        )
        return self.maker.encode(GRID, header=self.maker.header(0.0, "map"), info=info, data=cells.ravel())

    def transform(self, stamp: float) -> bytes:
        """/tf: map → odom."""
        assert self.map_from_odometry is not None
        at, make = self.map_from_odometry, self.maker.make
        moved = make["geometry_msgs/msg/Transform"](
            translation=make["geometry_msgs/msg/Vector3"](x=at.x, y=at.y, z=0.0), rotation=self.maker.turn(at.heading)
        )
        header = self.maker.header(stamp, "map")
        stamped = make["geometry_msgs/msg/TransformStamped"](
            header=header, child_frame_id=f"{self.maker.prefix}odom", transform=moved
        )
        return self.maker.encode(TF, transforms=[stamped])

    def amcl_pose(self, stamp: float) -> bytes:
        pose = self.maker.make["geometry_msgs/msg/PoseWithCovariance"](
            pose=self._pose(self.pose), covariance=np.zeros(36)
        )
        return self.maker.encode(POSE, header=self.maker.header(stamp, "map"), pose=pose)

    def _pose(self, pose: Pose) -> Any:
        point = self.maker.make["geometry_msgs/msg/Point"](x=pose.x, y=pose.y, z=0.0)
        return self.maker.make["geometry_msgs/msg/Pose"](position=point, orientation=self.maker.turn(pose.heading))
