"""FOLLOW WALL on an ideal robot: straight walls, corners, openings, and what it says where there is no wall."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest

from core.errors import Refused
from core.geometry import Pose
from core.navigation.control_context import ControlContext
from core.navigation.wall import RightWall, WallSettings
from tests.core.commands.stage import Stage


class SightedStage(Stage):
    """A laser that looks 120 degrees to either side and not through walls."""

    @property
    def here(self) -> ControlContext:
        """What a command sees."""
        here = super().here
        points = here.scan_points[np.argsort(np.hypot(*here.scan_points.T))]
        bearing = np.round(np.degrees(np.arctan2(points[:, 1], points[:, 0])))
        _, nearest = np.unique(bearing, return_index=True)
        return dataclasses.replace(here, scan_points=points[nearest[np.abs(bearing[nearest]) <= 120]])


def wall(*corners: tuple[float, float]) -> np.ndarray:
    """Points (M, 2) [m] every centimetre along a line through corners."""
    legs = [np.linspace(a, b, 1 + round(100 * math.dist(a, b))) for a, b in pairwise(corners)]
    return np.vstack(legs)


def follow(stage: Stage, seconds: float) -> np.ndarray:
    """Follow the wall for so long: x, y [m] of every frame."""
    action, track = stage.begin("follow wall"), []
    while stage.stamp < seconds:
        assert not stage.step(action).finished
        track.append((stage.pose.x, stage.pose.y))
    return np.array(track)


def test_a_straight_wall_is_followed_at_half_a_metre() -> None:
    stage = SightedStage(Pose(0.0, 0.0, 0.3))
    stage.walls = wall((-2.0, -0.7), (5.0, -0.7))
    track = follow(stage, 20.0)
    assert track[-1, 0] > 1.5
    assert track[track[:, 0] > 1.0, 1] == pytest.approx(-0.2, abs=0.01)


def test_inner_and_outer_corners_are_driven_round_at_half_a_metre() -> None:
    stage = SightedStage(Pose(0.0, 0.0, 0.0))
    stage.walls = wall((-1.0, -0.5), (1.2, -0.5), (1.2, 0.8), (3.0, 0.8))
    track = follow(stage, 36.0)
    assert stage.pose.x > 1.5
    assert stage.pose.y == pytest.approx(1.3, abs=0.03)
    gaps = [np.hypot(*(stage.walls - place).T).min() for place in track]
    assert min(gaps) > 0.42
    assert max(gaps) < 0.62


def test_an_open_door_is_passed_by_in_a_straight_line() -> None:
    stage = SightedStage(Pose(0.3, 0.0, 0.0))
    room = wall((1.0, -0.65), (0.5, -0.65), (0.5, -2.5), (3.0, -2.5), (3.0, -0.65), (2.0, -0.65))
    stage.walls = np.vstack((wall((-1.0, -0.5), (1.0, -0.5)), room, wall((2.0, -0.5), (4.0, -0.5))))
    remarks = set()
    action = stage.begin("follow wall")
    while stage.stamp < 24.0:
        remarks.add(stage.step(action).remark)
        assert abs(stage.pose.y) < 0.04
    assert stage.pose.x > 2.5
    assert any("past an opening of 1.0 m" in remark or "past an opening of 1.1 m" in remark for remark in remarks)


@pytest.mark.campaign
def test_a_way_that_is_wide_enough_is_followed_in() -> None:
    stage = SightedStage(Pose(0.0, 0.0, 0.0))
    stage.walls = np.vstack(
        (wall((-1.0, -0.5), (1.0, -0.5), (1.0, -3.0)), wall((2.6, -3.0), (2.6, -0.5), (4.0, -0.5)))
    )
    follow(stage, 26.0)
    assert stage.pose.y < -0.8
    assert stage.pose.x == pytest.approx(1.5, abs=0.03)


@pytest.mark.campaign
def test_a_wall_farther_away_is_driven_to_first() -> None:
    stage = SightedStage(Pose(0.0, 0.0, 0.0))
    stage.walls = wall((-3.0, -2.0), (4.0, -2.0))
    action = stage.begin("follow wall")
    assert "To the wall on the right first; it was 2.0 m away." in stage.step(action).remark
    track = follow(stage, 45.0)
    assert track[-1, 1] == pytest.approx(-1.5, abs=0.02)
    assert track[-1, 0] > 0.3


def test_where_something_stands_at_the_wall_it_goes_to_another_place_of_it() -> None:
    stage = SightedStage(Pose(0.0, 0.0, 0.0))
    post = wall((-0.1, -1.5), (0.1, -1.5), (0.1, -1.6), (-0.1, -1.6), (-0.1, -1.5))
    stage.walls = np.vstack((wall((-3.0, -2.0), (4.0, -2.0)), post))
    track = follow(stage, 45.0)
    assert track[-1, 1] == pytest.approx(-1.5, abs=0.02)
    assert np.hypot(*(track[:, None] - post).transpose(2, 0, 1)).min() > 0.15


def test_a_table_leg_at_hand_is_not_what_is_followed() -> None:
    """It stands nearer than the wall does, too far from it to belong to it."""
    leg = 0.03 * np.array([(math.cos(a), math.sin(a)) for a in np.linspace(0.0, 6.0, 20)]) + np.array([0.1, -0.4])
    here = Pose(0.0, 0.0, 0.0)
    follower = RightWall(WallSettings())
    follower.see(here, np.vstack((wall((-2.0, -1.3), (2.0, -1.3)), leg)), 0.0)
    line = follower.line(here, 0.5)
    assert line is not None
    assert line.contact[1] == pytest.approx(-1.3, abs=0.02)
    alone = RightWall(WallSettings())
    alone.see(here, leg, 0.0)
    assert alone.line(here, 0.5) is None


@pytest.mark.campaign
def test_a_table_leg_behind_the_end_of_a_wall_is_not_what_follows_an_opening() -> None:
    """Else the robot would go round the leg for ever."""
    legs = [
        0.03 * np.array([(math.cos(a), math.sin(a)) for a in np.linspace(0.0, 6.2, 20)]) + (x, -0.55)
        for x in (2.0, 2.9)
    ]
    stage = SightedStage(Pose(0.0, 0.0, 0.0))
    stage.walls = np.vstack((wall((-2.0, -0.5), (1.2, -0.5), (1.2, -0.8), (-2.0, -0.8)), *legs))
    track = follow(stage, 40.0)
    assert track[:, 0].max() < 1.9
    assert track[-1, 1] == pytest.approx(-1.3, abs=0.03)


def test_someone_who_stands_there_is_no_wall_to_go_to() -> None:
    stage = SightedStage(Pose(0.0, 0.0, 0.0))
    stage.walls = np.vstack((wall((0.0, -1.0), (0.12, -1.0)), wall((0.2, -1.0), (0.32, -1.0))))  # two shins
    with pytest.raises(Refused, match="no wall on my right"):
        stage.begin("follow wall")


def test_without_room_at_the_wall_it_says_so() -> None:
    stage = SightedStage(Pose(0.0, 0.0, 0.0))
    posts = np.column_stack((np.arange(-0.9, 1.0, 0.2), np.full(10, -1.5)))
    stage.walls = np.vstack((wall((-0.4, -2.0), (0.4, -2.0)), posts))
    with pytest.raises(Refused, match="around me"):
        stage.begin("follow wall")


def test_without_a_wall_on_the_right_it_says_so() -> None:
    stage = SightedStage()
    stage.walls = wall((-2.0, 1.0), (2.0, 1.0))
    with pytest.raises(Refused, match="no wall on my right within 5 m"):
        stage.begin("follow wall")


def test_a_wall_that_vanishes_ends_it_in_words() -> None:
    stage = SightedStage()
    stage.walls = wall((-2.0, -0.5), (3.0, -0.5))
    action = stage.begin("follow wall")
    for _ in range(40):
        stage.step(action)
    stage.walls = wall((20.0, -0.5), (21.0, -0.5)) + np.array([0.0, 30.0])
    stage.pose = Pose(9.0, 9.0, 0.0)
    while not (progress := stage.step(action)).finished:
        assert stage.stamp < 8.0
    assert progress.finished == "failed"
    assert "wall on my right is gone" in progress.remark
