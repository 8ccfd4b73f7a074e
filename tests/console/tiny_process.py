"""The tiny robot in its process, as a console has it."""

from __future__ import annotations

from console.robot.process import RobotProcess
from tests.console import tiny_robot


class TinyProcess(RobotProcess):
    """Knows the scheme `tiny:` beside the others."""

    driver_module = tiny_robot.__name__
