"""Common part of the drivers of all ROS robots: speeds, the robot's lock, and goals for its own navigation."""

from __future__ import annotations

import contextlib
from abc import abstractmethod
from typing import cast

from core.errors import BadInput
from core.gate import Twist
from core.geometry import Pose
from core.robots.device import Device
from core.robots.findings import Findings
from core.robots.requests import (
    AnswerT,
    CancelGoal,
    OwnNavigation,
    ReadNavigation,
    Requests,
    RobotRequest,
    SendGoal,
)
from core.robots.ros.bridge import RosSensors, VelocityCommands
from core.robots.ros.navigation import RosNavigation
from core.robots.ros.topics import NOTHING, RosSettings, RosTopics
from core.robots.ros.typestore import RobotTypes


class RosDevice(Device):
    """A ROS robot behind any link. A link of its own kind says how messages are sent."""

    def __init__(self, settings: RosSettings) -> None:
        self.settings = settings
        self.types = RobotTypes()
        self.sensors: RosSensors | None = None
        self.topics: RosTopics | None = None  # as they were chosen at the first connection
        lock = self._send_lock if settings.lock not in ("", NOTHING) else None
        self._commands = VelocityCommands(self._send_twist, lock)

    def findings(self) -> Findings:
        """The robot's topics and what comes on them."""
        return Findings() if self.sensors is None else self.sensors.findings(self.settings)

    @property
    def requests(self) -> Requests:
        """Those for the robot's own navigation, where it has one."""
        navigation = self._navigation
        if navigation is None or not navigation.there:
            return ()
        return ReadNavigation, SendGoal, CancelGoal

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        """As of any device."""
        navigation = self._navigation
        if navigation is None:
            raise BadInput("This robot has no navigation of its own.")
        known_map = navigation.state().map_number
        asked: object = request
        if isinstance(asked, ReadNavigation):
            known_map = asked.known_map
        elif isinstance(asked, SendGoal):
            navigation.go(Pose(asked.x_m, asked.y_m, asked.heading_rad))
            self._commands.let_drive(True)
        elif isinstance(asked, CancelGoal):
            self._cancel_goal(navigation)
        else:
            raise BadInput("This robot takes no such request.")
        return cast(AnswerT, self._state(navigation, known_map))

    def drive(self, twist: Twist) -> None:
        """Send speeds, as often as this is called while they are not zero. Raises OSError when the link is lost.

        Two cannot steer: driving by hand or by command ends the goal of the robot's own navigation.
        """
        if self.topics is None or not self.topics.cmd_vel:
            return
        if twist.moves and self._navigation is not None and self._navigation.under_way:
            self._cancel_goal(self._navigation)
        self._commands.drive(twist)

    @property
    def _navigation(self) -> RosNavigation | None:
        return self.sensors.navigation if self.sensors is not None else None

    def _state(self, navigation: RosNavigation, known_map: int) -> OwnNavigation:
        state = navigation.state(known_map)
        if state.goal is None:
            self._commands.let_drive(False)
        return state

    def _cancel_goal(self, navigation: RosNavigation) -> None:
        navigation.cancel()
        with contextlib.suppress(OSError):  # without a link nothing is heard anyway; its loss shows elsewhere
            self._commands.stand()

    def _restart(self) -> None:
        """The link is up again: what moved when it was lost is to stand first."""
        if self._navigation is not None:
            self._navigation.restart()
        self._commands.let_drive(False)
        self._commands.restart()

    def _finish(self) -> None:
        """Stop, as far as the link still carries it."""
        if self._navigation is not None:
            self._navigation.cancel()
        with contextlib.suppress(OSError):
            self._commands.finish()

    @abstractmethod
    def _send_twist(self, twist: Twist) -> None:
        """Send speeds. Raises OSError when the link is lost."""

    @abstractmethod
    def _send_lock(self, closed: bool) -> None:
        """Send the lock of the robot's twist_mux. Raises OSError when the link is lost."""

    @abstractmethod
    def _send_goal(self, frame: str, goal: Pose) -> None:
        """Send a goal for the robot's own navigation. Raises OSError when the link is lost."""
