"""One run through an estimator: where it thought it was, how far off that is, and how sure it was."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from core.experiments.course_draws import Run
from core.geometry import Pose
from core.message import Array, message
from core.slam.consistency import nees
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.estimate import Estimate, Landmark
from core.slam.motion import Increment, steered


@message
class Trace:
    """The result of one estimator on one run."""

    times: Array  # (M,) [s] since the first move
    places: Array  # (M, 2) [m]
    truth: Array  # (M, 2) [m], where it was
    path: float  # [m] really travelled
    nees: float  # mean; ideal 3
    last: Estimate
    landmarks: tuple[Landmark, ...] = ()

    @property
    def errors(self) -> Array:
        """Position error of each place (M,) [m]."""
        return np.hypot(self.places[:, 0] - self.truth[:, 0], self.places[:, 1] - self.truth[:, 1])

    @property
    def average(self) -> float:
        """The average error [m] over the run: what the paper compares."""
        return float(self.errors.mean())

    @property
    def final(self) -> float:
        """The error [m] at the goal."""
        return float(self.errors[-1])


def reckoned(run: Run) -> Trace:
    """Dead reckoning (eq. 20): errors at every control update, NEES whenever there was a sighting."""
    way, surprises = Increment(), []
    places = np.empty((len(run.speeds), 2))
    for k, moved in enumerate(_moves(run), start=1):
        way = way.then(moved)
        places[k - 1] = way.pose.x, way.pose.y
        if k in run.seen:
            surprises.append(nees(Estimate(pose=way.pose, covariance=way.covariance), _truth(run, k)))
    return Trace(
        times=run.motion.step * np.arange(1, len(places) + 1),
        places=places,
        truth=run.truth[1:, :2],
        path=_path(run),
        nees=_mean(surprises),
        last=Estimate(pose=way.pose, covariance=way.covariance),
    )


def mapped(run: Run, ekf: EkfSettings, still: bool) -> Trace:
    """EKF-SLAM (eq. 17-33): errors and NEES at every sighting; with `still`, the frames at rest come first."""
    slam = EkfSlam(replace(ekf, still_scans=max(ekf.still_scans, len(run.still))))
    places, surprises = [], []
    for k in followed(slam, run, still):
        pose = slam.filter.pose
        places.append((pose.x, pose.y))
        surprises.append(slam.nees(_truth(run, k)))
    steps = np.array(sorted(run.seen))
    return Trace(
        times=run.motion.step * steps,
        places=np.array(places),
        truth=run.truth[steps, :2],
        path=_path(run),
        nees=_mean(surprises),
        last=slam.estimate,
        landmarks=slam.landmarks,
    )


def followed(slam: EkfSlam, run: Run, still: bool) -> Iterator[int]:
    """Take the filter through a run; yield after every sighting the number of controls until then."""
    for frame in run.still if still else ():
        slam.see(frame)
    gathered = Increment()
    for k, moved in enumerate(_moves(run), start=1):
        gathered = gathered.then(moved)
        if k in run.seen:
            slam.advance(gathered)
            slam.see(run.seen[k])
            gathered = Increment()
            yield k


def _moves(run: Run) -> list[Increment]:
    """The move according to every control update."""
    controls = zip(run.speeds.tolist(), run.steers.tolist(), strict=True)
    return [steered(speed, steer, run.motion.step, run.motion) for speed, steer in controls]


def _truth(run: Run, k: int) -> Pose:
    return Pose(*run.truth[k].tolist())


def _path(run: Run) -> float:
    return float(np.hypot(*np.diff(run.truth[:, :2], axis=0).T).sum())


def _mean(values: list[float]) -> float:
    finite = [value for value in values if math.isfinite(value)]
    return float(np.mean(finite)) if finite else math.nan
