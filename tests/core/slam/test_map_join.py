"""Two maps of one building as one: where the newer one lies is found, or refused, and all of both stays."""

import math

import numpy as np
import pytest

from core.errors import BadInput
from core.geometry import Pose
from core.slam.map.drawn_map import drawn_map
from core.slam.map.map_file import checked
from core.slam.map.occupancy import OccupancyGrid, OccupancySettings
from core.slam.map.submap import SubmapSettings
from core.slam.map_join import join_maps, match_maps
from core.slam.mapper import Mapper
from tests.benchmarks.join_maps import joined


def floor_plan(turned: int = 0, first: int = 0, last: int = 220) -> OccupancyGrid:
    """Two rooms and a passage, no part of which looks like another; some columns of it, turned by quarters."""
    odds = np.zeros((120, 220), np.float32)
    odds[10:110, 10:210] = -4.0
    for part in (np.s_[10:110, 10:12], np.s_[10:110, 208:210], np.s_[10:12, 10:210], np.s_[108:110, 10:210]):
        odds[part] = 4.0
    odds[10:60, 120:122] = odds[80:110, 120:122] = odds[30:44, 40:50] = odds[75:79, 150:190] = odds[60:90, 80:83] = (
        4.0
    )
    odds[:, :first] = odds[:, last:] = 0.0
    cells = np.ascontiguousarray(np.rot90(odds, -turned))
    return OccupancyGrid(revision=1, resolution=0.05, origin=np.array([-2.0, 1.0]), log_odds=cells)


@pytest.mark.campaign
def test_a_map_turned_and_shifted_is_found_in_another_one_and_joined() -> None:
    parts = Mapper().parts
    older, newer = (
        drawn_map(one, OccupancySettings(), SubmapSettings()) for one in (floor_plan(), floor_plan(1, 60))
    )
    match = match_maps(older, newer, parts)
    assert abs(math.remainder(match.pose.heading + math.pi / 2, math.tau)) < math.radians(1.0)
    assert match.overlap > 0.9 and match.conflict < 0.05 and match.agree >= 4
    both = checked(join_maps(older, newer, match, parts), "joined")
    assert both.submaps == older.submaps + newer.submaps
    assert len(both.arrays["view_poses"]) == len(older.arrays["view_poses"]) + len(newer.arrays["view_poses"])
    first = Pose(*both.arrays["view_poses"][0].tolist())
    assert first == Pose(*older.arrays["view_poses"][0].tolist()), "the axes of the older map stay"
    grid = Mapper(saved=both).grid
    known = (grid.log_odds != 0).sum() / (floor_plan().log_odds != 0).sum()
    assert 0.98 < known < 1.1


def test_maps_of_different_buildings_are_not_joined() -> None:
    other = np.zeros((100, 100), np.float32)
    other[10:90, 10:90] = -4.0
    y, x = np.indices(other.shape)
    other[np.abs(np.hypot(x - 50, y - 50) - 38) < 1.5] = 4.0
    grid = OccupancyGrid(revision=1, resolution=0.05, origin=np.zeros(2), log_odds=other)
    maps = [drawn_map(one, OccupancySettings(), SubmapSettings()) for one in (floor_plan(), grid)]
    with pytest.raises(BadInput, match=r"do not show enough|several places"):
        match_maps(*maps, Mapper().parts)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_two_drives_of_a_floor_become_one_map_that_is_as_good_as_either(seed: int) -> None:
    told = joined(seed)
    before, after = told["before"], told["after"]
    assert isinstance(before, dict) and isinstance(after, dict)
    assert after["median_m"] <= before["median_m"] + 0.02 and after["p90_m"] < 0.4
