"""Finding back: the robot stands, looks for its place on the frozen map, turns for another view, and else asks."""

import math
from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from core.geometry import Pose, turned_covariance, wrap
from core.message import Array
from core.sentences import Statement
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.status import LostPhase, LostStatus
from core.slam.relocalization.global_search import PoseFit, judge, search_near
from core.slam.relocalization.hypotheses import PlaceHypotheses, PlaceHypothesis, least_score, most_conflict
from core.slam.relocalization.search_pyramid import ScanView, SearchPyramid
from core.slam.scan_matching.match_covariance import match_spread

# Thresholds of the search for the robot's place.
TURN_RATE_RAD_S = 0.6  # [rad/s] of looking around on the spot
MAX_TURN_RAD = math.tau  # [rad] of looking around after which the operator is asked
MAX_SEARCH_S = 20.0  # [s] after which the operator is asked
CLICK_REACH_M = 1.0  # [m] around a click that are searched
CLICK_REACH_RAD = math.radians(30)  # [rad] around the heading that came with it
MIN_CLICK_SCORE = 0.6  # of a place near a click, at least
MAX_CLICK_CONFLICT = 0.2  # at most
MAX_CLICK_RIVAL = 0.92  # share of its score that another place near the click may reach
STAYED_REACH_M = 0.3  # [m] around the former place that are searched where a click is refuted
STAYED_REACH_RAD = math.radians(10)  # [rad] around its heading that are searched then
STANDING_TIME_S = 0.5  # [s] before looking around: perhaps it never left
MIN_FITTING_VIEWS = 4  # views one after the other that fit where the robot believed to be, for it never left
UNCHECKED_SD_M = 0.5  # [m] of a click that nothing on the map can confirm
UNCHECKED_SD_RAD = math.radians(40)  # [rad] of the heading of such a click
MIN_PLACE_SD_M = 0.03  # [m] of a found place, at least
MIN_HEADING_SD_RAD = math.radians(1.0)  # [rad]


@dataclass(frozen=True)
class RecoveredPose:
    """The robot knows where it is again."""

    pose: Pose  # world, at the frame in which it was found
    covariance: Array  # (3, 3) of x, y, heading, world
    score: float  # 0..1 of the newest view there
    words: str  # a sentence for the operator


@dataclass(frozen=True)
class Click:
    """The place at which the operator says that the robot is."""

    x: float  # [m], world
    y: float  # [m]
    heading: float | None  # [rad]; None: not given


EMPTY = Statement("place.empty")
NEVER_LEFT = Statement("place.never_left")


