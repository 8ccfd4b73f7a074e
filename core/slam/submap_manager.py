"""The submap manager: it keeps views and leaves a submap for a new one or for a known one."""

import math
from dataclasses import dataclass, field

import numpy as np

from core.geometry import Pose, turned_covariance, wrap
from core.message import Array
from core.perception.landmarks.frame_perception import Beams
from core.sensors import Laser
from core.slam.bearings.bearing_landmarks import BearingSettings, VoiceLandmarkSettings
from core.slam.ekf_slam import EkfSettings
from core.slam.estimate import Estimate
from core.slam.map.closure import ClosureSettings
from core.slam.map.keyframe import Keyframe, keyframe, thinned
from core.slam.map.map_graph import MapGraph
from core.slam.map.occupancy import OccupancySettings
from core.slam.map.pose_graph import GraphEdge, compose_covariance
from core.slam.map.submap import Submap, SubmapSettings
from core.slam.motion import Increment
from core.slam.relocalization.kidnap_detector import KidnapSettings
from core.slam.scan_matching.field_matching import ScanMatchingSettings, match_scan, search_wide, spread
from core.slam.scan_matching.likelihood_field import LikelihoodField

MIN_VARIANCE = 1e-6  # [m²], [rad²] that a driven way is uncertain at least, so that the graph can be solved
CONTRADICTED = np.diag([0.4**2, 0.4**2, math.radians(8) ** 2])  # of the pose when scans contradict each other
MENDED = np.diag([0.05**2, 0.05**2, math.radians(1) ** 2])  # of a place that was found instead
CARRIED = np.diag([1e4, 1e4, 1e2])  # [m²], [rad²] of a way that was not measured


@dataclass(frozen=True)
class MapperSettings:
    """The settings of everything the floor is made of."""

    floor: SubmapSettings = field(default_factory=SubmapSettings)
    matching: ScanMatchingSettings = field(default_factory=ScanMatchingSettings)
    closures: ClosureSettings = field(default_factory=ClosureSettings)
    ekf: EkfSettings = field(default_factory=EkfSettings)
    occupancy: OccupancySettings = field(default_factory=OccupancySettings)
    kidnap: KidnapSettings = field(default_factory=KidnapSettings)
    edges: BearingSettings = field(default_factory=BearingSettings)
    voices: VoiceLandmarkSettings = field(default_factory=VoiceLandmarkSettings)

    def new_submap(self, number: int, laser: Laser | None) -> Submap:
        """Make an empty submap, the robot at its origin."""
        return Submap(number, self.ekf, laser, self.occupancy, self.edges, self.voices)


