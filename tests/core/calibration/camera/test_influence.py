"""What one view would change is told: of those left out, and of one that decides the answer by itself."""

import re

import numpy as np
import pytest

from core.calibration.camera import bundle_adjustment, consistency, suspects
from core.calibration.camera.bundle_adjustment import BundleSolution
from core.calibration.camera.intrinsics import Calibration, calibrate
from core.calibration.camera.session import AcceptedView, CameraSession
from core.calibration.practice import BoardPlacement
from core.calibration.projection import PARAMETERS
from core.calibration.reports import camera_report
from core.message import Array
from tests.core.calibration.seen_boards import BOARD, SIZE, some_corners, views_of

FACING = BoardPlacement(most_tilt=np.deg2rad(6))
TILTED = BoardPlacement(least_tilt=np.deg2rad(35), most_tilt=np.deg2rad(45))
TOLD = re.compile(r"with it (\w+) would be ([\d.]+) instead of ([\d.]+) px, (\d+) sd")


def solved(pixels: Array) -> Calibration:
    return calibrate(views_of(pixels), BOARD, SIZE)


def free_of(found: Calibration) -> tuple[int, ...]:
    return tuple(PARAMETERS.index(name) for name in found.free)


def refined(found: Calibration, which: Array, *, everything: bool = False) -> Array:
    """The figures (5,) [pixel] that these views (M,) bool give by plain least squares."""
    some = found.corners.take(which)
    if everything:
        some = some._replace(used=np.ones_like(some.used))
    start = BundleSolution(found.solution.camera, found.poses.take(which))
    return suspects.MEANS @ bundle_adjustment.refine(some, start, free_of(found)).camera[:4]


def known_of(found: Calibration) -> suspects.Figures:
    return suspects.figures(found.solution.camera, found.covariance)


def stretched(corners: Array) -> Array:
    """As a board that is bent: a little wider, a little lower, and uneven."""
    middle = corners.mean(axis=0)
    return (corners - middle) * (1.05, 0.95) + middle + np.random.default_rng(5).normal(0, 0.6, corners.shape)


def rows_swapped(corners: Array) -> Array:
    grid = corners.reshape(BOARD.rows, BOARD.columns, 2).copy()
    grid[[1, 2]] = grid[[2, 1]]
    return grid.reshape(-1, 2)


@pytest.mark.parametrize("count", [6, 13])
def test_what_the_others_give_without_a_view_is_what_solving_without_it_gives(count: int) -> None:
    found = solved(some_corners(count, noise=0.15, seed=3)[0].pixels)
    known = known_of(found)
    numbers, others = suspects.without_each(
        found.corners,
        found.solution,
        consistency.equations(found.corners, found.solution),
        free_of(found),
        found.noise,
    )
    assert numbers.tolist() == list(range(count))
    for number in range(count):
        alone = refined(found, np.arange(count) != number)
        assert np.all(np.abs(others.values[number] - alone) < 0.15 * known.sds)
        assert np.all(others.sds[number] >= known.sds)


@pytest.mark.parametrize("culprit", [7, *(pytest.param(end, marks=pytest.mark.campaign) for end in (0, 12))])
def test_a_view_that_is_left_out_says_what_it_would_change(culprit: int) -> None:
    pixels = some_corners(13, noise=0.15, seed=2)[0].pixels.copy()
    pixels[culprit] = stretched(pixels[culprit])
    found = solved(pixels)
    verdict, known = found.verdicts[culprit], known_of(found)
    assert not verdict.used
    told = TOLD.search(verdict.reason)
    assert told is not None
    figure, value, sds = suspects.PINHOLE_NAMES.index(told[1]), float(told[2]), int(told[4])
    change = value - known.values[figure]
    assert float(told[3]) == pytest.approx(known.values[figure], abs=0.051)
    assert value == pytest.approx(refined(found, np.ones(13, bool), everything=True)[figure], abs=0.06)
    assert sds == pytest.approx(abs(change) / known.sds[figure], abs=0.6)
    assert ("show more tilted views to decide" in verdict.reason) == (abs(change) > 3 * known.sds[figure])
    assert camera_report(found)["views"][culprit]["remark"] == verdict.reason


def test_where_the_fault_is_certain_no_more_views_are_asked_for() -> None:
    pixels = some_corners(13, noise=0.15, seed=2)[0].pixels.copy()
    pixels[7] = rows_swapped(pixels[7])
    reason = solved(pixels).verdicts[7].reason
    assert "rows 2 and 3" in reason and TOLD.search(reason) and "to decide" not in reason


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.campaign) for seed in (1, 2))])
def test_the_only_tilted_view_is_named_as_the_one_that_decides(seed: int) -> None:
    facing, _ = some_corners(11, noise=0.1, seed=seed, how=FACING)
    tilted, _ = some_corners(1, noise=0.1, seed=seed + 50, how=TILTED)
    found = solved(np.concatenate((facing.pixels, tilted.pixels)))
    assert found.deciding.startswith("view 11 decides f by itself: without it f would be ")
    assert found.deciding in found.warnings and found.deciding in camera_report(found)["warnings"]
    more, _ = some_corners(6, noise=0.1, seed=seed + 80, how=TILTED)
    assert solved(np.concatenate((facing.pixels, tilted.pixels, more.pixels))).deciding == ""


def test_the_wizard_says_so_when_it_is_done() -> None:
    pixels = some_corners(20, noise=0.02, seed=1, how=FACING)[0].pixels
    tilted = some_corners(1, noise=0.02, seed=51, how=TILTED)[0].pixels
    session = CameraSession(BOARD)
    session.size = SIZE
    session.taken = [AcceptedView(view.name, view.corners) for view in views_of(np.concatenate((pixels, tilted)))]
    session.solve()
    assert session.progress().ready
    assert "Done" in session.progress().words and "view 20 decides f by itself" in session.progress().words


@pytest.mark.parametrize("count", [4, pytest.param(12, marks=pytest.mark.campaign)])
def test_in_ordinary_sets_of_views_hardly_any_decides(count: int) -> None:
    sets = [some_corners(13, noise=0.1, seed=1000 + seed)[0].pixels for seed in range(count)]
    assert sum(solved(pixels).deciding != "" for pixels in sets) <= 1


def test_too_few_views_all_decide_and_none_is_named() -> None:
    assert solved(some_corners(5, noise=0.1, seed=1)[0].pixels).deciding == ""
