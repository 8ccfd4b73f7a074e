"""Hypotheses of the robot's place over several views: carried along with the odometry, checked at every view."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, field

import numpy as np

from core.geometry import Pose, wrap
from core.slam.relocalization.global_search import PoseFit, SearchSettings, aside, judge, ring, same, search
from core.slam.relocalization.search_pyramid import ScanView, SearchPyramid
from core.slam.scan_matching.likelihood_field import MAX_SHIFT_M

SHIFTED_VIEWS = 3  # views that are shifted to see whether the walls pin them down


@dataclass(frozen=True)
class BeliefThresholds:
    """Conditions under which a place is believed. No place is better than a wrong one.

    Score, conflict and merit are those of a `PlaceHypothesis`. The usual conflict is the share of points that
    contradict this map even where the robot knows its place; the excess is what exceeds `view_conflict_per_usual`
    times that.
    """

    search: SearchSettings = field(default_factory=SearchSettings)
    new_view_m: float = 0.3  # between two views that add information
    new_view_rad: float = math.radians(20)  # turn on the spot between two views that add information
    confirming_turn_rad: float = math.radians(35)  # turn on the spot between two views that confirm each other
    min_score: float = 0.735  # mean over the views, on a map without usual conflict
    score_per_usual: float = 1.5  # by which the least score falls with the usual conflict
    min_merit: float = 0.58  # mean over the views
    two_view_margin: float = 0.035  # added to the least score and the least merit while there are two views only
    max_excess_conflict: float = 0.015  # mean over the views
    max_view_conflict: float = 0.04  # of every single view, on a map without usual conflict
    view_conflict_per_usual: float = 2.0  # by which the most conflict of a view grows with the usual conflict
    max_rival_share: float = 0.88  # of the best place's merit that another one may have with two views
    rival_share_per_view: float = 0.025  # by which that share grows with every view beyond the second
    max_rival_share_ever: float = 0.93  # however many views there are
    rival_share_per_excess: float = 5.0  # by which that share falls with the excess conflict of the best place
    min_carried_share: float = 0.6  # of the best place's merit from which another place is carried along
    first_whole_searches: int = 2  # views, from the first on, that are searched on the whole map
    views_per_search: int = 3  # one of which is searched on the whole map, later on
    max_shifted_share: float = 0.94  # of the best place's score that the views may reach 0.3 to 0.75 m from it
    max_views: int = 6  # that are kept
    drift_m: float = 0.15  # by which two views may disagree with the odometry between them at rest
    drift_share: float = 0.1  # of the way between them, in addition
    veer_rad: float = math.radians(3)  # by which two views may disagree with the odometry's heading at rest
    veer_share: float = 0.1  # of the turn between them, in addition
    veer_rad_per_m: float = math.radians(4)  # of the way between them, in addition

    def least_score(self, usual: float) -> float:
        """Return the least score on a map whose usual conflict is `usual`."""
        return self.min_score - self.score_per_usual * usual

    def most_conflict(self, usual: float) -> float:
        """Return the most conflict of a single view on such a map."""
        return self.max_view_conflict + self.view_conflict_per_usual * usual


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

    def __init__(
        self, pyramid: SearchPyramid, thresholds: BeliefThresholds | None = None, usual: float = 0.0
    ) -> None:
        """`usual`: share of points (0..1) that contradict this map even where the robot knows its place."""
        self._usual = usual
        self.pyramid, self.thresholds = pyramid, thresholds or BeliefThresholds()
        self.views: list[ScanView] = []
        self.places: list[PlaceHypothesis] = []  # best first
        self._taken = 0  # views since the present ones began

    def is_news(self, view: ScanView) -> bool:
        """Return whether a view was taken far enough from the last one to add information."""
        return not self.views or self._apart(self.views[-1], view, self.thresholds.new_view_rad)

    def consider(self, view: ScanView) -> Generator[None, None, None]:
        """Take in a view: carry on what the former views allowed, search the map with it, and intersect."""
        limits, carried = self.thresholds, list[PlaceHypothesis]()
        for number, place in enumerate(self.places):
            fit = self.follow(self.views[-1], view, place.pose)
            if fit is not None:
                carried.append(PlaceHypothesis((*place.fits, fit)))
            if number % limits.search.pieces == limits.search.pieces - 1:
                yield
        every = limits.views_per_search
        if not carried or self._taken < limits.first_whole_searches or self._taken % every == every - 2:
            found = yield from search(self.pyramid, view, limits.search)
            for number, fit in enumerate(found):
                traced = None if any(same(fit.pose, place.pose) for place in carried) else self._trace(view, fit)
                if traced is not None:
                    carried.append(traced)
                if number % limits.search.pieces == limits.search.pieces - 1:
                    yield
            if not carried:
                self._taken = 0
                self.views.clear()
                carried = [PlaceHypothesis((fit,)) for fit in found]
        self._take(view, carried)

    def _take(self, view: ScanView, carried: list[PlaceHypothesis]) -> None:
        self._taken += 1
        self.views.append(view)
        if len(self.views) > self.thresholds.max_views:
            del self.views[0]
            carried = [PlaceHypothesis(place.fits[1:]) for place in carried]
        ranked: list[PlaceHypothesis] = []
        for place in sorted(carried, key=lambda place: -place.merit):
            if not any(same(place.pose, better.pose) for better in ranked):
                ranked.append(place)
        least = self.thresholds.min_carried_share * ranked[0].merit if ranked else 0.0
        self.places = [place for place in ranked[: self.thresholds.search.most] if place.merit >= least]

    def believed(self) -> PlaceHypothesis | None:
        """The one place that fits every view well, that no other rivals, and that is pinned down; else None."""
        return None if self.doubt() else self.places[0]

    def doubt(self) -> str:
        """Return why the best place is not believed; "" when it is."""
        limits = self.thresholds
        if not self.places:
            return "nothing on the map fits"
        best = self.places[0]
        if not any(self._apart(one, self.views[-1], limits.confirming_turn_rad) for one in self.views[:-1]):
            return "one view only" if len(self.views) == 1 else "I have seen the place from one side only"
        more = limits.two_view_margin if len(best.fits) == 2 else 0.0
        if best.score < limits.least_score(self._usual) + more:
            return "the walls fit badly"
        most = limits.most_conflict(self._usual)
        excess = max(0.0, best.conflict - limits.view_conflict_per_usual * self._usual)
        against = excess > limits.max_excess_conflict or max(fit.conflict for fit in best.fits) > most
        if against or best.merit < limits.min_merit + more:
            return "I see through walls of the map"
        share = limits.max_rival_share + limits.rival_share_per_view * (len(best.fits) - 2)
        share = min(share, limits.max_rival_share_ever) - limits.rival_share_per_excess * excess
        if any(other.merit > share * best.merit for other in self.places[1:]):
            return "other places look the same"
        if self.looseness(best) > limits.max_shifted_share:
            return "the walls here leave it open along them"
        return ""

    def looseness(self, place: PlaceHypothesis) -> float:
        """Return the best score of the newest views 0.3 to 0.75 m aside, as a share of their score at the place."""
        tied = list(zip(self.views, place.fits, strict=True))[-SHIFTED_VIEWS:]
        scores = np.mean([aside(self.pyramid, view, fit.pose) for view, fit in tied], axis=0)
        return float(scores[ring()].max() / max(float(scores[15, 15]), 1e-9))

    def follow(self, before: ScanView, view: ScanView, pose: Pose) -> PoseFit | None:
        """The view's fit where the odometry leads from a pose at the view before; None where it does not fit."""
        limits = self.thresholds
        move = before.odometry.inverse() @ view.odometry
        way = math.hypot(move.x, move.y)
        reach = limits.drift_m + limits.drift_share * way
        angle = limits.veer_rad + limits.veer_share * abs(move.heading) + limits.veer_rad_per_m * way
        if reach > MAX_SHIFT_M:
            return None  # the odometry no longer says where the robot may be
        expected = pose @ move
        few = view.points[:: max(1, len(view.points) // limits.search.points)]
        found = self.pyramid.field.search(few, expected, reach, angle, 0.1, math.radians(1.5))
        fit = judge(self.pyramid, view, found)
        if fit is None or fit.score < limits.search.hopeful:
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
        return math.hypot(move.x, move.y) >= self.thresholds.new_view_m or abs(move.heading) >= turned
