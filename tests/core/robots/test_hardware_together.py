"""A base, a laser and a camera on wires of their own are one robot in one world."""

import numpy as np

from core.gate import ZERO, Twist
from core.robots.live import LiveRobot
from core.robots.scip import open_device as open_scip
from core.robots.serial_base import open_device as open_serial
from core.robots.srv1 import open_device as open_srv1
from core.sensors import SensorFrame
from tests.core.robots.links import frames, no_leak, shape
from tests.emulators.scip import ScipEmulator
from tests.emulators.serial_base import SerialRobot
from tests.emulators.srv1 import Srv1Emulator
from tests.emulators.world import World


def walls_ahead(read: list[SensorFrame]) -> list[float]:
    """The laser's range straight ahead, scan by scan [m]."""
    scans = [frame.scan for frame in read if frame.scan is not None]
    return [float(np.nanmedian(scan.ranges[np.abs(scan.angles) < 0.02])) for scan in scans]


def test_a_serial_base_and_a_hokuyo_drive_and_see() -> None:
    world = World()
    base, laser = SerialRobot(world), ScipEmulator()
    world.on_scan.append(laser.show_scan)
    for part in (base, laser, world):
        part.start()
    devices = [
        ("the base", open_serial(base.url.removeprefix("serial:"))),
        ("the laser", open_scip(laser.url.removeprefix("scip:"))),
    ]
    with no_leak():
        robot = LiveRobot(devices, shape)
        before = walls_ahead(frames(robot, 0.6, ZERO))
        frames(robot, 2.0, Twist(0.2, 0.0))
        rested = frames(robot, 1.0, ZERO)
        robot.close()
    rolled = [frame.wheels.odometry.x for frame in rested if frame.wheels is not None][-1]
    nearer = before[-1] - walls_ahead(rested)[-1]
    for part in (world, laser, base):
        part.stop()
    assert rolled > 0.3 and abs(rolled - world.truth.x) < 0.03
    assert abs(nearer - rolled) < 0.15
    assert robot.profile.laser is not None and robot.profile.laser.beams == 682


def test_an_srv1_and_a_hokuyo_drive_and_see() -> None:
    world = World(failsafe=None)
    base, laser = Srv1Emulator(world), ScipEmulator()
    world.on_scan.append(laser.show_scan)
    for part in (base, laser, world):
        part.start()
    devices = [
        ("the robot", open_srv1(base.url.removeprefix("srv1:"))),
        ("the laser", open_scip(laser.url.removeprefix("scip:"))),
    ]
    robot = LiveRobot(devices, shape)
    frames(robot, 0.3, ZERO)
    read = frames(robot, 2.0, Twist(0.0, 0.5))
    robot.close()
    for part in (world, laser, base):
        part.stop()
    not_turned = 0.5 * world.left_out  # [rad] on a busy machine
    assert 0.7 - not_turned < world.truth.heading < 1.25
    assert sum(frame.scan is not None for frame in read) >= 14
    assert sum(frame.image is not None for frame in read) >= 8
