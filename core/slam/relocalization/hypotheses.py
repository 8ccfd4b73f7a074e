"""Hypotheses of the robot's place over several views: carried along with the odometry, checked at every view."""

import math
from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from core.geometry import Pose, wrap
from core.slam.relocalization.global_search import (
    FINE_POINTS,
    MAX_CANDIDATES,
    MIN_CANDIDATE_SCORE,
    PLACES_PER_STEP,
    PoseFit,
    aside,
    judge,
    ring,
    same,
    search,
)
from core.slam.relocalization.search_pyramid import ScanView, SearchPyramid
from core.slam.scan_matching.likelihood_field import MAX_SHIFT_M

SHIFTED_VIEWS = 3  # views that are shifted to see whether the walls pin them down

# Conditions under which a place is believed; no place is better than a wrong one. Score, conflict and merit are those
# of a `PlaceHypothesis`. The usual conflict is the share of points that contradict this map even where the robot
# knows its place; the excess is what exceeds VIEW_CONFLICT_PER_USUAL times that.
NEW_VIEW_M = 0.3  # between two views that add information
NEW_VIEW_RAD = math.radians(20)  # turn on the spot between two views that add information
CONFIRMING_TURN_RAD = math.radians(35)  # turn on the spot between two views that confirm each other
MIN_BELIEF_SCORE = 0.735  # mean over the views, on a map without usual conflict
SCORE_PER_USUAL = 1.5  # by which the least score falls with the usual conflict
MIN_MERIT = 0.58  # mean over the views
TWO_VIEW_MARGIN = 0.035  # added to the least score and the least merit while there are two views only
MAX_EXCESS_CONFLICT = 0.015  # mean over the views
MAX_VIEW_CONFLICT = 0.04  # of every single view, on a map without usual conflict
VIEW_CONFLICT_PER_USUAL = 2.0  # by which the most conflict of a view grows with the usual conflict
MAX_RIVAL_SHARE = 0.88  # of the best place's merit that another one may have with two views
RIVAL_SHARE_PER_VIEW = 0.025  # by which that share grows with every view beyond the second
MAX_RIVAL_SHARE_EVER = 0.93  # however many views there are
RIVAL_SHARE_PER_EXCESS = 5.0  # by which that share falls with the excess conflict of the best place
MIN_CARRIED_SHARE = 0.6  # of the best place's merit from which another place is carried along
FIRST_WHOLE_SEARCHES = 2  # views, from the first on, that are searched on the whole map
VIEWS_PER_SEARCH = 3  # one of which is searched on the whole map, later on
MAX_SHIFTED_SHARE = 0.94  # of the best place's score that the views may reach 0.3 to 0.75 m from it
MAX_KEPT_VIEWS = 6  # that are kept
DRIFT_M = 0.15  # by which two views may disagree with the odometry between them at rest
DRIFT_SHARE = 0.1  # of the way between them, in addition
VEER_RAD = math.radians(3)  # by which two views may disagree with the odometry's heading at rest
VEER_SHARE = 0.1  # of the turn between them, in addition
VEER_RAD_PER_M = math.radians(4)  # of the way between them, in addition


def least_score(usual: float) -> float:
    """Return the least score on a map whose usual conflict is `usual`."""
    return MIN_BELIEF_SCORE - SCORE_PER_USUAL * usual


def most_conflict(usual: float) -> float:
    """Return the most conflict of a single view on such a map."""
    return MAX_VIEW_CONFLICT + VIEW_CONFLICT_PER_USUAL * usual


@dataclass(frozen=True)
class PlaceHypothesis:
    """One place for the newest view, with how all views fit that are tied to it by the odometry."""

    fits: tuple[PoseFit, ...]  # one for each view, oldest first

    @property
    def pose(self) -> Pose:
        """At the newest view."""
        return self.fits[-1].pose

    @property
    def score(self) -> float:
        """Mean over the views."""
        return float(np.mean([fit.score for fit in self.fits]))

    @property
    def merit(self) -> float:
        """The score minus the conflict, by which places are compared."""
        return self.score - self.conflict

    @property
    def conflict(self) -> float:
        """Mean over the views."""
        return float(np.mean([fit.conflict for fit in self.fits]))


