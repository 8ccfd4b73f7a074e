"""Moves between two scans by the scans alone: walls laid on walls, from several guesses."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from core.geometry import Pose, wrap
from core.message import Array
from core.perception.landmarks.deskew import beam_ends
from core.perception.landmarks.frame_perception import Beams
from core.sensors import Laser, Scan
from core.slam.scan_matching.point_to_line import LAST_REACH_M, MIN_POINTS, WallPoints, residuals

BEAM_RAD = math.radians(1.4)  # over which neighbouring beams are drawn together …
EDGE_M = 0.25  # … where they end no farther apart
MAX_POINTS_LAID = 70  # of the later scan
REACHES_M = (0.35, 0.2, LAST_REACH_M, LAST_REACH_M)  # within which points belong to each other, round by round
LAST_STEP = 2e-3  # [m], [rad] of a round, after which another one adds nothing
SOFT_M = 0.03  # off its wall, at which a point weighs half
POINT_SD_M = 0.06  # of a point off its wall, their dependence on each other taken in
GOOD_SHARE, LEAST_SHARE = 0.85, 0.75  # of the usual fit: enough to guess no further, to believe the move
ROOM_M, MAX_ROOM_M = 3.0, 7.0  # median range of a room, and that from which on a place is scaled to one
FIRST_FIT, FIT_MEMORY = 0.6, 0.05  # usual fit before any is known, and the weight of a new one


@dataclass(frozen=True)
class ScanMove:
    """The robot's move between two scans, by them alone."""

    pose: Pose
    information: Array  # (3, 3) of x [m], y [m], heading [rad]; singular where walls leave it open

    @property
    def sds(self) -> tuple[float, float]:
        """Standard deviations of the place [m], in the worse direction, and of the heading [rad]."""
        variances = np.diag(np.linalg.inv(self.information + 1e-6 * np.eye(3)))
        return math.sqrt(variances[:2].max()), math.sqrt(variances[2])


def lay(base: WallPoints, other: WallPoints, guess: Pose) -> tuple[float, ScanMove] | None:
    """Lay a scan's walls on an earlier scan's, near a guess of base_from_other → how well they fit 0..1, the move.

    Point-to-line matching with Cauchy weights (Censi, ICRA 2008). None where too few points find a wall.
    """
    pose, fit, curvature = guess, 0.0, np.eye(3)
    for reach in REACHES_M:
        pairs = residuals(base, other, pose, reach)
        if pairs is None:
            return None
        off, slopes = pairs
        weights = 1.0 / (1.0 + (off / SOFT_M) ** 2)
        weighed = slopes.T * weights
        curvature, fit = weighed @ slopes, float(weights.sum()) / len(other.points)
        x, y, turn = (-np.linalg.solve(curvature + 1e-3 * np.eye(3), weighed @ off)).tolist()
        pose = Pose(pose.x + x, pose.y + y, wrap(pose.heading + turn))
        if reach == LAST_REACH_M and max(abs(x), abs(y), abs(turn)) < LAST_STEP:
            break
    return fit, ScanMove(pose, curvature / POINT_SD_M**2)


class PairMatcher:
    """Finds the move between two scans of one laser; it learns how well its scans usually fit.

    Places that are much larger than a room, or are measured in another unit, are laid on each other in a scale of
    their own: reaches and edges are those of rooms.
    """

    def __init__(self, laser: Laser) -> None:
        self._laser = laser
        self._usual = FIRST_FIT
        self.scale, self._measured = 1.0, False  # of the walls, per metre; whether it was taken from a scan

    def walls_of(self, scan: Scan) -> WallPoints:
        """Draw a scan's neighbouring beams together, against their noise → its walls, seen from the robot."""
        ends, hits = beam_ends(scan, self._laser, None, scan.stamp)
        if not self._measured and hits.any():
            middle = float(np.median(np.hypot(*ends[hits].T)))
            self.scale, self._measured = 1.0 if middle < MAX_ROOM_M else ROOM_M / middle, True
        ends = ends * self.scale
        step = max(1, round(BEAM_RAD / abs(scan.angle_step)))
        count = len(ends) // step
        groups = ends[: count * step].reshape(count, step, 2)
        whole: Array = np.asarray(hits[: count * step].reshape(count, step).all(axis=1))
        if step > 1:
            with np.errstate(invalid="ignore"):
                whole = whole & (np.abs(groups[:, 0] - groups[:, -1]).max(axis=1) < EDGE_M)
        return WallPoints(Beams(ends=groups.mean(axis=1), hits=whole))

    def match(self, base: WallPoints, other: WallPoints, guesses: Iterable[Pose]) -> ScanMove | None:
        """Two scans' walls → the move that fits best, from one guess after another until one fits; None: none."""
        few, best = other.thinned(MAX_POINTS_LAID), None
        if min(len(base.points), len(few.points)) < MIN_POINTS:
            return None
        for guess in guesses:
            found = lay(base, few, _scaled(guess, self.scale))
            if found is not None and (best is None or found[0] > best[0]):
                best = found
            if best is not None and best[0] >= GOOD_SHARE * self._usual:
                break
        if best is None or best[0] < LEAST_SHARE * self._usual:
            return None
        self._usual += FIT_MEMORY * (best[0] - self._usual)
        units = np.array([self.scale, self.scale, 1.0])
        return ScanMove(_scaled(best[1].pose, 1.0 / self.scale), best[1].information * np.outer(units, units))


def _scaled(move: Pose, scale: float) -> Pose:
    return Pose(scale * move.x, scale * move.y, move.heading)
