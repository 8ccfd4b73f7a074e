"""What the guard is told of a scan, and when a scan says nothing."""

import math
from dataclasses import replace

import numpy as np
import pytest

from core.gate.guard import HORIZON_M
from core.geometry import Pose
from core.robots.nearness import FORGOTTEN_S, RESTED_SCANS, Freshness, NearField, field_of, near_points
from core.sensors import Laser, Scan, SensorFrame, Wheels
from core.sensors.checks import MAX_AGE_S, MAX_LEAD_S

LASER = Laser()


def scan_of(ranges: np.ndarray, stamp: float = 0.0, *, time_step: float = 0.0) -> Scan:
    return Scan(
        stamp=stamp, ranges=ranges, angle_min=LASER.angle_min, angle_step=LASER.angle_step, time_step=time_step
    )


def frame_of(scan: Scan, stamp: float = 0.0, *, speed: float = 0.0, turn_rate: float = 0.0) -> SensorFrame:
    return SensorFrame(stamp=stamp, scan=scan, wheels=Wheels(odometry=Pose(), speed=speed, turn_rate=turn_rate))


def test_one_point_in_every_two_degrees_and_it_is_the_nearest() -> None:
    ranges = np.full(LASER.beams, 1.0)
    ranges[::7] = 0.6
    scan = scan_of(ranges)
    points = near_points(scan, LASER, frame_of(scan))
    assert len(points) == pytest.approx(239.8 / 2, abs=2)
    distances = np.hypot(*np.array(points).T)
    assert np.count_nonzero(np.isclose(distances, 0.6, atol=1e-3)) > 0.8 * len(points)


def test_what_is_far_blind_or_free_is_left_out() -> None:
    ranges = np.full(LASER.beams, np.nan)
    ranges[0], ranges[100], ranges[200], ranges[341] = 1.6, np.inf, 0.01, 1.4
    scan = scan_of(ranges)
    ((x, y),) = near_points(scan, LASER, frame_of(scan))
    assert math.hypot(x, y) == pytest.approx(1.4, abs=1e-3)
    assert HORIZON_M == 1.5


def test_points_are_in_the_robot_frame_wherever_the_laser_sits() -> None:
    ranges = np.full(LASER.beams, np.nan)
    ranges[341] = 1.0
    laser = Laser(mounting=Pose(0.1, 0.05, math.pi / 2))
    scan = scan_of(ranges)
    ((x, y),) = near_points(scan, laser, frame_of(scan))
    assert (x, y) == pytest.approx((0.1, 1.05), abs=0.01)


def test_points_are_where_they_are_when_the_frame_is_made() -> None:
    ranges = np.full(LASER.beams, np.nan)
    ranges[341] = 1.0
    scan = scan_of(ranges)
    ((x, _),) = near_points(scan, LASER, frame_of(scan, 0.1, speed=0.3))
    assert x == pytest.approx(0.97, abs=0.005)


