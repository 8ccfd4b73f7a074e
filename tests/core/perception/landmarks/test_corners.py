import time

import numpy as np
import pytest

from core.geometry import Pose, wrap
from core.perception.landmarks.corners import Corner, CornerSettings, find_corners
from core.perception.landmarks.deskew import deskew
from core.perception.landmarks.lines import Sweep
from core.sensors import Laser, Scan
from tests.core.perception.corner_room import LASER, box, scan_of, two_walls

RUNS = 300


def corners_in(scan: Scan, settings: CornerSettings | None = None, laser: Laser = LASER) -> tuple[Corner, ...]:
    return find_corners(scan, laser, *deskew(scan, laser, None, scan.stamp), settings)


def trials(
    distance: float, convex: bool, noise: float, runs: int = RUNS
) -> tuple[list[np.ndarray], list[Corner], int]:
    """Errors (2,) of the corners found, the corners, and how many were found that are none."""
    rng, errors, found, false = np.random.default_rng(5), [], [], 0
    settings = CornerSettings(noise_floor=noise, noise_ratio=noise)
    for _ in range(runs):
        place, walls = two_walls(distance, convex, rng)
        seen = corners_in(scan_of(walls, rng, floor=noise, share=noise, range_max=4.0), settings)
        near = [corner for corner in seen if np.hypot(*(corner.position - place)) < 0.25]
        false += len(seen) - len(near[:1])
        errors += [corner.position - place for corner in near[:1]]
        found += near[:1]
    return errors, found, false


@pytest.mark.parametrize("convex", [False, True])
def test_a_corner_three_metres_away_is_found_to_a_centimetre_and_knows_how_well(convex: bool) -> None:
    errors, found, false = trials(3.0, convex, 0.01)
    nees = [e @ np.linalg.solve(c.covariance, e) for e, c in zip(errors, found, strict=True)]
    assert len(found) >= 0.97 * RUNS
    assert false <= 0.02 * RUNS
    assert np.sqrt(np.mean([e @ e for e in errors])) < 0.015
    assert 1.6 < np.mean(nees) < 2.6
    assert {corner.kind for corner in found} == {"convex" if convex else "concave"}


def test_with_three_per_cent_noise_the_covariance_stays_honest() -> None:
    errors, found, false = trials(2.0, False, 0.03, 150)
    nees = [e @ np.linalg.solve(c.covariance, e) for e, c in zip(errors, found, strict=True)]
    assert len(found) >= 0.95 * 150
    assert false <= 0.02 * 150
    assert 1.5 < np.mean(nees) < 2.8


def test_the_corners_of_a_room_open_towards_its_middle() -> None:
    seen = corners_in(scan_of(box(-2, -1.5, 2.2, 1.8), np.random.default_rng(0), pose=Pose(0.2, 0.1, 0.3)))
    assert len(seen) == 2  # the others lie behind, outside the field of view
    for corner in seen:
        back = np.arctan2(-corner.position[1], -corner.position[0])
        assert corner.kind == "concave"
        assert abs(wrap(corner.opening - float(back))) < corner.sector
        assert corner.sector == pytest.approx(np.pi / 4, abs=0.05)


def test_a_pillar_is_convex_and_opens_towards_the_robot() -> None:
    walls = np.vstack((box(-5, -5, 5, 5), box(1.2, -0.3, 1.8, 0.3)))
    seen = corners_in(scan_of(walls, np.random.default_rng(0), pose=Pose(0.2, 1.2, -0.8)))
    pillar = [corner for corner in seen if corner.kind == "convex"]
    assert len(pillar) == 1
    assert np.allclose(Pose(0.2, 1.2, -0.8).apply(pillar[0].position[None])[0], (1.2, 0.3), atol=0.02)


def test_a_flat_wall_has_no_corner() -> None:
    rng = np.random.default_rng(2)
    wall = np.array([(1.5, -4.0, 1.5, 4.0)])
    assert sum(len(corners_in(scan_of(wall, rng))) for _ in range(60)) <= 1


def test_the_edge_of_something_nearer_is_no_corner() -> None:
    rng = np.random.default_rng(3)
    board_before_wall = np.array([(1.5, -0.8, 1.5, 0.8), (2.5, -3.0, 2.5, 3.0)])
    assert sum(len(corners_in(scan_of(board_before_wall, rng))) for _ in range(60)) <= 1


def test_the_mounting_shifts_corners_with_it() -> None:
    scan = scan_of(box(-2, -1.5, 2.2, 1.8), np.random.default_rng(0))
    laser = Laser(mounting=Pose(0.12, -0.03, 0.2))
    plain = corners_in(scan)
    mounted = corners_in(scan, laser=laser)
    for a, b in zip(plain, mounted, strict=True):
        assert np.allclose(laser.mounting.apply(a.position[None])[0], b.position)
        assert wrap(a.opening + 0.2 - b.opening) == pytest.approx(0.0, abs=1e-9)


def test_a_line_fitted_in_inverse_ranges_is_neither_tilted_nor_too_sure() -> None:
    rng = np.random.default_rng(7)
    settings, truth = CornerSettings(noise_floor=0.03, noise_ratio=0.03), np.array([0.4, 0.3])
    angles = np.linspace(-0.4, 0.4, 80)
    rays = np.column_stack((np.cos(angles), np.sin(angles)))
    squared = []
    for _ in range(400):
        ranges = 1.0 / (rays @ truth)
        points = rays * (ranges * (1 + 0.03 * rng.normal(size=80)))[:, None]
        fitted = Sweep(points, np.arange(80), angles[1] - angles[0], settings).fit_ranges(0, 79)
        assert fitted is not None
        error = fitted[0] - truth
        squared.append(error @ np.linalg.solve(fitted[1], error))
    assert 1.7 < np.mean(squared) < 2.4


@pytest.mark.parametrize("points", [0, 1, 5])
def test_a_nearly_empty_scan_has_no_corners(points: int) -> None:
    ranges = np.full(LASER.beams, np.nan)
    ranges[:points] = 1.0
    scan = Scan(stamp=0.0, ranges=ranges, angle_min=LASER.angle_min, angle_step=LASER.angle_step)
    assert corners_in(scan) == ()


def test_two_milliseconds_are_enough_for_a_scan_of_682_beams() -> None:
    """Or as much as 600 inversions take: on a busy machine they are slower, too."""
    walls = np.vstack((box(-3, -2, 3, 2), box(1, 1, 1.4, 1.4), box(-1.6, -2, -1, -1.5)))
    scan = scan_of(walls, np.random.default_rng(0))
    points, beams = deskew(scan, LASER, None, 0.0)
    spent, compared = [], []
    for _ in range(30):
        began = time.process_time()
        find_corners(scan, LASER, points, beams)
        between = time.process_time()
        for _ in range(100):
            np.linalg.inv(np.eye(3))
        spent.append(between - began)
        compared.append(time.process_time() - between)
    assert min(spent) < max(0.002, 6 * min(compared))
