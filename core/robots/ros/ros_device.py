"""Common part of the drivers of all ROS robots: speeds, the robot's lock, and goals for its own navigation."""

import contextlib
import time
from abc import abstractmethod
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, cast

from msgspec.structs import replace as replace_struct

from core.errors import BadInput, Unavailable
from core.gate import Twist
from core.geometry import Pose
from core.robots.device import Device, Findings
from core.robots.requests import (
    AnswerT,
    CancelGoal,
    ReadNavigation,
    Requests,
    RobotRequest,
    SendGoal,
    SentSpeeds,
    SpeedsType,
    SwitchSpeeds,
)
from core.robots.ros.bridge import RosSensors, UnmovedBase, VelocityCommands
from core.robots.ros.navigation import RosNavigation
from core.robots.ros.topics import NOTHING, RosSettings, RosTopics
from core.robots.ros.typestore import BOOL, GOAL, TWIST, TWIST_STAMPED, RobotTypes
from core.sensors.checks import Fault, fault

TIMEOUT = "cmd_vel_timeout"  # parameter of the robot's controller: after how long a silence the base stops
MAX_TIMEOUT_S = 60.0
SENT_AS: dict[SpeedsType, str] = {"Twist": TWIST, "TwistStamped": TWIST_STAMPED}


def stopping(values: Iterable[object]) -> float | None:
    """Values of `cmd_vel_timeout` [s] → the worst of them: 0, which is never, else the longest; None: no value."""
    usable = [
        float(value)
        for value in values
        if isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < MAX_TIMEOUT_S
    ]
    return 0.0 if 0.0 in usable else max(usable, default=None)


class RosDevice(Device):
    """A ROS robot behind any link. A link of its own kind says how messages are sent."""

    def __init__(self, settings: RosSettings) -> None:
        self.settings = settings
        self.types = RobotTypes()
        self.sensors: RosSensors | None = None
        self.topics: RosTopics | None = None  # as they were chosen at the first connection
        lock = self._send_lock if settings.lock not in ("", NOTHING) else None
        self._unmoved = UnmovedBase()
        self._doubt: Fault | None = None  # whether it takes the type of the speeds
        self._switched = False  # since zero was asked for the last time
        self._commands = VelocityCommands(self._send_twist, lock)

    def findings(self) -> Findings:
        """The robot's topics and what comes on them."""
        if self.sensors is None:
            return Findings()
        found, doubt = self.sensors.findings(self.settings), self._doubt
        return replace_struct(found, faults=(*found.faults, doubt)) if doubt is not None else found

    @property
    def requests(self) -> Requests:
        """Those for the robot's own navigation, where it has one; to switch the type of its speeds, where guessed."""
        navigation = self._navigation
        own = (ReadNavigation, SendGoal, CancelGoal) if navigation is not None and navigation.there else ()
        return (*own, SwitchSpeeds) if self.topics is not None and self.topics.guessed else own

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        """As of any device."""
        asked: object = request
        if isinstance(asked, SwitchSpeeds):
            return cast(AnswerT, self._switch(asked.type))
        navigation = self._navigation
        if navigation is None:
            raise BadInput("This robot has no navigation of its own.")
        known_map = navigation.state().map_number
        if isinstance(asked, ReadNavigation):
            known_map = asked.known_map
        elif isinstance(asked, SendGoal):
            navigation.go(Pose(asked.x_m, asked.y_m, asked.heading_rad))
            self._commands.let_drive(True)
        elif isinstance(asked, CancelGoal):
            self._cancel_goal(navigation)
        else:
            raise BadInput("This robot takes no such request.")
        state = navigation.state(known_map)
        if state.goal is None:
            self._commands.let_drive(False)
        return cast(AnswerT, state)

    def drive(self, twist: Twist) -> None:
        """Send speeds, as often as this is called while they are not zero. Raises OSError when the link is lost.

        Two cannot steer: driving by hand or by command ends the goal of the robot's own navigation.
        """
        if self.topics is None or not self.topics.cmd_vel:
            return
        if twist.moves and self._navigation is not None and self._navigation.under_way:
            self._cancel_goal(self._navigation)
        if self._switched and twist.moves:
            return
        self._switched = False
        self._commands.drive(twist)
        if self.topics.guessed:
            self._watch(twist)

    def _watch(self, twist: Twist) -> None:
        """Doubt the guessed type of the speeds as long as the base has not moved by them."""
        if self.sensors is None or self.topics is None:
            return
        if self._unmoved.watch(twist, self.sensors.place, time.monotonic()):
            sent, other = "Twist", "TwistStamped"
            if self.topics.cmd_vel_type == TWIST_STAMPED:
                sent, other = other, sent
            self._doubt = fault("speeds.type_guessed", self.topics.cmd_vel, used=True, sent=sent, other=other)
            self.sensors.doubt(self._doubt)
        elif self._unmoved.moved:
            self._doubt = None

    def _switch(self, name: SpeedsType) -> SentSpeeds:
        """Send speeds as another type from now on; nothing moves by it before zero was asked for."""
        if self.topics is None or self.sensors is None:
            raise Unavailable("The robot is not connected.")
        if self.topics.cmd_vel_type != SENT_AS[name]:
            with contextlib.suppress(OSError):
                self._commands.finish()
            self.topics = self.sensors.topics = replace(self.topics, cmd_vel_type=SENT_AS[name])
            self._unmoved, self._doubt, self._switched = UnmovedBase(), None, True
            with contextlib.suppress(OSError):  # a link that is lost gets the new type when it is back
                self._advertise_speeds(self.topics)
        return SentSpeeds(name)

    @property
    def _navigation(self) -> RosNavigation | None:
        return self.sensors.navigation if self.sensors is not None else None

    def _cancel_goal(self, navigation: RosNavigation) -> None:
        navigation.cancel()
        with contextlib.suppress(OSError):  # without a link nothing is heard anyway; its loss shows elsewhere
            self._commands.stand()

    def _restart(self) -> None:
        """The link is up again: what moved when it was lost is to stand first."""
        if self._navigation is not None:
            self._navigation.cancel()
        self._commands.let_drive(False)
        self._commands.restart()

    def _finish(self) -> None:
        if self._navigation is not None:
            self._navigation.cancel()
        with contextlib.suppress(OSError):
            self._commands.finish()

    @abstractmethod
    def _advertise_speeds(self, topics: RosTopics) -> None:
        """Say that speeds will come as another type. Raises OSError when the link is lost."""

    @abstractmethod
    def _publish(self, topic: str, kind: str, content: Any) -> None:
        """Send a message of this type, where the link is up to the topic. Raises OSError when it is lost."""

    def _send_twist(self, twist: Twist) -> None:
        if self.topics is not None:
            kind = self.topics.cmd_vel_type
            self._publish(self.topics.cmd_vel, kind, self.types.speeds(kind, twist, self.topics.base_frame))

    def _send_lock(self, closed: bool) -> None:
        if self.topics is not None and self.topics.lock:
            self._publish(self.topics.lock, BOOL, self.types.flag(closed))

    def _send_goal(self, frame: str, goal: Pose) -> None:
        if self.topics is not None:
            self._publish(self.topics.goal, GOAL, self.types.goal(frame, goal))
