"""The outline of a map: straight where walls are, closed where one is interrupted, and nothing from noise."""

import itertools

import cv2
import numpy as np

from core.message import Array
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.outline import MapOutline, trace_outline

CELL_M = 0.05
PX_PER_CELL = 4  # picture elements along a cell, where rings are filled again
ORIGIN = np.array([-1.0, -2.0])


def outlined(odds: Array, origin: Array = ORIGIN) -> MapOutline:
    return trace_outline(
        OccupancyGrid(revision=1, resolution=CELL_M, origin=origin, log_odds=odds.astype(np.float32))
    )


def room(rows: int = 80, columns: int = 120) -> Array:
    odds = np.full((rows, columns), -2.0)
    odds[[0, 1, -1, -2]] = odds[:, [0, 1, -1, -2]] = 4.0
    return odds


def test_walls_lie_where_their_cells_are_wherever_the_map_begins() -> None:
    for origin in (ORIGIN, np.array([10.0, 3.5])):
        extent = outlined(room(), origin).extent
        assert extent is not None
        truth = (*origin, *(origin + CELL_M * np.array([120, 80])))
        assert np.abs(np.array(extent) - truth).max() <= CELL_M / 2


def test_a_straight_wall_has_few_corners() -> None:
    walls = outlined(room()).walls
    assert len(walls) == 2  # outside and inside
    assert all(len(ring) <= 16 for ring in walls)  # strokes end round


def test_a_gap_of_a_cell_is_closed_and_a_door_is_not() -> None:
    odds = room()
    odds[:2, 40:41] = -2.0  # a beam that passed a reflection
    assert len(outlined(odds).walls) == 2
    odds[:2, 40:56] = -2.0  # a door of 0.8 m
    assert len(outlined(odds).walls) == 1


def test_a_single_cell_of_little_evidence_is_no_wall() -> None:
    odds = np.full((40, 40), -2.0)
    odds[20, 20] = 0.5
    assert outlined(odds).walls == ()


def test_nothing_is_too_square_to_be_drawn() -> None:
    for side in range(2, 12):
        odds = np.full((40, 40), -2.0)
        odds[20 : 20 + side, 20 : 20 + side] = 4.0
        walls = outlined(odds).walls
        area = sum(cv2.contourArea((ring / CELL_M).astype(np.float32)) for ring in walls)
        assert len(walls) == 1 and abs(area - side**2) < 0.5 * side**2 + 2, (side, area)


def test_nothing_known_has_no_outline() -> None:
    empty = outlined(np.zeros((0, 0)))
    assert empty.extent is None and empty.walls == empty.floor == ()
    assert outlined(np.zeros((30, 30))).extent is None


def test_what_is_drawn_is_what_is_known_under_any_turn() -> None:
    """Rings filled again cover the occupied cells and leave the free ones: a law over turned and mirrored rooms."""
    odds = room()
    odds[30:38, 20:60] = 4.0  # what is as thick as this is drawn as it is
    for turns, mirrored in itertools.product(range(4), (False, True)):
        turned = np.rot90(odds, turns)
        turned = turned[:, ::-1] if mirrored else turned
        known = np.kron(turned > 0, np.ones((PX_PER_CELL, PX_PER_CELL)))
        drawn = np.zeros(known.shape, np.uint8)
        rings = [
            np.round((ring - ORIGIN) * PX_PER_CELL / CELL_M - 0.5).astype(np.int32) for ring in outlined(turned).walls
        ]
        cv2.fillPoly(drawn, rings, 1)
        assert (drawn == known).mean() > 0.96


def test_a_wall_of_uneven_thickness_is_drawn_by_a_straight_stroke() -> None:
    """Beams leave one to three cells along a wall, as they fall; a plan shows the wall."""
    random = np.random.default_rng(4)
    odds = np.full((40, 160), -2.0)
    odds[20, 10:150] = 4.0
    for side in (19, 21):
        odds[side, 10:150] = np.where(random.random(140) < 0.4, 4.0, -2.0)
    (wall,) = outlined(odds).walls
    assert len(wall) <= 12
    assert np.abs(wall[:, 1] - (ORIGIN[1] + 20.5 * CELL_M)).max() < 1.5 * CELL_M
