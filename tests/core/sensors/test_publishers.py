"""Two publishers under one name: told by their turns, and never seen where one robot moves."""

import itertools
import math

import numpy as np
import pytest

from core.geometry import Pose
from core.sensors import Scan
from core.sensors.publishers import (
    WATCHED_READINGS,
    PublisherWatch,
    ReadingT,
    odometry_turns,
    odometry_watch,
    scan_watch,
    sector_ranges,
)

BEAMS, PERIOD_S = 360, 0.1
MAX_TURN_ACCELERATION = 6.0  # [rad/s²]
TURNS = {"ABAB": "AB", "AAB": "AAB", "AABB": "AABB", "AAAB": "AAAB", "ABBB": "ABBB"}


def scan_in_room(pose: Pose, seed: int = 0, *, beams: int = BEAMS, person: float | None = None) -> Scan:
    """A room of 6 x 4 m with its middle at the origin, as a laser sees it; `person`: bearing of someone at 0.8 m."""
    step = math.tau / beams
    bearings = -math.pi + step * np.arange(beams)
    ahead = bearings + pose.heading
    c, s = np.cos(ahead), np.sin(ahead)
    along = np.where(c > 0, 3.0 - pose.x, 3.0 + pose.x) / np.maximum(np.abs(c), 1e-6)
    aside = np.where(s > 0, 2.0 - pose.y, 2.0 + pose.y) / np.maximum(np.abs(s), 1e-6)
    ranges = np.minimum(along, aside) + np.random.default_rng(seed).normal(0, 0.01, beams)
    if person is not None:
        ranges[np.abs(np.angle(np.exp(1j * (bearings - person)))) < 0.15] = 0.8
    return Scan(stamp=0.0, ranges=ranges, angle_min=-math.pi, angle_step=step, range_max=10.0)


def told(readings: list[ReadingT], watch: PublisherWatch[ReadingT]) -> list[bool]:
    return [watch.take(one, PERIOD_S * number) for number, one in enumerate(readings)]


@pytest.mark.parametrize("turns", TURNS.values(), ids=TURNS)
@pytest.mark.parametrize("apart_m", [0.5, 1.0, 2.0])
def test_scans_of_two_robots_are_told_whatever_their_turns(turns: str, apart_m: float) -> None:
    here, there = Pose(-1.0, 0.5, 0.2), Pose(-1.0 + apart_m, 0.5, 0.2)
    order = itertools.islice(itertools.cycle(turns), 3 * WATCHED_READINGS)
    views = [
        sector_ranges(scan_in_room(here @ Pose(0.02 * n) if who == "A" else there, n)) for n, who in enumerate(order)
    ]
    found = told(views, scan_watch())
    assert found.index(True) < 4 * len(turns) and all(found[found.index(True) :])


@pytest.mark.parametrize("turn_rate", [0.0, 0.5, 1.5, 3.0, -3.0, 6.0])
@pytest.mark.parametrize("speed", [0.0, 0.3, 1.0])
def test_one_robot_is_never_taken_for_two_however_it_moves(turn_rate: float, speed: float) -> None:
    for period in (0.05, 0.1, 0.2):
        watch, pose = scan_watch(), Pose(-1.5, -0.5, 0.3)
        for number in range(round(6.0 / period)):
            sense = math.sin(number * period * MAX_TURN_ACCELERATION / max(abs(turn_rate), 3.0))  # to and fro
            pose = pose @ Pose(sense * speed * period, 0.0, sense * turn_rate * period)
            walker = 1.5 * number * period  # someone walks around it
            seen = scan_in_room(pose, number, beams=BEAMS + number % 3, person=walker)
            assert not watch.take(sector_ranges(seen), number * period)


def test_one_robot_that_turns_to_and_fro_abruptly_comes_back_to_another_place_each_time() -> None:
    for seed in range(4):
        watch, pose, chance = scan_watch(), Pose(-1.5, -0.5, 0.3), np.random.default_rng(seed)
        turn_rate = 0.0
        for number in range(200):
            turn_rate = chance.uniform(-1.5, 1.5) if number % 4 == 0 else turn_rate
            pose = pose @ Pose(0.02, 0.0, turn_rate * PERIOD_S)
            pose = pose if abs(pose.x) < 2.0 and abs(pose.y) < 1.0 else Pose()
            assert not watch.take(sector_ranges(scan_in_room(pose, number)), PERIOD_S * number)


def test_publishers_that_the_wire_names_are_told_though_they_see_the_same() -> None:
    watch, view = scan_watch(), sector_ranges(scan_in_room(Pose()))
    found = [watch.take(view, PERIOD_S * n, ("/a/laser", "/b/laser")[n % 2]) for n in range(8)]
    assert found.index(True) < 6
    watch = scan_watch()
    assert not any(watch.take(view, PERIOD_S * n, "/a/laser" if n < 9 else "/b/laser") for n in range(18))


def test_readings_that_lie_far_apart_in_time_say_nothing() -> None:
    watch = scan_watch()
    views = [sector_ranges(scan_in_room(Pose(x), n)) for n, x in enumerate([0.0, 1.5] * 10)]
    assert not any(watch.take(view, 3.0 * number) for number, view in enumerate(views))


@pytest.mark.parametrize("turns", TURNS.values(), ids=TURNS)
@pytest.mark.parametrize("other", [Pose(0.0, 0.15), Pose(0.0, 0.0, 0.2), Pose(4.0, -2.0, 3.0)])
def test_odometry_of_two_robots_is_told_and_a_restart_of_one_is_not(turns: str, other: Pose) -> None:
    order = itertools.islice(itertools.cycle(turns), 3 * WATCHED_READINGS)
    found = told([Pose(0.006 * n) if who == "A" else other for n, who in enumerate(order)], odometry_watch())
    assert found.index(True) < 4 * len(turns) and all(found[found.index(True) :])
    restarted = [Pose(1.0 + 0.1 * n) for n in range(30)] + [Pose(0.1 * n) for n in range(30)]
    assert not any(told([*restarted, *restarted], odometry_watch()))


def test_a_base_that_shakes_is_one_base() -> None:
    chance, watch, pose = np.random.default_rng(3), odometry_watch(), Pose()
    for number in range(400):
        pose = pose @ Pose(0.04 * chance.random(), 0.0, chance.normal(0, 0.05))
        shaken = pose @ Pose(chance.normal(0, 0.01), chance.normal(0, 0.01), chance.normal(0, 0.02))
        assert not watch.take(shaken, 0.02 * number)


@pytest.mark.parametrize("sd_m", [0.1, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("rate_hz", [1, 5, 10])
def test_places_by_satellite_in_a_log_that_jump_about_are_of_one_robot(sd_m: float, rate_hz: int) -> None:
    for seed in range(5):
        times = np.arange(400) / rate_hz
        chance = np.random.default_rng(seed)
        places = np.column_stack([0.4 * times, 0 * times, 0 * times]) + chance.normal(0, sd_m, (400, 3)) * [1, 1, 0]
        assert odometry_turns(times, places) == 0.0


@pytest.mark.parametrize("turns", TURNS.values(), ids=TURNS)
def test_a_log_of_two_odometries_in_turns_is_told(turns: str) -> None:
    order = list(itertools.islice(itertools.cycle(turns), 400))
    places = np.array([(0.006 * n, 0.0, 0.0) if who == "A" else (4.0, -2.0, 3.0) for n, who in enumerate(order)])
    assert odometry_turns(0.1 * np.arange(400), places) == 1.0
