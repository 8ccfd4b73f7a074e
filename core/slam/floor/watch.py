"""Watching that the robot is where it believes to be, and looking for its place when it is not."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.sensors import Laser
from core.slam.estimate import SlamHealth
from core.slam.floor.alarm import Alarm, AlarmSettings, Signs, Walls
from core.slam.floor.chart import View
from core.slam.floor.health import Lost
from core.slam.floor.lost import Click, Finding, Found, LostSettings
from core.slam.floor.tracker import Tracker
from core.slam.occupancy import Grid

SETTLED = 3.0  # [s] after waking or being found in which nothing is suspected: the map is only just there


@dataclass(frozen=True)
class WatchSettings:
    """When the robot counts as lost, and how its place is found."""

    alarm: AlarmSettings = field(default_factory=AlarmSettings)
    lost: LostSettings = field(default_factory=LostSettings)


class Watch:
    """Between the robot's own confidence and the search for its place."""

    def __init__(self, laser: Laser | None, settings: WatchSettings, watched: bool) -> None:
        self._mounting = laser.mounting if laser else Pose()
        self._settings, self._watched = settings, watched
        self._alarm, self._walls = Alarm(settings.alarm), Walls()
        self._finding: Finding | None = None
        self._odometry = Pose()  # adds up the wheels' moves while the robot is lost
        self._since: float | None = None
        self.words = ""  # told when the robot was found

    @property
    def lost(self) -> bool:
        """Whether the robot's place is being looked for."""
        return self._finding is not None

    @property
    def doubtful(self) -> bool:
        """Whether nothing should be written to the map."""
        return self.lost or bool(self._alarm.doubt)

    @property
    def told(self) -> Lost | None:
        """What the operator should know."""
        return self._finding.lost if self._finding else None

    @property
    def turn(self) -> float:
        """How fast [rad/s] the robot should turn on the spot for another look; 0 while its place is known."""
        return self._finding.turn if self._finding else 0.0

    def needs(self, stamp: float) -> bool:
        """Whether a scan at this time is to be judged."""
        self._since = stamp if self._since is None or stamp < self._since else self._since
        return self._watched and not self.lost and stamp > self._since + SETTLED

    def heed(
        self, stamp: float, tracker: Tracker, wheels: Pose, health: SlamHealth, points: Array, grid: Grid, pose: Pose
    ) -> None:
        """One scan: how it lies on the views around, and its points (M, 2) [m], robot frame, on the map."""
        signs = Signs(
            stamp=stamp,
            match=tracker.score,
            agreement=self._walls.agreement(grid, pose.apply(points)),
            nis=health.nis,
            unmatched=health.ignored / max(1, health.ignored + health.matched),
            wheels=wheels,
            scans=tracker.seen,
        )
        if self._alarm.heed(signs):
            self.begin(stamp, self._alarm.doubt, grid, None if self._alarm.carried else pose)

    def clicked(self, stamp: float, click: Click, grid: Grid, believed: Pose) -> None:
        """The operator says where the robot is, which believes to be elsewhere."""
        if self._finding is None:
            self.begin(stamp, "you have told me so", grid, believed)
        if self._finding is not None:
            self._finding.place_at(click)

    def search(
        self, stamp: float, step: Pose, ends: Array | None, hits: Array | None, may_turn: bool = False
    ) -> Found | None:
        """One frame of looking for the robot's place → the place once it is found."""
        if self._finding is None:
            return None
        self._odometry = self._odometry @ step
        view = None
        if ends is not None and hits is not None:
            view = View.of_beams(stamp, self._odometry, self._mounting, np.asarray(ends), hits)
        found = self._finding.step(stamp, self._odometry, view, may_turn)
        if found is not None:
            self._finding, self.words, self._since = None, found.words, stamp
            self._alarm.calm()
        return found

    def begin(self, stamp: float, why: str, grid: Grid, before: Pose | None = None) -> None:
        """Look for the robot's place on this map; `why`: a clause for the operator; `before`: where it may yet be."""
        self._odometry = Pose()
        settings, usual = self._settings.lost, self._alarm.usual
        self._finding = Finding(stamp, why, grid, settings=settings, usual=usual, before=before)
