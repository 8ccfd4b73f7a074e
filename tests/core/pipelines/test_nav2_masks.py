"""Zones as Nav2's masks and back: the same cells, whatever their form."""

import math

import numpy as np
import pytest

from core.errors import BadInput
from core.navigation.zones import MapZone
from core.pipelines.nav2_map import Nav2Cells, read_nav2_map
from core.pipelines.nav2_masks import covered, keep_out_polygons, mask_files, slow_polygons
from core.slam.map.occupancy import OccupancyGrid
from tests.core.pipelines.nav2_reference import reference

ORIGIN_M = (-3.217, 1.114)


def lattice(shape: tuple[int, int]) -> OccupancyGrid:
    return OccupancyGrid(revision=1, resolution=0.05, origin=np.array(ORIGIN_M), log_odds=np.zeros(shape, np.float32))


def blobs(seed: int) -> np.ndarray:
    """Cells at random, or rectangles over each other: with holes, corners that touch, islands."""
    rng = np.random.default_rng(seed)
    cells = rng.random(rng.integers(5, 30, 2)) < (rng.uniform(0.1, 0.9) if seed % 2 else 0.0)
    for _ in range(0 if seed % 2 else 4):
        row, column = rng.integers(0, cells.shape[0]), rng.integers(0, cells.shape[1])
        cells[row : row + 9, column : column + 11] ^= True
    return cells


@pytest.mark.parametrize("seed", range(8))
def test_a_keep_out_mask_comes_back_with_the_same_cells(seed: int) -> None:
    cells = blobs(seed)
    polygons, _ = keep_out_polygons(Nav2Cells((100 * cells).astype(np.int8), 0.05, (*ORIGIN_M, 0.0)))
    zones = [MapZone(name=str(k), kind="keep_out", points=np.round(ring, 3)) for k, ring in enumerate(polygons)]
    files = mask_files(zones, lattice(cells.shape))
    read = read_nav2_map(files["keepout_mask.yaml"], files["keepout_mask.pgm"])
    assert np.array_equal(read.values, 100 * cells)
    assert np.array_equal(read.values, reference(files["keepout_mask.yaml"].decode(), files["keepout_mask.pgm"]))
    assert mask_files(zones, lattice(cells.shape)) == files


def test_a_speed_mask_comes_back_with_the_same_limits_and_never_a_higher_one() -> None:
    cells = np.zeros((12, 20), np.int8)
    cells[2:7, 3:9], cells[5:10, 9:18] = 7, 30
    drawn, without = slow_polygons(Nav2Cells(cells, 0.05, (*ORIGIN_M, 0.0), "raw"), 2, 0.0, 0.01, 1.0)
    zones = [MapZone(name=str(k), kind="slow", points=ring, max_speed=v) for k, (ring, v) in enumerate(drawn)]
    files = mask_files(zones, lattice(cells.shape))
    read = read_nav2_map(files["speed_mask.yaml"], files["speed_mask.pgm"])
    assert np.array_equal(read.values, cells) and read.mode == "raw" and without == 0
    odd = [MapZone(name="odd", kind="slow", points=zones[0].points, max_speed=0.079)]
    files = mask_files(odd, lattice(cells.shape))
    assert read_nav2_map(files["speed_mask.yaml"], files["speed_mask.pgm"]).values.max() == 7
    assert b"type: 2" in files["nav2_params.yaml"] and b"multiplier: 0.01" in files["nav2_params.yaml"]


def test_a_speed_in_percent_is_of_the_robots_largest_and_zero_is_no_limit() -> None:
    cells = np.zeros((6, 12), np.int8)
    cells[1:4, 1:4], cells[1:4, 6:9] = 60, 100
    drawn, without = slow_polygons(Nav2Cells(cells, 0.05, (*ORIGIN_M, 0.0), "raw"), 1, 100.0, -1.0, 0.5)
    assert [round(speed, 6) for _, speed in drawn] == [0.2] and without == 9


def test_percents_that_are_read_as_metres_per_second_are_refused() -> None:
    values = np.zeros((4, 4), np.int8)
    values[1:3, 1:3] = 30
    mask = Nav2Cells(values, 0.05, (0.0, 0.0, 0.0), "raw")
    with pytest.raises(BadInput, match="70 m/s"):
        slow_polygons(mask, 2, 100.0, -1.0, 0.5)
    assert [limit for _, limit in slow_polygons(mask, 2, 0.0, 0.01, 0.5)[0]] == [pytest.approx(0.3)]


def test_every_cell_that_a_polygon_enters_is_covered() -> None:
    rng = np.random.default_rng(5)
    grid = lattice((40, 40))
    for _ in range(5):
        turns = np.sort(rng.uniform(0, math.tau, 6))
        points = (
            np.array(ORIGIN_M) + 1.0 + rng.uniform(0.3, 0.9, (6, 1)) * np.column_stack((np.cos(turns), np.sin(turns)))
        )
        zone, cells = MapZone(name="z", kind="keep_out", points=points), covered(points, grid)
        for x, y in rng.uniform(0.0, 2.0, (200, 2)) + ORIGIN_M:
            if zone.depth(x, y) > 0.003:
                column, row = np.floor((np.array([x, y]) - grid.origin) / 0.05).astype(int)
                assert cells[row, column]
        assert cells.sum() * 0.05**2 < 3.3


def test_a_turned_mask_is_refused() -> None:
    with pytest.raises(BadInput, match="turned"):
        keep_out_polygons(Nav2Cells(np.zeros((3, 3), np.int8), 0.05, (0.0, 0.0, 0.1)))
