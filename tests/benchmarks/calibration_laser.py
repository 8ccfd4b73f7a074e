"""The laser's calibration measured: `python -m tests.benchmarks.calibration_laser [--runs 20]`.

Everything automatic, with a person holding the board, in front of walls and furniture; eq. 13 as it is printed, point
to plane with perfect knowledge of the beams, beside ours on the same data.
"""

import time
from collections import Counter
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from core.calibration.board.board import Board
from core.calibration.laser.board_line import average
from core.calibration.laser.extrinsics import solve
from core.calibration.laser.plane_pairs import PlanePair
from core.calibration.laser.planes import board_pose
from core.calibration.laser.range_lines import fit_ranges
from core.calibration.laser.solve import LaserPose, calibrate_laser
from core.calibration.mount import Extrinsics
from core.calibration.practice import visible
from core.calibration.projection import Poses, exponential
from core.geometry import OPTICAL, Transform
from core.message import Array
from core.optics import TABLE_3
from core.sensors.laser import Laser
from tests.benchmarks.command import run_command
from tests.practice_room import PracticeRoom, RoomSettings, Shot, some_mount

BOARD = Board(columns=9, rows=6, square=0.03, panel=(0.34, 0.25))


def a_room(seed: int, noise: float) -> PracticeRoom:
    rng = np.random.default_rng(seed)
    return PracticeRoom(TABLE_3, Laser(), BOARD, some_mount(rng), rng, RoomSettings(noise=noise))


def off(found: Transform, room: PracticeRoom) -> Array:
    """(6,): turn [rad] and shift [m] away from the truth."""
    turn = Rotation.from_matrix(found.rotation @ room.laser_from_camera.rotation.T).as_rotvec()
    return np.concatenate((turn, found.translation - room.laser_from_camera.translation))


def point_to_plane(room: PracticeRoom, shots: list[Shot]) -> Transform:
    """Eq. 13: the sum of squared distances of laser points from the camera's planes, beams labelled by the truth."""
    points, normals, distances = [], [], []
    for shot in shots:
        plane = board_pose(room.model, BOARD, shot.corners).plane
        scan = average(shot.scans, room.rays, room.settings.noise)
        beams = np.flatnonzero(shot.on_board & np.isfinite(scan.ranges))
        points.append(room.rays[beams] * scan.ranges[beams, None])
        normals.append(np.tile(plane.normal, (len(beams), 1)))
        distances.append(np.full(len(beams), plane.distance))
    every, normal, distance = np.concatenate(points), np.concatenate(normals), np.concatenate(distances)

    def residuals(state: Array) -> Array:
        turn = exponential(state[None, :3])[0] @ OPTICAL
        return np.sum(((every - state[3:]) @ turn) * normal, axis=1) - distance

    best = least_squares(residuals, np.zeros(6), method="lm").x
    return Transform(rotation=exponential(best[None, :3])[0] @ OPTICAL, translation=best[3:])


def labelled(room: PracticeRoom, shots: list[Shot]) -> Extrinsics:
    """Ours with the same perfect labels."""
    pairs: list[PlanePair] = []
    for shot in shots:
        scan = average(shot.scans, room.rays, room.settings.noise)
        beams = shot.on_board & np.isfinite(scan.ranges)
        ranges = fit_ranges(room.rays[beams], scan.ranges[beams], scan.sd)
        pairs.append(PlanePair(plane=board_pose(room.model, BOARD, shot.corners).plane, ranges=ranges))
    return solve(pairs)


def campaign(runs: int, poses: int, scans: int, noise: float) -> dict[str, Any]:
    """`runs` rooms: automatic, with perfect labels, and eq. 13 with perfect labels."""
    errors: dict[str, list[Array]] = {"automatic": [], "labelled": [], "eq_13": []}
    inside: list[Array] = []
    weak: Counter[str] = Counter()
    right, seconds = [], 0.0
    for seed in range(runs):
        room = a_room(seed, noise)
        empty = average(room.background(50), room.rays).ranges
        shots = room.shots(poses, scans)
        known = noise if scans < 5 else None
        begun = time.process_time()
        seen = [
            LaserPose(
                name=str(number),
                board=board_pose(room.model, BOARD, shot.corners),
                scan=average(shot.scans, room.rays, known),
            )
            for number, shot in enumerate(shots)
        ]
        told = calibrate_laser(seen, BOARD, empty)
        seconds += time.process_time() - begun
        error = off(told.extrinsics.transform, room)
        errors["automatic"].append(error)
        inside.append(np.abs(error) < 2 * told.extrinsics.sds)
        weak[", ".join(told.extrinsics.weak) or "none"] += 1
        right += [shot.on_board[beams].mean() for shot, beams in zip(shots, told.beams, strict=True) if len(beams)]
        errors["labelled"].append(off(labelled(room, shots).transform, room))
        errors["eq_13"].append(off(point_to_plane(room, shots), room))
    return {
        "runs": runs,
        "poses": poses,
        "scans_per_pose": scans,
        "range_noise_m": noise,
        **{how: summary(np.array(each)) for how, each in errors.items()},
        "within_two_sds": float(np.mean(inside)),
        "beams_right": float(np.mean(right)),
        "said_to_be_open": dict(weak),
        "solve_ms": seconds / runs * 1e3,
    }


def summary(errors: Array) -> dict[str, float]:
    """Errors (R, 6) → medians and worst of angle [deg] and distance [mm]."""
    turns, shifts = np.degrees(np.linalg.norm(errors[:, :3], axis=1)), 1e3 * np.linalg.norm(errors[:, 3:], axis=1)
    return {
        "deg_median": float(np.median(turns)),
        "deg_worst": float(turns.max()),
        "mm_median": float(np.median(shifts)),
        "mm_worst": float(shifts.max()),
    }


def degenerate(runs: int) -> dict[str, dict[str, int]]:
    """What is said to be open when boards are only yawed, only pitched, or only facing."""
    told: dict[str, dict[str, int]] = {}
    for name, axis in (("yaw only", 1), ("pitch only", 0), ("facing only", None)):
        weak: Counter[str] = Counter()
        for seed in range(runs):
            room = a_room(seed, 0.02)
            shots = room.shots(20, 1, poses=turned_only(room, axis))
            weak[", ".join(labelled(room, shots).weak) or "none"] += 1
        told[name] = dict(weak)
    return told


def turned_only(room: PracticeRoom, axis: int | None, count: int = 400) -> Poses:
    vectors = np.zeros((count, 3))
    if axis is not None:
        vectors[:, axis] = np.deg2rad(room.rng.uniform(-45, 45, count))
    rotations, depth = exponential(vectors), room.rng.uniform(0.35, 1.1, count)
    places = np.column_stack((room.rng.uniform(0, 320, count), room.rng.uniform(0, 256, count)))
    middle = np.column_stack((TABLE_3.unproject(places), np.ones(count))) * depth[:, None]
    poses = Poses(rotations, middle - rotations @ BOARD.centre)
    return poses.take(visible(TABLE_3, poses, BOARD, 4.0))


def main(*, runs: int = 20) -> object:
    return {
        "campaigns": [
            campaign(runs, poses, scans, noise)
            for poses, scans, noise in ((20, 20, 0.03), (20, 1, 0.02), (10, 20, 0.03), (10, 1, 0.02), (5, 20, 0.03))
        ],
        "degenerate": degenerate(runs),
    }


if __name__ == "__main__":
    run_command(main)
