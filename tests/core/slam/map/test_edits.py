"""Edits over what was seen: they outlast all that is seen later, and leave no trace when they are taken back."""

import itertools
import math
from collections.abc import Iterable, Iterator

import numpy as np
import pytest

from core.gate import Twist
from core.pilot import Pilot
from core.robots import Profile, Robot
from core.robots.connect import connect
from core.sensors import SensorFrame
from core.settings import Settings
from core.simulation.settings import SimulationSettings
from core.slam.map.edits import SAID_LOG_ODDS, MapEdit, MapEdits
from core.slam.map.occupancy import OccupancyGrid
from core.snapshot import Snapshot

BLIND = Settings(simulation=SimulationSettings(camera=False, microphones="none"))


def grid_of(log_odds: np.ndarray, origin: tuple[float, float] = (-1.0, 0.5)) -> OccupancyGrid:
    return OccupancyGrid(revision=1, resolution=0.05, origin=np.array(origin), log_odds=log_odds.astype(np.float32))


def rectangle(x: float, y: float, wide: float, high: float) -> np.ndarray:
    return np.array([[x, y], [x + wide, y], [x + wide, y + high], [x, y + high]])


def test_an_area_and_a_stroke_change_the_cells_whose_middles_lie_in_them() -> None:
    grid = grid_of(np.full((40, 60), 2.0))
    y, x = np.indices(grid.log_odds.shape) * 0.05 + np.array([0.525, -0.975])[:, None, None]
    area = MapEdit("free", rectangle(-0.5, 0.8, 0.6, 0.3)).cells(grid)
    assert np.array_equal(area, (x > -0.5) & (x < 0.1) & (y > 0.8) & (y < 1.1))
    stroke = MapEdit("occupied", np.array([[-0.5, 1.0], [1.0, 1.0]]), 0.3).cells(grid)
    away = np.hypot(x - np.clip(x, -0.5, 1.0), y - 1.0)
    assert (stroke[away < 0.12]).all() and not stroke[away > 0.18].any()
    cropped = MapEdits((MapEdit("crop", rectangle(-0.5, 0.8, 0.6, 0.3)),)).on(grid)
    assert (cropped.log_odds[~area] == 0).all() and (cropped.log_odds[area] == 2.0).all()


def test_later_edits_lie_over_earlier_ones_and_without_any_it_is_the_same_grid() -> None:
    rng = np.random.default_rng(1)
    grid = grid_of(rng.normal(0, 2, (50, 50)))
    edits = (MapEdit("occupied", rectangle(-0.8, 0.7, 1, 1)), MapEdit("unknown", rectangle(-0.5, 0.9, 0.3, 0.3)))
    both, one = MapEdits(edits).on(grid), MapEdits(edits[:1]).on(grid)
    hole = edits[1].cells(grid)
    assert (both.log_odds[hole] == 0).all() and (one.log_odds[hole] == SAID_LOG_ODDS).all()
    assert np.array_equal(both.log_odds[~hole], one.log_odds[~hole])
    assert MapEdits().on(grid) is grid
    assert MapEdits((MapEdit("free", rectangle(4, 4, 1, 1)),)).on(grid).log_odds.shape > grid.log_odds.shape


def test_a_landmark_where_the_map_was_erased_is_hidden() -> None:
    grid = grid_of(np.full((40, 40), -1.0))
    edits = MapEdits(
        (MapEdit("free", rectangle(-0.5, 0.8, 0.5, 0.5)), MapEdit("occupied", rectangle(-0.2, 0.9, 0.2, 0.2)))
    )
    assert edits.hides(grid, np.array([[-0.4, 1.0], [-0.1, 1.0], [0.5, 1.0]])).tolist() == [True, False, False]


@pytest.fixture(scope="module")
def drive() -> tuple[Profile, list[SensorFrame]]:
    """A second and a half in the lab, for all tests here."""
    robot = connect("sim:lab", seed=3, settings=BLIND)
    frames = list(driven(robot, 1.5))
    robot.close()
    return robot.profile, frames