def test_a_blind_laser_says_nothing() -> None:
    ranges = np.full(LASER.beams, np.nan)
    assert not Freshness().shows(scan_of(ranges), moving=True)
    ranges[: LASER.beams // 20] = 1.0
    assert not Freshness().shows(scan_of(ranges), moving=True)
    assert not Freshness().shows(scan_of(np.array([])), moving=True)


def test_no_echo_at_all_is_a_free_room_only_when_nothing_was_near_before() -> None:
    nothing = np.full(LASER.beams, np.inf)
    freshness = Freshness()
    assert not freshness.shows(scan_of(nothing), moving=False)  # it never showed an echo
    near, far = nothing.copy(), nothing.copy()
    near[300:320], far[300:320] = HORIZON_M - 0.1, HORIZON_M + 0.1
    assert freshness.shows(scan_of(near), moving=False)
    assert not any(freshness.shows(scan_of(nothing), moving=moving) for moving in (False, True, False))
    assert freshness.shows(scan_of(far), moving=True)
    assert freshness.shows(scan_of(nothing), moving=True)


def test_a_laser_that_hangs_on_the_move_says_nothing() -> None:
    freshness, ranges = Freshness(), np.linspace(1.0, 2.0, LASER.beams)
    assert [freshness.shows(scan_of(ranges), moving=True) for _ in range(4)] == [True, True, False, False]
    assert freshness.shows(scan_of(ranges + 0.001), moving=True)


def test_a_laser_that_hangs_does_not_come_back_by_standing_for_a_moment() -> None:
    freshness, ranges = Freshness(), np.linspace(1.0, 2.0, LASER.beams)
    for _ in range(3):
        freshness.shows(scan_of(ranges), moving=True)
    assert not any(freshness.shows(scan_of(ranges), moving=False) for _ in range(15))
    assert not freshness.shows(scan_of(ranges), moving=True)
    assert freshness.shows(scan_of(ranges + 0.001), moving=True)
    for _ in range(3):
        freshness.shows(scan_of(ranges), moving=True)
    assert any(freshness.shows(scan_of(ranges), moving=False) for _ in range(RESTED_SCANS))


def test_a_robot_that_stands_may_see_the_same_again() -> None:
    freshness, ranges = Freshness(), np.linspace(1.0, 2.0, LASER.beams)
    assert all(freshness.shows(scan_of(ranges), moving=False) for _ in range(5))


def test_the_field_is_how_far_it_looks_to_the_worse_side() -> None:
    assert field_of(LASER) == pytest.approx(2.086, abs=0.01)
    assert field_of(Laser(mounting=Pose(0, 0, 0.5))) == pytest.approx(2.09 - 0.5, abs=0.01)
    assert field_of(Laser(beams=1024, angle_min=-math.pi)) == math.pi
    assert field_of(Laser(mounting=Pose(0, 0, math.pi))) == 0.0


HALF = Laser(beams=181, angle_min=-math.pi / 2, angle_step=math.radians(1))
FRONT = replace(HALF, name="front", mounting=Pose(0.1, 0.0, 0.0))
BACK = replace(HALF, name="back", mounting=Pose(-0.1, 0.0, math.pi))


def test_two_lasers_see_all_around_and_one_alone_only_its_side() -> None:
    assert field_of(FRONT, BACK) == math.pi
    assert field_of(FRONT) == pytest.approx(math.pi / 2, abs=0.01)
    assert field_of(BACK) == 0.0


def test_what_the_other_laser_saw_counts_for_a_moment_and_is_carried_along() -> None:
    near = NearField((FRONT, BACK))

    def seen(laser: Laser, distance: float, stamp: float, x: float) -> tuple[list[tuple[float, float]], float]:
        ranges = np.full(laser.beams, np.inf)
        ranges[90] = distance + 0.001 * stamp
        scan = Scan(
            stamp=stamp, laser=laser.name, ranges=ranges, angle_min=laser.angle_min, angle_step=laser.angle_step
        )
        wheels = Wheels(odometry=Pose(x, 0.0, 0.0), speed=0.0, turn_rate=0.0)
        found = near.see(SensorFrame(stamp=stamp, scan=scan, wheels=wheels), moving=True)
        assert found is not None
        return found.points, found.field

    points, field = seen(BACK, 0.5, 0.0, 0.0)
    assert field == 0.0 and points == [(pytest.approx(-0.6, abs=0.002), pytest.approx(0.0, abs=0.002))]
    points, field = seen(FRONT, 0.8, 0.1, 0.02)
    assert field == math.pi
    assert sorted(x for x, _ in points) == [pytest.approx(-0.62, abs=0.002), pytest.approx(0.9, abs=0.002)]
    points, field = seen(FRONT, 0.8, 0.3, 0.02)
    assert len(points) == 1 and field == pytest.approx(math.pi / 2, abs=0.01)
    seen(BACK, 0.5, 0.4, 0.02)
    seen(FRONT, 0.8, 0.2, 0.02)  # the clock was reset: what the other laser saw is of no known age
    points, field = seen(FRONT, 0.9, 0.45, 0.02)
    assert len(points) == 1 and field == pytest.approx(math.pi / 2, abs=0.01)


AHEAD = Laser(beams=3, angle_min=-0.001, angle_step=0.001)


def scan_ahead(distance: float, stamp: float, laser: str = "", noise: float = 0.0) -> Scan:
    ranges = np.full(3, distance) + noise
    return Scan(stamp=stamp, laser=laser, ranges=ranges, angle_min=-0.001, angle_step=0.001)


@pytest.mark.parametrize("age", [0.0, 0.1, 0.29])
def test_the_age_of_a_scan_goes_with_its_points(age: float) -> None:
    near = NearField((AHEAD,)).see(SensorFrame(stamp=5.0, scan=scan_ahead(1.0, 5.0 - age)), moving=True)
    assert near is not None and near.age == pytest.approx(age)


@pytest.mark.parametrize("age", [MAX_AGE_S + 0.01, 1.2, 60.0, -MAX_LEAD_S - 0.01, -60.0])
def test_a_scan_that_is_old_or_stamped_ahead_tells_nothing_but_its_age(age: float) -> None:
    field = NearField((AHEAD,))
    assert field.see(SensorFrame(stamp=100.0, scan=scan_ahead(1.0, 100.0 - age)), moving=True) is None
    assert field.untimely == pytest.approx(age)
    assert field.see(SensorFrame(stamp=100.1, scan=scan_ahead(1.0, 100.1, noise=0.01)), moving=True) is not None
    assert field.untimely is None


@pytest.mark.parametrize("stamp", [math.nan, math.inf, -math.inf])
def test_a_scan_without_a_finite_stamp_tells_nothing(stamp: float) -> None:
    assert NearField((AHEAD,)).see(SensorFrame(stamp=100.0, scan=scan_ahead(1.0, stamp)), moving=True) is None


def test_a_scan_that_another_overtook_is_left_out_until_the_clock_is_reset() -> None:
    field = NearField((AHEAD,))
    assert field.see(SensorFrame(stamp=5.0, scan=scan_ahead(1.0, 4.95)), moving=True) is not None
    assert field.see(SensorFrame(stamp=5.05, scan=scan_ahead(1.1, 4.9)), moving=True) is None
    assert field.see(SensorFrame(stamp=0.1, scan=scan_ahead(1.2, 0.1)), moving=True) is not None


@pytest.mark.parametrize("age", [0.1, 0.2, 0.29])
def test_a_robot_that_brakes_is_nearer_than_its_late_scan_and_its_present_speed_say(age: float) -> None:
    field, odometry, speed, seen = NearField((AHEAD,)), 0.0, 0.3, None
    wall = 1.0
    for tick in range(40):
        stamp = 0.025 * tick
        frame = SensorFrame(stamp=stamp, wheels=Wheels(odometry=Pose(odometry), speed=speed, turn_rate=0.0))
        if stamp == pytest.approx(0.9):
            then = 0.3 * min(stamp - age, 0.75)  # at full speed until 0.75 s, when it stood at once
            seen = field.see(replace(frame, scan=scan_ahead(wall - then, stamp - age)), moving=True)
        field.see(frame, moving=True)
        speed = 0.3 if stamp < 0.75 - 1e-9 else 0.0
        odometry += 0.025 * speed
    assert seen is not None
    assert min(x for x, _ in seen.points) == pytest.approx(wall - 0.3 * 0.75, abs=0.009)


def test_while_one_of_two_lasers_is_late_nothing_is_known_until_it_is_silent_for_long() -> None:
    rear = replace(AHEAD, name="rear", mounting=Pose(0.0, 0.0, math.pi))
    field = NearField((AHEAD, rear))
    known = list[float]()
    for tick in range(60):
        stamp, jitter = 0.1 * tick, 0.001 * tick
        if tick < 20:
            field.see(SensorFrame(stamp=stamp, scan=scan_ahead(1.0, stamp - 0.6, "laser", jitter)), moving=True)
        if field.see(SensorFrame(stamp=stamp, scan=scan_ahead(1.0, stamp, "rear", jitter)), moving=True):
            known.append(stamp)
    assert known and min(known) == pytest.approx(1.9 + FORGOTTEN_S, abs=0.11)


@pytest.mark.parametrize(("age", "offset"), [(0.6, 0.6), (-0.3, -0.3), (0.1, -0.1)])
def test_the_time_offset_of_a_laser_counts_for_the_guard(age: float, offset: float) -> None:
    field = NearField((replace(AHEAD, time_offset=offset),))
    wheels = Wheels(odometry=Pose(), speed=0.3, turn_rate=0.0)
    frame = SensorFrame(stamp=100.0, scan=scan_ahead(1.0, 100.0 - age), wheels=wheels)
    seen = field.see(frame, moving=True)
    assert field.untimely is None and seen is not None and seen.age == pytest.approx(age - offset, abs=1e-6)
    assert seen.points[0][0] == pytest.approx(1.0 - 0.3 * (age - offset), abs=1e-3)


@pytest.mark.parametrize(("first", "then"), [(Pose(5.0), None), (None, Pose(5.0))])
def test_without_common_odometry_the_other_lasers_points_are_left_out(first: Pose | None, then: Pose | None) -> None:
    rear = replace(AHEAD, name="rear", mounting=Pose(0.0, 0.0, math.pi))
    field, seen = NearField((AHEAD, rear)), None
    for stamp, name, odometry in ((1.0, "rear", first), (1.1, "laser", then)):
        wheels = None if odometry is None else Wheels(odometry=odometry, speed=0.0, turn_rate=0.0)
        seen = field.see(SensorFrame(stamp=stamp, scan=scan_ahead(1.0, stamp, name), wheels=wheels), moving=False)
    assert seen is not None and [x for x, _ in seen.points] == [pytest.approx(1.0, abs=0.01)] * len(seen.points)
