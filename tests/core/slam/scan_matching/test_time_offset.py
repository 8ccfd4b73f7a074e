"""The time offset between laser and odometry: found from turns, and only from turns."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from core.geometry import Pose
from core.message import Array
from core.sensors import Laser, Scan, Wheels
from core.slam.scan_matching.time_offset import (
    Estimated,
    TimeOffsetEstimator,
    TimeOffsetSettings,
    TurnMatcher,
    fit_time_offset,
)
from tests.benchmarks.time_offset import JITTER, Leg, Stamping, estimated, frames, turns

SETTINGS = TimeOffsetSettings()
TIMES = np.arange(0.0, 8.0, 0.025)  # [s]
STRAIGHT: tuple[Leg, ...] = ((1.0, 0.0, 0.0), (3.0, 0.2, 0.0), (1.0, 0.0, 0.0))
LATER = 1000.0  # [s]


def odometry(start: float = 1.0, end: float = 6.0, rate: float = 1.0) -> Array:
    """Headings (K,) [rad] at TIMES of a robot that turns from `start` to `end` [s]."""
    return rate * np.clip(TIMES - start, 0.0, end - start)


def fit(offset: float, headings: Array, scale: float = 1.0, seed: int = 0) -> Estimated | None:
    """The fit of scans whose stamps miss `offset` [s], on odometry that shows `scale` times the turn."""
    stamps = np.arange(0.3, 7.5, 0.1)
    noise = np.random.default_rng(seed).normal(scale=0.002, size=len(stamps))
    seen = np.interp(stamps + offset, TIMES, headings) + noise
    return fit_time_offset(stamps, seen, (TIMES, scale * headings), SETTINGS)


@pytest.mark.parametrize("offset", [-0.15, -0.1, -0.04, 0.0, 0.04, 0.1, 0.15])
@pytest.mark.parametrize("scale", [1.0, 0.96, 1.04])
def test_the_offset_is_found_despite_the_scale_of_the_odometry(offset: float, scale: float) -> None:
    found = [fit(offset, odometry(), scale, seed) for seed in range(5)]
    errors = np.array([one.offset - offset for one in found if one is not None])
    assert len(errors) == len(found)
    assert np.abs(errors).max() < 0.005


def test_errors_are_as_large_as_claimed() -> None:
    found = [fit(0.06, odometry(), seed=seed) for seed in range(60)]
    squared = [(one.offset - 0.06) ** 2 / one.variance for one in found if one is not None]
    assert len(squared) == len(found)
    assert np.mean(squared) < 2.0


def test_an_even_turn_without_beginning_and_end_tells_little() -> None:
    even, whole = fit(0.05, odometry(start=-1.0, end=9.0)), fit(0.05, odometry())
    assert whole is not None
    assert math.sqrt(whole.variance) < SETTINGS.accepted_sd
    assert even is None or math.sqrt(even.variance) > SETTINGS.accepted_sd


def test_a_robot_that_was_turned_by_hand_gives_no_offset() -> None:
    stamps = np.arange(0.3, 7.5, 0.1)
    seen = np.interp(stamps, TIMES, odometry()) + np.where(stamps > 3.5, 0.5, 0.0)
    assert fit_time_offset(stamps, seen, (TIMES, odometry()), SETTINGS) is None


def test_an_offset_beyond_what_is_looked_for_is_not_taken_for_a_smaller_one() -> None:
    assert fit(0.35, odometry()) is None


@pytest.mark.parametrize(
    ("turn", "shift", "place"),
    [
        ("360", -0.1, "floor"),
        ("90+90", 0.0, "floor"),
        ("90+90", 0.1, "lab"),
        *(
            pytest.param(*one, marks=pytest.mark.campaign)
            for one in itertools.product(("360", "90+90"), (-0.1, 0.0, 0.1), ("lab", "floor"))
        ),
    ],
)
def test_one_turn_tells_the_offset_within_10_ms(place: str, shift: float, turn: str) -> None:
    for seed, (rate, jitter) in enumerate(((0.5, JITTER), (1.5, 0.0))):
        stamping = Stamping(shift, jitter, filtered=jitter > 0, seed=seed)
        offset, sd = estimated(place, turns(rate)[turn], stamping, seed)
        assert offset == pytest.approx(-shift, abs=0.010)
        assert sd < SETTINGS.accepted_sd


def snapshot_of_a_bare_room(heading: float, laser: Laser, noise: Array) -> Array:
    """Ranges [m] in the middle of a room of 4 by 3 m, all beams at once."""
    angles = heading + laser.angle_min + laser.angle_step * np.arange(laser.beams)
    walls = np.abs(np.column_stack((np.cos(angles), np.sin(angles)))) / (2.0, 1.5)
    return 1 / walls.max(axis=1) + noise


def heading_errors(laser: Laser, chance: np.random.Generator) -> Array:
    """Headings by matching minus the true ones [rad], of scans turned to either side of a first one."""
    errors = list[float]()
    for start, side, turn in itertools.product(chance.uniform(-math.pi, math.pi, 6), (1.0, -1.0), (0.1, 0.25, 0.45)):
        matcher = TurnMatcher(laser)
        for turned in (0.0, side * turn):
            ranges = snapshot_of_a_bare_room(start + turned, laser, chance.normal(scale=0.01, size=laser.beams))
            scan = Scan(stamp=0.0, ranges=ranges, angle_min=laser.angle_min, angle_step=laser.angle_step)
            heading = matcher.match(scan, 0.0, Wheels(odometry=Pose(), speed=0.0, turn_rate=0.0), turned)
            assert heading is not None
        errors.append(side * (heading - side * turn))
    return np.array(errors)


def test_walls_beyond_the_view_of_an_earlier_scan_draw_no_later_one_back() -> None:
    laser = Laser(beams=181, angle_min=-math.pi / 2, angle_step=math.pi / 180)
    errors = heading_errors(laser, np.random.default_rng(3))
    assert float(np.mean(errors)) == pytest.approx(0.0, abs=math.radians(0.12))  # -0.3° where they count


def test_jittering_stamps_without_a_filter_have_the_offset_of_their_mean() -> None:
    stamping = Stamping(0.04, JITTER, seed=2)
    offset, _ = estimated("lab", turns(1.0)["360"], stamping, 2)
    assert offset == pytest.approx(-0.04 - JITTER / 2, abs=0.010)


def test_driving_straight_tells_nothing() -> None:
    assert math.isnan(estimated("lab", STRAIGHT, Stamping(0.1), 0)[0])


def after_two_drives(first: float, second: float, pause: float = LATER) -> Estimated:
    """What is known after turns with one shift [s] of the stamps and, `pause` [s] after they began, with another."""
    estimator = TimeOffsetEstimator(Laser(), SETTINGS)
    for later, shift in ((0.0, first), (pause, second)):
        for frame in frames("lab", turns(1.0)["90+90"], Stamping(shift), 1):
            scan = None if frame.scan is None else replace(frame.scan, stamp=frame.scan.stamp + later)
            estimator.update(frame.stamp + later, frame.wheels, scan)
    assert estimator.newest is not None
    return estimator.newest


@pytest.mark.parametrize("second", [0.02, 0.04])
def test_a_clock_that_drifts_is_followed(second: float) -> None:
    assert after_two_drives(0.02, second).offset == pytest.approx(-second, abs=0.010)


def test_a_clock_that_was_set_is_followed_at_once() -> None:
    assert after_two_drives(0.02, 0.12, pause=20.0).offset == pytest.approx(-0.12, abs=0.010)


def test_turns_that_agree_make_the_offset_surer() -> None:
    twice = after_two_drives(0.05, 0.05)
    _, once = estimated("lab", turns(1.0)["90+90"], Stamping(0.05), 1)
    assert math.sqrt(twice.variance) < once


def test_odometry_with_gaps_tells_nothing() -> None:
    estimator = TimeOffsetEstimator(Laser(), SETTINGS)
    for number, frame in enumerate(frames("lab", turns(1.0)["90+90"], Stamping(0.1), 0)):
        estimator.update(frame.stamp, frame.wheels if number % 12 == 0 else None, frame.scan)
    assert estimator.newest is None


def test_odometry_that_stalls_in_a_turn_while_scans_go_on_tells_nothing_and_breaks_nothing() -> None:
    estimator = TimeOffsetEstimator(Laser(), SETTINGS)
    for frame in frames("lab", turns(1.0)["90+90"], Stamping(0.0), 0):
        stalled, silent = 1.5 < frame.stamp < 4.0, 1.5 < frame.stamp < 3.0
        estimator.update(frame.stamp, None if stalled else frame.wheels, None if silent else frame.scan)
    assert estimator.newest is None or abs(estimator.newest.offset) < 0.010


def test_scans_that_lie_too_far_apart_tell_nothing() -> None:
    estimator, number = TimeOffsetEstimator(Laser(), SETTINGS), 0
    for frame in frames("lab", turns(0.5)["360"], Stamping(0.1), 0):
        number += frame.scan is not None
        estimator.update(frame.stamp, frame.wheels, frame.scan if number % 7 == 0 else None)
    assert estimator.newest is None
