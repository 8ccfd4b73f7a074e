"""Zones: no way touches one to keep out of, no speed leads into one, and a slow one caps before it is entered."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.errors import Refused
from core.gate import Twist
from core.geometry import Pose
from core.navigation.planner import PlannerSettings, plan
from core.navigation.zones import SLOW_MARGIN_M, KeepOuts, MapZone, SlowZones, stopping_way
from core.slam.map.occupancy import OccupancyGrid
from tests.core.navigation.rooms import NO_SCAN

RADIUS = 0.09
OPEN = OccupancyGrid(revision=1, resolution=0.05, origin=np.zeros(2), log_odds=np.full((80, 100), -2.0, np.float32))


def zone(*corners: tuple[float, float], speed: float | None = None, name: str = "stairs") -> MapZone:
    return MapZone(
        name=name, kind="keep_out" if speed is None else "slow", points=np.array(corners, float), max_speed=speed
    )


def box(left: float, bottom: float, right: float, top: float, speed: float | None = None) -> MapZone:
    return zone((left, bottom), (right, bottom), (right, top), (left, top), speed=speed)


@settings(max_examples=15)
@given(
    st.lists(st.tuples(st.floats(1.2, 3.8), st.floats(0.8, 3.2)), min_size=3, max_size=6),
    st.floats(0.3, 3.7),
    st.floats(0.3, 3.7),
)
def test_no_planned_way_touches_a_zone_to_keep_out_of(
    corners: list[tuple[float, float]], start: float, goal: float
) -> None:
    keep_outs = KeepOuts((zone(*corners),))
    try:
        way = plan(keep_outs.on(OPEN), NO_SCAN, Pose(0.3, start), (4.7, goal), RADIUS, PlannerSettings())
    except Refused:
        return  # it may fill the room
    assert max(keep_outs.zones[0].depth(x, y) for x, y in way) <= -RADIUS


def test_a_zone_beyond_the_known_map_is_a_wall_too() -> None:
    grown = KeepOuts((box(-1.0, 1.0, 6.0, 1.2),)).on(OPEN)
    assert (grown.origin <= (-1.0, 0.0)).all() and grown.log_odds.shape[1] * grown.resolution >= 7.0
    with pytest.raises(Refused):
        plan(grown, NO_SCAN, Pose(1.0, 0.5), (1.0, 1.1), RADIUS, PlannerSettings())
    assert KeepOuts().on(OPEN) is OPEN


@given(st.floats(0, 4), st.floats(0, 3), st.floats(-math.pi, math.pi), st.floats(-0.3, 0.3))
def test_whoever_is_let_drive_on_stands_before_the_zone(x: float, y: float, heading: float, speed: float) -> None:
    keep_outs, pose = KeepOuts((box(2.0, 1.0, 3.0, 2.0),)), Pose(x, y, heading)
    depth = keep_outs.zones[0].depth
    end = pose @ Pose(math.copysign(stopping_way(speed), speed), 0.0, 0.0)
    if keep_outs.ahead(pose, Twist(speed, 0.0), RADIUS) is None:
        inside = depth(x, y) > 0.0
        assert inside or speed == 0.0 or depth(end.x, end.y) <= max(-RADIUS, depth(x, y)) + 1e-6
    else:
        assert depth(end.x, end.y) > -RADIUS


def test_a_robot_in_a_zone_may_leave_it_and_enter_no_other() -> None:
    here, other = box(0.0, 0.0, 1.0, 1.0), box(1.5, 0.0, 2.0, 1.0)
    keep_outs, inside = KeepOuts((here, other)), Pose(0.5, 0.5)
    assert keep_outs.ahead(inside, Twist(0.3, 0.0), RADIUS) is None
    assert keep_outs.left_by(inside).zones == (other,)
    assert keep_outs.ahead(Pose(1.39, 0.5), Twist(0.3, 0.0), RADIUS) is other
    assert keep_outs.ahead(Pose(1.39, 0.5), Twist(-0.3, 0.0), RADIUS) is None


def test_a_zone_that_is_driven_along_hides_none_ahead() -> None:
    beside, ahead = box(0.0, 0.55, 3.0, 1.0), box(1.5, 0.0, 2.0, 0.52)
    for zones in ((beside, ahead), (ahead, beside)):
        assert KeepOuts(zones).ahead(Pose(1.39, 0.5), Twist(0.3, 0.0), RADIUS) is ahead
        assert KeepOuts(zones).ahead(Pose(0.9, 0.5), Twist(0.3, 0.0), RADIUS) is None


def test_the_lowest_slow_zone_caps_before_the_body_is_in_it() -> None:
    slow = SlowZones((box(1.0, 0.0, 3.0, 2.0, 0.1), box(2.0, 0.0, 3.0, 2.0, 0.05)))
    assert slow.cap(Pose(0.0, 1.0), RADIUS, 0.5) is None
    assert slow.cap(Pose(1.0 - RADIUS - SLOW_MARGIN_M, 1.0), RADIUS, 0.5) == 0.1
    assert slow.cap(Pose(2.5, 1.0), RADIUS, 0.5) == slow.cap(None, RADIUS, 0.5) == 0.05
    assert slow.cap(Pose(2.5, 1.0), RADIUS, 0.04) is None and SlowZones().cap(None, RADIUS, 0.5) is None


@given(st.floats(0.02, 1.0), st.floats(0.0, 1.5))
def test_the_speed_on_the_way_to_a_slow_zone_can_be_lost_before_it(speed: float, gap: float) -> None:
    zone = SlowZones((box(1.0, 0.0, 3.0, 2.0, speed),))
    x = 1.0 - RADIUS - gap
    cap = zone.cap(Pose(x, 1.0), RADIUS, 5.0)
    assert cap is not None and cap >= speed
    left = max(0.0, gap - SLOW_MARGIN_M)
    assert cap == speed or stopping_way(cap) - stopping_way(speed) <= left + 1e-6
    assert zone.cap(Pose(x - 0.1, 1.0), RADIUS, 5.0) >= cap  # type: ignore[operator]