def driven(robot: Robot, seconds: float) -> Iterator[SensorFrame]:
    """The frames with a scan of a drive."""
    begun = None
    while True:
        frame = robot.read()
        begun = frame.stamp if begun is None else begun
        if frame.stamp > begun + seconds:
            return
        if frame.scan is not None:
            yield frame
        robot.drive(Twist(0.1 * math.sin(0.3 * frame.stamp), 0.5 * math.cos(0.11 * frame.stamp)))


def map_twice(profile: Profile, frames: Iterable[SensorFrame], edited_at: float) -> None:
    """Two pilots on the same frames, one map edited: in the end it differs in the edited cells alone."""
    plain, edited = Pilot(profile), Pilot(profile)
    edits = MapEdits(
        (
            MapEdit("free", rectangle(0.5, -2.0, 2.0, 4.0)),
            MapEdit("occupied", np.array([[-1.0, 0.5], [-0.2, 0.9]]), 0.2),
            MapEdit("unknown", rectangle(-2.0, -2.0, 1.0, 1.0)),
        )
    )
    for frame in frames:
        if frame.stamp > edited_at and not edited._edits.edits:
            edited.edit_map(edits)
        seen, shown = plain.step(frame), edited.step(frame)
    assert all(edit.cells(shown.grid).any() for edit in edits.edits)
    wanted = edits.on(seen.grid)
    assert np.array_equal(shown.grid.log_odds, wanted.log_odds) and (wanted.log_odds != seen.grid.log_odds).any()
    assert shown.estimate.pose == seen.estimate.pose, "the robot finds its place by what was seen alone"
    gone = edits.hides(shown.grid, np.array([mark.position for mark in seen.landmarks]).reshape(-1, 2))
    assert len(shown.landmarks) == len(seen.landmarks) - int(gone.sum())
    edited.edit_map(MapEdits())
    later = SensorFrame(stamp=frame.stamp + 0.01)
    again, same = edited.step(later).grid, plain.step(later).grid
    assert again.log_odds.tobytes() == same.log_odds.tobytes() and np.array_equal(again.origin, same.origin)


def test_edits_outlast_the_mapping_that_goes_on_and_undo_returns_every_bit(
    drive: tuple[Profile, list[SensorFrame]],
) -> None:
    map_twice(*drive, edited_at=0.5)


@pytest.mark.campaign
def test_edits_outlast_thirty_minutes_of_mapping() -> None:
    robot = connect("sim:lab", seed=3, settings=BLIND)
    map_twice(robot.profile, itertools.islice(driven(robot, 1800.0), None, None, 4), edited_at=2.0)
    robot.close()


def test_a_map_that_is_turned_and_turned_back_is_the_same_to_the_bit(
    drive: tuple[Profile, list[SensorFrame]],
) -> None:
    pilot = Pilot(drive[0])
    for frame in drive[1]:
        before = pilot.step(frame)

    def next_one() -> Snapshot:
        nonlocal stamp
        stamp += 0.01
        return pilot.step(SensorFrame(stamp=stamp))

    stamp = before.stamp
    pilot.turn_map(0.3)
    there = next_one().estimate.pose
    assert abs(math.remainder(there.heading - before.estimate.pose.heading - 0.3, math.tau)) < 1e-6
    far = math.hypot(before.estimate.pose.x, before.estimate.pose.y)
    assert math.isclose(math.hypot(there.x, there.y), far, abs_tol=1e-6)
    pilot.turn_map(-0.3)
    assert next_one().grid.log_odds.tobytes() == before.grid.log_odds.tobytes()
    for _ in range(36):
        pilot.turn_map(math.radians(10.0))
    after = next_one()
    assert after.grid.log_odds.shape == before.grid.log_odds.shape
    assert np.abs(after.grid.log_odds - before.grid.log_odds).max() < 1e-3
