"""The scan tracker: it matches the newest scan against the views around, and detects slipping wheels."""

import math
from collections.abc import Sequence

import numpy as np

from core.geometry import Pose, turned_covariance, wrap
from core.message import Array
from core.slam.map.keyframe import thinned
from core.slam.motion import Increment
from core.slam.scan_matching.field_matching import (
    EQUAL_SCORE,
    ScanMatchingSettings,
    blurred,
    information,
    match_scan,
    window,
)
from core.slam.scan_matching.likelihood_field import LikelihoodField, Match

MIN_POINTS = 20  # points of a scan that can be matched
SLIP_CHI2 = 16.3  # chi-square, 3 degrees of freedom, 99.9 %: wheels and scan contradict each other
DOUBT_GAIN = 0.05  # by which the doubt in the wheels follows what one scan says of them
USUAL_MISFIT = 2.0  # squared distance per dof that says nothing against the wheels: matches are not white
MAX_MISFIT_STEP = 4.0  # that one scan can say, at most
MAX_DOUBT = 1e4  # doubt
FIRST_DOUBT = 100.0  # doubt in wheels that are unknown yet; good ones are trusted after a few seconds of driving
CONTRADICTION_SHARE = 0.3  # of a contradiction remains as doubt in the scan, too
MIN_INFORMATION = 100.0  # [1/m²], [1/rad²]: of a direction with less information a scan says nothing
SEARCH_WIDTH_SD = 3.0  # of an unknown move, around which it is looked for
MIN_VARIANCE = 1e-9  # [m²], [rad²] that keeps a standing wheel's covariance regular


class ScanTracker:
    """Lays scans on a field of the views around, in the frame of the active submap."""

    def __init__(self, settings: ScanMatchingSettings) -> None:
        self.settings = settings
        self.score: float | None = None  # of the newest match
        self.seen: Pose | None = None  # the newest move by the scans alone
        self.slipping = False
        self.doubt = FIRST_DOUBT  # how much worse the wheels may be than they claim: a factor on their covariance
        self.shown = 1.0  # how much worse the scans have shown them to be
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
        if self._field is None or len(points) < MIN_POINTS:
            return wheels
        few = thinned(points)
        reach, angle = self._window(wheels)
        guess = stood or start @ wheels.pose
        match = match_scan(self._field, few, guess, reach, angle)
        own = information(self._field, few, match, reach, self.settings)
        if np.linalg.matrix_rank(own, MIN_INFORMATION, hermitian=True) < len(own):
            match = _nearer(self._field, few, guess, match)
        self.score = match.score
        if match.score >= self.settings.score:
            self.seen = (stood or start).inverse() @ match.pose
            self._stood = match.pose
        if wheels.still:
            return wheels
        if self.seen is None:
            return Increment(wheels.pose, self.shown * wheels.covariance)
        return self._fuse(wheels, self.seen, own)

    def _window(self, wheels: Increment) -> tuple[float, float]:
        """How far around the end of a move to look: [m] and [rad] to either side; wider for an unknown one."""
        reach, angle = window(wheels.pose, self.settings)
        if not wheels.is_unknown:
            return reach, angle
        place_sd, heading_sd = np.sqrt(np.diag(wheels.covariance)[1:]).tolist()
        settings = self.settings
        return min(reach + SEARCH_WIDTH_SD * place_sd, settings.widest), min(
            angle + SEARCH_WIDTH_SD * heading_sd, settings.widest_angle
        )

    def _fuse(self, wheels: Increment, seen: Pose, own: Array) -> Increment:
        """The wheels' move and the scan's (`own`: its information where it ends), by how sure each of them is.

        Where the walls leave the place open the wheels' word stands (degeneracy; Zhang, Kaess and Singh, ICRA 2016),
        and it is as sure as they claim, unless scans have shown elsewhere that it is not.
        """
        found = turned_covariance(own, seen.heading)
        error = seen.vector - wheels.pose.vector
        error[2] = wrap(float(error[2]))
        values, axes = np.linalg.eigh(found)
        values, axes = values[values > MIN_INFORMATION], axes[:, values > MIN_INFORMATION]
        found, held = (axes * values) @ axes.T, axes @ axes.T
        claimed = wheels.covariance + MIN_VARIANCE * np.eye(3)
        sides = math.sqrt(self.doubt) * held + math.sqrt(self.shown) * (np.eye(3) - held)
        believed = sides @ claimed @ sides
        squared = float(error @ blurred(found, believed) @ error)
        shown = float(error @ blurred(found, self.shown * claimed) @ error)
        self.doubt = _learnt(self.doubt, squared, len(values))
        self.shown = _learnt(self.shown, shown, len(values))
        self.slipping = squared > SLIP_CHI2
        x, y, turn = (held @ error).tolist() if self.slipping else (0.0, 0.0, 0.0)
        surprise = np.diag([x * x + y * y, x * x + y * y, turn * turn])
        believed += surprise
        gain = believed @ blurred(found, believed)
        covariance = believed - gain @ believed + CONTRADICTION_SHARE**2 * surprise
        fused = Pose(*(wheels.pose.vector + gain @ error).tolist())
        return Increment(fused, 0.5 * (covariance + covariance.T))


def _nearer(field: LikelihoodField, points: Array, guess: Pose, best: Match) -> Match:
    """The place nearest to the guess at which the points fit, unless they fit clearly better elsewhere around.

    Along an open corridor points at the rim of the view have nothing to lie on yet, so farther back, and turned a
    little, a scan seems to fit better.
    """
    near = field.refine(points, guess)
    return near if near.score > best.score - EQUAL_SCORE else best


def _learnt(doubt: float, squared: float, count: int) -> float:
    """A doubt in the wheels after a squared distance of `count` degrees of freedom between them and a scan."""
    if count == 0:
        return doubt
    return min(
        max(doubt * math.exp(DOUBT_GAIN * min(squared / count - USUAL_MISFIT, MAX_MISFIT_STEP)), 1.0), MAX_DOUBT
    )