class Recovery:
    """One search for the robot's place, from when it was lost; `step` with every frame."""

    def __init__(
        self,
        stamp: float,
        why: str,
        grid: OccupancyGrid,
        points: Array | None = None,
        usual: float = 1.0,
        before: Pose | None = None,
        asked: bool = False,
    ) -> None:
        """`why`: a clause for the operator. The map as it is now: grid and points (K, 2) [m] of its walls, world.

        `usual`: usual share of a scan's points (0..1) that lie at the map's walls (`KidnapDetector.usual`).
        `before`: where the robot believed to be until now, unless it was felt to be carried away.
        `asked`: an operator began it.
        """
        self._usual, self._before, self._asked = usual, before, asked
        self.turn = 0.0  # [rad/s] that the robot should turn on the spot now, if it may
        self.waiting = False  # for a view from somewhere else
        self._since = self._now = stamp
        self._words = Statement("place.lost", why=why)
        self._phase: LostPhase = "searching"
        self._view: ScanView | None = None  # the newest
        self._compared: ScanView | None = None  # the newest that was laid where the robot believed to be
        self._fitting = 0  # how many of them fit there, one after the other
        self._odometry: Pose | None = None
        self._turned = 0.0
        self._mapped, self._points = grid, points
        self._chart: SearchPyramid | None = None
        self._places: tuple[Pose, ...] = ()
        self._work = self._find()

    @property
    def lost(self) -> LostStatus:
        """For the operator."""
        places = np.array([place.vector for place in self._places]).reshape(-1, 3)
        return LostStatus(
            phase=self._phase, words=self._words, since=self._since, candidates=places, asked=self._asked
        )

    def place_at(self, click: Click) -> None:
        """Search around a place that the operator clicked first."""
        self._work = self._find_near(click)

    def step(self, stamp: float, odometry: Pose, view: ScanView | None, may_turn: bool) -> RecoveredPose | None:
        """Take one frame, with its odometry and, where it brought a scan, the view.

        `may_turn`: whether the robot may turn by itself now. A little work is done each time; the place once found.
        """
        if self._odometry is not None:
            self._turned += abs(wrap(odometry.heading - self._odometry.heading))
        self._now, self._odometry, self._view = stamp, odometry, view or self._view
        waits = self._before is not None and stamp - self._since < STANDING_TIME_S
        looks = self._phase != "asking" and self._view is not None and not waits
        self.turn = TURN_RATE_RAD_S if looks and may_turn else 0.0
        if self._phase == "confirming":
            self._words = Statement("place.turning") if may_turn else Statement("place.holding")
        try:
            next(self._work)
        except StopIteration as over:
            return over.value
        return None

    def _find(self) -> Generator[None, None, RecoveredPose | None]:
        """Search the whole map with every new view until one place is believed."""
        pyramid = yield from self._charted()
        if pyramid is None:
            self._phase, self._words = "asking", EMPTY
            while True:
                yield
        seen = PlaceHypotheses(pyramid, 1.0 - self._usual)
        while True:
            while self._view is None or not seen.is_news(self._view):
                self._ask_after(seen)
                self.waiting = True
                yield
                stayed = self._stayed(pyramid)
                if stayed is not None:
                    return stayed
            self.waiting = False
            yield from seen.consider(self._view)
            self._places = tuple(place.pose for place in seen.places)
            if self._phase != "asking" and self._places:
                self._phase = "confirming"
            best = seen.believed()
            if best is not None:
                yield
                found = self._confirmed(seen, best)
                if found is not None:
                    return found

    def _stayed(self, pyramid: SearchPyramid) -> RecoveredPose | None:
        """Return the former place if the scans fit there again: a person may have stood in front of the laser."""
        view = self._view
        if self._before is None or view is None or view is self._compared:
            return None
        self._compared = view
        former = self._before @ view.odometry
        fit = judge(pyramid, view, former)
        usual = 1.0 - self._usual
        fits = (
            fit is not None
            and former.distance_to(fit.pose.x, fit.pose.y) < STAYED_REACH_M
            and abs(wrap(fit.pose.heading - former.heading)) < STAYED_REACH_RAD
            and fit.score >= least_score(usual)
            and fit.conflict <= most_conflict(usual)
        )
        self._fitting = self._fitting + 1 if fits else 0
        return self._found(view, fit, NEVER_LEFT) if fit is not None and self._fitting >= MIN_FITTING_VIEWS else None

    def _find_near(self, click: Click) -> Generator[None, None, RecoveredPose | None]:
        """Search around a click; one view is enough where it fits, as a person has given the place."""
        guess = Pose(click.x, click.y, click.heading or 0.0)
        pyramid = yield from self._charted()
        view = self._view
        if pyramid is None:
            sd = [UNCHECKED_SD_M, UNCHECKED_SD_M, UNCHECKED_SD_RAD]
            return RecoveredPose(guess, np.diag(sd) ** 2, 0.0, Statement("place.trusted"))
        if view is None:
            self._phase, self._words = "asking", Statement("place.no_view")
            return (yield from self._find())
        self._phase, self._words = "searching", Statement("place.around_click")
        angle = math.pi if click.heading is None else CLICK_REACH_RAD
        fits = yield from search_near(pyramid, view, guess, CLICK_REACH_M, angle)
        doubt = self._doubt(fits)
        if not doubt:
            return self._found(view, fits[0], Statement("place.clicked"))
        if self._before is not None:
            former = self._before @ view.odometry
            stays = yield from search_near(pyramid, view, former, STAYED_REACH_M, STAYED_REACH_RAD)
            if not self._doubt(stays):
                return self._found(view, stays[0], Statement("place.stayed", doubt=doubt))
        self._phase, self._words = "asking", Statement("place.unfit", doubt=doubt)
        self._places = tuple(fit.pose for fit in fits)
        return (yield from self._find())

    def _charted(self) -> Generator[None, None, SearchPyramid | None]:
        """Return the frozen map, prepared once; None where it has too little for a search."""
        if self._chart is None:
            self._chart = yield from SearchPyramid.prepare(self._mapped, self._points)
        return self._chart

    def _ask_after(self, seen: PlaceHypotheses) -> None:
        """Ask the operator after a full turn or the end of the patience."""
        over = self._turned >= MAX_TURN_RAD or self._now - self._since >= MAX_SEARCH_S
        if over and self._phase != "asking":
            self._phase, self._words = "asking", Statement("place.asking", doubt=seen.doubt())

    def _doubt(self, fits: list[PoseFit]) -> str:
        """Return why a click is not believed; "" when it is."""
        if not fits or fits[0].score < MIN_CLICK_SCORE:
            return "the walls fit badly"
        if fits[0].conflict > MAX_CLICK_CONFLICT:
            return "I see through walls of the map"
        if any(other.score > MAX_CLICK_RIVAL * fits[0].score for other in fits[1:]):
            return "several places near it look the same"
        return ""

    def _confirmed(self, seen: PlaceHypotheses, best: PlaceHypothesis) -> RecoveredPose | None:
        """The believed place by the newest scan of all, or None where that contradicts it."""
        view = self._view
        if view is None:
            return None
        fit = seen.follow(seen.views[-1], view, best.pose)
        return None if fit is None else self._found(view, fit, Statement("place.agreed", views=len(seen.views)))

    def _found(self, view: ScanView, fit: PoseFit, words: str) -> RecoveredPose:
        """A fit of a view, carried on to now."""
        own = match_spread(
            view.points,
            point_sd=0.1,
            wall=0.5,
            unknown=np.array([1.0, 1.0, 0.5]),
            floor=np.array([MIN_PLACE_SD_M, MIN_PLACE_SD_M, MIN_HEADING_SD_RAD]),
        )
        now = view.odometry if self._odometry is None else self._odometry
        pose = fit.pose @ (view.odometry.inverse() @ now)
        self.turn = 0.0
        return RecoveredPose(pose, turned_covariance(own, fit.pose.heading), fit.score, words)