class SubmapManager:
    """Owns the active submap; puts views into the map graph."""

    def __init__(self, parts: MapperSettings, laser: Laser | None, graph: MapGraph) -> None:
        self._parts, self._laser, self._graph = parts, laser, graph
        self._driven: Increment | None = Increment()  # since the newest view; None: the robot was carried
        self.spread = np.zeros((3, 3))  # of the active submap in the world
        self._looked_from = Pose()  # where the views around were chosen, in the submap that was active then
        if graph.submaps:
            self.active, self._driven = graph.submaps[0], None
        else:
            self.active = self._new()

    @property
    def base(self) -> Pose:
        """The pose of the active submap in the world."""
        return self._graph.world_from(self.active.id) if self.active.views else Pose()

    @property
    def estimate(self) -> Estimate:
        """The robot's pose and its covariance in the world's axes."""
        inner, base = self.active.estimate, self.base
        if base == Pose() and not self.spread.any():
            return inner
        covariance = compose_covariance(base, self.spread, inner.pose, inner.covariance)
        return Estimate(pose=base @ inner.pose, covariance=covariance)

    def moved(self, move: Increment) -> None:
        """Add the robot's move since the scan before."""
        if self._driven is not None and not move.still:
            self._driven = self._driven.then(move)

    def draw(self, beams: Beams) -> None:
        """Put a scan on the active submap's tile."""
        pose = self.active.pose
        self.active.tile.insert(pose @ beams.viewpoint, pose.apply(beams.ends), beams.hits)

    def mend(self, beams: Beams) -> None:
        """Correct the pose where a new scan and the view before look through each other's walls.

        The match was wrong then, or the motion was. A pose is searched at which the two agree. Without such a pose
        the way is in doubt.
        """
        if not self._graph.views or self._driven is None or not self.is_new or int(beams.hits.sum()) < 2:
            return
        state, limit, last = self.active.filter, self._parts.floor.contradiction, self._graph.poses[-1]
        place = last.inverse() @ self.base @ state.pose
        now = keyframe(-1, self.active.id, 0.0, place, beams)
        if contradiction(self._graph.views[-1], now, place) <= limit:
            return
        better = place_again(self._graph, now, place)
        if better is not None and contradiction(self._graph.views[-1], now, better) <= limit:
            state.predict(Increment(place.inverse() @ better, MENDED))
            self._driven = Increment(Pose(), MENDED)
        else:
            state.doubt(CONTRADICTED)
            self._driven = self._driven.then(Increment(Pose(), CONTRADICTED))

    def keep(self, stamp: float, beams: Beams) -> Submap | None:
        """Keep the scan as a view if it is a new one; change rooms where it is time to → the room that was left."""
        if not self.is_new or int(beams.hits.sum()) < 2:
            return None
        if not self.active.views or not self._leaves():
            self._add(stamp, beams, self._tie() if self.active.views else None)
            return None
        left, tie, here = self.active, self._tie(), self.estimate
        left.interrupt()
        entered = self._known_here(thinned(beams.points))
        if entered is None:
            self.active, self.spread = self._new(), here.covariance
            self._add(stamp, beams, tie)
            self.draw(beams)
        else:
            self._enter(*entered)
            self._add(stamp, beams, self._tie())
        return left

    def reset_pose(self, pose: Pose, covariance: Array) -> None:
        """Set the robot to the world pose at which it was found, with covariance (3, 3); the way there is unknown."""
        views = self._graph.views
        if not views:
            self.active.reset_pose(pose, covariance)
            return
        places = self._graph.pose_array()
        nearest = int(np.argmin(np.hypot(places[:, 0] - pose.x, places[:, 1] - pose.y)))
        submap = self._graph.submaps[views[nearest].submap]
        back = self._graph.world_from(submap.id).inverse()
        self._enter(submap, back @ pose, turned_covariance(covariance, back.heading))
        self._driven = None

    def points_around(self) -> list[Array]:
        """Points (K, 2) [m] of the newest views and of the nearest ones, in the active submap's frame."""
        settings, graph, here = self._parts.floor, self._graph, self.active.pose
        self._looked_from = here
        newest = [] if self._driven is None else graph.views[-settings.lately :]
        near = sorted(self.active.views, key=lambda view: view.local.distance_to(here.x, here.y))
        chosen = {view.id: view for view in (*newest, *near[: settings.nearby])}
        back = self.base.inverse()
        return [
            (view.local if view.submap == self.active.id else back @ graph.poses[view.id]).apply(view.points)
            for view in chosen.values()
        ]

    @property
    def has_moved_on(self) -> bool:
        """True if other views are around than those that were chosen, also where the map needs no new one."""
        here = self.active.pose
        return here.distance_to(self._looked_from.x, self._looked_from.y) > self._parts.floor.view_distance

    def respread(self) -> None:
        """Update the covariance of the active submap's place after a change of the graph."""
        self.spread = self._graph.spread_of(self.active.id)

    @property
    def is_new(self) -> bool:
        """True if the map has no view like the present one."""
        pose, views = self.active.pose, self.active.views
        if views and self._driven is not None and not self._apart(pose, views[-1].local):
            return False
        settings = self._parts.floor
        gaps = [(pose.distance_to(view.local.x, view.local.y), self._turn(pose, view.local)) for view in views]
        alike = sum(gap <= settings.view_distance and turn <= settings.view_turn for gap, turn in gaps)
        crowd = sum(gap <= settings.crowd_distance and turn <= settings.crowd_turn for gap, turn in gaps)
        return alike < settings.alike and crowd < settings.crowd

    def _new(self) -> Submap:
        submap = self._parts.new_submap(len(self._graph.submaps), self._laser)
        self._graph.submaps.append(submap)
        return submap

    def _apart(self, one: Pose, other: Pose) -> bool:
        settings = self._parts.floor
        far = one.distance_to(other.x, other.y) > settings.view_distance
        return far or self._turn(one, other) > settings.view_turn

    @staticmethod
    def _turn(one: Pose, other: Pose) -> float:
        return abs(wrap(one.heading - other.heading))

    def _leaves(self) -> bool:
        settings, pose = self._parts.floor, self.active.pose
        far = math.hypot(pose.x, pose.y)
        full = self.active.table.corners > settings.landmarks
        return far > settings.size or (full and far > settings.smallest)

    def _add(self, stamp: float, beams: Beams, tie: GraphEdge | None) -> None:
        """A new view of the active submap, tied to an anchor and to the view before."""
        local, graph = self.active.pose, self._graph
        view = keyframe(len(graph.views), self.active.id, stamp, local, beams)
        pose = graph.poses[tie.a] @ tie.move if tie is not None else self.base @ local
        driven = None
        if graph.views:
            covariance = CARRIED if self._driven is None else self._driven.covariance + MIN_VARIANCE * np.eye(3)
            driven = Increment(graph.poses[-1].inverse() @ pose, covariance)
        self._driven = Increment()
        graph.add(view, driven, tie, pose)

    def _tie(self) -> GraphEdge:
        """Return the edge from the active submap's anchor to the robot, by the filter; its node is the next view."""
        settings, anchor, inner = self._parts.floor, self.active.anchor, self.active.estimate
        floor = np.diag([settings.tie_sd**2, settings.tie_sd**2, settings.tie_heading_sd**2])
        covariance = turned_covariance(inner.covariance, -anchor.local.heading) + floor
        return GraphEdge(anchor.id, len(self._graph.views), anchor.local.inverse() @ inner.pose, covariance)

    def _enter(self, submap: Submap, local: Pose, covariance: Array) -> None:
        self.active.interrupt()
        self.active = submap
        submap.reset_pose(local, covariance)
        self.respread()

    def _known_here(self, points: Array) -> tuple[Submap, Pose, Array] | None:
        """A submap that lies here for certain, with the robot's pose in it and its covariance."""
        settings, graph, here = self._parts.floor, self._graph, self.estimate.pose
        places = graph.pose_array()
        gaps = np.hypot(places[:, 0] - here.x, places[:, 1] - here.y)
        ways = graph.ways_from(len(graph.views) - 1, settings.return_way)
        for number in np.argsort(gaps, kind="stable").tolist():
            if gaps[number] > settings.return_distance:
                break
            submap = graph.submaps[graph.views[number].submap]
            loop_closure = graph.closure_between(submap.id, self.active.id)
            guess = graph.world_from(submap.id).inverse() @ here
            near_its_rim = math.hypot(guess.x, guess.y) > settings.size - settings.inside
            undone = loop_closure is not None and loop_closure.undone
            if submap is self.active or undone or near_its_rim or ways[number] > settings.return_way:
                continue
            return self._fits(submap, guess, points)
        return None

    def _fits(self, submap: Submap, guess: Pose, points: Array) -> tuple[Submap, Pose, Array] | None:
        """Match the scan to a known submap near its expected place; None where it does not fit there."""
        settings = self._parts.floor
        near = sorted(submap.views, key=lambda view: view.local.distance_to(guess.x, guess.y))[: settings.nearby]
        seen = LikelihoodField(np.vstack([view.local.apply(view.points) for view in near]))
        match = match_scan(seen, points, guess, settings.return_reach, settings.return_angle)
        if match.score < settings.return_score:
            return None
        own = spread(seen, points, match.pose, self._parts.matching)
        return submap, match.pose, turned_covariance(own, match.pose.heading)


