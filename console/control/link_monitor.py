"""Link monitor, a watchdog: notices when the robot's link or the pilot falls silent, and when it is back."""

from console.control.dispatcher import CommandDispatcher
from console.control.notices import Notifications
from console.robot.supervisor import RobotSupervisor
from core.sentences import Statement

HANGS = Statement("pilot.hangs")


class LinkMonitor:
    """Tells the dispatcher and the notice board, once each time."""

    def __init__(self, robot: RobotSupervisor, dispatcher: CommandDispatcher, notifications: Notifications) -> None:
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
            self._dispatcher.ended_without_pilot(Statement("pilot.hung"))
            self._notifications.tell("error", HANGS, "pilot")
        elif before and not hangs:
            self._notifications.tell("info", Statement("pilot.goes_on"), "pilot")
        return hangs

    def _look_at_link(self) -> bool:
        before, (self._link, _) = self._link, self._robot.link()
        if self._link == "lost" != before:
            self._dispatcher.ended_without_pilot(Statement("robot.link_was_lost"))
            self._notifications.tell("error", self._robot.trouble or Statement("robot.link_lost"), "link")
        elif self._link == "live" and before == "lost":
            self._notifications.tell("info", Statement("robot.back"), "link")
        return self._link == "lost"
