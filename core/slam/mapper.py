"""The mapper (front end and back end of SLAM): track, see, draw, keep a view, straighten the map in spare time."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from core.geometry import Pose, wrap
from core.message import Array
from core.perception.landmarks.frame_perception import BearingSet, FramePerception
from core.sensors import Laser, SensorFrame
from core.slam.association.visibility import VisibilityCheck
from core.slam.estimate import Association, Estimate, Landmark, SlamHealth
from core.slam.loop_closure.loop_closer import LoopCloser
from core.slam.map.global_grid import GlobalGrid
from core.slam.map.map_file import SavedMap
from core.slam.map.map_graph import MapGraph
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.status import LostStatus, MapStatus
from core.slam.map_io import is_of_drive, keep, restore
from core.slam.map_view import MapView
from core.slam.motion import Motion
from core.slam.relocalization.monitor import LocalizationMonitor
from core.slam.relocalization.recovery import Click
from core.slam.scan_matching.scan_tracker import ScanTracker
from core.slam.submap_manager import MapperSettings, SubmapManager

STRAYED_M, STRAYED_RAD = 0.3, math.radians(15)  # from where the robot believed to be: another place
SAME_POSE = 1e-9  # [m], [rad] by which a map that is turned back may be off, before it is set to what it was
MAX_OWED_PIECES = 5.0  # pieces of work that a frame with a scan leaves to the frames after it
NO_POINTS = np.zeros((0, 2))


@dataclass(frozen=True)
class AnchoredPose:
    """A place on the map that moves with the map: seen from a view."""

    view: int  # -1: there is none yet
    seen: Pose  # view_from_robot


class Mapper:
    """Estimator of pose and map through a building; `update` with every frame."""

    def __init__(
        self,
        parts: MapperSettings | None = None,
        laser: Laser | None = None,
        watched: bool = True,
        saved: SavedMap | None = None,
        believed: Pose | None = None,
    ) -> None:
        """`watched`: the robot can be lost, then it is looked for; a recording is taken as it comes.

        `saved`: the map to go on in; the robot looks for its place there first, and at `believed` before anywhere.
        Raises BadInput if it does not suit.
        """
        self.parts = parts or MapperSettings()
        self.graph = MapGraph()
        if saved is not None:
            restore(saved, self.graph, self.parts, laser)
        self._tracker = ScanTracker(self.parts.matching)
        self._loop_closer = LoopCloser(self.graph, self.parts.matching, self.parts.closures)
        self._global_grid = GlobalGrid(self.graph, self.parts.occupancy)
        self._map_view = MapView(self.graph)
        self._monitor = LocalizationMonitor(self.parts.kidnap, watched)
        self.submaps = SubmapManager(self.parts, laser, self.graph)
        self._points = NO_POINTS  # (M, 2) [m] of the newest scan, in the active submap
        self._revision = 0  # of the map that the rest has taken in
        self._stamp: float | None = None
        self._owed = 0.0  # pieces of work
        self._enters, self._believed = saved is not None, believed
        self._global_grid.finish(self.submaps.active.id)
        self._turned: tuple[Array, Array] | None = None  # poses (K, 3) before the map was turned last, and after
        self.strayed = False  # whether the place that was found last is another one than was believed

    def update(
        self,
        frame: SensorFrame,
        seen: FramePerception,
        motion: Motion,
        voices: BearingSet | None = None,
        may_turn: bool = False,
    ) -> Estimate:
        """Take one frame: what is seen in it, and the robot's move since the frame before → the estimate.

        `voices`: directions that became known with this frame. `may_turn`: the robot may turn on the spot by itself
        while its place is searched for.
        """
        self._begin_in_loaded_map(frame.stamp)
        self._predict(motion)
        if motion.restarted:
            self._monitor.doubt_restarted(frame.stamp, self.grid, self.estimate.pose)
        self._match_scan(frame.stamp, seen, motion)
        self._correct_by_landmarks(frame, seen)
        self._correct_by_edges(seen)
        self._update_map(frame.stamp, seen)
        self._relocalize(frame.stamp, seen, motion, may_turn)
        self._close_loops(frame.stamp, busy=seen.beams is not None)
        self._correct_by_voices(voices)
        return self.estimate

    @property
    def estimate(self) -> Estimate:
        """The pose and its covariance in the world's axes."""
        return self.submaps.estimate

    @property
    def points(self) -> Array:
        """The newest scan's points (M, 2) [m], in the world."""
        return self.submaps.base.apply(self._points)

    @property
    def anchored_pose(self) -> AnchoredPose:
        """The robot's pose, anchored to a view so that it moves with the map."""
        active = self.submaps.active
        if not active.views:
            return AnchoredPose(-1, active.pose)
        newest = active.views[-1]
        return AnchoredPose(newest.id, newest.local.inverse() @ active.pose)

    def anchored(self, pose: Pose) -> Callable[[], Pose]:
        """A pose in the world → what says where it is by the map as it is then: it moves with the nearest view, that
        of the robot itself with the newest.
        """
        stand = self.anchored_pose
        if pose != self.estimate.pose and self.graph.views:
            away = self.graph.pose_array()[:, :2] - (pose.x, pose.y)
            nearest = int(np.argmin(np.hypot(*away.T)))
            stand = AnchoredPose(nearest, self.graph.poses[nearest].inverse() @ pose)
        return partial(self.where, stand) if stand.view >= 0 else lambda: pose

    def where(self, stand: AnchoredPose) -> Pose:
        """The world pose of a place by the present map."""
        return stand.seen if stand.view < 0 else self.graph.poses[stand.view] @ stand.seen

    @property
    def grid(self) -> OccupancyGrid:
        """The occupancy map of the world."""
        return self._global_grid.grid(self.submaps.active, self._stamp or 0.0)

    @property
    def landmarks(self) -> tuple[Landmark, ...]:
        """The landmarks of all submaps, in the world."""
        return self._map_view.landmarks()

    @property
    def associations(self) -> tuple[Association, ...]:
        """The associations of the newest sightings, in the world."""
        return self._map_view.associations(self.submaps.active)

    @property
    def slam(self) -> SlamHealth:
        """The health of the filter in the active submap; it looks around where the map does."""
        return replace(self.submaps.active.health, looking_around=self.looking_around)

    @property
    def lost(self) -> LostStatus | None:
        """The status of the search for the robot's place; None: it is known."""
        return self._monitor.status

    @property
    def turn(self) -> float:
        """Turn rate [rad/s] at which the robot should turn on the spot for another look at its place."""
        return self._monitor.turn

    @property
    def health(self) -> MapStatus:
        """The health of the scan layer."""
        return MapStatus(
            submaps=self._map_view.submaps(self.submaps.active),
            closures=self._map_view.closures(),
            lost=self.lost,
            match_score=self._tracker.score,
            slipping=self._tracker.slipping,
            graph_revision=self.graph.revision,
        )

    @property
    def looking_around(self) -> bool:
        """The still start is not over: the first move had better wait. A lost robot moves to be found."""
        return self.lost is None and len(self.graph.submaps) == 1 and self.submaps.active.looking_around

    def believe(self, closure: int, believed: bool) -> bool:
        """Take a closure back, the map no longer bends to it, or believe it again → whether there is such a one."""
        return self._loop_closer.believe(closure, believed)

    def turn_map(self, angle: float) -> None:
        """Turn everything about the origin of the world by `angle` [rad]; turned back, it is as before to the bit."""
        if not self.graph.views:
            return
        poses, onto, last = self.graph.pose_array(), Pose(0.0, 0.0, angle), self._turned
        turned = np.array([(onto @ Pose(*row)).vector for row in poses.tolist()])
        if last is not None and np.array_equal(poses[: len(last[1])], last[1]):
            first = len(last[0])
            if np.abs(turned[:first] - last[0]).max() < SAME_POSE:
                turned[:first] = last[0]
        self._turned = poses, turned
        self.graph.revise(turned)
        self._apply_graph()
        self._global_grid.finish(self.submaps.active.id)

    def place_at(self, x: float, y: float, heading: float | None) -> None:
        """Search at the place that the operator clicked: world [m], [rad]."""
        self._monitor.clicked(self._stamp or 0.0, Click(x, y, heading), self.grid, self.estimate.pose)

    def resume_at(self, pose: Pose, covariance: Array) -> None:
        """Go on in the map that was given, at this world pose with its covariance (3, 3), without a search."""
        self._enters = False
        self.submaps.reset_pose(pose, covariance)
        self._tracker.around(self.submaps.points_around())

    @property
    def found(self) -> str:
        """A sentence on how the robot was found last; "" if it never was lost."""
        return self._monitor.words

    def saved(self) -> SavedMap | None:
        """Return the whole map as it is now; None while there is none."""
        return keep(self.graph, self.parts.occupancy.resolution) if self.graph.views else None

    def pose_in(self, saved: SavedMap) -> Pose | None:
        """Return where the robot should be on a map that was saved on this drive; None: it was saved on another."""
        known = not self._monitor.lost and is_of_drive(saved, self.graph)
        return self.estimate.pose if known else None

    def finish(self) -> None:
        """Do all the work that is left at the end of a log."""
        self._loop_closer.finish()
        self._apply_graph()
        self._global_grid.finish(self.submaps.active.id)

    def _begin_in_loaded_map(self, stamp: float) -> None:
        if self._enters:
            self._enters = False
            self._monitor.begin(stamp, "this map was just loaded", self.grid, self._believed, asked=True)

    def _predict(self, motion: Motion) -> None:
        self.submaps.active.advance(motion.increment)

    def _match_scan(self, stamp: float, seen: FramePerception, motion: Motion) -> None:
        """Let the scan correct the wheels' move since the sightings before, and see whether all is well."""
        if seen.beams is None:
            return
        points, active = seen.beams.points, self.submaps.active
        wheels = moved = active.filter.pending
        if self.parts.matching.corrects and not motion.by_scans and not self._monitor.lost:
            moved = self._tracker.track(active.pose @ wheels.pose.inverse(), wheels, points)
            active.filter.amend(moved)
        self.submaps.moved(moved)
        if self._monitor.needs(stamp):
            pose = self.estimate.pose
            self._monitor.observe(stamp, self._tracker, wheels.pose, active.health, points, self.grid, pose)

    def _correct_by_landmarks(self, frame: SensorFrame, seen: FramePerception) -> None:
        """EKF update; what the scan sees through is missing from the map."""
        if seen.sightings is None or self._monitor.lost:
            return
        view = None
        if frame.scan is not None and seen.beams is not None:
            view = VisibilityCheck(frame.scan, seen.beams.viewpoint, seen.camera)
        self.submaps.active.see(seen.sightings, view)

    def _correct_by_edges(self, seen: FramePerception) -> None:
        if seen.edges is not None and not self._monitor.lost:
            active = self.submaps.active
            active.edges.see(seen.edges, None if seen.beams is None else seen.beams.points)

    def _correct_by_voices(self, voices: BearingSet | None) -> None:
        if voices is not None and not self._monitor.lost:
            active = self.submaps.active
            active.voices.see(voices)

    def _update_map(self, stamp: float, seen: FramePerception) -> None:
        """Draw the scan, and keep it if it shows anything new; nothing is written while the place is in doubt."""
        beams, submaps = seen.beams, self.submaps
        if beams is None:
            return
        if not self._monitor.doubtful:
            submaps.mend(beams)
            submaps.draw(beams)
            known = len(self.graph.views)
            left = submaps.keep(stamp, beams)
            if left is not None:
                self._global_grid.rest(left)
            if len(self.graph.views) > known:
                self._loop_closer.look_at(known, stamp)
            if len(self.graph.views) > known or submaps.has_moved_on:
                self._tracker.around(submaps.points_around())
        pose = submaps.active.pose
        self._points = pose.apply(beams.points)

    def _relocalize(self, stamp: float, seen: FramePerception, motion: Motion, may_turn: bool) -> None:
        found = self._monitor.search(stamp, motion.increment.pose, seen.beams, may_turn)
        if found is not None:
            believed = self.estimate.pose
            turned = abs(wrap(found.pose.heading - believed.heading))
            self.strayed = believed.distance_to(found.pose.x, found.pose.y) > STRAYED_M or turned > STRAYED_RAD
            self.submaps.reset_pose(found.pose, found.covariance)
            self._tracker.around(self.submaps.points_around())

    def _close_loops(self, stamp: float, busy: bool) -> None:
        """Pieces of background work for the time that has passed; after a `busy` frame they wait a little."""
        elapsed = 0.0 if self._stamp is None else max(0.0, stamp - self._stamp)
        self._stamp = stamp
        settings = self.parts.floor
        self._owed = min(self._owed + elapsed * settings.pieces, settings.most_pieces)
        pieces = 0 if busy and self._owed < MAX_OWED_PIECES else int(self._owed)
        self._owed -= pieces
        if pieces:
            self._global_grid.work(self.submaps.active.id, 1)
            if self.parts.matching.corrects:
                self._loop_closer.work(pieces)
        self._apply_graph()

    def _apply_graph(self) -> None:
        if self._revision != self.graph.revision:
            self._revision = self.graph.revision
            self.submaps.respread()
            self._tracker.around(self.submaps.points_around())
