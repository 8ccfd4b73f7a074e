"""The template of a driver of one's own, which simulates itself until its TODOs are done, and of its test."""

import importlib.util
import re

from core.errors import BadInput

DRIVER = '''"""Driver of NAME, py:NAME.py:ARGUMENTS. It simulates a room until the TODOs are done."""

import threading

import numpy as np
from core.robots.driver import ZERO, Base, Device, Equipment, Laser, Pose, Readings, Scan, Twist, arc


class Driver(Device):
    def __init__(self, arguments: str = "") -> None:  # TODO: the arguments may be a port or an address
        self.over, self.twist, self.pose = threading.Event(), ZERO, Pose()

    def open(self) -> Equipment:  # TODO: connect; raise OSError while the robot cannot be reached
        self.over.clear()
        self.twist = ZERO
        laser = Laser(beams=360, angle_min=-np.pi, angle_step=np.pi / 180, rate=10.0)
        return Equipment(name="NAME", base=Base(wheelbase=0.16, radius=0.1, max_speed=0.3), lasers=(laser,))

    def run(self, readings: Readings) -> None:  # TODO: read until the link is lost, then return or raise OSError
        now = scanned = readings.now()
        while not self.over.wait(0.02):
            now, lasted = readings.now(), readings.now() - now
            self.pose = self.pose @ arc(self.twist.v * lasted, self.twist.w * lasted)
            readings.wheels(self.pose, self.twist.v, self.twist.w)  # odometry, speeds now [m/s], [rad/s]
            if now >= scanned + 0.1:
                scanned, angles = max(scanned + 0.1, now - 0.05), self.pose.heading + np.radians(np.arange(-180, 180))
                beams = np.column_stack((np.cos(angles), np.sin(angles)))  # to the walls of a room of 6 m by 4 m
                walls = ([3.0, 2.0] - np.sign(beams) * [self.pose.x, self.pose.y]) / (np.abs(beams) + 1e-9)
                ranges = walls.min(1) + np.random.normal(0.0, 0.01, 360)  # [m], right to left
                readings.scan(Scan(stamp=now, ranges=ranges, angle_min=-np.pi, angle_step=np.pi / 180))

    def drive(self, twist: Twist) -> None:  # TODO: send the speeds to the robot; called 40 times a second
        self.twist = twist

    def close(self) -> None:  # TODO: close the link, so that `run` returns
        self.over.set()
'''
TEST = '''"""The driver of NAME passes every check. The robot moves at 2 cm/s for about a second, twice."""

from pathlib import Path

import pytest

try:
    from core.robots.driver import check_robot
except ImportError:
    import core

    where = f"{core.__name__} of {list(core.__path__)}"
    pytest.exit(f"{where} hides Beckon's own package core: give the folder another name, or run this test elsewhere.")


def test_the_driver_passes_every_check() -> None:
    report = check_robot(f"py:{Path(__file__).with_name('NAME.py')}:", drive=True)
    assert [f"{check.name}: {check.advice}" for check in report.checks if not check.passed] == []
'''
NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")


def check_name(name: str) -> None:
    """Raise BadInput for a name that no driver can have."""
    if not NAME.fullmatch(name):
        raise BadInput("A driver's name has small letters, digits and underscores only, such as my_robot.")
    if importlib.util.find_spec(name) is not None:
        raise BadInput(f"{name} is the name of another Python module; choose another one, such as {name}_robot.")


def sources(name: str) -> dict[str, str]:
    """Name of a file → its text, of the driver and of its test."""
    return {f"{name}.py": DRIVER.replace("NAME", name), f"test_{name}.py": TEST.replace("NAME", name)}
