"""Odometry for any instant."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.geometry import Pose
from core.recording.odometry_track import OdometryTrack, heading_of

TIMES = np.linspace(0, 10, 101)
ARC = np.column_stack([np.sin(0.4 * TIMES), 1 - np.cos(0.4 * TIMES), 0.4 * TIMES])
POSE = st.builds(Pose, st.floats(-50, 50), st.floats(-50, 50), st.floats(-3, 3))


@given(POSE)
def test_a_track_does_not_depend_on_where_its_frame_lies(offset):
    moved = np.array([(offset @ Pose(*row)).vector for row in ARC])
    track = OdometryTrack.of(TIMES, moved)
    assert track is not None
    for time in (0.0, 3.33, 10.0):
        expected = Pose(math.sin(0.4 * time), 1 - math.cos(0.4 * time), 0.4 * time)
        there = track.wheels_at(time).odometry
        assert there.distance_to(expected.x, expected.y) < 1e-3
        assert abs((expected.inverse() @ there).heading) < 1e-6


def test_speeds_are_those_of_the_motion():
    wheels = OdometryTrack.of(TIMES, ARC).wheels_at(5.05)
    assert (wheels.speed, wheels.turn_rate) == pytest.approx((0.4, 0.4), abs=1e-3)
    backwards = OdometryTrack.of(TIMES, ARC * (-1, -1, 1))
    assert backwards.wheels_at(5.05).speed == pytest.approx(-0.4, abs=1e-3)


@pytest.mark.parametrize("of_none", [np.full((101, 2), np.nan), np.full((101, 2), 1e9)])
def test_a_base_that_sends_no_speeds_still_has_its_places(of_none):
    track = OdometryTrack.of(TIMES, ARC, of_none)
    assert track is not None and track.wheels_at(5.05).speed == pytest.approx(0.4, abs=1e-3)
    some = np.full((101, 2), 0.4)
    some[50] = np.nan
    assert len(OdometryTrack.of(TIMES, ARC, some).times) == 100


def test_outside_the_track_the_robot_stands():
    track = OdometryTrack.of(TIMES, ARC)
    before, after = track.wheels_at(-3.0), track.wheels_at(99.0)
    assert before.odometry.vector == pytest.approx((0, 0, 0)) and before.speed == 0
    assert (
        after.odometry.vector == pytest.approx((math.sin(4), 1 - math.cos(4), 4 - 2 * math.pi))
        and after.turn_rate == 0
    )


def test_order_repeats_and_absurd_rows_do_not_matter():
    rng = np.random.default_rng(1)
    order = rng.permutation(np.r_[0:101, 20:40])
    times, poses = TIMES[order].copy(), ARC[order].copy()
    times, poses = np.r_[times, np.nan, 5.02, 5.03], np.vstack([poses, ARC[0], [np.inf, 0, 0], [1e9, 0, 0]])
    track = OdometryTrack.of(times, poses)
    assert np.array_equal(track.times, TIMES)
    assert track.poses == pytest.approx(ARC, abs=1e-12)


def test_fewer_than_two_places_are_no_track():
    assert OdometryTrack.of(TIMES[:1], ARC[:1]) is None
    assert OdometryTrack.of(np.zeros(0), np.zeros((0, 3))) is None


def test_the_heading_of_a_quaternion_is_its_turn_about_the_vertical():
    angles = np.linspace(-3, 3, 13)
    half = angles / 2
    assert heading_of(0 * half, 0 * half, np.sin(half), np.cos(half)) == pytest.approx(angles)
