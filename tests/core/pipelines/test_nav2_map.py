"""The exported map, read back by the rule of Nav2's map server."""

from __future__ import annotations

import numpy as np
import pytest
import yaml

from core.pipelines.nav2_map import nav2_map
from core.slam.map.occupancy import OccupancyGrid


def make_grid(log_odds, origin=(-1.25, 2.123456), resolution=0.05):
    return OccupancyGrid(
        revision=1, resolution=resolution, origin=np.array(origin), log_odds=np.asarray(log_odds, dtype=np.float32)
    )


def load_as_nav2(text: str, pgm: bytes):
    """Nav2's map_io: p = (255 - pixel) / 255; row 0 of the picture is the highest y."""
    settings = yaml.safe_load(text)
    magic, size, depth, pixels = pgm.split(b"\n", 3)
    columns, rows = (int(word) for word in size.split())
    assert (magic, depth) == (b"P5", b"255")
    picture = np.frombuffer(pixels, np.uint8).reshape(rows, columns)
    p = (255 - picture.astype(float)) / 255
    cells = np.full((rows, columns), -1)
    cells[p >= settings["occupied_thresh"]] = 100
    cells[p <= settings["free_thresh"]] = 0
    return settings, cells[::-1]


def test_every_cell_comes_back_as_what_it_was():
    rng = np.random.default_rng(3)
    kind = rng.choice([-1, 0, 100], (17, 31))
    log_odds = np.select([kind == 100, kind == 0], [2.5, -2.5], 0.0)
    settings, cells = load_as_nav2(*nav2_map(make_grid(log_odds)))
    assert np.array_equal(cells, kind)
    assert settings["image"] == "map.pgm" and settings["mode"] == "trinary" and settings["negate"] == 0


def test_the_unknown_grey_stays_unknown():
    _, cells = load_as_nav2(*nav2_map(make_grid(np.zeros((4, 5)))))
    assert (cells == -1).all()


@pytest.mark.parametrize(("log_odds", "cell"), [(0.4, -1), (-0.4, -1), (0.8, 100), (-0.8, 0), (4.0, 100), (-4.0, 0)])
def test_a_cell_is_drawn_when_it_is_fairly_sure(log_odds, cell):
    _, cells = load_as_nav2(*nav2_map(make_grid(np.full((2, 2), log_odds))))
    assert (cells == cell).all()


def test_the_lowest_row_of_the_grid_is_the_last_of_the_picture():
    log_odds = np.zeros((3, 2))
    log_odds[0, 1] = 3.0
    _, pgm = nav2_map(make_grid(log_odds))
    assert pgm.split(b"\n", 3)[3] == bytes([205, 205, 205, 205, 205, 0])


def test_origin_and_resolution_keep_their_digits():
    settings, _ = load_as_nav2(*nav2_map(make_grid(np.zeros((1, 1)), origin=(-1.23456789, 1e-7), resolution=1 / 30)))
    assert settings["resolution"] == pytest.approx(1 / 30, abs=1e-9)
    assert settings["origin"] == pytest.approx([-1.23456789, 1e-7, 0.0], abs=1e-9)
    assert list(settings) == ["image", "mode", "resolution", "origin", "negate", "occupied_thresh", "free_thresh"]
