"""A link that stalls now and then and delivers everything afterwards, each reading with its own stamp."""

import math
from collections import deque

import numpy as np
import pytest

from core.gate import Twist
from core.geometry import Pose, wrap
from core.pilot import Pilot
from core.robots.readings import Readings
from core.sensors import SensorFrame, Wheels
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.snapshot import Snapshot
from tests.benchmarks.time_offset import turns

STALLS = ((1.6, 1.9), (3.1, 3.4), (5.3, 5.6))  # [s]: two of them within a turn


def driven_over_a_stalling_link(*, odometry: bool) -> list[tuple[SensorFrame, Snapshot]]:
    """Two turns: what the robot sensed, and what the pilot made of what had arrived by then."""
    robot = SimulatedRobot("lab", seed=1, settings=SimulationSettings(camera=False))
    now, waiting = 0.0, deque[SensorFrame]()
    readings, pilot = Readings(lambda: now), Pilot(robot.profile)
    seen: list[tuple[SensorFrame, Snapshot]] = []
    for seconds, speed, turn_rate in turns(0.8)["90+90"]:
        for _ in range(round(seconds * robot.profile.rate)):
            robot.drive(Twist(speed, turn_rate))
            sensed = robot.read()
            now = sensed.stamp
            waiting.append(sensed)
            while waiting and not any(begin < now < end for begin, end in STALLS):
                hand_on(waiting.popleft(), readings, odometry=odometry)
            seen.append((sensed, pilot.step(readings.frame())))
    return seen


def hand_on(sensed: SensorFrame, readings: Readings, *, odometry: bool) -> None:
    wheels = sensed.wheels
    assert wheels is not None
    if odometry:
        readings.wheels(wheels.odometry, wheels.speed, wheels.turn_rate, sensed.stamp)
    if sensed.scan is not None:
        readings.scan(sensed.scan)


def heading_errors(seen: list[tuple[SensorFrame, Snapshot]]) -> list[float]:
    """[rad] of every frame."""
    truths = [(sensed.truth, now.estimate.pose) for sensed, now in seen]
    return [abs(wrap(pose.heading - truth.heading)) for truth, pose in truths if truth is not None]


def test_stalls_within_turns_bend_neither_the_heading_nor_the_laser_s_stamps() -> None:
    seen = driven_over_a_stalling_link(odometry=True)
    assert max(heading_errors(seen)) < math.radians(3)
    timings = [timing for _, now in seen for timing in now.timings]
    assert timings and not any(timing.applied for timing in timings)


def test_stalls_leave_scan_odometry_where_it_is() -> None:
    seen = driven_over_a_stalling_link(odometry=False)
    errors = heading_errors(seen)
    assert max(errors[-20:]) < math.radians(1)
    assert np.median(errors) < math.radians(2)
    assert not any(now.floor.lost for _, now in seen)


def test_a_reading_that_was_carried_on_is_known_as_it_was_read() -> None:
    read = Wheels(odometry=Pose(1.0, 2.0, 0.5), speed=0.2, turn_rate=0.8)
    carried = read.carried(0.3)
    assert carried.age == pytest.approx(0.3)
    assert carried.odometry.heading == pytest.approx(0.5 + 0.24)
    assert carried.as_read.vector == pytest.approx(read.odometry.vector)
