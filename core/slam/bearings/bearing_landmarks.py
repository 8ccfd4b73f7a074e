"""Landmarks from bearings alone: followed from look to look, made once they are seen from different sides, then used.

A direction that is followed becomes a landmark when the poses from which it was seen differ enough (delayed
initialisation). Those poses stay in the filter until then, so what the landmark and the robot err alike is known and
nothing is counted twice.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import scipy

from core.geometry import Pose, wrap, wrap_all
from core.message import Array
from core.perception.landmarks.frame_perception import BearingSet
from core.perception.landmarks.landmarks import SeenWalls, wall_range
from core.setting import Meta, Section
from core.slam.bearings.geometry import (
    PastPose,
    coincide,
    crossed,
    expected_bearings,
    forget,
    ranged_then,
    remember,
    seen_now,
    seen_then,
)
from core.slam.consistency import squared_error
from core.slam.ekf.filter import AttachedPoint, Filter, Innovation


@dataclass(frozen=True)
class BearingSettings(Section):
    """When a direction that is seen or heard again and again becomes a landmark. The defaults are those of edges.

    Watch:
        used: the pose's sd in a corridor
        farthest: landmarks far outside the room (then lower it)
    """

    apart: float = 0.1  # [m] way between two corrections, at least: from one place errors repeat
    apart_turn: float = math.radians(5)  # [rad] turn between two corrections, where the way is shorter
    spacing: float = 0.25  # [m] way between the poses that a new landmark is made from
    poses: int = 8  # such poses, at most
    parallax: float = math.radians(4)  # [rad] difference of directions that makes a landmark, at least
    vague: float = 0.2  # sd of a new landmark's distance as a share of it, at most
    nearest: float = 0.3  # [m] distance of a new landmark, at least
    floor: float = 0.0  # [rad] sd of a bearing that adds to what the sensor claims
    gate: float = 9.0  # [χ²] squared distance of a bearing that is used, at most; 99.7 % at 1 dof
    follow: float = math.radians(0.8)  # [rad] change of a direction between two looks, at most
    follow_per_way: float = 0.7  # [rad/m] further change per way driven between them
    lapse: float = 0.5  # [s] time after which a direction that is not seen again is given up
    chances: int = 3  # corrections in a row that a landmark contradicts before it goes
    again: float = 0.3  # [m] sd of the distance of two landmarks that may be one, at most; 0: never
    most: int = 60  # landmarks of a submap, at most; those seen last stay
    walls: bool = True  # whether a landmark on a wall that the laser sees takes its distance from it
    wall_sd: float = 0.02  # [m] sd of such a distance across the wall
    used: Annotated[
        bool, Meta(meaning="whether they correct the pose; where the laser sees corners it is as good alone")
    ] = False
    farthest: Annotated[float, Meta("m", 1, 100, "distance of a new landmark, at most")] = 12.0


@dataclass(frozen=True)
class VoiceLandmarkSettings(BearingSettings):
    """The same for a person who stands and calls."""

    apart: float = 0.2
    apart_turn: float = 3.2
    spacing: float = 0.3
    parallax: float = math.radians(25)
    floor: float = math.radians(3)
    follow: float = math.radians(15)
    follow_per_way: float = 1.0
    lapse: float = 10.0
    chances: int = 4
    again: float = 0.6
    most: int = 4
    walls: bool = False


Crossing = tuple[Array, Array, Array]  # place (2,), its covariances (2, size) and own (2, 2)

MAX_STEP_RATIO = 2.5  # times that the steps in brightness of one edge may differ
MAX_SECOND_SHARE = 0.5  # of the second nearest direction's distance, at most, for the nearest to be the same
VAGUE_BEARING_SD_RAD = math.radians(2.0)  # sd of a bearing from which it does not say which landmark is seen again
MAX_OFF_SDS = 2.5  # sd that a landmark seen again may be off
COINCIDE_CHI2 = 9.21  # squared distance of two landmarks that are one, 99 % at 2 dof
MIN_VIEWS = 3  # views that make a landmark: two cross anywhere
AT_ONCE = 3  # directions of which it is tried with one look: the work of a step has a bound
PROVEN_CORRECTIONS = 3  # corrections with which a landmark that was found again must agree before it is used
NO_PAIR_COST = 10.0  # cost of a pair that is none


@dataclass(frozen=True)
class View:
    """A bearing from a pose of the past."""

    past: PastPose
    bearing: float  # [rad] in its eye's axes
    sd: float  # [rad]


@dataclass(eq=False)
class BearingLandmark:
    """A landmark."""

    point: AttachedPoint
    look: float
    seen: float  # [s] last
    contradictions: int = 0  # in a row


@dataclass(eq=False)
class Track:
    """A direction that is followed."""

    angle: float  # [rad] in the filter's plane, when it was seen last
    look: float
    seen: float  # [s] last
    views: list[View] = field(default_factory=list[View])
    landmark: BearingLandmark | None = None
    agreed: int = PROVEN_CORRECTIONS  # corrections that agreed since the landmark was found again


class BearingLandmarks:
    """The landmarks of one kind in one filter; `see` with every look."""

    def __init__(self, state: Filter, settings: BearingSettings) -> None:
        self._state, self._settings = state, settings
        self.landmarks: list[BearingLandmark] = []
        self._tracks: list[Track] = []
        self._poses: list[PastPose] = []
        self._looked: Pose | None = None  # at the newest look
        self._corrected: Pose | None = None  # at the newest correction
        self._remembered: Pose | None = None  # the newest pose that is kept
        self.used = 0  # bearings that have corrected the state
        self.refused = 0  # bearings that contradicted it

    def see(self, seen: BearingSet, points: Array | None = None) -> None:
        """Take one look; `points` (K, 2) [m] of a scan at that time, robot frame: walls on which landmarks may be."""
        if not self._settings.used:
            return
        now = self._follow(seen)
        pose = self._state.pose
        if not now or not _has_moved(self._corrected, pose, self._settings.apart, self._settings.apart_turn):
            return
        self._corrected = pose
        self._correct(seen, [(track, row) for track, row in now if track.landmark is not None])
        fresh = [(track, row) for track, row in now if track.landmark is None]
        if fresh and _has_moved(self._remembered, pose, self._settings.spacing, math.inf):
            self._remembered = self._state.pose
            self._keep_views(seen, fresh)
            ripe = sorted(
                (track for track, _ in fresh if len(track.views) >= MIN_VIEWS), key=lambda one: -len(one.views)
            )
            for track in ripe[:AT_ONCE]:
                self._make(track, seen, points)
        self._clean_up()

    def interrupt(self) -> None:
        """The robot is elsewhere, or it goes on in another filter: only what is a landmark already stays."""
        self._tracks.clear()
        self._clean_up()
        self._looked = self._corrected = self._remembered = None

    def places(self) -> Array:
        """The landmarks (M, 2) [m] in the filter's plane."""
        indices = [self._state.index_of(landmark.point) for landmark in self.landmarks]
        return self._state.points[indices].reshape(-1, 2)

    # following

    def _follow(self, seen: BearingSet) -> list[tuple[Track, int]]:
        """Bearings → the tracks that they continue, and new tracks; those that are seen now, with their bearing."""
        limits, eye = self._settings, self._state.pose @ seen.eye
        self._tracks = [track for track in self._tracks if abs(seen.stamp - track.seen) <= limits.lapse]
        way = 0.0 if self._looked is None else eye.distance_to(self._looked.x, self._looked.y)
        self._looked = eye
        pairs, taken = self._pairs(seen, eye, limits.follow + limits.follow_per_way * way)
        for track, row in pairs:
            track.angle = eye.heading + float(seen.bearings[row])
            track.seen = max(track.seen, seen.stamp)  # an utterance is judged once more when it is over
            track.look = float(seen.looks[row])
            if track.landmark is not None:
                track.landmark.seen = track.seen
        pairs += self._found_again(seen, [row for row in range(len(seen.bearings)) if row not in taken])
        taken |= {row for _, row in pairs}
        for row in range(len(seen.bearings)):
            if row not in taken:
                angle = eye.heading + float(seen.bearings[row])
                self._tracks.append(Track(angle, float(seen.looks[row]), seen.stamp))
                pairs.append((self._tracks[-1], row))
        return pairs

    def _found_again(self, seen: BearingSet, left: list[int]) -> list[tuple[Track, int]]:
        """Bearings that no track has, landmarks that no track follows → new tracks of these, where it is clear."""
        followed = {id(track.landmark) for track in self._tracks}
        dormant = [landmark for landmark in self.landmarks if id(landmark) not in followed]
        if not dormant or not left or self._settings.again == 0:
            return []
        points = [landmark.point for landmark in dormant]
        angles = expected_bearings(self._state, seen.eye, points)
        spreads = seen_now(self._state, seen.eye, points, angles).state.diagonal()
        sds = np.sqrt(spreads[:, None] + self._variances(seen, np.array(left))[None, :])
        off = np.abs(wrap_all(seen.bearings[left][None, :] - angles[:, None])) / sds
        off[(sds > VAGUE_BEARING_SD_RAD) | ~_alike(np.array([one.look for one in dormant]), seen.looks[left])] = (
            NO_PAIR_COST
        )
        pairs: list[tuple[Track, int]] = []
        for a, b in np.argwhere(off < MAX_OFF_SDS).tolist():
            if min(_second(off[a], b), _second(off[:, b], a)) > 2 * MAX_OFF_SDS:
                row, landmark = left[b], dormant[a]
                angle = self._state.pose.heading + seen.eye.heading + float(seen.bearings[row])
                track = Track(angle, float(seen.looks[row]), seen.stamp, landmark=landmark, agreed=0)
                self._tracks.append(track)
                pairs.append((track, row))
        return pairs

    def _pairs(self, seen: BearingSet, eye: Pose, reach: float) -> tuple[list[tuple[Track, int]], set[int]]:
        """Tracks and bearings, one to one, where it is clear; and all bearings that are near any track."""
        if not self._tracks or not len(seen.bearings):
            return [], set()
        gaps = self._gaps(seen, eye) / reach
        gaps[~_alike(np.array([track.look for track in self._tracks]), seen.looks)] = NO_PAIR_COST
        rows, columns = scipy.optimize.linear_sum_assignment(np.minimum(gaps, NO_PAIR_COST))
        pairs = [
            (self._tracks[a], b)
            for a, b in zip(rows.tolist(), columns.tolist(), strict=True)
            if gaps[a, b] < 1 and gaps[a, b] <= MAX_SECOND_SHARE * min(_second(gaps[a], b), _second(gaps[:, b], a))
        ]
        return pairs, set(np.flatnonzero((gaps < 1).any(axis=0)).tolist())

    def _gaps(self, seen: BearingSet, eye: Pose) -> Array:
        """(T, M) [rad]: how far every bearing is from where each track should be seen."""
        there = np.array([track.angle - eye.heading for track in self._tracks])
        known = {k: track.landmark.point for k, track in enumerate(self._tracks) if track.landmark is not None}
        if known:
            there[[*known]] = expected_bearings(self._state, seen.eye, [*known.values()])
        return np.abs(wrap_all(seen.bearings[None, :] - there[:, None]))

    # using

    def _correct(self, seen: BearingSet, pairs: list[tuple[Track, int]]) -> None:
        """One stacked correction by the landmarks that are seen; those that the others contradict are left out."""
        if not pairs:
            return
        landmarks = [track.landmark for track, _ in pairs if track.landmark is not None]
        rows = np.array([row for _, row in pairs])
        innovation = seen_now(self._state, seen.eye, [one.point for one in landmarks], seen.bearings[rows])
        total = innovation.state + np.diag(self._variances(seen, rows))
        fits = _agreeing(total, innovation.residuals[:, 0], self._settings.gate)
        kept = [k for k in fits if pairs[k][0].agreed >= PROVEN_CORRECTIONS]
        for k, (track, _) in enumerate(pairs):
            track.agreed += k in fits
            if k not in fits and track.agreed < PROVEN_CORRECTIONS:
                self._tracks.remove(track)
        for k, landmark in enumerate(landmarks):
            proven = pairs[k][0].agreed >= PROVEN_CORRECTIONS
            landmark.contradictions = 0 if k in fits else landmark.contradictions + proven
        self.used += len(kept)
        self.refused += len(landmarks) - len(kept)
        if kept:
            chosen = Innovation(innovation.crossing[kept], np.empty(0), innovation.residuals[kept])
            self._state.take_in(chosen, total[np.ix_(kept, kept)])

    def _variances(self, seen: BearingSet, rows: Array) -> Array:
        return seen.sds[rows] ** 2 + self._settings.floor**2

    # making

    def _keep_views(self, seen: BearingSet, pairs: list[tuple[Track, int]]) -> None:
        """Remember where the robot is, and what of it is seen from here."""
        self._poses.append(remember(self._state, seen.eye))
        sds = np.sqrt(self._variances(seen, np.arange(len(seen.bearings))))
        for track, row in pairs:
            track.views.append(View(self._poses[-1], float(seen.bearings[row]), float(sds[row])))
        if len(self._poses) > self._settings.poses:
            oldest = self._poses[0]
            for track in self._tracks:
                track.views = [view for view in track.views if view.past is not oldest]
            self._poses.remove(oldest)
            forget(self._state, oldest)

    def _make(self, track: Track, seen: BearingSet, points: Array | None) -> None:
        """A track becomes a landmark, if its views cross at a clear angle and agree."""
        limits, last = self._settings, track.views[-1]
        best = self._clearest(track.views)
        if best is None:
            return
        first, place = best
        point = self._state.attach(*place)
        for view in track.views:
            if view is first or view is last:
                continue
            if not self._take_in(seen_then(self._state, view.past, point, view.bearing), view.sd**2):
                self._state.detach(point)
                track.views = [last]
                return
        if limits.walls and points is not None:
            self._lay_on_wall(point, last, seen.eye, points)
        track.views = []
        track.landmark = self._known(point, track)
        if track.landmark is None:
            track.landmark = BearingLandmark(point, track.look, track.seen)
            self.landmarks.append(track.landmark)

    def _clearest(self, views: Sequence[View]) -> tuple[View, Crossing] | None:
        """The view that crosses the newest one so that the place is surest, and that place; None: too vague.

        The oldest view has the widest angle, but the odometry since then may say least of where it was.
        """
        last, surest, clearest = views[-1], self._settings.vague, None
        for view in views[:-1]:
            bearings = ((view.past, view.bearing), (last.past, last.bearing))
            place = crossed(self._state, bearings, max(view.sd, last.sd))
            vague = math.inf if place is None else self._vagueness(view, last, *place)
            if place is not None and vague < surest:
                surest, clearest = vague, (view, place)
        return clearest

    def _vagueness(self, first: View, last: View, place: Array, rows: Array, own: Array) -> float:
        """The sd of a place's distance as a share of it; inf when it is not seen from different sides, or is too near
        or too far.
        """
        limits = self._settings
        eyes = self._state.points[[self._state.index_of(view.past.eye) for view in (first, last)]]
        to = place - eyes
        reach = np.hypot(to[:, 0], to[:, 1])
        parallax = abs(wrap(math.atan2(to[0, 1], to[0, 0]) - math.atan2(to[1, 1], to[1, 0])))
        if parallax < limits.parallax or reach.min() < limits.nearest or reach.max() > limits.farthest:
            return math.inf
        along = to[1] / reach[1]
        column = 3 + 2 * self._state.index_of(last.past.eye) + np.arange(2)
        cross = rows[:, column]
        relative = own + self._state.covariance.rows(column)[:, column] - cross - cross.T
        return math.sqrt(max(float(along @ relative @ along), 0.0)) / float(reach[1])

    def _lay_on_wall(self, point: AttachedPoint, view: View, eye: Pose, points: Array) -> None:
        wall = wall_range(SeenWalls(points, eye), view.bearing, view.sd, self._settings.wall_sd)
        if wall is not None:
            self._take_in(ranged_then(self._state, view.past, point, wall[0]), wall[1] ** 2)

    def _take_in(self, innovation: Innovation, variance: float) -> bool:
        total = innovation.state + variance
        if float(innovation.residuals[0, 0]) ** 2 > self._settings.gate * float(total[0, 0]):
            return False
        self._state.take_in(innovation, total)
        return True

    def _known(self, point: AttachedPoint, track: Track) -> BearingLandmark | None:
        """The landmark that was here before, if there is one and only one; the two become one."""
        limits = self._settings
        followed = {id(other.landmark) for other in self._tracks}
        near: list[tuple[BearingLandmark, Innovation]] = []
        for landmark in self.landmarks:
            if id(landmark) in followed or not _alike(np.array([landmark.look]), np.array([track.look]))[0, 0]:
                continue
            both = coincide(self._state, point, landmark.point)
            spread = both.state + 1e-9 * np.eye(2)
            close = math.sqrt(float(np.trace(spread))) < limits.again
            if close and squared_error(both.residuals[:, 0], spread) < COINCIDE_CHI2:
                near.append((landmark, both))
        if len(near) != 1:
            return None
        landmark, both = near[0]
        self._state.take_in(both, both.state + 1e-9 * np.eye(2))
        self._state.detach(point)
        landmark.contradictions, landmark.seen = 0, track.seen
        return landmark

    # forgetting

    def _clean_up(self) -> None:
        """Forget landmarks that are contradicted, or too many, and poses that no direction needs."""
        limits = self._settings
        self.landmarks.sort(key=lambda landmark: -landmark.seen)
        for k, landmark in reversed(list(enumerate(self.landmarks))):
            if k >= limits.most or landmark.contradictions >= limits.chances:
                self._state.detach(landmark.point)
                self.landmarks.remove(landmark)
                self._tracks = [track for track in self._tracks if track.landmark is not landmark]
        needed = {id(view.past) for track in self._tracks for view in track.views}
        for past in [past for past in self._poses if id(past) not in needed]:
            self._poses.remove(past)
            forget(self._state, past)


