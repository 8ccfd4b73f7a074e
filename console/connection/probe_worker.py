"""The worker that connects to a robot to see what is there: a driver that hangs or breaks is killed with it."""

from __future__ import annotations

import time

from console.connection.probe_jobs import CheckedFile, CheckRobotFile, ProbeRobot
from console.workers.job import Handler
from core.robots.connect import devices_of, live
from core.robots.connection import FoundRobot, ReadConnection
from core.robots.robot_file import parse_robot_file
from core.robots.robot_file_text import toml_text

LISTENING = 2.0  # [s], over which the rates are measured
NAME = "The robot file"


class ProbeWorker:
    """Remembers nothing from job to job."""

    @property
    def handlers(self) -> tuple[Handler, ...]:
        """Every job it knows."""
        return ProbeRobot.handled_by(self.probe), CheckRobotFile.handled_by(self.check)

    def probe(self, job: ProbeRobot) -> FoundRobot:
        """Return the findings on the robot. Raises BadInput, Unavailable."""
        robot = live(job.file.url, job.file)
        try:
            time.sleep(LISTENING)
            return robot.ask(ReadConnection())
        finally:
            robot.close()

    def check(self, job: CheckRobotFile) -> CheckedFile:
        """The text as it may be written. Raises BadInput, Unavailable."""
        text = toml_text(job.file, job.comment)
        read = parse_robot_file(text, NAME)
        devices_of(read.url, read)
        return CheckedFile(text)
