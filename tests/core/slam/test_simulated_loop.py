"""The whole way from scans and pictures to a pose, on the simulated robot."""

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from core.gate import Twist
from core.geometry import wrap
from core.perception.landmarks.corners import find_corners
from core.perception.landmarks.deskew import deskew
from core.perception.landmarks.edges import find_edges
from core.perception.landmarks.landmarks import sight
from core.simulation.robot import SimulatedRobot
from core.simulation.settings import SimulationSettings
from core.slam.dead_reckoning import DeadReckoning
from core.slam.motion import MotionSettings, WheelTrack
from tests.core.slam.frame_slam import FrameSlam

QUARTER = (math.pi / 2 / 0.6, 0.0, 0.6)
LOOP = (
    (1.5, 0.0, 0.0),
    (12.0, 0.15, 0.0),
    QUARTER,
    (7.0, 0.15, 0.0),
    QUARTER,
    (16.0, 0.15, 0.0),
    QUARTER,
    (7.0, 0.15, 0.0),
    QUARTER,
)


@dataclass
class Outcome:
    errors: list[float] = field(default_factory=list)
    headings: list[float] = field(default_factory=list)
    reckoned: list[float] = field(default_factory=list)
    nees: list[float] = field(default_factory=list)
    confirmed: int = 0
    landmarks: int = 0


def drive(
    settings: SimulationSettings, seed: int, motion: MotionSettings | None = None, legs: int | None = None
) -> Outcome:
    """The loop in the laboratory, driven by the clock, or its first legs."""
    robot = SimulatedRobot("lab", seed=seed, settings=settings)
    laser, camera = robot.profile.laser, robot.profile.camera
    assert laser is not None
    slam, reckoning, track = FrameSlam(motion=motion, laser=laser), DeadReckoning(), WheelTrack(motion)
    edges, edges_stamp, outcome = (), 0.0, Outcome()
    for seconds, v, w in LOOP[:legs]:
        for _ in range(round(40 * seconds)):
            robot.drive(Twist(v, w))
            frame, sightings = robot.read(), None
            if frame.image is not None and camera is not None:
                edges, edges_stamp = find_edges(frame.image, camera), frame.image.stamp
            if frame.scan is not None:
                corners = find_corners(frame.scan, laser, *deskew(frame.scan, laser, frame.wheels, frame.stamp))
                sightings, edges = sight(
                    corners, edges, stamp=frame.stamp, edges_stamp=edges_stamp, wheels=frame.wheels, camera=camera
                )
                outcome.confirmed += sum(sighting.confirmed for sighting in sightings)
            pose, truth = slam.update(frame, sightings).pose, frame.truth
            assert truth is not None
            outcome.errors.append(pose.distance_to(truth.x, truth.y))
            outcome.headings.append(abs(wrap(pose.heading - truth.heading)))
            outcome.reckoned.append(
                reckoning.update(track.step(frame.stamp, frame.wheels)).pose.distance_to(truth.x, truth.y)
            )
            if v or w:
                outcome.nees.append(slam.nees(truth))
    outcome.landmarks = len(slam.landmarks)
    return outcome


def test_the_laboratory_is_mapped_to_a_centimetre_and_the_filter_knows_it() -> None:
    runs = [drive(SimulationSettings(camera=False), seed) for seed in (1,)]
    errors = np.concatenate([run.errors for run in runs])
    assert errors.max() < 0.03
    assert errors.mean() < 0.2 * np.mean([run.reckoned for run in runs])
    assert max(max(run.headings) for run in runs) < math.radians(1.0)
    assert 1.0 < np.nanmean([run.nees for run in runs]) < 6.0
    assert all(15 < run.landmarks < 60 for run in runs)


@pytest.mark.campaign
def test_with_the_paper_s_wheel_noise_the_loop_is_held_too() -> None:
    motion = MotionSettings(model="paper")
    run = drive(SimulationSettings(camera=False, wheel_noise="paper"), 1, motion)
    assert np.mean(run.errors) < 0.02
    assert max(run.errors) < 0.06
    assert np.mean(run.errors) < 0.3 * np.mean(run.reckoned)
    assert 1.0 < np.nanmean(run.nees) < 6.0


@pytest.mark.campaign
@pytest.mark.parametrize(("legs", "confirmed"), [(3, 50), (5, 100)], ids=["begun", "half"])
def test_vertical_edges_in_real_pictures_confirm_corners_and_harm_nothing(legs: int, confirmed: int) -> None:
    run = drive(SimulationSettings(camera=True), 1, legs=legs)
    assert run.confirmed > confirmed
    assert max(run.errors) < 0.03
    assert 1.0 < np.nanmean(run.nees) < 6.0
