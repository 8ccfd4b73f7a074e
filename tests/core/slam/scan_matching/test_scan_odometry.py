import dataclasses
import math
import time

import numpy as np
import pytest

from core.gate import Twist
from core.geometry import Pose, wrap
from core.robots.requests import CarryRobot
from core.sensors import Scan
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.slam.scan_matching.likelihood_field import LikelihoodField
from core.slam.scan_matching.scan_odometry import ScanOdometry


def robot(seed: int = 1) -> SimulatedRobot:
    return SimulatedRobot("lab", seed=seed, settings=SimulationSettings(camera=False))


def walls() -> np.ndarray:
    along = np.arange(-2, 2, 0.01)
    sides = [np.column_stack((along, np.full(len(along), y))) for y in (-1.5, 1.8)]
    return Pose(0.0, 0.0, 0.3).apply(np.vstack((*sides, np.column_stack((np.full(len(along), 2.0), along)))))


def test_the_gradient_of_the_field_is_its_derivative() -> None:
    field, points = LikelihoodField(walls()), walls()[::7]
    _, jacobian = field._slopes(points, 0.031, -0.017, 0.011)
    for axis in range(3):
        step = 1e-6 * np.eye(3)[axis]
        at = np.array([0.031, -0.017, 0.011])
        high, low = field._slopes(points, *(at + step))[0], field._slopes(points, *(at - step))[0]
        agree = np.isclose(jacobian[:, axis], (high - low) / 2e-6, atol=1e-4)
        assert agree.mean() > 0.99  # but for the few points on the border of two cells


@pytest.mark.parametrize("pose", [Pose(0.12, -0.08, 0.06), Pose(-0.15, 0.1, -0.12)])
def test_a_displaced_scan_is_laid_back(pose: Pose) -> None:
    field = LikelihoodField(walls())
    points = pose.inverse().apply(walls()[::3])
    found = field.search(points, Pose(), 0.2, math.radians(10), 0.1, math.radians(1))
    match = field.refine(points, field.search(points, found, 0.05, math.radians(0.5), 0.05, math.radians(0.25)))
    assert match.pose.distance_to(pose.x, pose.y) < 0.01
    assert abs(wrap(match.pose.heading - pose.heading)) < math.radians(0.3)
    assert match.score > 0.9


def test_where_nothing_is_seen_nothing_is_matched() -> None:
    match = LikelihoodField(walls()).refine(np.zeros((0, 2)), Pose(0.1, 0.2, 0.3))
    assert (match.pose, match.score) == (Pose(0.1, 0.2, 0.3), 0.0)


@pytest.mark.campaign
def test_the_laser_alone_follows_a_drive_and_knows_how_well() -> None:
    driven, errors, squared = robot(), [], []
    laser = driven.profile.laser
    assert laser is not None
    odometry, told_at = ScanOdometry(laser), None
    for seconds, v, w in ((1.0, 0.0, 0.0), (6.0, 0.2, 0.0), (3.0, 0.0, 0.6), (5.0, 0.15, 0.1), (2.0, 0.0, -0.8)):
        for _ in range(round(40 * seconds)):
            driven.drive(Twist(v, w))
            frame = driven.read()
            if frame.scan is None or frame.truth is None:
                continue
            step = odometry.update(frame.scan)
            errors.append(odometry.pose.distance_to(frame.truth.x, frame.truth.y))
            if told_at is None:
                told_at = frame.truth
            if not step.still:
                true = told_at.inverse() @ frame.truth
                off = np.array([true.x, true.y, wrap(true.heading - step.pose.heading)])
                off[:2] -= (step.pose.x, step.pose.y)
                squared.append(off @ np.linalg.solve(step.covariance, off))
                told_at = frame.truth
    assert max(errors) < 0.06
    assert 1.0 < np.mean(squared) < 5.0


def test_a_laser_at_rest_reports_rest() -> None:
    standing = robot()
    laser = standing.profile.laser
    assert laser is not None
    odometry, still = ScanOdometry(laser), []
    for _ in range(200):
        frame = standing.read()
        if frame.scan is not None:
            still.append(odometry.update(frame.scan).still)
    assert np.mean(still) > 0.8
    assert math.hypot(odometry.pose.x, odometry.pose.y) < 0.02


def test_where_nothing_fits_the_move_is_told_to_be_unsure() -> None:
    carried = robot()
    laser = carried.profile.laser
    assert laser is not None
    odometry, spreads = ScanOdometry(laser), []
    for index in range(120):
        if index == 60:
            carried.ask(CarryRobot(x_m=3.0, y_m=1.5, heading_rad=2.0))
        frame = carried.read()
        if frame.scan is not None:
            spreads.append(float(np.trace(odometry.update(frame.scan).covariance)))
    assert max(spreads) > 20 * np.median([spread for spread in spreads if spread] or [1e-9])


@pytest.mark.parametrize("apart", [0.0, 1e-5, 0.004, 3.0])
def test_scans_whose_stamps_say_nothing_of_the_speed_do_not_carry_the_robot_away(apart: float) -> None:
    driven = robot()
    laser = driven.profile.laser
    assert laser is not None
    odometry, stamp, stamps = ScanOdometry(laser), 0.0, list[float]()
    while len(stamps) < 80:
        driven.drive(Twist(0.0, 0.5 if 20 <= len(stamps) < 30 else 0.0))
        scan = driven.read().scan
        if scan is not None:
            stamp += apart if 24 <= len(stamps) < 28 else 0.1
            stamps.append(stamp)
            odometry.update(dataclasses.replace(scan, stamp=stamp))
    assert math.hypot(odometry.pose.x, odometry.pose.y) < 0.1
    assert (odometry.wheels.speed, odometry.wheels.turn_rate) == (0.0, 0.0)


@pytest.mark.parametrize("valid", [0, 5])
def test_an_empty_scan_is_no_move(valid: int) -> None:
    laser = robot().profile.laser
    assert laser is not None
    odometry = ScanOdometry(laser)
    ranges = np.full(laser.beams, np.nan)
    ranges[:valid] = 1.0
    scan = Scan(stamp=0.0, ranges=ranges, angle_min=laser.angle_min, angle_step=laser.angle_step)
    for index in range(3):
        assert odometry.update(dataclasses.replace(scan, stamp=0.1 * index)).still


def test_a_search_beyond_what_the_field_can_shift_takes_no_longer() -> None:
    field, points = LikelihoodField(walls()), walls()[::7]
    began = time.process_time()
    found = field.search(points, Pose(0.4, 0.1, 0.0), 50.0, 40.0, 0.1, math.radians(1.5))
    assert time.process_time() - began < 3.0
    assert found.distance_to(0.0, 0.0) < 0.1


def test_a_pose_that_was_searched_has_plain_numbers_which_a_state_message_can_carry() -> None:
    field = LikelihoodField(np.array([[0.05 * step, 1.0] for step in range(40)]))
    points = np.array([[0.05 * step, 0.9] for step in range(40)])
    found = field.search(points, Pose(), 0.2, 0.1, 0.1, 0.05)
    assert [type(value) for value in (found.x, found.y, found.heading)] == [float] * 3
