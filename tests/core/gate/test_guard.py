"""The guard: geometry by brute force, and what it may and may not take away."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.gate import Limits, Twist
from core.gate.guard import (
    CRAWL_SPEED_M_S,
    GRAZE_SPEED_M_S,
    HORIZON_M,
    MAX_REMEMBERED_POINTS,
    ObstacleGuard,
    approach,
)

LIMITS = Limits()
REACH = LIMITS.radius + LIMITS.margin
near = st.floats(-1.5, 1.5)


def along(twist: Twist, way: float) -> tuple[float, float]:
    """Where the centre is after `way` [m] of the twist's arc."""
    turned = way * twist.w / abs(twist.v)
    chord = way if abs(turned) < 1e-9 else way * math.sin(turned / 2) / (turned / 2)
    forward = chord * math.copysign(1.0, twist.v)
    return forward * math.cos(turned / 2), forward * math.sin(turned / 2)


def guard_with(*points: tuple[float, float]) -> ObstacleGuard:
    guard = ObstacleGuard(LIMITS)
    guard.see(points)
    return guard


@settings(max_examples=300, deadline=None)
@given(st.sampled_from([-0.3, -0.1, 0.1, 0.3]), st.floats(-1.5, 1.5), near, near)
def test_the_way_to_a_point_is_what_walking_the_arc_finds(v: float, w: float, x: float, y: float) -> None:
    twist = Twist(v, w)
    way, miss = approach(twist, (x, y), REACH)
    begins_inside = math.hypot(x, y) < REACH
    step = 0.002
    found = math.inf
    for n in range(int(HORIZON_M / step)):
        cx, cy = along(twist, n * step)
        if math.hypot(x - cx, y - cy) < REACH:
            found = n * step
            break
    if begins_inside:
        assert way == (math.inf if x * v <= 0 else 0.0) or abs(x) < 1e-9
    elif abs(miss - REACH) < 1e-3:
        return  # it only just enters the circle, or only just does not
    elif math.isfinite(found):
        assert way == pytest.approx(found, abs=2 * step)
    else:
        assert way > HORIZON_M - 2 * step


def test_a_wall_ahead_slows_and_then_stops() -> None:
    speeds = [guard_with((d, 0.0)).permit(Twist(0.3, 0.0)).twist.v for d in (1.0, 0.2, 0.16, 0.13, 0.12, 0.1)]
    assert speeds[0] == 0.3
    assert speeds == sorted(speeds, reverse=True)
    assert speeds[2] < 0.2
    assert speeds[-2:] == [0.0, 0.0]


def test_it_names_what_is_in_the_way() -> None:
    permitted = guard_with((0.8, 0.4), (0.12, 0.02)).permit(Twist(0.1, 0.0))
    assert permitted.point == (0.12, 0.02)
    assert permitted.limit == 0.0
    assert permitted.reason == "something is in the way"


def test_a_point_behind_does_not_hold_who_drives_ahead() -> None:
    assert guard_with((-0.1, 0.0)).permit(Twist(0.3, 0.0)).twist == Twist(0.3, 0.0)


def test_backing_off_from_a_wall_is_never_refused() -> None:
    assert guard_with((0.091, 0.0), (0.095, 0.03)).permit(Twist(-0.3, 0.4)).twist == Twist(-0.3, 0.4)


def test_backing_into_a_point_is_refused() -> None:
    assert guard_with((-0.12, 0.0)).permit(Twist(-0.3, 0.0)).twist.v == 0.0


def test_turning_on_the_spot_is_free_beside_a_wall() -> None:
    assert guard_with((0.092, 0.0), (0.0, 0.088)).permit(Twist(0.0, 1.0)).twist == Twist(0.0, 1.0)


def test_turning_is_refused_with_something_inside_the_outline() -> None:
    assert guard_with((0.05, 0.0)).permit(Twist(0.0, 1.0)).twist == Twist(0.0, 0.0)


def test_who_is_blocked_ahead_may_still_turn() -> None:
    assert guard_with((0.11, 0.0)).permit(Twist(0.2, 0.8)).twist == Twist(0.0, 0.8)


def test_a_slowed_arc_keeps_its_shape() -> None:
    permitted = guard_with((0.17, 0.0)).permit(Twist(0.3, 0.3))
    assert 0.0 < permitted.twist.v < 0.3
    assert permitted.twist.w / permitted.twist.v == pytest.approx(1.0)


def test_along_a_wall_within_the_margin_it_goes_slowly_on() -> None:
    wall = [(0.02 * n, 0.105) for n in range(-30, 60)]
    assert guard_with(*wall).permit(Twist(0.3, 0.0)).twist.v == pytest.approx(GRAZE_SPEED_M_S)


