"""The five commands on an ideal robot: what they promise, and how they give up."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.errors import Refused
from core.geometry import Pose, wrap
from tests.core.commands.stage import OPEN, Stage

WALL = np.column_stack((np.full(101, 1.0), np.linspace(-1.0, 1.0, 101)))
BOX = np.column_stack((np.full(21, 1.0), np.linspace(-0.2, 0.2, 21)))


@pytest.mark.parametrize(("words", "angle"), [("turn left", math.pi / 2), ("turn right", -math.pi / 2)])
@pytest.mark.parametrize("heading", [0.0, 2.5, -3.0])
def test_a_turn_ends_ninety_degrees_further(words: str, angle: float, heading: float) -> None:
    stage = Stage(Pose(1.0, 2.0, heading))
    assert stage.obey(words).finished == "done"
    assert abs(wrap(stage.pose.heading - heading - angle)) < math.radians(0.5)
    assert (stage.pose.x, stage.pose.y) == pytest.approx((1.0, 2.0))
    assert stage.stamp < 5.0


def test_a_whole_turn_goes_all_the_way_round() -> None:
    stage = Stage()
    turned, last = 0.0, 0.0
    action = stage.begin("turn left", angle_rad=2 * math.pi)
    while not stage.step(action).finished:
        turned += wrap(stage.pose.heading - last)
        last = stage.pose.heading
    assert turned == pytest.approx(2 * math.pi, abs=0.01)


@pytest.mark.parametrize("jump", [-2.0, 0.6, 3.1])
def test_a_turn_goes_as_far_as_was_said_where_the_robot_finds_its_place_in_the_middle(jump: float) -> None:
    stage = Stage()
    action, turned, finished = stage.begin("turn left"), 0.0, ""
    while not finished:
        stage.jump = Pose(0.5, 0.2, jump) if turned > 0.8 else Pose()
        last = stage.pose.heading
        finished = stage.step(action).finished
        turned += wrap(stage.pose.heading - last)
    assert finished == "done"
    assert turned == pytest.approx(math.pi / 2, abs=0.04)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.05, 4.0), st.floats(-3.0, 3.0))
def test_continue_goes_straight_for_its_distance(distance: float, heading: float) -> None:
    stage = Stage(Pose(0.5, -0.5, heading))
    assert stage.obey("continue 1 meters", distance_m=distance).finished == "done"
    moved = Pose(0.5, -0.5, heading).inverse() @ stage.pose
    assert moved.x == pytest.approx(distance, abs=0.007)
    assert moved.y == pytest.approx(0.0, abs=0.003)


def test_continue_bears_a_pose_that_jumps() -> None:
    stage = Stage()
    rng = np.random.default_rng(3)
    action = stage.begin("continue 1.5 meters")
    progress = stage.step(action)
    while not progress.finished:
        if round(stage.stamp / 0.025) % 4 == 0:
            stage.jump = Pose(*rng.normal(0, (0.004, 0.004, 0.004)))
        progress = stage.step(action)
    assert progress.finished == "done"
    assert stage.pose.distance_to(1.5, 0) < 0.03


@settings(max_examples=15, deadline=None)
@given(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0), st.floats(-3.1, 3.1))
def test_stop_at_ends_at_its_point(x: float, y: float, heading: float) -> None:
    stage = Stage(Pose(0.0, 0.0, heading))
    assert stage.obey("stop at 0 and 0", 300.0, x_m=x, y_m=y).finished == "done"
    assert stage.pose.distance_to(x, y) < 0.03


def bent(words: str, place: str | None = None, **numbers: float) -> Stage:
    """Obey while a loop is closed in the middle, by which the map moves."""
    stage = Stage()
    action = stage.begin(words, place, **numbers)
    while not (progress := stage.step(action)).finished:
        assert stage.stamp < 60.0
        if stage.stamp > 4.0:
            stage.bend = Pose(0.15, -0.2, 0.1)
    assert progress.finished == "done"
    return stage


def test_a_place_is_reached_where_it_is_and_numbers_where_the_map_has_them_though_the_map_is_bent_meanwhile() -> None:
    there = bent("stop at 1 and 0.5", "window", heading_rad=1.0).pose
    assert (there.x, there.y, there.heading) == pytest.approx((1.0, 0.5, 1.0), abs=0.06)
    stage = bent("stop at 1 and 0.5")
    seen = stage.bend @ stage.pose
    assert (seen.x, seen.y) == pytest.approx((1.0, 0.5), abs=0.06)


def test_continue_goes_straight_though_the_map_is_bent_meanwhile() -> None:
    there = bent("continue 1 meters").pose
    assert (there.x, there.y, there.heading) == pytest.approx((1.0, 0.0, 0.0), abs=0.03)


def test_stop_at_where_it_stands_is_done_at_once() -> None:
    stage = Stage()
    assert stage.obey("stop at 0 and 0").finished == "done"
    assert stage.stamp < 1.0


def test_stop_moving_is_done_at_once_and_asks_for_zero() -> None:
    for words in ("stop moving", "do not stop", "start"):
        progress = Stage().obey(words)
        assert progress.finished == "done"
        assert progress.remark


def test_stop_says_why_it_is_only_a_stop() -> None:
    assert "from -20 to 20" in Stage().obey("stop at 99 and 1").remark


def test_progress_never_falls_and_ends_at_one() -> None:
    stage = Stage()
    action = stage.begin("continue 0.5 meters")
    fractions = [0.0]
    while fractions[-1] < 1:
        fractions.append(stage.step(action).fraction or 0.0)
    assert fractions == sorted(fractions)


def test_continue_towards_a_wall_fails_and_says_what_blocks_it() -> None:
    stage = Stage()
    stage.walls = WALL
    progress = stage.obey("continue 2 meters")
    assert progress.finished == "failed"
    assert "blocks the way 0.0" in progress.remark
    assert "0.8" in progress.remark
    assert stage.nearest > 0.09


@pytest.mark.parametrize("words", ["turn left", "continue 1 meters", "stop at 1 and 0.5"])
def test_a_robot_that_is_held_gives_up_within_seconds(words: str) -> None:
    stage = Stage()
    stage.held = True
    progress = stage.obey(words)
    assert progress.finished == "failed"
    assert "no further" in progress.remark
    assert stage.stamp < 6.0


def test_a_box_that_appears_on_the_way_is_driven_around() -> None:
    stage = Stage()
    action = stage.begin("stop at 2 and 0")
    progress = stage.step(action)
    while not progress.finished:
        if stage.stamp > 3.0:
            stage.walls = BOX
        progress = stage.step(action)
    assert progress.finished == "done"
    assert stage.pose.distance_to(2, 0) < 0.03
    assert stage.nearest > 0.12
    assert np.abs(stage.path[:, 1]).max() > 0.2 or len(stage.path) < 10


def test_a_way_that_closes_is_waited_for_and_then_given_up() -> None:
    log_odds = OPEN.log_odds.copy()
    log_odds[:, 130] = 4
    log_odds[115:125, 130] = -4
    stage = Stage(grid=dataclasses.replace(OPEN, log_odds=log_odds))
    action = stage.begin("stop at 1.5 and 0")
    progress = stage.step(action)
    while not progress.finished:
        if stage.stamp > 1.0:
            stage.walls = np.column_stack((np.full(31, 0.52), np.linspace(-0.3, 0.3, 31)))
        progress = stage.step(action)
    assert progress.finished == "failed"
    assert "no way there" in progress.remark
    assert 5.0 < stage.stamp < 10.0


def test_goals_out_of_reach_or_in_a_wall_are_refused_at_once() -> None:
    with pytest.raises(Refused, match="not on the map"):
        Stage().begin("stop at 11 and 0")
    log_odds = OPEN.log_odds.copy()
    log_odds[118:122, 138:142] = 4
    with pytest.raises(Refused, match="in a wall"):
        Stage(grid=dataclasses.replace(OPEN, log_odds=log_odds)).begin("stop at 1 and 0")


def test_a_command_that_creeps_is_given_up_after_its_time() -> None:
    stage = Stage()
    action = stage.begin("continue 1 meters")
    progress = stage.step(action)
    while not progress.finished:
        stage.stamp += 0.06
        progress = stage.step(action)
    assert progress.finished == "failed"
    assert "too long" in progress.remark
    assert stage.stamp == pytest.approx(22.0, abs=0.2)
