"""The tiny robot in its process, as a console has it."""

from console.robot.supervisor import RobotSupervisor
from tests.console import tiny_robot


class TinyProcess(RobotSupervisor):
    """Knows the scheme `tiny:` beside the others."""

    driver_module = tiny_robot.__name__
