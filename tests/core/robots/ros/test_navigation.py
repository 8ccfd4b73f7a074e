"""The robot's own map, pose and goals, over each link, and with grids that are none."""

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from core.errors import Refused
from core.gate import Twist
from core.geometry import Pose
from core.robots.connect import connect
from core.robots.live import LiveRobot
from core.robots.requests import CancelGoal, OwnNavigation, ReadNavigation, SendGoal
from core.robots.ros.navigation import RosNavigation, own_map
from core.robots.ros.topics import GRID, RosTopics
from core.robots.ros.typestore import RobotTypes
from tests.core.robots.links import frames, until
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.own_navigation import EmulatedNavigation
from tests.emulators.ros_messages import RosMessageMaker
from tests.emulators.rosbridge import RosbridgeEmulator
from tests.emulators.world import World
from tests.emulators.zenoh_robot import ZenohEmulator

LINKS: dict[str, Any] = {"foxglove": FoxgloveEmulator, "zenoh": ZenohEmulator, "rosbridge": RosbridgeEmulator}


class Deaf(World):
    """A world whose camera nobody looks at."""

    def start(self) -> None:
        self.on_image.clear()
        super().start()


@contextmanager
def driven(kind: str, options: str = "", **navigation: bool) -> Iterator[tuple[LiveRobot, EmulatedNavigation, Any]]:
    world = Deaf()
    emulator = LINKS[kind](world)
    own = emulator.navigation = EmulatedNavigation(world, emulator.maker, **navigation)
    world.start()
    emulator.start()
    robot = connect(emulator.url + "?image=none&camera_info=none&sound=none" + options)
    try:
        assert isinstance(robot, LiveRobot)
        yield robot, own, emulator
    finally:
        robot.close()
        emulator.stop()
        world.stop()


def state_of(robot: LiveRobot) -> OwnNavigation:
    return robot.ask(ReadNavigation())


def is_near(said: OwnNavigation, true: Pose, metres: float = 0.1) -> bool:
    return said.pose is not None and true.distance_to(said.pose.x_m, said.pose.y_m) < metres


@pytest.mark.parametrize("kind", LINKS)
def test_map_and_pose_come_and_a_goal_goes_out_and_is_cancelled(kind: str) -> None:
    with driven(kind) as (robot, own, emulator):
        assert {"drive", "navigate"} <= robot.profile.capabilities
        until(lambda: state_of(robot).map_number and state_of(robot).pose)
        said = state_of(robot)
        assert said.map is not None and said.map.cell_m == pytest.approx(0.05) and 5 < said.map.width_m < 30
        assert is_near(said, own.pose) and said.known_from == "/tf" and said.takes_goals == "/goal_pose"
        assert robot.ask(ReadNavigation(known_map=said.map_number)).map is None
        frames(robot, 0.2)
        assert own.goals == [] and emulator.received == []  # nothing is sent unless someone asks

        wanted = own.pose @ Pose(1.0, 0.0, 0.0)
        robot.ask(SendGoal(x_m=wanted.x, y_m=wanted.y, heading_rad=wanted.heading))
        until(lambda: own.world.speeds and own.world.speeds[-1][1] > 0)
        frame, goal = own.goals[0]
        assert frame == "map" and math.dist((goal.x, goal.y), (wanted.x, wanted.y)) < 1e-6
        assert robot.ask(CancelGoal()).goal is None
        until(lambda: len(own.goals) == 2)
        assert own.pose.distance_to(own.goals[1][1].x, own.goals[1][1].y) < 0.15
        until(lambda: own.world.speeds[-1][1:] == (0.0, 0.0))
        until(lambda: emulator.received and not any(any(row[1:]) for row in emulator.received))


def test_beckon_s_own_motion_ends_the_goal_first() -> None:
    with driven("foxglove", frames=False) as (robot, own, _):
        until(lambda: state_of(robot).known_from == "/amcl_pose")
        assert is_near(state_of(robot), own.pose)
        wanted = own.pose @ Pose(1.0, 0.0, 0.0)
        robot.ask(SendGoal(x_m=wanted.x, y_m=wanted.y))
        frames(robot, 0.3, Twist(0.0, 0.3))
        until(lambda: len(own.goals) == 2)
        assert state_of(robot).goal is None


