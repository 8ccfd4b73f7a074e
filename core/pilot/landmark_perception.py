"""Seeing: from a frame's raw readings to points, corners, edges and sightings."""

import math
from dataclasses import replace

import cv2
import numpy as np

from core.errors import BadInput
from core.geometry import Pose, Transform, arc
from core.message import Array
from core.perception.image_quality.quality import PictureQuality, judge
from core.perception.landmarks.corners import Corner, find_corners
from core.perception.landmarks.deskew import beam_ends
from core.perception.landmarks.edge_pairs import EdgePair, edge_pairs
from core.perception.landmarks.edges import NOTHING, ImageEdge, find_edges
from core.perception.landmarks.frame_perception import Beams, BearingSet, FramePerception
from core.perception.landmarks.landmarks import SeenWalls, Sighting, edges_on_walls, laser_in_picture, sight
from core.perception.landmarks.stereo import MAX_STAMPS_S, edges_by_pair, second_camera
from core.robots import Profile
from core.sensors import Camera, Image, Laser, Scan, SensorFrame, Wheels
from core.settings import Settings
from core.slam.motion import Motion
from core.slam.motion_history import MotionHistory
from core.snapshot import CameraView

NO_POINTS = np.zeros((0, 2))
MAX_EDGE_AGE_S = 0.2  # for which edges may confirm corners, and points may be drawn on a picture
REST_AFTER_STANDING_S = 3.0  # of standing after which one picture more tells nothing that thirty did not
REST_AFTER_READING_S = 5.0  # after which one scan more tells nothing that fifty did not: they draw the map here
REST_LOOK_PERIOD_S = 0.45  # between the pictures that are looked at then while something changes in them
LOOK_WHEN_SLOW_S = 0.15  # [s] between the pictures that are looked at where the computer is too slow for all
UNCHANGED_PERIOD_S = 1.95  # between the pictures and scans that are looked at then while nothing changes
CELL_PX = 8  # of a picture's cells, whose brightness shows whether it has changed
MIN_BRIGHTNESS_STEP = 6.0  # [grey levels] in a cell: twenty times what noise does to it
MIN_RANGE_CHANGE_M = 0.1  # by which a beam differs, at least, where something has moved
CHANGED_SHARE = 0.05  # the same as a share of its range: 3.5 standard deviations where a range is known to 1 %
MAX_CHANGED_BEAMS_SHARE = 0.01  # of the beams that may differ although nothing has: edges are hit now and missed now
MAX_SCAN_WAIT_S = 0.3  # since the newest scan for which a picture's edges wait for the next
MAX_SECOND_WAIT_S = 0.06  # for which they wait for the second picture of a pair of cameras
MAX_TRACKED_EDGE_AGE_S = 0.5  # for which edges may confirm corners where the move between the two is remembered