def _has_moved(since: Pose | None, pose: Pose, way: float, turn: float) -> bool:
    if since is None:
        return True
    return since.distance_to(pose.x, pose.y) >= way or abs(wrap(pose.heading - since.heading)) >= turn


def _alike(some: Array, others: Array) -> Array:
    """Looks (T,) and (M,) → (T, M) bool: whether each two may be of one edge."""
    a, b = some[:, None], others[None, :]
    size = np.maximum(np.minimum(np.abs(a), np.abs(b)), 1e-9)
    similar = np.maximum(np.abs(a), np.abs(b)) <= MAX_STEP_RATIO * size
    return ((a * b > 0) & similar) | (a == 0) | (b == 0)


def _second(gaps: Array, best: int) -> float:
    """The least of gaps (K,) besides the one at `best`."""
    return float(np.delete(gaps, best).min(initial=NO_PAIR_COST))


def _agreeing(total: Array, residuals: Array, gate: float) -> list[int]:
    """Numbers with the covariance (M, M) → those left when the oddest is removed until none is beyond the gate.

    Each is judged by what the others say: of residuals with a common cause only what is its own counts.
    """
    kept = list(range(len(residuals)))
    while kept:
        inverse = np.linalg.inv(total[np.ix_(kept, kept)])
        odd = (inverse @ residuals[kept]) ** 2 / inverse.diagonal()
        worst = int(odd.argmax())
        if odd[worst] <= gate:
            break
        del kept[worst]
    return kept
