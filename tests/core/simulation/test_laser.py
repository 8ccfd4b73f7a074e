"""Simulated scans."""

import numpy as np
import pytest

from core.geometry import Pose
from core.message import Array
from core.sensors import Laser, Scan
from core.simulation.laser import SimulatedLaser
from core.simulation.world import LAB, Rect, Thing, World, outline

ROOM = World(name="room", walls=outline([Rect(-2.0, -1.5, 3.0, 2.5)]))
STILL = np.zeros((2, 3))
SPAN = np.array([0.0, 0.1])


def exact(laser: Laser | None = None) -> SimulatedLaser:
    return SimulatedLaser(laser or Laser(), np.random.default_rng(0), floor_sd=0, share_sd=0, dropout=0)


def distance_to_wall(angles: Array, x: float = 0.0, y: float = 0.0) -> Array:
    c, s = np.cos(angles), np.sin(angles)
    across = np.where(c > 0, (3.0 - x) / np.where(c == 0, 1, c), (-2.0 - x) / np.where(c == 0, 1, c))
    along = np.where(s > 0, (2.5 - y) / np.where(s == 0, 1, s), (-1.5 - y) / np.where(s == 0, 1, s))
    return np.minimum(across, along)


def test_a_scan_is_that_of_the_urg() -> None:
    scan = exact().scan(ROOM, 0.5, SPAN + 0.5, STILL)
    assert len(scan.ranges) == 682
    assert np.degrees(scan.angles[-1] - scan.angles[0]) == pytest.approx(239.4, abs=0.1)
    assert scan.times[-1] - scan.stamp == pytest.approx(0.0665, abs=1e-4)
    np.testing.assert_allclose(scan.ranges, distance_to_wall(scan.angles), atol=0.0006)  # whole millimetres


def test_every_beam_leaves_from_where_the_robot_is_at_its_time() -> None:
    times = np.linspace(0, 0.1, 5)
    poses = np.column_stack((0.3 * times, -0.1 * times, 1.5 * times))
    scan = exact().scan(ROOM, 0.0, times, poses)
    x, y, heading = 0.3 * scan.times, -0.1 * scan.times, 1.5 * scan.times
    c, s = np.cos(heading + scan.angles), np.sin(heading + scan.angles)
    ends = np.column_stack((x + scan.ranges * c, y + scan.ranges * s))
    gaps = np.abs(np.column_stack((ends[:, 0] - 3.0, ends[:, 0] + 2.0, ends[:, 1] - 2.5, ends[:, 1] + 1.5)))
    assert gaps.min(axis=1).max() < 0.001
    frozen = exact().scan(ROOM, 0.0, SPAN, STILL)
    assert np.nanmax(np.abs(scan.ranges - frozen.ranges)) > 0.02


def test_a_laser_that_sits_elsewhere_sees_from_there() -> None:
    laser = Laser(mounting=Pose(0.2, 0.1, 0.5))
    scan = exact(laser).scan(ROOM, 0.0, SPAN, STILL)
    np.testing.assert_allclose(scan.ranges, distance_to_wall(scan.angles + 0.5, 0.2, 0.1), atol=0.0006)


@pytest.mark.parametrize(("floor_sd", "share_sd"), [(0.010, 0.01), (0.030, 0.03)])
def test_range_noise_is_as_the_settings_say(floor_sd: float, share_sd: float) -> None:
    laser = SimulatedLaser(Laser(), np.random.default_rng(1), floor_sd=floor_sd, share_sd=share_sd, dropout=0.004)
    scans = np.array([laser.scan(ROOM, 0.0, SPAN, STILL).ranges for _ in range(150)])
    truth = distance_to_wall(Scan(stamp=0, ranges=scans[0], angle_min=-2.0923, angle_step=2 * np.pi / 1024).angles)
    expected = np.maximum(floor_sd, share_sd * truth)
    spread = (scans - truth) / expected
    assert np.nanmean(spread) == pytest.approx(0.0, abs=0.02)
    assert np.nanstd(spread) == pytest.approx(1.0, abs=0.02)
    assert np.isnan(scans).mean() == pytest.approx(0.004, abs=0.001)


def test_beams_fail_beyond_the_range_and_where_they_graze() -> None:
    corridor = World(name="corridor", walls=outline([Rect(-9.0, -0.3, 9.0, 0.3)]))
    scan = SimulatedLaser(Laser(), np.random.default_rng(2), dropout=0.0).scan(corridor, 0.0, SPAN, STILL)
    assert np.isnan(scan.ranges[np.abs(scan.angles) < 0.05]).all()  # the far end is 9 m away
    assert not np.isnan(scan.ranges[np.abs(np.abs(scan.angles) - 1.5) < 0.5]).any()
    flat = np.isnan(scan.ranges[(np.abs(scan.angles) > 0.06) & (np.abs(scan.angles) < 0.12)])
    assert 0.1 < flat.mean() < 0.9


def test_a_person_is_seen_as_two_legs() -> None:
    person = Thing(id="p", what="person", pose=Pose(1.5, 0.0, np.pi), length=0.4, depth=0.4, height=1.75)
    empty, full = (exact().scan(world, 0.0, SPAN, STILL).ranges for world in (ROOM, ROOM.with_thing(person)))
    nearer = full < empty - 0.1
    legs = np.flatnonzero(np.diff(nearer.astype(int), prepend=0) == 1)
    assert len(legs) == 2
    assert full[nearer].min() == pytest.approx(1.5 - 0.055, abs=0.01)
    assert nearer.sum() * 2 * np.pi / 1024 * 1.5 == pytest.approx(4 * 0.055, abs=0.03)


def test_the_same_seed_makes_the_same_scan() -> None:
    first, second = (
        SimulatedLaser(Laser(), np.random.default_rng(7)).scan(LAB, 0.0, SPAN, STILL).ranges for _ in range(2)
    )
    np.testing.assert_array_equal(first, second)
