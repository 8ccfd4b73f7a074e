"""The position by laser and wheels alone, beside the one by all senses."""

from dataclasses import replace

from core.gate import Twist
from core.pilot import Pilot
from core.settings import ChapterSettings, Settings
from core.simulation.robot import SimulatedRobot

COMPARED = replace(Settings(), chapter=ChapterSettings(laser_reference=True))


def test_the_reference_is_what_a_robot_without_a_camera_believes_and_steers_nothing() -> None:
    robot = SimulatedRobot("corridor", seed=20)
    both, plain = Pilot(robot.profile, COMPARED), Pilot(robot.profile)
    blind = Pilot(replace(robot.profile, cameras=(), arrays=()))
    distances: list[float] = []
    for _ in range(200):
        frame = robot.read()
        robot.drive(Twist(0.25 if frame.stamp > 2.0 else 0.0, 0.0))
        snapshot, alone = both.step(frame), blind.step(replace(frame, image=None, sound=None))
        reference = snapshot.by_laser
        assert reference is not None
        assert reference.pose == alone.estimate.pose
        assert snapshot.estimate.pose == plain.step(frame).estimate.pose
        distances.append(snapshot.estimate.pose.distance_to(reference.pose.x, reference.pose.y))
    assert max(distances) > 0.005  # where only the camera sees how far it is along the corridor


def test_the_reference_moves_with_the_map_and_goes_on_in_one_that_is_loaded() -> None:
    robot = SimulatedRobot("lab", seed=3)
    pilot = Pilot(robot.profile, COMPARED)
    for _ in range(60):
        pilot.step(robot.read())
    pilot.turn_map(0.5)
    turned = pilot.step(robot.read())
    assert turned.by_laser is not None
    assert abs(turned.by_laser.pose.heading - turned.estimate.pose.heading) < 0.02
    other = Pilot(robot.profile, COMPARED)
    other.enter_map(pilot.keep_map())
    for _ in range(99):
        other.step(robot.read())
    loaded = other.step(robot.read())
    assert loaded.by_laser is not None
    assert loaded.by_laser.pose.distance_to(loaded.estimate.pose.x, loaded.estimate.pose.y) < 0.05
    assert abs(loaded.by_laser.pose.heading - 0.5) < 0.05


def test_without_a_laser_or_unasked_there_is_none() -> None:
    robot = SimulatedRobot("lab", seed=3)
    frame = robot.read()
    assert Pilot(robot.profile).step(frame).by_laser is None
    without = Pilot(replace(robot.profile, lasers=()), COMPARED)
    assert without.step(replace(frame, scan=None)).by_laser is None
    assert Pilot(robot.profile, COMPARED).step(frame).by_laser is not None
