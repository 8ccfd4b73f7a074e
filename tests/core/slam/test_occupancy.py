from __future__ import annotations

import numpy as np

from core.geometry import Pose
from core.slam.occupancy import OccupancyMap, OccupancySettings

ANGLES = np.linspace(-np.pi / 2, np.pi / 2, 361)


def half_circle(pose: Pose, radius: float) -> np.ndarray:
    return pose.apply(radius * np.column_stack((np.cos(ANGLES), np.sin(ANGLES))))


def value(drawn: OccupancyMap, x: float, y: float) -> float:
    grid = drawn.grid()
    column, row = np.floor((np.array([x, y]) - grid.origin) / grid.resolution).astype(int)
    return float(grid.log_odds[row, column])


def test_what_a_beam_passed_is_free_what_it_met_is_occupied_and_behind_it_is_unknown() -> None:
    drawn, pose = OccupancyMap(), Pose(0.3, -0.2, 0.7)
    drawn.insert(pose, half_circle(pose, 2.0), np.ones(361, bool))
    ahead = pose.apply(np.array([[1.0, 0.0], [2.0, 0.0], [2.3, 0.0], [-1.0, 0.0]]))
    free, hit, behind_the_wall, behind_the_back = (value(drawn, *point) for point in ahead)
    assert free < 0 < hit
    assert behind_the_wall == behind_the_back == 0


def test_a_beam_without_a_measurement_neither_clears_nor_fills() -> None:
    drawn, pose = OccupancyMap(), Pose()
    ends = half_circle(pose, 2.0)
    blind = np.abs(ANGLES) < 0.2
    ends[blind] = np.nan
    drawn.insert(pose, ends, ~blind)
    assert value(drawn, 1.0, 0.0) == 0
    assert value(drawn, 0.7, 0.7) < 0


def test_a_beam_that_met_nothing_clears_its_way_and_marks_nothing() -> None:
    drawn, pose = OccupancyMap(), Pose()
    drawn.insert(pose, half_circle(pose, 3.0), np.zeros(361, bool))
    assert value(drawn, 2.0, 0.0) < 0
    assert (drawn.grid().log_odds <= 0).all()


def test_growing_keeps_what_was_drawn_where_it_was() -> None:
    drawn, pose = OccupancyMap(OccupancySettings(block=1.0)), Pose()
    drawn.insert(pose, half_circle(pose, 1.0), np.ones(361, bool))
    before = value(drawn, 0.98, 0.03), value(drawn, 0.5, 0.1)
    far = Pose(-7.3, 6.2, 3.0)
    drawn.insert(far, half_circle(far, 1.0), np.ones(361, bool))
    assert (value(drawn, 0.98, 0.03), value(drawn, 0.5, 0.1)) == before
    assert value(drawn, *far.apply(np.array([[0.5, 0.0]]))[0]) < 0


def test_standing_still_draws_one_scan_of_five_and_the_grid_stays_the_same_value() -> None:
    drawn, pose = OccupancyMap(), Pose()
    done = [drawn.insert(pose, half_circle(pose, 2.0), np.ones(361, bool)) for _ in range(11)]
    assert done == [True, *[False] * 4, True, *[False] * 4, True]
    assert drawn.grid() is drawn.grid()
    assert not drawn.grid().log_odds.flags.writeable


def test_what_moved_away_vanishes() -> None:
    drawn, pose = OccupancyMap(OccupancySettings(waits=1)), Pose()
    near, far = half_circle(pose, 1.0), half_circle(pose, 2.0)
    for _ in range(10):
        drawn.insert(pose, near, np.ones(361, bool))
    assert value(drawn, 1.0, 0.0) > 0
    for _ in range(25):
        drawn.insert(pose, far, np.ones(361, bool))
    assert value(drawn, 1.0, 0.0) < 0
