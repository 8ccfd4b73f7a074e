"""Link monitor, a watchdog: notices when the robot's link or the pilot falls silent, and when it is back."""

from __future__ import annotations

from console.control.dispatcher import CommandDispatcher
from console.control.notices import Notifications
from console.robot.link import RobotLink

HANGS = "The pilot does not go on; the robot stands. Restart the console if it stays like this."


class LinkMonitor:
    """Tells the dispatcher and the notice board, once each time."""

    def __init__(self, robot: RobotLink, dispatcher: CommandDispatcher, notifications: Notifications) -> None:
        self._robot = robot
        self._dispatcher = dispatcher
        self._notifications = notifications
        self._link = ""
        self._hangs = False

    def look(self, *, hangs: bool) -> bool:
        """`hangs`: whether the pilot does not go on. → Whether nothing can be under way now."""
        return self._look_at_pilot(hangs) | self._look_at_link()

    def _look_at_pilot(self, hangs: bool) -> bool:
        before, self._hangs = self._hangs, hangs
        if hangs and not before:
            self._dispatcher.setpoint_sender.stop()
            self._dispatcher.ended_without_pilot("The pilot did not go on; the robot was stopped.")
            self._notifications.tell("error", HANGS, "pilot")
        elif before and not hangs:
            self._notifications.tell("info", "The pilot goes on. The robot moves only on a new command.", "pilot")
        return hangs

    def _look_at_link(self) -> bool:
        before, (self._link, _) = self._link, self._robot.link()
        if self._link == "lost" != before:
            self._dispatcher.ended_without_pilot("The robot's link was lost.")
            why = self._robot.trouble or "The robot's link is lost; the robot stops by itself."
            self._notifications.tell("error", why, "link")
        elif self._link == "live" and before == "lost":
            self._notifications.tell("info", "The robot is back. It moves only on a new command.", "link")
        return self._link == "lost"