class PlaceHypotheses:
    """The places that all views allow."""

    def __init__(self, pyramid: SearchPyramid, usual: float = 0.0) -> None:
        """`usual`: share of points (0..1) that contradict this map even where the robot knows its place."""
        self._usual = usual
        self.pyramid = pyramid
        self.views: list[ScanView] = []
        self.places: list[PlaceHypothesis] = []  # best first
        self._taken = 0  # views since the present ones began

    def is_news(self, view: ScanView) -> bool:
        """Return whether a view was taken far enough from the last one to add information."""
        return not self.views or self._apart(self.views[-1], view, NEW_VIEW_RAD)

    def consider(self, view: ScanView) -> Generator[None, None, None]:
        """Take in a view: carry on what the former views allowed, search the map with it, and intersect."""
        carried: list[PlaceHypothesis] = []
        for number, place in enumerate(self.places):
            fit = self.follow(self.views[-1], view, place.pose)
            if fit is not None:
                carried.append(PlaceHypothesis((*place.fits, fit)))
            if number % PLACES_PER_STEP == PLACES_PER_STEP - 1:
                yield
        if (
            not carried
            or self._taken < FIRST_WHOLE_SEARCHES
            or self._taken % VIEWS_PER_SEARCH == VIEWS_PER_SEARCH - 2
        ):
            found = yield from search(self.pyramid, view)
            for number, fit in enumerate(found):
                traced = None if any(same(fit.pose, place.pose) for place in carried) else self._trace(view, fit)
                if traced is not None:
                    carried.append(traced)
                if number % PLACES_PER_STEP == PLACES_PER_STEP - 1:
                    yield
            if not carried:
                self._taken = 0
                self.views.clear()
                carried = [PlaceHypothesis((fit,)) for fit in found]
        self._take(view, carried)

    def _take(self, view: ScanView, carried: list[PlaceHypothesis]) -> None:
        self._taken += 1
        self.views.append(view)
        if len(self.views) > MAX_KEPT_VIEWS:
            del self.views[0]
            carried = [PlaceHypothesis(place.fits[1:]) for place in carried]
        ranked: list[PlaceHypothesis] = []
        for place in sorted(carried, key=lambda place: -place.merit):
            if not any(same(place.pose, better.pose) for better in ranked):
                ranked.append(place)
        least = MIN_CARRIED_SHARE * ranked[0].merit if ranked else 0.0
        self.places = [place for place in ranked[:MAX_CANDIDATES] if place.merit >= least]

    def believed(self) -> PlaceHypothesis | None:
        """The one place that fits every view well, that no other rivals, and that is pinned down; else None."""
        return None if self.doubt() else self.places[0]

    def doubt(self) -> str:
        """Return why the best place is not believed; "" when it is."""
        if not self.places:
            return "nothing on the map fits"
        best = self.places[0]
        if not any(self._apart(one, self.views[-1], CONFIRMING_TURN_RAD) for one in self.views[:-1]):
            return "one view only" if len(self.views) == 1 else "I have seen the place from one side only"
        more = TWO_VIEW_MARGIN if len(best.fits) == 2 else 0.0
        if best.score < least_score(self._usual) + more:
            return "the walls fit badly"
        most = most_conflict(self._usual)
        excess = max(0.0, best.conflict - VIEW_CONFLICT_PER_USUAL * self._usual)
        against = excess > MAX_EXCESS_CONFLICT or max(fit.conflict for fit in best.fits) > most
        if against or best.merit < MIN_MERIT + more:
            return "I see through walls of the map"
        share = MAX_RIVAL_SHARE + RIVAL_SHARE_PER_VIEW * (len(best.fits) - 2)
        share = min(share, MAX_RIVAL_SHARE_EVER) - RIVAL_SHARE_PER_EXCESS * excess
        if any(other.merit > share * best.merit for other in self.places[1:]):
            return "other places look the same"
        if self.looseness(best) > MAX_SHIFTED_SHARE:
            return "the walls here leave it open along them"
        return ""

    def looseness(self, place: PlaceHypothesis) -> float:
        """Return the best score of the newest views 0.3 to 0.75 m aside, as a share of their score at the place."""
        tied = list(zip(self.views, place.fits, strict=True))[-SHIFTED_VIEWS:]
        scores = np.mean([aside(self.pyramid, view, fit.pose) for view, fit in tied], axis=0)
        return float(scores[ring()].max() / max(float(scores[15, 15]), 1e-9))

    def follow(self, before: ScanView, view: ScanView, pose: Pose) -> PoseFit | None:
        """The view's fit where the odometry leads from a pose at the view before; None where it does not fit."""
        move = before.odometry.inverse() @ view.odometry
        way = math.hypot(move.x, move.y)
        reach = DRIFT_M + DRIFT_SHARE * way
        angle = VEER_RAD + VEER_SHARE * abs(move.heading) + VEER_RAD_PER_M * way
        if reach > MAX_SHIFT_M:
            return None  # the odometry no longer says where the robot may be
        expected = pose @ move
        few = view.points[:: max(1, len(view.points) // FINE_POINTS)]
        found = self.pyramid.field.search(few, expected, reach, angle, 0.1, math.radians(1.5))
        fit = judge(self.pyramid, view, found)
        if fit is None or fit.score < MIN_CANDIDATE_SCORE:
            return None
        strayed = expected.distance_to(fit.pose.x, fit.pose.y) > 1.5 * reach
        veered = abs(wrap(expected.heading - fit.pose.heading)) > 1.5 * angle
        return None if strayed or veered else fit

    def _trace(self, view: ScanView, fit: PoseFit) -> PlaceHypothesis | None:
        """A place of the newest view, followed back through all former views; None when one of them forbids it."""
        fits, later = [fit], view
        for former in reversed(self.views):
            back = self.follow(later, former, fits[0].pose)
            if back is None:
                return None
            fits.insert(0, back)
            later = former
        return PlaceHypothesis(tuple(fits))

    def _apart(self, one: ScanView, other: ScanView, turned: float) -> bool:
        move = one.odometry.inverse() @ other.odometry
        return math.hypot(move.x, move.y) >= NEW_VIEW_M or abs(move.heading) >= turned
