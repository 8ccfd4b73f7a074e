"""Jobs of the worker that connects to another robot to see what is there, or checks a robot file."""

from console.workers.job import Job
from core.recording import LogSettings
from core.robots.connection import FoundRobot
from core.robots.robot_file import RobotFile


class ProbeRobot(Job[FoundRobot], frozen=True):
    """Connect, listen for some seconds, let go; nothing is driven."""

    file: RobotFile  # with its URL
    restrained: bool = False  # a camera on the network sends pictures from the address that was named, or nothing


class CheckRecording(Job[None], frozen=True):
    """Read a recording whole, as its replay does."""

    path: str  # may end in #N
    settings: LogSettings


class CheckRobotFile(Job[str], frozen=True):
    """Write a robot file's text, read it back, and ask its drivers about their own entries → the text."""

    file: RobotFile
    comment: str
