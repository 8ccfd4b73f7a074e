import dataclasses

import numpy as np
import pytest

from core.geometry import Pose, arc
from core.perception.landmarks.deskew import beam_ends, deskew
from core.sensors import Laser, Wheels
from tests.core.perception.corner_room import LASER, box, scan_of

ROOM = box(-2.0, -1.5, 2.5, 1.8)


def off_the_walls(points: np.ndarray) -> np.ndarray:
    x, y = np.abs(points[:, 0] - 0.25), np.abs(points[:, 1] - 0.15)
    return np.minimum(np.abs(x - 2.25), np.abs(y - 1.65))


def test_a_scan_at_rest_is_the_polar_picture() -> None:
    scan = scan_of(ROOM, np.random.default_rng(0))
    points, beams = deskew(scan, LASER, None, 7.0)
    angles = scan.angles[beams]
    assert np.allclose(points, scan.ranges[beams, None] * np.column_stack((np.cos(angles), np.sin(angles))))


def test_a_scan_taken_on_an_arc_fits_the_room_again() -> None:
    scan = scan_of(ROOM, np.random.default_rng(0), floor=0.0, share=0.0, speed=0.3, turn_rate=1.5)
    at = 0.075
    wheels = Wheels(odometry=Pose(), speed=0.3, turn_rate=1.5)
    points, _ = deskew(scan, LASER, wheels, at)
    assert off_the_walls(arc(0.3 * at, 1.5 * at).apply(points)).max() < 1e-9
    crooked, _ = deskew(scan, LASER, None, at)
    assert off_the_walls(arc(0.3 * at, 1.5 * at).apply(crooked)).max() > 0.05


@pytest.mark.parametrize(("speed", "turn_rate"), [(0.2, 0.0), (-0.1, 1.0), (0.0, -1.5)])
def test_another_instant_is_the_same_points_from_another_place(speed: float, turn_rate: float) -> None:
    scan = scan_of(ROOM, np.random.default_rng(1), speed=speed, turn_rate=turn_rate)
    wheels = Wheels(odometry=Pose(), speed=speed, turn_rate=turn_rate)
    early, _ = deskew(scan, LASER, wheels, 0.0)
    late, _ = deskew(scan, LASER, wheels, 0.2)
    assert np.allclose(arc(0.2 * speed, 0.2 * turn_rate).apply(late), early, atol=1e-12)


def test_the_mounting_carries_the_points() -> None:
    scan = scan_of(ROOM, np.random.default_rng(2))
    laser = Laser(mounting=Pose(0.1, -0.05, 0.4))
    plain, _ = deskew(scan, LASER, None, 0.0)
    mounted, _ = deskew(scan, laser, None, 0.0)
    assert np.allclose(mounted, laser.mounting.apply(plain))


def test_nothing_measured_has_no_end_and_nothing_met_ends_at_the_limit() -> None:
    scan = scan_of(ROOM, np.random.default_rng(3))
    ranges = scan.ranges.copy()
    ranges[10], ranges[20], ranges[30], ranges[40] = np.nan, np.inf, 0.0, 9.0
    ends, hits = beam_ends(dataclasses.replace(scan, ranges=ranges), LASER, None, 0.0)
    assert np.isnan(ends[[10, 30, 40]]).all()
    assert np.hypot(*ends[20]) == pytest.approx(scan.range_max)
    assert not hits[[10, 20, 30, 40]].any()
    assert hits.sum() == LASER.beams - 4