def test_the_lock_is_closed_but_while_its_own_navigation_may_drive() -> None:
    with driven("foxglove", "&lock=/stop_lock", lock=True) as (robot, own, emulator):
        assert robot.profile.lock == "/stop_lock"
        until(lambda: len(emulator.locks) > 3 and state_of(robot).pose)
        assert all(closed for _, closed in emulator.locks)
        wanted = own.pose @ Pose(1.0, 0.0, 0.0)
        robot.ask(SendGoal(x_m=wanted.x, y_m=wanted.y))
        until(lambda: own.world.speeds and own.world.speeds[-1][1] > 0)
        assert not emulator.locks[-1][1]
        asked = time.monotonic()
        robot.ask(CancelGoal())
        until(lambda: emulator.locks[-1][1])
        assert emulator.locks[-1][0] - asked < 0.3
        count = len(emulator.locks)
        until(lambda: len(emulator.locks) > count + 3)
        assert all(closed for _, closed in emulator.locks[count:])


def test_a_lost_link_ends_the_goal_as_soon_as_it_is_back() -> None:
    with driven("rosbridge") as (robot, own, emulator):
        until(lambda: state_of(robot).pose)
        wanted = own.pose @ Pose(1.0, 0.0, 0.0)
        robot.ask(SendGoal(x_m=wanted.x, y_m=wanted.y))
        until(lambda: own.goals)
        emulator.stop()
        until(lambda: robot.read().trouble)
        emulator.start()
        until(lambda: len(own.goals) > 1)
        assert state_of(robot).goal is None


def test_no_goal_is_sent_that_stop_could_not_end() -> None:
    topics = RosTopics(map="/map", goal="/goal_pose", candidates={}, types={"/map": GRID})
    navigation = RosNavigation(topics, lambda *_: pytest.fail("it was sent"))
    with pytest.raises(Refused, match="STOP could not end it"):
        navigation.go(Pose(1.0, 0.0, 0.0))


MAKER = RosMessageMaker(0.0)
PLAIN = np.zeros((4, 5), np.int8)


def grid(cells: Any = PLAIN, corner: Pose = Pose(), cell: float = 0.05, **sizes: int) -> Any:  # noqa: B008
    own = EmulatedNavigation(World(), MAKER)
    types = RobotTypes()
    types.borrow(GRID)
    content = types.decode("/map", GRID, own.grid_message(cells, corner, cell, **sizes))
    assert content is not None
    return content


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (grid(width=4_000_000_000, height=4_000_000_000), "million"),
        (grid(width=6), "20 came"),
        (grid(width=0, height=0), "0 by 0"),
        (grid(cell=math.nan), "no cell of a map"),
        (grid(cell=1e9), "no cell of a map"),
        (grid(corner=Pose(math.inf, 0.0, 0.0)), "no pose on the floor"),
        (grid(corner=Pose(0.0, 0.0, math.nan)), "no pose on the floor"),
    ],
)
def test_a_grid_that_is_none_is_refused_with_one_sentence(content: Any, why: str) -> None:
    navigation = RosNavigation(RosTopics(candidates={}, types={}), lambda *_: None)
    assert why in navigation.take_map(content)
    assert navigation.take_map(content) == ""  # said once
    assert why in navigation.state().refused and navigation.state().map is None


def test_a_large_map_is_handed_on_in_coarser_cells_without_losing_a_wall() -> None:
    cells = np.zeros((3100, 1000), np.int8)
    cells[1500, 400] = 100
    found = own_map(grid(cells))
    assert found.cell_m == pytest.approx(0.15) and found.height_m == pytest.approx(3100 * 0.05, abs=0.15)
    import cv2

    picture = cv2.imdecode(np.frombuffer(found.png, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture is not None and (picture == 101).sum() == 1