class LandmarkPerception:
    """Remembers the newest picture's edges and the newest scan's points, to bring the two together."""

    def __init__(self, profile: Profile, settings: Settings) -> None:
        self._lasers = {laser.name: laser for laser in profile.lasers}
        self._laser = profile.laser or Laser()  # of scans that name none
        self.camera = profile.camera
        self._second = second_camera(profile.cameras) if settings.edges.by_pair else None
        self._seconds: tuple[float, tuple[ImageEdge, ...]] = (-np.inf, ())  # time [s] and edges of its newest picture
        self._settings = settings
        self._edges: tuple[ImageEdge, ...] = ()
        self._edges_stamp = -np.inf
        self._small: Array | None = None  # the newest picture that was looked at, shrunk
        self._reported = -np.inf  # [s] of the newest picture whose edges were reported as bearings
        self._quality: PictureQuality | None = None
        self._points = np.zeros((0, 2))
        self._points_stamp = -np.inf
        self._recall = MotionHistory()
        self.view: CameraView | None = None
        self.trouble = ""  # why the newest picture is of no use
        self.poor = ""  # what is wrong with the pictures, once they have been unusable for a while
        self._usable_stamp = np.inf
        self._moved_stamp = np.inf  # of the newest frame in which the robot moved, or might have
        self._scan: Scan | None = None  # the newest that was looked at

    def camera_of(self, image: Image | None, stamp: float) -> Camera | None:
        """The camera as it stood when a picture was taken, seen from the robot at `stamp` [s]."""
        moved = None if image is None else self._recall.moved(stamp, image.stamp)
        if self.camera is None or moved is None or moved.pose == Pose():
            return self.camera
        return replace(self.camera, mounting=Transform.of_pose(moved.pose) @ self.camera.mounting)

    def take_second(self, image: Image | None) -> None:
        """Find the edges of a picture, if it is of the second camera of a pair."""
        if image is not None and self._second is not None and image.camera == self._second.name:
            self._seconds = image.stamp, find_edges(image, self._second, self._settings.edges)

    def look(self, frame: SensorFrame, motion: Motion, idle: bool = False) -> FramePerception:
        """One frame → what is seen in it; `view` is renewed when a picture or new matches came.

        `idle`: nobody needs the newest scan of a robot that stands, where it is like the one before.
        """
        self._recall.add(frame.stamp, motion.increment)
        if motion.wheels is None or motion.wheels.moves or self._moved_stamp > frame.stamp:
            self._moved_stamp = frame.stamp
        if frame.image is not None and self.camera is not None:
            try:
                if not self._has_seen_enough(frame.image, frame.pace):
                    self._judge(frame.image, motion.wheels)
                    self._find_edges(frame.image, self.camera)
                self._show(frame.image, self.camera, motion.wheels)
                self.trouble = ""
            except BadInput as trouble:
                self.trouble = str(trouble)
        if frame.scan is None:
            waits = frame.stamp - self._points_stamp < MAX_SCAN_WAIT_S  # a scan says which of them confirm a corner
            if self._second is not None and self._seconds[0] < self._edges_stamp:
                waits |= frame.stamp - self._edges_stamp < MAX_SECOND_WAIT_S
            by_pair, bearings = ((), None) if waits else self._alone(self._edges, NO_POINTS, frame.stamp)
            return FramePerception(sightings=by_pair or None, edges=bearings)
        if idle and self._is_like_before(frame.scan, frame.stamp):
            return FramePerception()
        self._scan = frame.scan
        if motion.scanned is not None:
            return self._look_at_scan(frame.scan, motion.scanned, motion.scanned, motion.wheels)
        then = self._recall.taken(frame.scan, frame.stamp)
        return self._look_at_scan(frame.scan, then, frame.stamp, motion.wheels)

    def _has_seen_enough(self, image: Image, pace: float = 1.0) -> bool:
        """True for most pictures of a robot that stands: looking is half of what an idle console computes.

        On a computer that is too slow for the robot (`pace` < 1) it is true for every second one of any robot.
        """
        age = image.stamp - self._edges_stamp
        if pace < 1 and 0 <= age < LOOK_WHEN_SLOW_S:
            return True
        if image.stamp - self._moved_stamp <= REST_AFTER_STANDING_S or not 0 <= age < UNCHANGED_PERIOD_S:
            return False
        return age < REST_LOOK_PERIOD_S or not self._has_changed(image)

    def _has_changed(self, image: Image) -> bool:
        small = _shrunk(image.pixels)
        last = self._small
        return last is None or last.shape != small.shape or float(np.abs(small - last).max()) > MIN_BRIGHTNESS_STEP

    def _is_like_before(self, scan: Scan, stamp: float) -> bool:
        """True for most scans of a robot that stands in a room in which nothing moves."""
        last = self._scan
        if last is None or stamp - self._moved_stamp <= REST_AFTER_READING_S or last.laser != scan.laser:
            return False
        if not 0 <= scan.stamp - last.stamp < UNCHANGED_PERIOD_S or last.ranges.shape != scan.ranges.shape:
            return False
        known = np.isfinite(scan.ranges) & np.isfinite(last.ranges)
        ranges = last.ranges[known]
        least = np.maximum(MIN_RANGE_CHANGE_M, CHANGED_SHARE * ranges)
        return float(np.mean(np.abs(scan.ranges[known] - ranges) > least)) <= MAX_CHANGED_BEAMS_SHARE

    def _judge(self, image: Image, wheels: Wheels | None) -> None:
        settings = self._settings.image_quality
        turn_rate = wheels.turn_rate if wheels else 0.0
        quality = judge(image, turn_rate=turn_rate, settings=settings, edges=self._settings.edges)
        self._quality = quality
        if quality.state != "unusable" or self._usable_stamp > image.stamp:
            self._usable_stamp, self.poor = image.stamp, ""
        elif not self.poor and image.stamp - self._usable_stamp > settings.unusable_after:
            self.poor = quality.complaint

    def _find_edges(self, image: Image, camera: Camera) -> None:
        preparation = self._quality.preparation if self._quality else NOTHING
        self._edges = find_edges(image, camera, self._settings.edges, preparation)
        self._edges_stamp, self._small = image.stamp, _shrunk(image.pixels)

    def _show(self, image: Image, camera: Camera, wheels: Wheels | None) -> None:
        height, width = image.pixels.shape[:2]
        self.view = CameraView(
            stamp=image.stamp,
            width=width,
            height=height,
            edges=self._edges,
            laser=self._points_in_picture(camera, image.stamp, wheels),
            quality=self._quality,
        )

    def _points_in_picture(self, camera: Camera, stamp: float, wheels: Wheels | None) -> Array:
        elapsed = stamp - self._points_stamp
        if elapsed > MAX_EDGE_AGE_S:
            return np.zeros((0, 3))
        moved = arc(wheels.speed * elapsed, wheels.turn_rate * elapsed) if wheels else Pose()
        return laser_in_picture(self._points, self._laser, camera, moved)

    def _look_at_scan(self, scan: Scan, then: float, stamp: float, wheels: Wheels | None) -> FramePerception:
        """Find points and corners in a scan, seen from the pose of time `then` [s]; `stamp`: of the newest pose."""
        felt = self._recall.wheels(then, stamp, wheels)
        laser = self._lasers.get(scan.laser, self._laser)
        ends, hits = beam_ends(scan, laser, felt, then)
        corners = find_corners(scan, laser, ends[hits], np.flatnonzero(hits), self._settings.corners)
        since = self._recall.moved(then, self._edges_stamp)
        known = MAX_TRACKED_EDGE_AGE_S if since is not None else MAX_EDGE_AGE_S
        fresh = self._edges if abs(then - self._edges_stamp) < known else ()
        sightings, edges = sight(
            corners,
            fresh,
            stamp=then,
            edges_stamp=self._edges_stamp,
            wheels=felt,
            moved=None if since is None else since.pose,
            camera=self.camera,
            settings=self._settings.edges,
        )
        sightings, ends = self._recall.bring(then, stamp, sightings, ends)
        few = len(corners) < self._settings.edges.corners_enough
        looked = fresh and (few or self._second is not None)
        on_walls, bearings = self._alone(edges, ends[hits], stamp, few) if looked else ((), None)
        beams = Beams(ends=ends, hits=hits, viewpoint=laser.mounting)
        self._points, self._points_stamp = beams.points, stamp
        if fresh and self.view is not None:
            self.view = replace(self.view, edges=edges)
        gated = self._settings.edges.edge_required and self.camera is not None
        return FramePerception(
            beams=beams,
            sightings=None if gated and not fresh else (*sightings, *on_walls),
            camera=self.camera if gated else None,
            edges=bearings,
            pairs=self._pairs(corners, fresh, then, felt),
        )

    def _alone(
        self, edges: tuple[ImageEdge, ...], points: Array, stamp: float, few: bool = True
    ) -> tuple[tuple[Sighting, ...], BearingSet | None]:
        """The newest picture's edges that confirm no corner, once, seen from the robot at `stamp` [s].

        Those on walls that the laser sees, by `points` (M, 2) [m] of its scan, are sightings, and so are those whose
        distance a second camera gives; the others are bearings. Where corners are not `few`, a second camera is asked
        only where the scan shows nothing.
        """
        if self.camera is None or self._edges_stamp <= self._reported:
            return (), None
        move = self._recall.moved(stamp, self._edges_stamp)
        if move is None:
            return (), None
        self._reported = self._edges_stamp
        settings = self._settings.edges
        x, y = self.camera.mounting.translation[:2].tolist()
        eye, on_walls = move.pose @ Pose(x, y), ()
        alone, walls = tuple(edge for edge in edges if not edge.matched), SeenWalls(points, eye)
        if not few:
            alone = tuple(edge for edge in alone if walls.near(edge.bearing) is None)
        if settings.on_walls:
            on_walls, alone = edges_on_walls(alone, points, eye, stamp, settings)
        if self._second is not None and abs(self._seconds[0] - self._edges_stamp) <= MAX_STAMPS_S:
            pair = self.camera, self._second
            by_pair, alone = edges_by_pair(alone, self._seconds[1], pair, eye, stamp, settings)
            on_walls = *on_walls, *by_pair
        sd = math.hypot(settings.bearing_sd, settings.shift_share * move.pose.heading)
        return on_walls, None if not few else BearingSet(
            stamp=self._edges_stamp,
            eye=eye,
            bearings=np.array([edge.bearing for edge in alone]),
            sds=np.full(len(alone), sd),
            looks=np.array([edge.step for edge in alone]),
        )

    def _pairs(
        self, corners: tuple[Corner, ...], edges: tuple[ImageEdge, ...], stamp: float, wheels: Wheels | None
    ) -> tuple[EdgePair, ...]:
        if self.camera is None:
            return ()
        elapsed = self._edges_stamp - stamp
        moved = arc(wheels.speed * elapsed, wheels.turn_rate * elapsed) if wheels and edges else Pose()
        return edge_pairs(corners, edges, moved, self.camera, self._settings.edges)


def _shrunk(pixels: Array) -> Array:
    return cv2.resize(pixels, None, fx=1 / CELL_PX, fy=1 / CELL_PX, interpolation=cv2.INTER_AREA).astype(np.float32)
