"""The state says how far the position by laser alone lies from the estimate."""

import math
from dataclasses import replace

from console.state_view import by_laser
from core.geometry import Pose
from core.pilot import Pilot
from core.settings import ChapterSettings, Settings
from core.simulation.robot import SimulatedRobot


def test_distance_and_turn_of_the_reference_are_those_between_the_two_poses() -> None:
    robot = SimulatedRobot("lab", seed=3)
    compared = replace(Settings(), chapter=ChapterSettings(laser_reference=True))
    snapshot = Pilot(robot.profile, compared).step(robot.read())
    assert snapshot.by_laser is not None
    other = replace(snapshot.by_laser, pose=Pose(0.3, -0.4, math.pi - 0.1))
    apart = replace(snapshot, estimate=replace(snapshot.estimate, pose=Pose(0, 0, 0.1 - math.pi)), by_laser=other)
    told = by_laser(apart)
    assert told is not None
    assert (told.distance_m, told.turn_rad) == (0.5, -0.2)
    assert told.pose.x_m == 0.3
    assert by_laser(replace(snapshot, by_laser=None)) is None