VIEWS_BEFORE = 9  # views before that make the place
SEARCH_REACH_M, SEARCH_ANGLE_RAD = 1.2, math.radians(36)  # around what was believed
MIN_SCORE = 0.25  # of the scan at the better place, at least: it may show much that is new


def contradiction(one: Keyframe, other: Keyframe, between: Pose) -> float:
    """Share 0..1 of the points that two views look through, `between` one_from_other; the mean of both ways."""
    shares: list[float] = []
    for first, second, pose in ((one, other, between), (other, one, between.inverse())):
        on, through = first.judge(pose.apply(second.points))
        shares.append(through.sum() / max(1, int((on | through).sum())))
    return sum(shares) / 2


def place_again(graph: MapGraph, view: Keyframe, seen: Pose) -> Pose | None:
    """Search the pose of a view, seen from the newest view of the map, around `seen`; None where it fits nowhere."""
    newest, back = graph.views[-1], graph.poses[-1].inverse()
    before = range(max(0, newest.id - VIEWS_BEFORE + 1), newest.id + 1)
    points = np.vstack([(back @ graph.poses[number]).apply(graph.views[number].points) for number in before])
    *_, found = search_wide(LikelihoodField(points), view.points, seen, SEARCH_REACH_M, SEARCH_ANGLE_RAD)
    likely = [match for match in found if match.score >= MIN_SCORE]
    best = min(likely, key=lambda match: contradiction(newest, view, match.pose) - match.score, default=None)
    return None if best is None else best.pose
