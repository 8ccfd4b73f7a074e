"""A map that was drawn elsewhere is gone on in: every cell, and the place of a robot that wakes anywhere in it."""

import math

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import Pose
from core.perception.landmarks.frame_perception import Beams, FramePerception
from core.pipelines.nav2_map import map_pixels
from core.sensors import SensorFrame
from core.slam.map.drawn_map import _cast, drawn_map
from core.slam.map.map_file import checked
from core.slam.map.occupancy import OccupancyGrid, OccupancySettings
from core.slam.map.submap import SubmapSettings
from core.slam.mapper import Mapper
from core.slam.motion import Motion


def floor_plan() -> OccupancyGrid:
    """Two rooms of 6 m and 5 m, a door between them, and things at no symmetry."""
    odds = np.zeros((140, 260), np.float32)
    odds[10:130, 10:250] = -4.0
    for part in (np.s_[10:130, 10:12], np.s_[10:130, 248:250], np.s_[10:12, 10:250], np.s_[128:130, 10:250]):
        odds[part] = 4.0
    odds[10:70, 140:142], odds[90:130, 140:142], odds[30:45, 40:52], odds[80:84, 190:230] = 4.0, 4.0, 4.0, 4.0
    return OccupancyGrid(revision=1, resolution=0.05, origin=np.array([-2.0, -3.0]), log_odds=odds)


@pytest.mark.campaign
def test_the_grid_of_a_drawn_map_is_the_drawn_one_and_the_robot_finds_its_place_in_it() -> None:
    grid = floor_plan()
    saved = checked(drawn_map(grid, OccupancySettings(), SubmapSettings()), "drawn")
    assert saved.submaps > 1
    mapper = Mapper(saved=saved)
    drawn = mapper.grid
    first = np.rint((grid.origin - drawn.origin) / 0.05).astype(int)
    rows, columns = grid.log_odds.shape
    pixels = map_pixels(drawn)[::-1][first[1] : first[1] + rows, first[0] : first[0] + columns]
    assert (
        np.array_equal(pixels, map_pixels(grid)[::-1]) and (drawn.log_odds != 0).sum() == (grid.log_odds != 0).sum()
    )
    true = Pose(3.1, 1.4, 0.6)
    ends, hits = _cast(grid, np.array([true.x, true.y]))
    ends = Pose(0, 0, -true.heading).apply(ends)
    beams = Beams(ends=ends, hits=hits)
    for step in range(400):
        stamp = 0.1 * step
        mapper.update(SensorFrame(stamp=stamp), FramePerception(beams=beams), Motion(), may_turn=True)
        if mapper.lost is not None and mapper.lost.phase == "asking":
            mapper.place_at(true.x, true.y, None)
        if mapper.lost is None:
            break
    here = mapper.estimate.pose
    assert (
        here.distance_to(true.x, true.y) < 0.1 and abs(math.remainder(here.heading - true.heading, math.tau)) < 0.05
    )


def test_a_map_without_walls_or_floor_is_refused() -> None:
    for odds in (np.zeros((50, 50)), np.full((50, 50), -4.0), np.full((50, 50), 4.0)):
        grid = OccupancyGrid(revision=1, resolution=0.05, origin=np.zeros(2), log_odds=odds.astype(np.float32))
        with pytest.raises(BadInput, match="no free floor"):
            drawn_map(grid, OccupancySettings(), SubmapSettings())
