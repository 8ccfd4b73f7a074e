"""Hypotheses of the robot's place over several views: carried along with the odometry, checked at every view."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass, field

import numpy as np

from core.geometry import Pose, wrap
from core.slam.relocalization.global_search import PoseFit, SearchSettings, aside, judge, ring, same, search
from core.slam.relocalization.search_pyramid import ScanView, SearchPyramid
from core.slam.scan_matching.likelihood_field import FARTHEST

NEWEST = 3  # views that are shifted to see whether the walls pin them down


@dataclass(frozen=True)
class BeliefSettings:
    """Conditions under which a place is believed. No place is better than a wrong one."""

    search: SearchSettings = field(default_factory=SearchSettings)
    apart: float = 0.3  # [m] between two views that add information, or …
    turned: float = math.radians(20)  # [rad] … this
    confirmed: float = math.radians(35)  # [rad] of turning on the spot from which views confirm each other
    score: float = 0.735  # mean over the views, at least …
    score_usual: float = 1.5  # … less so many times the conflict that is usual on this map …
    merit: float = 0.58  # … and so much of it beyond the share of beams that contradict the map
    of_two: float = 0.035  # by which both must be higher as long as there are two views only
    spotless: float = 0.015  # mean conflict that is more than usual, at most
    worst: float = 0.04  # conflict of every single view, at most …
    worst_usual: float = 2.0  # … and so many times what is usual on this map more
    rival: float = 0.88  # share of the best place's merit that any other may reach with two views …
    rival_more: float = 0.025  # … with every further view so much more …
    rival_most: float = 0.93  # … but never more than this …
    rival_doubt: float = 5.0  # … and less by so many times the conflict that is more than usual
    chance: float = 0.6  # share of it below which a place is not carried along
    whole: int = 2  # views that are searched on the whole map; later ones only where the others leave the robot …
    again: int = 3  # … but for one of so many
    loose: float = 0.94  # share of the best place's score that shifting the views by 0.3 to 0.75 m may leave
    views: int = 6  # that are kept
    drift: float = 0.15  # [m] by which two views may disagree with the odometry between them …
    drift_share: float = 0.1  # … and this share of the way
    veer: float = math.radians(3)  # [rad] and as much in heading …
    veer_share: float = 0.1  # … and this share of the turn
    veer_way: float = math.radians(4)  # [rad/m] … and this for the way

    def least_score(self, usual: float) -> float:
        """Return the least score on a map whose usual conflict is `usual`."""
        return self.score - self.score_usual * usual

    def most_conflict(self, usual: float) -> float:
        """Return the most conflict of a single view on such a map."""
        return self.worst + self.worst_usual * usual


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

    def __init__(self, pyramid: SearchPyramid, settings: BeliefSettings | None = None, usual: float = 0.0) -> None:
        """`usual`: share of points (0..1) that contradict this map even where the robot knows its place."""
        self._usual = usual
        self.pyramid, self.settings = pyramid, settings or BeliefSettings()
        self.views: list[ScanView] = []
        self.places: list[PlaceHypothesis] = []  # best first
        self._taken = 0  # views since the present ones began

    def is_news(self, view: ScanView) -> bool:
        """Return whether a view was taken far enough from the last one to add information."""
        return not self.views or self._apart(self.views[-1], view, self.settings.turned)

    def consider(self, view: ScanView) -> Generator[None, None, None]:
        """Take in a view: carry on what the former views allowed, search the map with it, and intersect."""
        settings, carried = self.settings, list[PlaceHypothesis]()
        for number, place in enumerate(self.places):
            fit = self.follow(self.views[-1], view, place.pose)
            if fit is not None:
                carried.append(PlaceHypothesis((*place.fits, fit)))
            if number % settings.search.pieces == settings.search.pieces - 1:
                yield
        if not carried or self._taken < settings.whole or self._taken % settings.again == settings.again - 2:
            found = yield from search(self.pyramid, view, settings.search)
            for number, fit in enumerate(found):
                traced = None if any(same(fit.pose, place.pose) for place in carried) else self._trace(view, fit)
                if traced is not None:
                    carried.append(traced)
                if number % settings.search.pieces == settings.search.pieces - 1:
                    yield
            if not carried:
                self._taken = 0
                self.views.clear()
                carried = [PlaceHypothesis((fit,)) for fit in found]
        self._take(view, carried)

    def _take(self, view: ScanView, carried: list[PlaceHypothesis]) -> None:
        self._taken += 1
        self.views.append(view)
        if len(self.views) > self.settings.views:
            del self.views[0]
            carried = [PlaceHypothesis(place.fits[1:]) for place in carried]
        ranked: list[PlaceHypothesis] = []
        for place in sorted(carried, key=lambda place: -place.merit):
            if not any(same(place.pose, better.pose) for better in ranked):
                ranked.append(place)
        least = self.settings.chance * ranked[0].merit if ranked else 0.0
        self.places = [place for place in ranked[: self.settings.search.most] if place.merit >= least]

    def believed(self) -> PlaceHypothesis | None:
        """The one place that fits every view well, that no other rivals, and that is pinned down; else None."""
        return None if self.doubt() else self.places[0]

    def doubt(self) -> str:
        """Return why the best place is not believed; "" when it is."""
        settings = self.settings
        if not self.places:
            return "nothing on the map fits"
        best = self.places[0]
        if not any(self._apart(one, self.views[-1], settings.confirmed) for one in self.views[:-1]):
            return "one view only" if len(self.views) == 1 else "I have seen the place from one side only"
        more = settings.of_two if len(best.fits) == 2 else 0.0
        if best.score < settings.least_score(self._usual) + more:
            return "the walls fit badly"
        most = settings.most_conflict(self._usual)
        unusual = max(0.0, best.conflict - settings.worst_usual * self._usual)
        against = unusual > settings.spotless or max(fit.conflict for fit in best.fits) > most
        if against or best.merit < settings.merit + more:
            return "I see through walls of the map"
        rival = min(settings.rival + settings.rival_more * (len(best.fits) - 2), settings.rival_most)
        rival -= settings.rival_doubt * unusual
        if any(other.merit > rival * best.merit for other in self.places[1:]):
            return "other places look the same"
        if self.looseness(best) > settings.loose:
            return "the walls here leave it open along them"
        return ""

    def looseness(self, place: PlaceHypothesis) -> float:
        """Return the best score of the newest views 0.3 to 0.75 m aside, as a share of their score at the place."""
        tied = list(zip(self.views, place.fits, strict=True))[-NEWEST:]
        scores = np.mean([aside(self.pyramid, view, fit.pose) for view, fit in tied], axis=0)
        return float(scores[ring()].max() / max(float(scores[15, 15]), 1e-9))

    def follow(self, before: ScanView, view: ScanView, pose: Pose) -> PoseFit | None:
        """The view's fit where the odometry leads from a pose at the view before; None where it does not fit."""
        settings = self.settings
        move = before.odometry.inverse() @ view.odometry
        way = math.hypot(move.x, move.y)
        reach = settings.drift + settings.drift_share * way
        angle = settings.veer + settings.veer_share * abs(move.heading) + settings.veer_way * way
        if reach > FARTHEST:
            return None  # the odometry no longer says where the robot may be
        expected = pose @ move
        few = view.points[:: max(1, len(view.points) // settings.search.points)]
        found = self.pyramid.field.search(few, expected, reach, angle, 0.1, math.radians(1.5))
        fit = judge(self.pyramid, view, found)
        if fit is None or fit.score < settings.search.hopeful:
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
        return math.hypot(move.x, move.y) >= self.settings.apart or abs(move.heading) >= turned
