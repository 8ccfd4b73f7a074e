"""A chessboard in front of the simulated camera and laser."""

import cv2
import numpy as np
import pytest

from core.calibration.board.board import Board
from core.calibration.board.chessboard import find_board
from core.calibration.practice import BoardPlacement, held
from core.calibration.projection import exponential
from core.geometry import OPTICAL, Pose, Transform
from core.message import Array
from core.optics import CameraModel
from core.sensors import Camera, Laser
from core.simulation.camera import SimulatedCamera
from core.simulation.laser import SimulatedLaser
from core.simulation.world import HeldBoard, Rect, Thing, World, outline

BOARD = Board(columns=9, rows=6, square=0.03, panel=(0.34, 0.25))
ROOM = World(name="room", walls=outline([Rect(-2.0, -1.5, 3.0, 2.5)]))
ROBOT = Pose(0.2, -0.1, 0.3)
STILL = np.tile(ROBOT.vector, (2, 1))
SPAN = np.array([0.0, 0.1])


def held_at(rotation: Array, translation: Array, camera: Camera | None = None, robot: Pose = ROBOT) -> HeldBoard:
    """A board at a pose in the camera's frame."""
    pose = Transform(rotation=rotation, translation=translation)
    mounting = (camera or Camera()).mounting
    return HeldBoard(
        columns=9, rows=6, square=0.03, panel=(0.34, 0.25), pose=Transform.of_pose(robot) @ mounting @ pose
    )


def taken(world: World, camera: Camera | None = None, snr: float = 42.0) -> Array:
    simulated = SimulatedCamera(camera or Camera(), world, np.random.default_rng(0), snr=snr)
    return cv2.cvtColor(simulated.take(world, 0.0, ROBOT).pixels, cv2.COLOR_BGR2GRAY)


def exact() -> SimulatedLaser:
    return SimulatedLaser(Laser(), np.random.default_rng(0), floor_sd=0, share_sd=0, dropout=0)


TURNED = Camera(
    mounting=Transform(
        rotation=exponential(np.array([[0.0, 0.08, 0.3]]))[0] @ OPTICAL, translation=np.array([0.02, 0.03, 0.2])
    )
)


@pytest.mark.parametrize("camera", [Camera(), TURNED], ids=["level", "turned and pitched"])
def test_corners_are_seen_where_the_camera_model_projects_them(camera: Camera) -> None:
    how = BoardPlacement(nearest=0.25, farthest=0.8, most_tilt=np.deg2rad(50))
    poses = held(np.random.default_rng(2), 8, camera.model, BOARD, how)
    off = []
    for rotation, translation in zip(*poses, strict=True):
        view = find_board(taken(ROOM.with_board(held_at(rotation, translation, camera)), camera), BOARD)
        assert view is not None
        off.append(view.corners - camera.model.project(BOARD.points @ rotation.T + translation))
    errors = np.array(off)
    assert np.sqrt(np.mean(errors**2)) < 0.09
    assert np.abs(errors.mean(axis=(0, 1))).max() < 0.02


def test_a_pixel_is_the_mean_of_what_it_covers() -> None:
    camera = Camera(model=CameraModel(width=160, height=128, fx=80.0, fy=80.0, cx=79.5, cy=63.5))

    def print_at(distance: float) -> Array:
        """The picture of squares that are 2.4 m / `distance` pixels large."""
        board = held_at(np.eye(3), np.array([-0.12, -0.075, distance]), camera)
        reach = 0.06 * 80 / distance
        rows, columns = (slice(round(c - reach) + 1, round(c + reach)) for c in (63.5, 79.5))
        return taken(ROOM.with_board(board), camera, snr=100.0)[rows, columns].astype(float)

    near, far = print_at(0.3), print_at(2.4)
    assert np.ptp(near) > 150
    assert np.ptp(far) < 70
    assert far.mean() == pytest.approx(near.mean(), rel=0.1)


def test_what_stands_before_the_board_hides_it_and_its_back_is_blank() -> None:
    board = held_at(np.eye(3), np.array([-0.12, -0.1, 0.9]))
    spot = ROBOT.apply(np.array([[0.5, 0.0]]))[0]
    box = Thing(id="b", what="box", pose=Pose(*spot), length=0.3, depth=0.3, height=0.6)
    assert find_board(taken(ROOM.with_board(board)), BOARD) is not None
    assert find_board(taken(ROOM.with_board(board).with_thing(box)), BOARD) is None
    half_turn = exponential(np.array([[0.0, np.pi, 0.0]]))[0]
    back = taken(ROOM.with_board(held_at(half_turn, np.array([0.12, -0.075, 0.5]))), snr=100.0)
    assert np.ptp(back[110:160, 110:200]) < 12


@pytest.mark.parametrize("place", [(0.0, 0.0, -0.4), (0.0, 0.0, 0.0), (3.0, 0.0, 0.3), (0.0, 0.0, 0.051)])
def test_boards_out_of_view_are_not_drawn_and_do_no_harm(place: tuple[float, float, float]) -> None:
    turned = exponential(np.array([[0.0, np.pi / 2, 0.0]]))[0]
    for rotation in (np.eye(3), turned):
        grey = taken(ROOM.with_board(held_at(rotation, np.array(place))))
        assert grey.shape == (256, 320)


def test_the_laser_ends_on_the_panel_in_its_own_plane() -> None:
    rotation = exponential(np.array([[0.5, -0.4, 0.2]]))[0]
    board = held_at(rotation, np.array([-0.1, -0.06, 0.6]))
    empty = exact().scan(ROOM, 0.0, SPAN, STILL)
    scan = exact().scan(ROOM.with_board(board), 0.0, SPAN, STILL)
    struck = scan.ranges < empty.ranges - 0.01
    assert 40 < np.count_nonzero(struck) < 140
    angles, ranges = scan.angles[struck], scan.ranges[struck]
    flat = ROBOT.apply(np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles))))
    points = board.pose.inverse().apply(np.column_stack((flat, np.full(len(flat), Laser().height))))
    assert np.abs(points[:, 2]).max() < 0.002  # whole millimetres
    assert np.all(np.abs(points[:, :2] - BOARD.centre[:2]) < np.array(BOARD.half_size) + 0.002)
    assert np.all(scan.ranges[~struck] == empty.ranges[~struck])


def test_a_board_above_or_below_the_laser_is_not_met() -> None:
    empty = exact().scan(ROOM, 0.0, SPAN, STILL).ranges
    for higher in (-0.3, 0.3):
        board = held_at(np.eye(3), np.array([-0.12, -0.075 + higher, 0.6]))
        np.testing.assert_array_equal(exact().scan(ROOM.with_board(board), 0.0, SPAN, STILL).ranges, empty)


def test_a_board_is_in_the_robots_way_as_far_as_it_hangs_low() -> None:
    upright = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])

    def at(z: float) -> World:
        middle = np.array([1.0, 0.0, z])
        pose = Transform(rotation=upright, translation=middle - upright @ BOARD.centre)
        return ROOM.with_board(HeldBoard(columns=9, rows=6, square=0.03, panel=(0.34, 0.25), pose=pose))

    assert ROOM.distance(0.9, 0.0) == pytest.approx(1.5)
    assert at(0.2).distance(0.9, 0.0) == pytest.approx(0.1)
    assert at(0.2).distance(1.0, 0.27) == pytest.approx(0.1)
    assert at(0.4).distance(0.9, 0.0) == pytest.approx(1.5)
