"""Steering, on an ideal base that lags a little."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.gate import Twist
from core.geometry import Pose, arc, wrap
from core.navigation.steering import Arrival, Pursuit, StallDetector, SteeringSettings, approach, hold_line, spin

SETTINGS = SteeringSettings()
STEP = 0.025


class Base:
    """Does what it is told, 0.1 s later."""

    def __init__(self, pose: Pose) -> None:
        self.pose = pose
        self.orders = [Twist()] * 4
        self.stamp = 0.0

    def drive(self, twist: Twist) -> None:
        self.orders.append(twist)
        now = self.orders.pop(0)
        self.pose = self.pose @ arc(now.v * STEP, now.w * STEP)
        self.stamp += STEP


@given(st.floats(-math.pi, math.pi))
def test_spinning_closes_the_error_and_never_turns_away(error: float) -> None:
    rate = spin(error, 0.6, SETTINGS)
    assert abs(rate) <= 0.6
    assert rate * error >= 0
    assert abs(rate) >= min(SETTINGS.turn_floor, 0.6)


@given(st.floats(-1, 5))
def test_the_approach_is_slow_at_its_end_and_never_backwards(left: float) -> None:
    assert 0 < approach(left, 0.1, SETTINGS) <= 0.1


@settings(max_examples=25, deadline=None)
@given(st.floats(-math.pi, math.pi))
def test_a_turn_ends_within_its_tolerance_despite_the_lag(angle: float) -> None:
    base, arrival = Base(Pose()), Arrival(SETTINGS.heading_tolerance, SETTINGS)
    while not arrival.settled(base.stamp):
        assert base.stamp < 10
        left = wrap(angle - base.pose.heading)
        base.drive(Twist(0.0, 0.0 if arrival.reached(abs(left), base.stamp) else spin(left, 0.6, SETTINGS)))
    assert abs(wrap(angle - base.pose.heading)) < 2 * SETTINGS.heading_tolerance


def test_a_line_is_held_after_a_push_aside() -> None:
    start, base, left = Pose(), Base(Pose(0.0, 0.05, 0.2)), 1.5
    while left > SETTINGS.distance_tolerance:
        left = 1.5 - base.pose.x
        base.drive(hold_line(base.pose, start, left, 0.1, 0.6, SETTINGS))
    assert base.pose.x == pytest.approx(1.5, abs=0.01)
    assert base.pose.y == pytest.approx(0.0, abs=0.005)


@settings(max_examples=25, deadline=None)
@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi), st.floats(0.05, 2.0))
def test_a_straight_path_ends_at_its_goal_wherever_the_robot_looks(
    heading: float, direction: float, far: float
) -> None:
    goal = np.array([far * math.cos(direction), far * math.sin(direction)])
    base = Base(Pose(0.0, 0.0, heading))
    pursuit = Pursuit(np.linspace((0.0, 0.0), goal, 2 + int(far / 0.05)), SETTINGS)
    while base.pose.distance_to(*goal) > SETTINGS.goal_tolerance:
        assert base.stamp < 50
        base.drive(pursuit.steer(base.pose, 0.1, 0.6, 1.0))


def test_a_bent_path_is_followed_closely() -> None:
    bent = np.vstack((np.linspace((0, 0), (1, 0), 21), np.linspace((1, 0.05), (1, 1), 20)))
    base = Base(Pose())
    pursuit = Pursuit(bent, SETTINGS)
    farthest = 0.0
    while base.pose.distance_to(1, 1) > SETTINGS.goal_tolerance:
        assert base.stamp < 40
        base.drive(pursuit.steer(base.pose, 0.1, 0.6, 1.0))
        farthest = max(farthest, float(np.hypot(bent[:, 0] - base.pose.x, bent[:, 1] - base.pose.y).min()))
    assert farthest < 0.08


def test_a_path_of_one_point_is_a_path() -> None:
    assert Pursuit(np.array([[0.5, 0.0]]), SETTINGS).steer(Pose(), 0.1, 0.6, 1.0) == Twist(0.1, 0.0)


def test_little_space_slows() -> None:
    path = np.linspace((0, 0), (1, 0), 21)
    wide = Pursuit(path, SETTINGS).steer(Pose(), 0.1, 0.6, 1.0)
    tight = Pursuit(path, SETTINGS).steer(Pose(), 0.1, 0.6, 0.0)
    assert 0 < tight.v < wide.v


def test_arriving_wants_an_unbroken_while_and_forgives_a_tremble() -> None:
    arrival = Arrival(0.01, SETTINGS)
    assert not arrival.reached(0.02, 0.0)
    assert arrival.reached(0.005, 0.1)
    assert arrival.reached(0.03, 0.2)
    assert not arrival.reached(0.04, 0.3)
    assert not arrival.reached(0.02, 0.4)
    assert arrival.reached(0.0, 0.5)
    assert not arrival.settled(0.7)
    assert arrival.settled(0.5 + SETTINGS.settle)


def test_headway_is_lost_only_after_patience() -> None:
    headway = StallDetector(0.02, 4.0)
    assert not any(headway.lost(10 - stamp, stamp) for stamp in range(8))
    assert not headway.lost(3.0, 10.0)
    assert headway.lost(2.99, 11.5)
