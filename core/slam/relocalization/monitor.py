"""The localization monitor: it checks the robot's place and searches for it when the robot is lost."""

from core.geometry import Pose
from core.message import Array
from core.perception.landmarks.frame_perception import Beams
from core.slam.estimate import SlamHealth
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.status import LostStatus
from core.slam.relocalization.kidnap_detector import (
    KidnapDetector,
    KidnapSettings,
    LocalizationEvidence,
    WidenedWalls,
)
from core.slam.relocalization.recovery import Click, RecoveredPose, Recovery
from core.slam.relocalization.search_pyramid import ScanView
from core.slam.scan_matching.scan_tracker import ScanTracker

SETTLING_S = 3.0  # after the start or after being found in which nothing is suspected: the map is only just there


class LocalizationMonitor:
    """Between the robot's own confidence and the search for its place."""

    def __init__(self, settings: KidnapSettings, watched: bool) -> None:
        self._watched = watched
        self._detector, self._walls = KidnapDetector(settings), WidenedWalls()
        self._recovery: Recovery | None = None
        self._odometry = Pose()  # adds up the wheels' moves while the robot is lost
        self._since: float | None = None
        self.words = ""  # a sentence on how the robot was found last

    @property
    def lost(self) -> bool:
        """True while the robot's place is searched for."""
        return self._recovery is not None

    @property
    def doubtful(self) -> bool:
        """True while nothing should be written to the map."""
        return self.lost or bool(self._detector.doubt)

    @property
    def status(self) -> LostStatus | None:
        """The status of the search for the operator; None: the robot's place is known."""
        return self._recovery.lost if self._recovery else None

    @property
    def turn(self) -> float:
        """Turn rate [rad/s] of the robot on the spot for another look; 0 while its place is known."""
        return self._recovery.turn if self._recovery else 0.0

    def needs(self, stamp: float) -> bool:
        """Return whether a scan at this time is to be judged."""
        self._since = stamp if self._since is None or stamp < self._since else self._since
        return self._watched and not self.lost and stamp > self._since + SETTLING_S

    def observe(
        self,
        stamp: float,
        tracker: ScanTracker,
        wheels: Pose,
        health: SlamHealth,
        points: Array,
        grid: OccupancyGrid,
        pose: Pose,
    ) -> None:
        """One scan: how it lies on the views around, and its points (M, 2) [m], robot frame, on the map."""
        evidence = LocalizationEvidence(
            stamp=stamp,
            match=tracker.score,
            agreement=self._walls.agreement(grid, pose.apply(points)),
            nis=health.nis,
            unmatched=health.ignored / max(1, health.ignored + health.matched),
            wheels=wheels,
            scans=tracker.seen,
        )
        if self._detector.observe(evidence):
            self.begin(stamp, self._detector.doubt, grid, None if self._detector.carried else pose)

    def doubt_restarted(self, stamp: float, grid: OccupancyGrid, pose: Pose) -> None:
        """Look for the robot's place: its base was restarted, and what it rolled meanwhile nobody knows."""
        if self.needs(stamp):
            self.begin(stamp, "the base was restarted", grid, pose)

    def clicked(self, stamp: float, click: Click, grid: OccupancyGrid, believed: Pose) -> None:
        """Search at the place that the operator clicked; the robot believes to be at `believed`."""
        if self._recovery is None:
            self.begin(stamp, "you clicked another place", grid, believed, asked=True)
        if self._recovery is not None:
            self._recovery.place_at(click)

    def search(self, stamp: float, step: Pose, beams: Beams | None, may_turn: bool = False) -> RecoveredPose | None:
        """One frame of looking for the robot's place → the place once it is found."""
        if self._recovery is None:
            return None
        self._odometry = self._odometry @ step
        view = None
        if beams is not None:
            view = ScanView.of_beams(stamp, self._odometry, beams)
        found = self._recovery.step(stamp, self._odometry, view, may_turn)
        if found is not None:
            self._recovery, self.words, self._since = None, found.words, stamp
            self._detector.calm()
        return found

    def begin(
        self, stamp: float, why: str, grid: OccupancyGrid, before: Pose | None = None, *, asked: bool = False
    ) -> None:
        """Look for the robot's place on this map; `why`: a clause for the operator; `before`: where it may yet be;
        `asked`: an operator began it.
        """
        self._odometry = Pose()
        self._recovery = Recovery(stamp, why, grid, usual=self._detector.usual, before=before, asked=asked)
