"""A chessboard held up in the simulated room: requests, motion, refusals."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.errors import BadInput
from core.geometry import Pose, Transform
from core.message import Array
from core.robots.requests import (
    BoardInCamera,
    CarryRobot,
    PlaceBoard,
    PlacedBoard,
    PlacedThing,
    PlaceThing,
    ReadPlan,
    RemoveThing,
    RobotRequest,
)
from core.sensors import Camera, SensorFrame
from core.simulation.faulty_robot import open_robot
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings

BLIND = SimulationSettings(camera=False)
EXACT = SimulationSettings(camera=False, wheel_noise="none", laser_noise="none", dropout=0.0)
MIDDLE = np.array([0.12, 0.075, 0.0])  # of a 9x6 board of 30 mm


def board(**more: Any) -> PlaceBoard:
    return PlaceBoard(**({"x_m": 0.8, "y_m": 0.1, "z_m": 0.2} | more))


def in_camera(turn: tuple[float, float, float], middle: tuple[float, float, float], **more: Any) -> PlaceBoard:
    rotation = Rotation.from_rotvec(turn).as_matrix()
    place = BoardInCamera(rotation.tolist(), (np.array(middle) - rotation @ MIDDLE).tolist())
    return PlaceBoard(panel_m=(0.34, 0.25), in_camera=place, **more)


def things(robot: SimulatedRobot) -> dict[str, PlacedThing | PlacedBoard]:
    return {thing.id: thing for thing in robot.ask(ReadPlan()).things if not thing.fixed}


def held(robot: SimulatedRobot) -> PlacedBoard:
    found = things(robot)["board"]
    assert isinstance(found, PlacedBoard)
    return found


def where(robot: SimulatedRobot) -> Array:
    told = held(robot)
    return np.array([told.x_m, told.y_m, told.z_m])


def next_scan(robot: SimulatedRobot) -> Array:
    return next(frame.scan.ranges for frame in iter(robot.read, None) if frame.scan is not None)


def test_a_board_is_held_up_by_someone_behind_it_and_put_away_again() -> None:
    robot = open_robot("lab", settings=EXACT)
    before = next_scan(robot)
    told = robot.ask(board(holder=True))
    assert (told.id, told.holder, told.columns, told.rows) == ("board", "board's holder", 9, 6)
    assert told.panel_m == pytest.approx([0.33, 0.24])
    holder = things(robot)["board's holder"]
    assert math.hypot(holder.x_m, holder.y_m) > math.hypot(0.8, 0.1) + 0.15
    robot.read()
    assert np.nanmin(next_scan(robot)[300:400]) == pytest.approx(0.8, abs=0.02)
    assert robot.ask(RemoveThing(id="board")).id == "board"
    assert things(robot) == {}
    robot.read()
    np.testing.assert_array_equal(next_scan(robot), before)


def test_without_a_rotation_it_faces_the_robot_upright() -> None:
    robot = open_robot("lab", settings=BLIND)
    robot.ask(CarryRobot(x_m=1.0, y_m=1.0, heading_rad=0.4))
    rotation = np.array(robot.ask(board(x_m=1.0, y_m=0.0)).rotation)
    np.testing.assert_allclose(rotation[:, 2], [0.0, -1.0, 0.0], atol=1e-12)  # away from the viewer
    np.testing.assert_allclose(rotation[:, 1], [0.0, 0.0, -1.0], atol=1e-12)  # rows go down


def test_a_pose_in_the_cameras_frame_is_meant_from_where_the_robot_truly_stands() -> None:
    robot = open_robot("lab")
    robot.ask(CarryRobot(x_m=1.0, y_m=1.0, heading_rad=2.0))
    told = robot.ask(in_camera((0.3, -0.2, 0.1), (0.05, 0.0, 0.5)))
    seen = (Transform.of_pose(Pose(1.0, 1.0, 2.0)) @ Camera().mounting).apply(np.array([[0.05, 0.0, 0.5]]))[0]
    np.testing.assert_allclose([told.x_m, told.y_m, told.z_m], seen, atol=1e-12)


def test_it_moves_smoothly_and_takes_its_time() -> None:
    robot = open_robot("lab")
    first = robot.ask(in_camera((0.0, 0.0, 0.0), (0.0, 0.0, 0.5), holder=True, seconds=1.0))
    assert first.seconds == 0.0  # it was not there before
    start = where(robot)
    told = robot.ask(in_camera((0.4, 0.3, 0.0), (0.1, -0.05, 0.8), holder=True, seconds=1.0))
    assert told.seconds == 1.0
    track = [start]
    for _ in range(44):
        robot.read()
        track.append(where(robot))
    speeds = np.linalg.norm(np.diff(track, axis=0), axis=1) * 40
    np.testing.assert_allclose(track[-1], [told.x_m, told.y_m, told.z_m], atol=1e-12)
    assert speeds[0] < 0.02 and np.all(speeds[39:] < 0.02)
    assert speeds.max() == pytest.approx(1.875 * np.linalg.norm(track[-1] - start), rel=0.01)
    assert np.all(np.diff(np.linalg.norm(np.array(track) - start, axis=1)) >= 0)
    np.testing.assert_allclose(held(robot).rotation, told.rotation, atol=1e-12)


def test_a_motion_may_be_turned_around_on_the_way_without_a_jump() -> None:
    robot = open_robot("lab")
    robot.ask(in_camera((0.0, 0.0, 0.0), (0.0, 0.0, 0.5)))
    robot.ask(in_camera((0.0, 0.5, 0.0), (0.1, 0.0, 0.9), seconds=1.0))
    for _ in range(20):
        robot.read()
    halfway = where(robot)
    robot.ask(in_camera((0.0, 0.0, 0.0), (0.0, 0.0, 0.5), seconds=1.0))
    robot.read()
    assert np.linalg.norm(where(robot) - halfway) < 0.01


def test_the_same_seed_and_requests_sense_the_same() -> None:
    def record() -> list[SensorFrame]:
        robot = open_robot("lab", seed=3)
        robot.ask(in_camera((0.2, 0.0, 0.0), (0.0, 0.0, 0.5), holder=True))
        robot.ask(in_camera((0.0, 0.5, 0.0), (0.1, 0.0, 0.7), holder=True, seconds=0.5))
        return [robot.read() for _ in range(30)]

    for one, other in zip(record(), record(), strict=True):
        if one.scan is not None and other.scan is not None:
            np.testing.assert_array_equal(one.scan.ranges, other.scan.ranges)
        if one.image is not None and other.image is not None:
            np.testing.assert_array_equal(one.image.pixels, other.image.pixels)


def test_things_and_the_robot_do_not_enter_a_board() -> None:
    robot = open_robot("lab", settings=BLIND)
    robot.ask(board())
    with pytest.raises(BadInput, match="does not fit there"):
        robot.ask(PlaceThing(what="box", x_m=0.8, y_m=0.1))
    with pytest.raises(BadInput, match="does not fit there"):
        robot.ask(CarryRobot(x_m=0.8, y_m=0.1))


@pytest.mark.parametrize(
    ("request_", "sentence"),
    [
        (board(z_m=0.1), "through the floor"),
        (board(z_m=2.65), "through the ceiling"),
        (board(x_m=5.6), "through a wall"),
        (board(x_m=-1.4, y_m=3.2, z_m=0.5), "through a wall or a piece of furniture"),
        (board(x_m=30.0), "through a wall"),
        (board(x_m=0.05), "touch the robot"),
        (board(x_m=-1.5, y_m=-2.3, holder=True), "Nobody can stand behind"),
        (board(columns=2), "3 to 40 inner corners"),
        (board(square_m=0.0), "1 mm and 1 m"),
        (board(square_m=0.4), "larger than 2 m"),
        (board(panel_m=[0.1, 0.1]), "panel is smaller"),
        (board(panel_m=[0.34]), "panel_m must be"),
        (board(z_m=None), "z_m must be a number"),
        (board(rotation=[[1, 0, 0], [0, 1, 0]]), "3 rows of 3 numbers"),
        (board(rotation=[[math.nan] * 3] * 3), "3 rows of 3 numbers"),
        (board(rotation=[[1, 0, 0], [0, 1, 0], [0, 0, -1]]), "rotation matrix"),
        (board(rotation=[[2, 0, 0], [0, 1, 0], [0, 0, 1]]), "rotation matrix"),
        (board(seconds=-1), "seconds must lie between"),
        (board(seconds=math.inf), "finite"),
        (PlaceBoard(in_camera=BoardInCamera(np.eye(3).tolist(), (0.0,))), "translation_m must be"),
        (PlaceThing(what="box", id="board", x_m=1, y_m=0), "belongs to the chessboard"),
        (RemoveThing(id="board"), "no chessboard"),
    ],
)
def test_what_cannot_be_held_is_answered_with_a_sentence(request_: RobotRequest[Any], sentence: str) -> None:
    robot = open_robot("lab")
    with pytest.raises(BadInput, match=sentence):
        robot.ask(request_)
    assert things(robot) == {}


def test_a_blind_robot_has_no_camera_frame_and_a_holder_stays_with_the_board() -> None:
    robot = open_robot("lab", settings=BLIND)
    with pytest.raises(BadInput, match="no camera"):
        robot.ask(in_camera((0, 0, 0), (0, 0, 0.5)))
    robot.ask(board(holder=True))
    with pytest.raises(BadInput, match="goes with it"):
        robot.ask(RemoveThing(id="board's holder"))
    robot.ask(board(holder=False))
    assert set(things(robot)) == {"board"}
