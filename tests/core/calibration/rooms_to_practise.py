"""Camera and laser before a board, for the tests."""

import numpy as np
from scipy.spatial.transform import Rotation

from core.calibration.board.board import Board
from core.calibration.laser.board_line import average
from core.calibration.laser.plane_pairs import PlanePair
from core.calibration.laser.planes import board_pose
from core.calibration.laser.range_lines import fit_ranges
from core.calibration.laser.solve import LaserPose
from core.calibration.practice import visible
from core.calibration.projection import Poses, exponential
from core.geometry import Transform
from core.optics import TABLE_3
from core.sensors.laser import Laser
from tests.practice_room import PracticeRoom, RoomSettings, Shot, some_mount

BOARD = Board(columns=9, rows=6, square=0.03, panel=(0.34, 0.25))


def a_room(seed: int, noise: float = 0.03, settings: RoomSettings | None = None) -> PracticeRoom:
    rng = np.random.default_rng(seed)
    return PracticeRoom(TABLE_3, Laser(), BOARD, some_mount(rng), rng, settings or RoomSettings(noise=noise))


def pair_of(room: PracticeRoom, shot: Shot) -> PlanePair:
    """The pair as one would have it with perfect knowledge of which beams end on the board."""
    scan = average(shot.scans, room.rays, room.settings.noise)
    beams = shot.on_board & np.isfinite(scan.ranges)
    ranges = fit_ranges(room.rays[beams], scan.ranges[beams], scan.sd)
    return PlanePair(plane=board_pose(room.model, room.board, shot.corners).plane, ranges=ranges)


def poses_of(
    room: PracticeRoom, shots: list[Shot], board: Board = BOARD, noise: float | None = None
) -> list[LaserPose]:
    return [
        LaserPose(
            name=f"pose {number}",
            board=board_pose(room.model, board, shot.corners),
            scan=average(shot.scans, room.rays, noise),
        )
        for number, shot in enumerate(shots, 1)
    ]


def turned_only(room: PracticeRoom, axis: int | None, count: int = 400) -> Poses:
    """Boards that are only turned about one axis of the camera (0: pitched, 1: yawed, None: facing)."""
    vectors = np.zeros((count, 3))
    if axis is not None:
        vectors[:, axis] = np.deg2rad(room.rng.uniform(-45, 45, count))
    rotations, depth = exponential(vectors), room.rng.uniform(0.35, 1.1, count)
    places = np.column_stack((room.rng.uniform(0, 320, count), room.rng.uniform(0, 256, count)))
    middle = np.column_stack((TABLE_3.unproject(places), np.ones(count))) * depth[:, None]
    poses = Poses(rotations, middle - rotations @ room.board.centre)
    return poses.take(visible(TABLE_3, poses, room.board, 4.0))


def error_of(found: Transform, room: PracticeRoom) -> tuple[float, float]:
    """Degrees and millimetres."""
    truth = room.laser_from_camera
    turn = Rotation.from_matrix(found.rotation @ truth.rotation.T).magnitude()
    return float(np.degrees(turn)), float(np.linalg.norm(found.translation - truth.translation) * 1e3)