def test_a_wall_that_would_be_touched_stops_it() -> None:
    wall = [(0.02 * n, 0.098 - 0.003 * n) for n in range(60)]
    assert guard_with(*wall).permit(Twist(0.3, 0.0)).twist.v < CRAWL_SPEED_M_S


def test_points_stay_where_they_are_while_the_robot_rolls() -> None:
    guard = guard_with((1.0, 0.0))
    for _ in range(100):
        guard.roll(Twist(0.3, 0.0), 0.02)
    assert guard.permit(Twist(0.1, 0.0)).point is None  # the point is 0.4 m ahead now
    for _ in range(47):
        guard.roll(Twist(0.3, 0.0), 0.02)
    blocked = guard.permit(Twist(0.1, 0.0))
    assert blocked.twist.v == 0.0
    assert blocked.point == pytest.approx((0.118, 0.0))


def test_points_turn_away_while_the_robot_turns() -> None:
    guard = guard_with((0.5, 0.0))
    guard.roll(Twist(0.0, 1.0), math.pi / 2)
    guard.roll(Twist(0.3, 0.0), 0.0)
    (point,) = guard._points_now()  # pyright: ignore[reportPrivateUsage]
    assert point == pytest.approx((0.0, -0.5))


def test_nonsense_points_are_left_out() -> None:
    guard = guard_with((math.nan, 0.0), (0.1, math.inf), (0.13, 0.0))
    assert guard.permit(Twist(0.3, 0.0)).point == (0.13, 0.0)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(near, near), max_size=20), st.floats(-0.3, 0.3), st.floats(-1.5, 1.5))
def test_it_only_ever_reduces(points: list[tuple[float, float]], v: float, w: float) -> None:
    twist = guard_with(*points).permit(Twist(v, w)).twist
    assert abs(twist.v) <= abs(v) and abs(twist.w) <= abs(w)
    assert twist.v * v >= 0 and twist.w * w >= 0


@settings(max_examples=60, deadline=None)
@given(st.floats(-0.4, 0.4), st.floats(-1.5, 1.5), st.floats(0.25, 0.8), st.floats(-2.0, 2.0))
def test_a_robot_that_brakes_as_it_can_never_touches(start: float, w: float, distance: float, bearing: float) -> None:
    """One point, an order at full speed, scans every 0.1 s that are 0.1 s old: the body stays clear of the point."""
    guard = ObstacleGuard(LIMITS)
    px, py = distance * math.cos(bearing), distance * math.sin(bearing)
    x, y, heading, v = 0.0, 0.0, start, 0.0
    seen: list[tuple[float, float]] = []
    for n in range(400):
        if n % 5 == 0:
            if seen:
                guard.see(seen)
            c, s = math.cos(heading), math.sin(heading)
            seen = [(c * (px - x) + s * (py - y), c * (py - y) - s * (px - x))]
        told = guard.permit(Twist(0.3, w)).twist if seen and n >= 5 else Twist()
        v = max(told.v, v - LIMITS.max_acceleration * 0.02) if told.v < v else min(told.v, v + 0.02)
        turn = told.w
        guard.roll(Twist(told.v, turn), 0.02)
        x, y, heading = x + v * 0.02 * math.cos(heading), y + v * 0.02 * math.sin(heading), heading + turn * 0.02
        assert math.hypot(px - x, py - y) > LIMITS.radius - 0.002


def test_what_the_laser_turned_its_back_on_still_blocks_the_way_back() -> None:
    guard = ObstacleGuard(LIMITS)
    guard.see([(0.3, 0.0)], field=2.0)
    guard.roll(Twist(0.0, 1.0), math.pi)
    guard.see([], field=2.0)  # the point is right behind now, where nothing looks
    guard.roll(Twist(-0.1, 0.0), 1.8)
    guard.see([], field=2.0)
    assert guard.permit(Twist(-0.1, 0.0)).twist.v == 0.0
    assert guard.permit(Twist(0.1, 0.0)).twist.v == 0.1
    for _ in range(11):
        guard.roll(Twist(), 1.0)
        guard.see([], field=2.0)
    assert guard.permit(Twist(-0.1, 0.0)).twist.v == -0.1  # long ago: whoever stood there may have gone


def test_what_the_laser_sees_no_more_in_front_is_gone() -> None:
    guard = ObstacleGuard(LIMITS)
    guard.see([(0.2, 0.0)], field=2.0)
    guard.see([], field=2.0)
    assert guard.permit(Twist(0.1, 0.0)) == guard_with().permit(Twist(0.1, 0.0))


def test_a_point_out_of_sight_is_remembered_once_and_not_for_ever() -> None:
    guard = ObstacleGuard(LIMITS)
    for number in range(1000):
        guard.see([(math.cos(number), math.sin(number))], field=1.0)
        guard.roll(Twist(0.1, 0.3), 0.1)
    assert len(guard._points) <= MAX_REMEMBERED_POINTS + 1  # pyright: ignore[reportPrivateUsage]
