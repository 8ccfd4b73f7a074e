"""The chapter's own forms of calibration: eq. 13 finds the mount, eq. 44 is an output and nothing else."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.calibration.laser.board_line import average
from core.calibration.laser.solve import calibrate_laser
from core.calibration.printed import equation_44
from core.geometry import Transform
from core.optics import TABLE_3
from tests.core.calibration.rooms_to_practise import BOARD, a_room, error_of, poses_of


@pytest.mark.campaign
def test_equation_13_finds_the_mount_from_the_same_beams() -> None:
    room = a_room(2)
    poses = poses_of(room, room.shots(20, 10))
    ours = calibrate_laser(poses, BOARD)
    printed = calibrate_laser(poses, BOARD, printed=True)
    turn, shift = error_of(printed.extrinsics.transform, room)
    assert turn < 1.5 and shift < 15.0  # [degrees], [mm]
    assert not np.allclose(printed.extrinsics.transform.translation, ours.extrinsics.transform.translation, atol=1e-6)
    assert np.all(printed.extrinsics.sds > 0)

    def cost(transform: Transform) -> float:
        """The sum of squared distances [m²] from the planes, which eq. 13 makes least."""
        total = 0.0
        for pose, beams, used in zip(poses, printed.beams, printed.used, strict=True):
            points = pose.scan.rays[beams] * pose.scan.ranges[beams][:, None]
            in_camera = (points - transform.translation) @ transform.rotation
            off = in_camera @ pose.board.plane.normal - pose.board.plane.distance
            total += float(off @ off) if used else 0.0
        return total

    assert cost(printed.extrinsics.transform) < cost(ours.extrinsics.transform)


def test_equation_44_gives_table_3_back() -> None:
    form = equation_44(TABLE_3)
    f = form["f_px"]
    assert f == pytest.approx((TABLE_3.fx + TABLE_3.fy) / 2)
    assert (f**3 * form["k1"], f**5 * form["k2"]) == pytest.approx((TABLE_3.k1, TABLE_3.k2))
    assert (f**2 * form["p1"], f**2 * form["p2"]) == pytest.approx((TABLE_3.p1, TABLE_3.p2))
    assert form["k1_r"] == TABLE_3.k1 == -0.43039
    assert equation_44(dataclasses.replace(TABLE_3, k1=0.0))["k1"] == 0.0


def test_the_printed_mounts_deviations_cover_its_errors_in_directions_that_the_poses_hardly_tell() -> None:
    off: list[np.ndarray] = []
    for seed in (1, 8, 10):  # of twelve rooms, those in which it errs most
        room = a_room(seed)
        poses, empty = poses_of(room, room.shots(5, 10)), average(room.background(50), room.rays).ranges
        found = calibrate_laser(poses, BOARD, empty, printed=True).extrinsics
        turn = Rotation.from_matrix(found.transform.rotation @ room.laser_from_camera.rotation.T).as_rotvec()
        shift = found.transform.translation - room.laser_from_camera.translation
        off.append(np.abs(np.concatenate((turn, shift))) / np.sqrt(np.diag(found.shown_covariance)))
    assert np.max(off) < 4.0  # 48 where the points' scatter alone counts
