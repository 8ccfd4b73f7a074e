"""Scans and pictures that arrive 0.3 s after they were taken, while the robot turns to and fro."""

import math
from collections import deque
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from core.gate import Twist
from core.geometry import wrap
from core.pilot.landmark_perception import LandmarkPerception
from core.sensors import Image, Scan
from core.settings import Settings
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.slam.odometry import Odometry
from tests.core.slam.frame_slam import FrameSlam

LATE = 12  # frames of 25 ms
DRIVE = ((1.5, 0.0, 0.0), *(((0.4, 0.15, 1.2), (0.4, 0.0, -1.2)) * 4))  # [s], [m/s], [rad/s]


@dataclass
class Outcome:
    """How it went."""

    errors: list[float] = field(default_factory=list)
    headings: list[float] = field(default_factory=list)
    nees: list[float] = field(default_factory=list)
    confirmed: int = 0
    landmarks: int = 0


def drive(*, late_scans: int = 0, late_pictures: int = 0, camera: bool = False) -> Outcome:
    """The drive, scans and pictures handed over so many frames after they were taken."""
    robot = SimulatedRobot("lab", seed=3, settings=SimulationSettings(camera=camera))
    settings, outcome = Settings(), Outcome()
    odometry = Odometry(robot.profile.laser, settings.motion, settings.scan_odometry)
    eyes, slam = (
        LandmarkPerception(robot.profile, settings),
        FrameSlam(settings.ekf, settings.motion, robot.profile.laser),
    )
    scans: deque[Scan | None] = deque([None] * late_scans)
    pictures: deque[Image | None] = deque([None] * late_pictures)
    for seconds, speed, turn_rate in DRIVE:
        for _ in range(round(40 * seconds)):
            robot.drive(Twist(speed, turn_rate))
            frame = robot.read()
            scans.append(frame.scan)
            pictures.append(frame.image)
            frame = replace(frame, scan=scans.popleft(), image=pictures.popleft())
            look = eyes.look(frame, odometry.update(frame))
            estimate, truth = slam.update(frame, look.sightings), frame.truth
            assert truth is not None
            outcome.confirmed += sum(sighting.confirmed for sighting in look.sightings or ())
            outcome.errors.append(estimate.pose.distance_to(truth.x, truth.y))
            outcome.headings.append(abs(wrap(estimate.pose.heading - truth.heading)))
            if speed:
                outcome.nees.append(slam.nees(truth))
    outcome.landmarks = len(slam.landmarks)
    return outcome


def test_scans_that_come_late_while_turning_tell_the_same_within_noise() -> None:
    timely, late = drive(), drive(late_scans=LATE)
    assert max(late.errors) < max(timely.errors) + 0.01
    assert max(late.headings) < max(timely.headings) + math.radians(0.4)
    assert np.nanmean(late.nees) < 6.0
    assert late.landmarks == pytest.approx(timely.landmarks, abs=4)


@pytest.mark.campaign
def test_edges_that_come_late_while_turning_confirm_the_same_corners() -> None:
    timely, late = drive(camera=True), drive(late_pictures=LATE, camera=True)
    assert late.confirmed > 0.8 * timely.confirmed > 15
    assert max(late.errors) < max(timely.errors) + 0.01
