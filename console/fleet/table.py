"""The state of the robots as the fleet knows it: the newest report of each, whether it is there, and who needs help.

Pure logic on the time that is passed in [s]. A robot is never dropped: what is old is shown with its age.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, get_args

from console.fleet.bus import RobotReport

STALE_AGE_S = 1.5  # of the newest report of a robot whose token is there
RETURN_TIME_S = 5.0  # after a start of the router in which its robots are not gone yet
LOW_BATTERY = 0.2

Presence = Literal["live", "stale", "gone"]
Need = Literal["unanswered", "gone", "stale", "robot", "lost", "halted", "error", "blocked", "battery", ""]
"""The more urgent ones first."""
UNSEEN_RANK, IDLE_RANK, WORKING_RANK = 99, 98, 97


@dataclass
class FleetRobot:
    name: str
    report: RobotReport | None = None  # None: it has not said anything since this fleet runs
    heard_at: float = 0.0  # [s] when the report came
    alive: bool = False  # its token is there
    link: Presence = "gone"
    since: float = 0.0  # [s] when the link became so
    unanswered: bool = False  # a stop of all has no answer of it

    def presence(self, now: float, returns_until: float) -> Presence:
        if self.alive:
            return "live" if self.report is not None and now - self.heard_at <= STALE_AGE_S else "stale"
        return "stale" if self.report is not None and now < returns_until else "gone"

    @property
    def need(self) -> Need:
        """Why it needs help; "" when it does not."""
        report = self.report
        if self.unanswered:
            return "unanswered"
        if report is None:
            return ""
        reasons: tuple[tuple[bool, Need], ...] = (
            (self.link == "gone", "gone"),
            (self.link == "stale", "stale"),
            (report.robot_link in ("stale", "lost"), "robot"),
            (report.lost, "lost"),
            (report.gate == "halted", "halted"),
            (report.notice is not None and report.notice.level == "error", "error"),
            (bool(report.gate_reason) and report.command is not None and not report.speed_m_s, "blocked"),
            (report.battery is not None and report.battery < LOW_BATTERY, "battery"),
        )
        for holds, need in reasons:
            if holds:
                return need
        return ""

    @property
    def rank(self) -> int:
        """The place in the order: need of help, work, idleness, never there."""
        if self.need:
            return get_args(Need).index(self.need)
        if self.report is None:
            return UNSEEN_RANK
        return WORKING_RANK if self.report.command is not None or self.report.operator is not None else IDLE_RANK


class FleetTable:
    def __init__(self) -> None:
        self.robots: dict[str, FleetRobot] = {}
        self._returns_until = 0.0

    def know(self, names: Iterable[str], now: float) -> None:
        """These robots have a certificate; others are forgotten."""
        self.robots = {name: self.robots.get(name) or FleetRobot(name, since=now) for name in names}

    def restarted(self, now: float) -> None:
        """The router restarts: nobody is there yet, and all may come back."""
        self._returns_until = now + RETURN_TIME_S
        for robot in self.robots.values():
            robot.alive = False
        self.tick(now)

    def came(self, name: str, now: float) -> None:
        """A robot's token is there."""
        self._set_alive(name, now, alive=True)

    def went(self, name: str, now: float) -> None:
        """A robot's token is gone: it ended, or was silent for a lease."""
        self._set_alive(name, now, alive=False)

    def hear(self, name: str, report: RobotReport, now: float) -> None:
        if (robot := self.robots.get(name)) is not None:
            robot.report, robot.heard_at = report, now
            self._settle(robot, now)

    def tick(self, now: float) -> None:
        for robot in self.robots.values():
            self._settle(robot, now)

    def sorted(self) -> list[FleetRobot]:
        """All of them, who needs help first."""
        return sorted(self.robots.values(), key=lambda robot: (robot.rank, robot.name.casefold()))

    def _set_alive(self, name: str, now: float, *, alive: bool) -> None:
        if (robot := self.robots.get(name)) is not None:
            robot.alive = alive
            self._settle(robot, now)

    def _settle(self, robot: FleetRobot, now: float) -> None:
        link = robot.presence(now, self._returns_until)
        if link != robot.link:
            robot.link, robot.since = link, now
