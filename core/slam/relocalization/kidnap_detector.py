"""Detection that the robot is not where it believes to be: it was carried, or the estimate diverged."""

import math
from collections import deque
from dataclasses import dataclass
from typing import Annotated

import cv2
import numpy as np

from core.geometry import Pose, wrap
from core.message import Array
from core.setting import Meta, Section
from core.slam.map.occupancy import OccupancyGrid
from core.slam.relocalization.search_pyramid import FREE, OCCUPIED_LOG_ODDS

MIN_KNOWN_POINTS = 20  # points on known ground that are evidence
WALL_RADIUS_CELLS = 2  # of a wall within which a point lies at it


@dataclass(frozen=True)
class KidnapSettings(Section):
    """Thresholds beyond which the robot counts as lost, and after how long.

    Watch:
        match: the warning that the place is lost; lower it where that comes without a cause
        agreement: the warning that the place is lost; lower it where that comes without a cause
        lasting: time until the robot says that it was moved
    """

    match_usual: float = 0.65  # share of this laser's usual score that is enough
    match_least: float = 0.3  # score that is always demanded
    agreement_usual: float = 0.7  # share of the usual agreement that is enough
    agreement_least: float = 0.4  # agreement that is always demanded
    habit: float = 0.02  # weight of a scan without doubt in the usual
    nis: float = 4.0  # normalised innovation squared per degree of freedom, at most
    unmatched: float = 0.5  # share of unmatched sightings from which `nis` counts
    carried: float = 0.5  # [m] move by the scans within `window` while the wheels stand: the robot was carried
    # [rad] turn by the scans within `window` while the wheels stand: the robot was carried
    carried_turn: float = math.radians(30)
    rolling: float = 0.05  # [m] roll of standing wheels, at most, a radian counted as 0.1 m
    window: float = 2.0  # [s] time over which both are compared
    match: Annotated[float, Meta("", 0, 1, "score of the newest scan on the views around, at least")] = 0.5
    agreement: Annotated[float, Meta("", 0, 1, "share of the points on known ground at walls, at least")] = 0.6
    lasting: Annotated[float, Meta("s", 0, 60, "time that any of these lasts until it counts as lost")] = 1.0


@dataclass(frozen=True)
class LocalizationEvidence:
    """The evidence of one scan on whether the pose is right. None: nothing."""

    stamp: float  # [s]
    match: float | None = None  # 0..1, on the views around
    agreement: float | None = None  # 0..1, on the map
    nis: float | None = None  # per degree of freedom
    unmatched: float = 0.0  # 0..1 of the sightings
    wheels: Pose | None = None  # the move since the scan before, by the wheels
    scans: Pose | None = None  # the same move by the scans


