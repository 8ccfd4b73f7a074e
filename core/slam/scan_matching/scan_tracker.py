"""The scan tracker: it matches the newest scan against the views around, and detects slipping wheels."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from core.geometry import Pose, rotation, wrap
from core.message import Array
from core.slam.map.keyframe import thinned
from core.slam.motion import Increment
from core.slam.scan_matching.field_matching import ScanMatchingSettings, ambiguity, match_scan, spread, window
from core.slam.scan_matching.likelihood_field import LikelihoodField

FEWEST = 20  # points of a scan that can be matched
SLIP = 16.3  # chi-square, 3 degrees of freedom, 99.9 %: wheels and scan contradict each other
LEARN = 0.05  # by which the doubt in the wheels follows what one scan says of them
USUAL = 2.0  # squared distance per degree of freedom that says nothing against the wheels: matches are not white
SHOCK = 4.0  # that one scan can say, at most
WORST = 1e4  # doubt
FIRST = 100.0  # doubt in wheels that are unknown yet; good ones are trusted after a few seconds of driving
SURPRISED = 0.3  # of a contradiction remains as doubt in the scan, too
SMALL = 1e-9  # [m²], [rad²] that keeps a standing wheel's covariance regular


class ScanTracker:
    """Lays scans on a field of the views around, in the frame of the active submap."""

    def __init__(self, settings: ScanMatchingSettings) -> None:
        self.settings = settings
        self.score: float | None = None  # of the newest match
        self.seen: Pose | None = None  # the newest move by the scans alone
        self.slipping = False
        self.doubt = FIRST  # how much worse the wheels are than they claim: a factor on their covariance
        self._field: LikelihoodField | None = None
        self._stood: Pose | None = None  # where the scan before lay, while the wheels stand

    def around(self, views: Sequence[Array]) -> None:
        """From now on match on these points, (K, 2) [m] each, in the submap's frame."""
        self._field, self._stood = LikelihoodField(np.vstack(views)) if views else None, None

    def track(self, start: Pose, wheels: Increment, points: Array) -> Increment:
        """The move from `start` (submap's frame) by the wheels → by wheels and scan together.

        `points` (M, 2) [m] of the scan at its end, robot frame. While the wheels stand, `seen` is the move since the
        scan before: a match that is a little off its place, always the same, is no move.
        """
        self.score, self.seen, self.slipping = None, None, False
        stood, self._stood = self._stood if wheels.still else None, None
        if self._field is None or len(points) < FEWEST:
            return wheels
        few = thinned(points)
        reach, angle = window(wheels.pose, self.settings)
        match = match_scan(self._field, few, stood or start @ wheels.pose, reach, angle)
        self.score = match.score
        if match.score >= self.settings.score:
            self.seen = (stood or start).inverse() @ match.pose
            self._stood = match.pose
        if wheels.still:
            return wheels
        if self.seen is None:
            return Increment(wheels.pose, self.doubt * wheels.covariance)
        own = spread(self._field, few, match.pose, self.settings)
        back = rotation(-match.pose.heading)
        own[:2, :2] += back @ ambiguity(self._field, few, match, reach) @ back.T
        return self._fuse(wheels, self.seen, own)

    def _fuse(self, wheels: Increment, seen: Pose, own: Array) -> Increment:
        """The wheels' move and the scan's (`own`: its covariance where it ends), by how sure each of them is."""
        onto = np.eye(3)
        onto[:2, :2] = rotation(seen.heading)
        noise = onto @ own @ onto.T
        error = seen.vector - wheels.pose.vector
        error[2] = wrap(float(error[2]))
        claimed = wheels.covariance + SMALL * np.eye(3)
        believed = self.doubt * claimed
        squared = float(error @ np.linalg.solve(believed + noise, error))
        self.slipping = squared > SLIP
        self.doubt = min(max(self.doubt * math.exp(LEARN * min(squared / 3 - USUAL, SHOCK)), 1.0), WORST)
        if self.slipping:
            return Increment(seen, noise + np.diag((SURPRISED * error) ** 2))
        gain = believed @ np.linalg.inv(believed + noise)
        fused = wheels.pose.vector + gain @ error
        covariance = believed - gain @ believed
        return Increment(Pose(*fused.tolist()), 0.5 * (covariance + covariance.T))
