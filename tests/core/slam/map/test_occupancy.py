import numpy as np
import pytest

from core.geometry import Pose
from core.slam.map.occupancy import OccupancyGrid, OccupancyMap, OccupancySettings


def ring(distance: float, count: int = 360) -> np.ndarray:
    """Beam ends (count, 2) all around the origin."""
    angles = np.linspace(-np.pi, np.pi, count, endpoint=False)
    return distance * np.column_stack((np.cos(angles), np.sin(angles)))


def at(grid: OccupancyGrid, x: float, y: float) -> float:
    column, row = ((np.array([x, y]) - grid.origin) / grid.resolution).astype(int)
    return float(grid.log_odds[row, column])


def drawn(ends: np.ndarray, hits: np.ndarray | None = None, pose: Pose | None = None) -> OccupancyGrid:
    occupancy = OccupancyMap()
    occupancy.insert(pose or Pose(), ends, np.isfinite(ends).all(axis=1) if hits is None else hits)
    return occupancy.grid()


def test_beams_clear_their_way_and_mark_their_end() -> None:
    grid = drawn(ring(2.0))
    assert at(grid, 1.0, 0.5) == pytest.approx(-0.4)
    assert at(grid, 2.0, 0.0) == pytest.approx(1.2)
    assert at(grid, 2.4, 0.0) == 0.0


def test_a_beam_that_met_nothing_clears_and_marks_nothing() -> None:
    ends = ring(2.0)
    grid = drawn(ends, np.zeros(len(ends), bool))
    assert at(grid, 1.5, 0.0) < 0
    assert grid.log_odds.max() == 0.0


def test_a_beam_that_failed_neither_clears_nor_marks() -> None:
    ends = ring(2.0)
    failed = np.abs(np.arctan2(ends[:, 1], ends[:, 0])) < 0.4
    ends[failed] = np.nan
    grid = drawn(ends)
    assert at(grid, 1.5, 0.0) == 0.0
    assert at(grid, 2.0, 0.0) == 0.0
    assert at(grid, -1.5, 0.0) < 0


def test_one_scan_marks_a_cell_once_however_many_beams_end_there() -> None:
    ends = np.repeat(np.array([[1.0, 0.02]]), 50, axis=0)
    assert drawn(ends).log_odds.max() == pytest.approx(1.2)


def test_belief_is_bounded_and_can_change() -> None:
    occupancy = OccupancyMap(OccupancySettings(waits=1))
    for _ in range(30):
        occupancy.insert(Pose(), ring(2.0), np.ones(360, bool))
    assert at(occupancy.grid(), 2.0, 0.0) == pytest.approx(4.0)
    for _ in range(30):
        occupancy.insert(Pose(), ring(3.0), np.ones(360, bool))
    assert at(occupancy.grid(), 2.0, 0.0) == pytest.approx(-4.0)


def test_growing_keeps_what_was_there_in_its_place() -> None:
    occupancy = OccupancyMap()
    occupancy.insert(Pose(), ring(2.0), np.ones(360, bool))
    before = occupancy.grid()
    far = Pose(-9.0, 7.0, 0.0)
    occupancy.insert(far, far.apply(ring(2.0)), np.ones(360, bool))
    after = occupancy.grid()
    assert at(after, 2.0, 0.0) == at(before, 2.0, 0.0)
    assert at(after, -7.0, 7.0) == pytest.approx(1.2)
    assert after.revision == before.revision + 1
    assert after.log_odds.shape > before.log_odds.shape


def test_from_one_place_only_some_scans_are_drawn() -> None:
    occupancy = OccupancyMap(OccupancySettings(waits=5))
    told = [occupancy.insert(Pose(), ring(2.0), np.ones(360, bool)) for _ in range(11)]
    assert told == [True, *([False] * 4 + [True]) * 2]
    assert occupancy.insert(Pose(0.1, 0.0, 0.0), ring(2.0), np.ones(360, bool))


def test_the_grid_is_the_same_value_until_it_changes() -> None:
    occupancy = OccupancyMap()
    occupancy.insert(Pose(), ring(2.0), np.ones(360, bool))
    first = occupancy.grid()
    occupancy.insert(Pose(), ring(2.0), np.ones(360, bool))
    assert occupancy.grid() is first
    assert not first.log_odds.flags.writeable


def test_what_lies_absurdly_far_does_not_make_the_map_grow() -> None:
    ends = ring(2.0)
    ends[0] = (1e7, 0.0)
    assert max(drawn(ends).log_odds.shape) < 400
    assert drawn(ring(2.0), pose=Pose(1e7, 0.0, 0.0)).log_odds.size == 0