class KidnapDetector:
    """Takes the signs of every scan; `doubt` says what is wrong, `lost` that it is certain.

    As long as there is doubt nothing should be written to the map: what is drawn from a wrong pose would prove it.
    """

    def __init__(self, settings: KidnapSettings | None = None) -> None:
        self.settings = settings or KidnapSettings()
        self.doubt = ""  # a clause: "what the laser sees is not on the map here"
        self.carried = False  # the scans moved while the wheels stood: it is not where it was
        self._since: dict[str, float] = {}
        self._moves: deque[tuple[float, Pose, Pose]] = deque()
        self._usual: dict[str, float] = {}
        self.lost = False

    @property
    def usual(self) -> float:
        """Share of the points on known ground that lie at walls while all is well."""
        return self._usual.get("agreement", 1.0)

    def calm(self) -> None:
        """Clear all doubt: the robot knows where it is."""
        self.doubt, self.carried, self.lost = "", False, False
        self._since.clear()
        self._moves.clear()

    def observe(self, evidence: LocalizationEvidence) -> bool:
        """Take the evidence of one scan → whether the robot is lost."""
        complaints = self._complaints(evidence)
        self._since = {words: self._since.get(words, evidence.stamp) for words in complaints}
        carried = self._carried(evidence)
        self.doubt = carried or next(iter(self._since), "")
        lasting = any(evidence.stamp - since >= self.settings.lasting - 1e-6 for since in self._since.values())
        self.carried = bool(carried)
        self.lost = self.carried or lasting
        return self.lost

    def _complaints(self, evidence: LocalizationEvidence) -> list[str]:
        settings, complaints = self.settings, list[str]()
        least = self._least("match", settings.match, settings.match_usual, settings.match_least)
        if evidence.match is not None and evidence.match < least:
            complaints.append("the scans do not fit what was seen just before")
        least = self._least("agreement", settings.agreement, settings.agreement_usual, settings.agreement_least)
        if evidence.agreement is not None and evidence.agreement < least:
            complaints.append("what the laser sees is not on the map here")
        if evidence.nis is not None and evidence.nis > settings.nis and evidence.unmatched > settings.unmatched:
            complaints.append("the corners are not where they should be")
        if not complaints:
            self._grow_used_to("match", evidence.match)
            self._grow_used_to("agreement", evidence.agreement)
        return complaints

    def _least(self, sign: str, enough: float, share: float, least: float) -> float:
        """Return the threshold of a sign, below what is usual: a noisy laser is not lost all the time."""
        return max(least, min(enough, share * self._usual.get(sign, 1.0)))

    def _grow_used_to(self, sign: str, value: float | None) -> None:
        if value is not None:
            usual = self._usual.get(sign, value)
            self._usual[sign] = usual + self.settings.habit * (value - usual)

    def _carried(self, evidence: LocalizationEvidence) -> str:
        """Return a clause if the scans moved while the wheels stood, else ""."""
        if evidence.wheels is None or evidence.scans is None:
            return ""
        settings = self.settings
        self._moves.append((evidence.stamp, evidence.wheels, evidence.scans))
        while self._moves[0][0] < evidence.stamp - settings.window:
            self._moves.popleft()
        rolled = sum(math.hypot(w.x, w.y) + 0.1 * abs(w.heading) for _, w, _ in self._moves)
        if rolled > settings.rolling:
            return ""
        rolled_to, moved_to = Pose(), Pose()
        for _, wheels, scans in self._moves:
            rolled_to, moved_to = rolled_to @ wheels, moved_to @ scans
        moved = rolled_to.inverse() @ moved_to  # a turn that begins is no carrying
        far = math.hypot(moved.x, moved.y) > settings.carried or abs(wrap(moved.heading)) > settings.carried_turn
        return "the robot was carried while its wheels stood" if far else ""


class WidenedWalls:
    """A grid's walls, widened once for each of its revisions: for asking how well a scan agrees with the map."""

    def __init__(self) -> None:
        self._grid: OccupancyGrid | None = None
        self._near = np.zeros((0, 0), bool)

    def agreement(self, grid: OccupancyGrid, points: Array) -> float | None:
        """Points hit (K, 2) [m], world → the share of those on known ground that lie at walls; None: too few."""
        if grid.log_odds.size == 0:
            return None
        if grid is not self._grid:
            wide = np.ones((2 * WALL_RADIUS_CELLS + 1, 2 * WALL_RADIUS_CELLS + 1), np.uint8)
            self._near = cv2.dilate((grid.log_odds > OCCUPIED_LOG_ODDS).astype(np.uint8), wide) > 0
            self._grid = grid
        cells = np.floor((points - grid.origin) / grid.resolution).astype(int)
        column, row = cells[((cells >= 0) & (cells < grid.log_odds.shape[::-1])).all(axis=1)].T
        at_wall = self._near[row, column]
        in_free = ~at_wall & (grid.log_odds[row, column] < FREE)
        known = int(at_wall.sum() + in_free.sum())
        return float(at_wall.sum() / known) if known >= MIN_KNOWN_POINTS else None
