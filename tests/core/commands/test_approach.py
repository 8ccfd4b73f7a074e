"""Going beside and after someone, on an ideal robot."""

import dataclasses
import math

import numpy as np
import pytest

from core.errors import Refused
from core.geometry import Pose
from core.navigation.control_context import ControlContext
from core.navigation.goal_controller import GoalAim, GoalController, GoalStep
from core.sentences import Statement
from tests.core.commands.stage import OPEN, Stage


def someone(x: float, y: float) -> np.ndarray:
    """Two legs as the laser sees them, (M, 2) [m]."""
    around = np.linspace(-math.pi, math.pi, 24)
    ring = 0.06 * np.column_stack((np.cos(around), np.sin(around)))
    return np.vstack((Pose(x, y + 0.1).apply(ring), Pose(x, y - 0.1).apply(ring)))


def go(stage: Stage, approach: GoalController, aim: GoalAim | None = None) -> GoalStep:
    step = approach.drive(stage.here, aim)
    stage.move(step.twist)
    return step


@pytest.mark.parametrize(("x", "y", "heading"), [(2.0, 0.0, 0.0), (-1.5, 1.0, 0.5), (0.3, -2.0, 3.0)])
def test_it_stops_half_a_metre_short_of_someone_and_faces_them(x: float, y: float, heading: float) -> None:
    stage = Stage(Pose(0.0, 0.0, heading))
    stage.walls = someone(x, y)
    approach = GoalController(GoalAim(x=x, y=y, keep=0.5), stage.here)
    while (step := go(stage, approach)).state != "there":
        assert step.state == "under way"
        assert stage.stamp < 60.0
    assert stage.pose.distance_to(x, y) == pytest.approx(0.5, abs=0.03)
    assert abs(stage.pose.bearing_to(x, y)) < 0.06
    assert not step.twist.moves


def test_a_place_may_be_reached_with_a_heading() -> None:
    stage = Stage()
    approach = GoalController(GoalAim(x=0.5, y=0.5, heading=-2.0), stage.here)
    while go(stage, approach).state != "there":
        assert stage.stamp < 30.0
    assert stage.pose.distance_to(0.5, 0.5) < 0.03
    assert abs(stage.pose.heading + 2.0) < 0.06


def test_it_goes_round_a_table_to_where_it_sees_who_called() -> None:
    stage = Stage()
    table = np.column_stack((np.full(41, 1.2), np.linspace(-1.0, 1.0, 41)))
    stage.walls = np.vstack((someone(1.6, 0.0), table))
    approach = GoalController(GoalAim(x=1.6, y=0.0, keep=0.5), stage.here)
    while go(stage, approach).state != "there":
        assert stage.stamp < 90.0
    assert stage.pose.x > 1.2
    assert stage.pose.distance_to(1.6, 0.0) == pytest.approx(0.5, abs=0.05)
    assert stage.nearest > 0.12


def test_it_keeps_its_distance_to_someone_who_walks_and_stands_and_walks_again() -> None:
    stage = Stage()
    x, gaps, states = 1.0, [], set()
    stage.walls = someone(x, 0.0)
    approach = GoalController(GoalAim(x=x, y=0.0, keep=0.8), stage.here, lasting=True, cruise=0.3)
    while stage.stamp < 34.0:
        x += 0.2 * 0.025 if stage.stamp % 12.0 < 6.0 else 0.0
        stage.walls = someone(x, 0.0)
        step = go(stage, approach, GoalAim(x=x, y=0.0, keep=0.8))
        states.add(step.state)
        gaps.append(stage.pose.distance_to(x, 0.0))
    assert states == {"under way", "there"}
    assert min(gaps) > 0.7
    assert max(gaps) < 1.3
    assert gaps[-1] < 0.95


def test_nobody_is_approached_who_stands_behind_walls() -> None:
    log_odds = OPEN.log_odds.copy()
    log_odds[:, 140:142] = 4
    with pytest.raises(Refused, match="no way there"):
        GoalController(GoalAim(x=3.0, y=0.0, keep=0.5), Stage(grid=dataclasses.replace(OPEN, log_odds=log_odds)).here)
    log_odds[90:150, 150:200] = 4
    with pytest.raises(Refused, match=r"no free place to stand 0\.5 m"):
        GoalController(GoalAim(x=2.6, y=0.0, keep=0.5), Stage(grid=dataclasses.replace(OPEN, log_odds=log_odds)).here)


def test_a_robot_that_something_holds_back_backs_up_tries_again_and_then_tells() -> None:
    stage = Stage()
    stage.walls = np.column_stack((np.full(81, 0.126), np.linspace(-1.0, 1.0, 81)))
    stage.held_forward = True
    approach = GoalController(GoalAim(x=0.8, y=0.0), stage.here)
    states, words = ["under way"], ""
    while states[-1] != "stuck":
        step = go(stage, approach)
        states.append(step.state)
        words = step.words
        assert stage.stamp < 60.0
    assert "backing" in states
    assert stage.pose.x < -0.05
    assert words.startswith(("Something blocks", "The robot gets no further"))


class BesideABox(Stage):
    """A stage on whose goal a box stands, of which the laser sees the sides that face it."""

    SIZE, MIDDLE = 0.5, np.array((1.5, 0.3))

    @property
    def here(self) -> ControlContext:
        along = np.arange(-self.SIZE / 2, self.SIZE / 2 + 1e-9, 0.02)
        seen = [np.empty((0, 2))]
        for normal in np.array([(1, 0), (0, 1), (-1, 0), (0, -1)]):
            side = self.MIDDLE + self.SIZE / 2 * normal + along[:, None] * normal[::-1]
            if (np.array((self.pose.x, self.pose.y)) - side[0]) @ normal > 0.0:
                seen.append(side)
        self.walls = np.vstack(seen)
        return super().here


@pytest.mark.parametrize("begin", [Pose(), Pose(1.0, 1.8, -1.0), Pose(3.0, 0.3, 3.0)])
def test_who_goes_round_what_stands_on_the_goal_says_so_within_a_round(begin: Pose) -> None:
    stage = BesideABox(begin)
    ended = stage.obey("stop at 1.5 and 0.3", seconds=100.0)
    assert ended.finished == "failed" and ended.remark == Statement("way.shut_again")
    assert stage.nearest > 0.12


class TwoDoors(Stage):
    """A wall with two doors, of which the one that the robot comes near shuts while the other one opens."""

    @property
    def here(self) -> ControlContext:
        shut = 0.4 if self.stamp % 6.0 < 3.0 else -0.4
        y = np.arange(-3.0, 3.0, 0.02)
        self.walls = np.column_stack((np.full_like(y, 1.0), y))[np.abs(y + shut) > 0.2]
        return super().here


def test_plans_that_gain_nothing_one_after_the_other_end_within_a_minute() -> None:
    stage = TwoDoors()
    ended = stage.obey("stop at 2 and 0", seconds=100.0)
    assert ended.finished == "failed" and ended.remark == Statement("way.shut_again")
    assert stage.stamp < 60.0
    assert stage.pose.x < 0.95
