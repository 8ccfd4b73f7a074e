"""Odometry from the laser alone, for robots and recordings without wheels."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from core.geometry import Pose, wrap
from core.message import Array
from core.perception.landmarks.deskew import deskew
from core.sensors import Laser, Scan, Wheels
from core.setting import Meta, Section
from core.slam.motion import Increment
from core.slam.scan_matching.likelihood_field import LikelihoodField, Match
from core.slam.scan_matching.match_covariance import match_spread


@dataclass(frozen=True)
class ScanOdometrySettings(Section):
    """Settings of scan odometry.

    Watch:
        reach: a robot without wheels that loses its way when it drives fast (then raise it)
        angle: a robot without wheels that loses its way when it turns fast (then raise it)
    """

    points: int = 180  # points of a scan that the search looks at
    score: float = 0.35  # score of a match, at least
    keyframes: int = 20  # keyframes that make up the local map
    distance: float = 0.15  # [m] way between keyframes
    turn: float = math.radians(8)  # [rad] turn between keyframes, where the way is shorter
    coast: float = 0.5  # share of the former motion that is expected to go on where a match fails
    still_distance: float = 0.008  # [m] a shorter move is none …
    still_turn: float = math.radians(0.2)  # [rad] … where its turn is smaller than this
    place_sd: float = 0.003  # [m] least sd of a matched move
    heading_sd: float = math.radians(0.1)  # [rad] least sd of a matched turn
    point_sd: float = 0.1  # [m] sd of a point across its wall, correlation included
    wall: float = 0.3  # [m] distance between neighbouring points on one wall, at most
    blind_speed: float = 0.3  # [m/s] sd of the speed where a match fails
    blind_turn: float = math.radians(30)  # [rad/s] sd of the turn rate where a match fails
    reach: Annotated[float, Meta("m", 0.02, 1, "distance around the predicted place searched")] = 0.2
    angle: Annotated[float, Meta("rad", 0.02, 1, "angle around the predicted heading searched")] = math.radians(10)


MIN_POINTS = 20  # points of a scan that can be matched
MAX_SPEED_M_S, MAX_TURN_RATE_RAD_S = 5.0, 8.0  # of a robot; a faster one was stamped wrongly
MAX_COASTING_S = 1.0  # for which the former motion goes on unseen, at most


class ScanOdometry:
    """Lays every scan on a local map of the scans before it."""

    def __init__(self, laser: Laser, settings: ScanOdometrySettings | None = None) -> None:
        self.settings = settings or ScanOdometrySettings()
        self.pose = Pose()
        self.score: float | None = None  # of the newest match; None: there was none
        self._laser = laser
        self._matched = Pose()  # of the newest scan
        self._motion = Pose()  # per second
        self.taken: float | None = None  # [s] when the last beam of the newest scan was measured: the pose's time
        self._frames: list[tuple[Pose, Array]] = []
        self._field: LikelihoodField | None = None

    @property
    def wheels(self) -> Wheels:
        """The wheels' reading that the scans stand in for: for de-skewing, dead reckoning and the operator."""
        return Wheels(odometry=self.pose, speed=self._motion.x, turn_rate=self._motion.heading)

    def update(self, scan: Scan) -> Increment:
        """A scan → the move since the scan before, each at its own time: they may come late, and several at once."""
        taken = float(max(scan.times[0], scan.times[-1]))
        elapsed = 0.0 if self.taken is None else taken - self.taken
        self.taken = taken
        if elapsed < 0.0:
            self._frames.clear()  # time went backwards (a seek): the local map is of no use
            self._field, self._motion = None, Pose()
        points, _ = deskew(scan, self._laser, self.wheels, taken)
        if self._field is None:
            if len(points) >= MIN_POINTS:
                self._keep(points)
            return Increment()
        match = self._search(self._field, points, elapsed)
        self.score = match.score if match else None
        if match is None:
            return self._coast(points, elapsed)
        self._motion = _per_second(self._matched.inverse() @ match.pose, elapsed)
        points, _ = deskew(scan, self._laser, self.wheels, taken)  # by this motion, not by the one before
        pose = self._field.refine(points, match.pose).pose
        self._motion, self._matched = _per_second(self._matched.inverse() @ pose, elapsed), pose
        self._keep(points)
        return self._report(self._spread(points))

    def _search(self, field: LikelihoodField, points: Array, elapsed: float) -> Match | None:
        """Search around where the motion leads, coarse then fine, and refine; None where nothing fits."""
        settings = self.settings
        if len(points) < MIN_POINTS:
            return None
        expected = self._matched @ _scaled(self._motion, min(elapsed, MAX_COASTING_S))
        thinned = points[:: max(1, len(points) // settings.points)]
        coarse = field.search(thinned, expected, settings.reach, settings.angle, 0.1, math.radians(1))
        fine = field.search(thinned, coarse, 0.05, math.radians(0.5), 0.05, math.radians(0.25))
        match = field.refine(points, fine)
        return match if match.score >= settings.score else None

    def _spread(self, points: Array) -> Array:
        """Covariance (3, 3) of a matched move: from the directions of the walls in the scan, with a floor."""
        settings = self.settings
        return match_spread(
            points,
            point_sd=settings.point_sd,
            wall=settings.wall,
            unknown=np.array([settings.reach, settings.reach, settings.angle]),
            floor=np.array([settings.place_sd, settings.place_sd, settings.heading_sd]),
        )

    def _report(self, covariance: Array) -> Increment:
        """Return the move since the last reported pose; a move within the jitter of the match counts as none."""
        step = self.pose.inverse() @ self._matched
        settings = self.settings
        if math.hypot(step.x, step.y) < settings.still_distance and abs(step.heading) < settings.still_turn:
            self._motion = Pose()
            return Increment()
        self.pose = self._matched
        return Increment(step, covariance)

    def _coast(self, points: Array, elapsed: float) -> Increment:
        settings = self.settings
        self._motion = _scaled(self._motion, settings.coast)
        self._matched = self._matched @ _scaled(self._motion, min(elapsed, MAX_COASTING_S))
        if len(points) >= MIN_POINTS:
            self._frames.clear()
            self._keep(points)
        self.pose, before = self._matched, self.pose
        sd = np.array([settings.blind_speed, settings.blind_speed, settings.blind_turn]) * max(elapsed, 0.1)
        return Increment(before.inverse() @ self.pose, np.diag(sd**2))

    def _keep(self, points: Array) -> None:
        if self._frames:
            last = self._frames[-1][0]
            near = last.distance_to(self._matched.x, self._matched.y) < self.settings.distance
            if near and abs(wrap(self._matched.heading - last.heading)) < self.settings.turn:
                return
        self._frames.append((self._matched, self._matched.apply(points)))
        del self._frames[: -self.settings.keyframes]
        self._field = LikelihoodField(np.vstack([kept for _, kept in self._frames]))


def _per_second(move: Pose, elapsed: float) -> Pose:
    """A move within `elapsed` [s] → per second; none where no robot moves so fast, because the stamps are wrong."""
    way = math.hypot(move.x, move.y)
    if way >= MAX_SPEED_M_S * elapsed or abs(move.heading) >= MAX_TURN_RATE_RAD_S * elapsed:
        return Pose()
    return _scaled(move, 1 / elapsed)


def _scaled(motion: Pose, share: float) -> Pose:
    return Pose(motion.x * share, motion.y * share, wrap(motion.heading * share))
