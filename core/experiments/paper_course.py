"""The paper's drive (section 6.2): an S of 3.2 m among twelve corners, its random draws, and estimators on them.

The print gives speed, wheelbase, rates and noise (eq. 43); the corners, and the points the S leads through, are ours.
As in the simulator that the paper used, the true robot does what was commanded; the noise is in what it hears of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path
from typing import Literal

import numpy as np

from core.errors import BadInput
from core.geometry import Pose, wrap, wrap_all
from core.message import Array, message
from core.perception.landmarks.landmarks import Sighting
from core.recording import Ids
from core.recording.archives import CONTROLS, RUN_NOISE
from core.recording.npz import Archive
from core.recording.sightings import MOST_ROWS, grouped
from core.slam.consistency import nees
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.estimate import Estimate, Landmark
from core.slam.motion import Increment, MotionSettings, steered

CONTROL_UPDATES = 1280  # control updates: 32 s at 40 Hz, 3.2 m at 0.1 m/s
UPDATES_PER_SIGHTING = 8  # control updates between sightings: 5 Hz
LANDMARKS = (
    (-1.0, -2.0),
    (5.0, -2.0),
    (5.0, 3.0),
    (-1.0, 3.0),
    (1.2, -2.0),
    (1.2, -1.6),
    (3.4, 3.0),
    (3.4, 2.6),
    (5.0, 0.5),
    (4.6, 0.5),
    (-1.0, 1.0),
    (-0.6, 1.0),
)  # [m]
GOALS = ((1.2, 0.2), (1.8, 0.9), (2.6, 0.9), (3.4, 0.2))  # [m]
GOAL_RADIUS_M = 0.05  # from a goal, the next one is steered for
MAX_STEER_RAD = math.radians(30)
STEER_RATE_RAD_S = math.radians(80)
ROOM_MARGINS_M = (1.0, 3.5)  # least and most between the drive and a wall of a drawn room
PILLAR_DEPTHS_M = (0.2, 0.6)  # least and most of a wall's edge into a drawn room
Field = Literal["laser", "half-plane", "camera"]
FIELDS: dict[Field, float] = {"laser": math.radians(120), "half-plane": math.pi / 2, "camera": math.radians(28)}
"""Half of the field of view: of the URG, of common simulators, of the camera of Table 3 (where edges are seen)."""

MIN_RANGE_M, MAX_RANGE_M = 0.06, 4.0  # between which the laser measures; it still detects up to 5.6 m
STILL_FRAMES = 10  # frames at rest before the first move
SEED_STRIDE = 100_000  # apart lie the seeds of two experiments, so that no run is drawn twice
FIRST_SEED = 1000  # the first run's seed
ROOM_SEED = 16  # of drawn rooms, before their number
MOST_RUNS = 10_000  # of a file
MAX_FILE_BYTES = 2_000_000_000  # of a file
MAX_LENGTH_M, MAX_ANGLE_RAD = 1e4, 7.0  # [m], [m/s] and [rad] beyond which nothing in a file can be


@message
class Course:
    """The true drive: what was commanded, and where it led."""

    speeds: Array  # (K,) [m/s]
    steers: Array  # (K,) [rad]
    truth: Array  # (K + 1, 3) x, y [m], heading [rad]; the first is the start
    landmarks: Array  # (N, 2) [m]


def edges_along_walls(spacing: float) -> Array:
    """The twelve corners, and further vertical edges (door frames, cabinets) every `spacing` [m] along the walls."""
    corners = np.array(LANDMARKS)
    (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
    across = np.arange(x0 + spacing / 2, x1, spacing)
    up = np.arange(y0 + spacing / 2, y1, spacing)
    walls = [np.column_stack((across, np.full(len(across), y))) for y in (y0, y1)]
    walls += [np.column_stack((np.full(len(up), x), up)) for x in (x0, x1)]
    return np.vstack((corners, *walls))


def drawn_room(rng: np.random.Generator, truth: Array) -> Array:
    """Draw a room like the one of figure 16 about a drive (K, 3): four corners, and a pillar's edge on every wall.

    Returns the twelve corners (12, 2) [m].
    """
    margins = rng.uniform(*ROOM_MARGINS_M, size=(2, 2))
    least, most = truth[:, :2].min(axis=0) - margins[0], truth[:, :2].max(axis=0) + margins[1]
    corners = [(x, y) for x in (least[0], most[0]) for y in (least[1], most[1])]
    for axis in (0, 1):
        for wall, into in ((least, 1.0), (most, -1.0)):
            along = rng.uniform(least[1 - axis], most[1 - axis])
            for depth in (0.0, rng.uniform(*PILLAR_DEPTHS_M)):
                across = wall[axis] + into * depth
                corners.append((across, along) if axis == 0 else (along, across))
    return np.array(corners)


@cache
def paper_course(wheelbase: float, step: float, cruise: float) -> Course:
    """Steer the S: wheelbase [m], control step [s], speed [m/s] → the drive without any noise."""
    motion = MotionSettings(wheelbase=wheelbase, step=step)
    x, y, heading, steer, goal = 0.0, 0.0, 0.0, 0.0, 0
    steers: list[float] = []
    truth = [(x, y, heading)]
    for _ in range(CONTROL_UPDATES):
        if goal < len(GOALS) - 1 and math.hypot(GOALS[goal][0] - x, GOALS[goal][1] - y) < GOAL_RADIUS_M:
            goal += 1
        towards = math.atan2(GOALS[goal][1] - y, GOALS[goal][0] - x)
        change = wrap(towards - heading - steer)
        steer += min(max(change, -STEER_RATE_RAD_S * step), STEER_RATE_RAD_S * step)
        steer = min(max(steer, -MAX_STEER_RAD), MAX_STEER_RAD)
        moved = steered(cruise, steer, step, motion).pose
        c, s = math.cos(heading), math.sin(heading)
        x, y = x + c * moved.x - s * moved.y, y + s * moved.x + c * moved.y
        heading = wrap(heading + moved.heading)
        steers.append(steer)
        truth.append((x, y, heading))
    return Course(
        speeds=np.full(CONTROL_UPDATES, cruise),
        steers=np.array(steers),
        truth=np.array(truth),
        landmarks=np.array(LANDMARKS),
    )


@dataclass(frozen=True)
class Draws:
    """The source of runs: drawn from a seed, or frozen in a file of the seed-mc form."""

    seed: int = 0
    data: Path | None = None
    motion: MotionSettings = CONTROLS
    sighting_noise: tuple[float, float] = RUN_NOISE  # [m], [rad] (eq. 43)
    field: Field = "laser"
    ids: Ids = "given"
    spacing: float | None = None  # [m] between further vertical edges along the walls; None: the twelve corners alone
    reach: float = MAX_RANGE_M  # [m] that the laser sees
    room: int | None = None  # seed of a drawn room; None: the one of figure 16

    def run(self, number: int) -> Run:
        """The run of that number; always the same for the same draws."""
        return self._drawn(number) if self.data is None else self._frozen(number, self.data)

    def _drawn(self, number: int) -> Run:
        """Speeds, steers, then sightings as they come, then the still frames, all from the run's own generator."""
        rng = np.random.default_rng(FIRST_SEED + SEED_STRIDE * self.seed + number)
        course = self.course
        count = len(course.speeds)
        speeds = course.speeds + self.motion.speed_sd * rng.standard_normal(count)
        steers = course.steers + self.motion.steer_sd * rng.standard_normal(count)
        seen = {k: self._look(course, k, rng) for k in range(UPDATES_PER_SIGHTING, count + 1, UPDATES_PER_SIGHTING)}
        still = tuple(self._look(course, 0, rng) for _ in range(STILL_FRAMES))
        return Run(
            number=number,
            truth=course.truth,
            landmarks=course.landmarks,
            speeds=speeds,
            steers=steers,
            motion=self.motion,
            seen=seen,
            still=still,
        )

    @property
    def course(self) -> Course:
        """The true drive, among the edges there are."""
        course = paper_course(self.motion.wheelbase, self.motion.step, self.motion.cruise)
        if self.room is not None:
            return replace(course, landmarks=drawn_room(np.random.default_rng((ROOM_SEED, self.room)), course.truth))
        return course if self.spacing is None else replace(course, landmarks=edges_along_walls(self.spacing))

    def _look(self, course: Course, k: int, rng: np.random.Generator) -> tuple[Sighting, ...]:
        x, y, heading = course.truth[k]
        away = course.landmarks - (x, y)
        ranges = np.hypot(away[:, 0], away[:, 1])
        bearings = wrap_all(np.arctan2(away[:, 1], away[:, 0]) - heading)
        names = np.flatnonzero(
            (ranges > MIN_RANGE_M) & (ranges < self.reach) & (np.abs(bearings) < FIELDS[self.field])
        )
        noise = self.sighting_noise * rng.standard_normal((len(names), 2))
        return self._sightings(np.column_stack((names, ranges[names] + noise[:, 0], bearings[names] + noise[:, 1])))

    def _frozen(self, number: int, path: Path) -> Run:
        file = frozen(path)
        rows, still = (table[table[:, 0] == number] for table in (file.sightings, file.still))
        looked = np.unique(rows[:, 1]).astype(int).tolist()
        if self.field != "laser":  # of what the laser saw; a picture without any is a picture, too
            rows, still = (table[np.abs(table[:, 4]) < FIELDS[self.field]] for table in (rows, still))
        seen = {k: np.zeros((0, 3)) for k in looked} | grouped(rows[:, 1], rows[:, 2:])
        return Run(
            number=number,
            truth=file.truth,
            landmarks=file.landmarks,
            speeds=file.speeds[number],
            steers=file.steers[number],
            motion=self.motion,
            seen={k: self._sightings(one) for k, one in seen.items()},
            still=tuple(self._sightings(one) for one in grouped(still[:, 1], still[:, 2:]).values()),
        )

    def _sightings(self, rows: Array) -> tuple[Sighting, ...]:
        """Rows (M, 3) of id, range [m], bearing [rad]."""
        noise = np.diag(np.square(self.sighting_noise))
        return tuple(
            Sighting(range=reach, bearing=bearing, covariance=noise, id=int(name) if self.ids == "given" else None)
            for name, reach, bearing in rows.tolist()
            if 0 < reach < MAX_LENGTH_M and abs(bearing) < MAX_ANGLE_RAD
        )


@message
class Run:
    """One drive as an estimator hears of it, and the truth to judge it by."""

    number: int
    truth: Array  # (K + 1, 3) x, y [m], heading [rad]
    landmarks: Array  # (N, 2) [m], the true ones
    speeds: Array  # (K,) [m/s], noisy
    steers: Array  # (K,) [rad], noisy
    motion: MotionSettings
    seen: dict[int, tuple[Sighting, ...]]  # after how many controls → what
    still: tuple[tuple[Sighting, ...], ...]  # frames at rest, before the first move


@message
class Frozen:
    """A file of the seed-mc form."""

    truth: Array  # (K + 1, 3)
    landmarks: Array  # (N, 2)
    speeds: Array  # (runs, K)
    steers: Array  # (runs, K)
    sightings: Array  # (M, 5) run, k, id, range, bearing
    still: Array  # (S, 5) run, frame, id, range, bearing


@lru_cache(maxsize=2)
def frozen(path: Path) -> Frozen:
    """Read and check a file. Raises BadInput."""
    archive = Archive(path, MAX_FILE_BYTES)
    try:
        speeds, steers = archive.floats("v_noisy", 0), archive.floats("steer_noisy", 0)
        truth, landmarks = archive.floats("truth", 3), archive.floats("landmarks", 2)
        rows = archive.floats("obs", 5)
        still = archive.floats("still_obs", 5) if "still_obs" in archive.names else np.zeros((0, 5))
    finally:
        archive.close()
    if speeds.shape != steers.shape or not 1 <= len(speeds) <= MOST_RUNS or max(len(rows), len(still)) > MOST_ROWS:
        raise BadInput(f"v_noisy and steer_noisy in {path.name} do not fit together, or there are too many runs.")
    if len(truth) != speeds.shape[1] + 1 or not speeds.shape[1]:
        raise BadInput(f"truth in {path.name} should have {speeds.shape[1] + 1} poses: the start and one a control.")
    most = {"truth": MAX_LENGTH_M, "landmarks": MAX_LENGTH_M, "v_noisy": MAX_LENGTH_M, "steer_noisy": MAX_ANGLE_RAD}
    for (name, limit), values in zip(most.items(), (truth, landmarks, speeds, steers), strict=True):
        if np.abs(values).max(initial=0.0) > limit:
            raise BadInput(f"{name} in {path.name} holds numbers beyond {limit:g}; metres and radians are expected.")
    seen = rows[(rows[:, 1] >= 1) & (rows[:, 1] <= speeds.shape[1])]
    if not np.isin(np.arange(len(speeds)), seen[:, 0]).all():
        raise BadInput(f"Some runs in {path.name} have no sighting; every run needs some.")
    return Frozen(truth=truth, landmarks=landmarks, speeds=speeds, steers=steers, sightings=seen, still=still)


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
    controls = zip(run.speeds.tolist(), run.steers.tolist(), strict=True)
    return [steered(speed, steer, run.motion.step, run.motion) for speed, steer in controls]


def _truth(run: Run, k: int) -> Pose:
    return Pose(*run.truth[k].tolist())


def _path(run: Run) -> float:
    return float(np.hypot(*np.diff(run.truth[:, :2], axis=0).T).sum())


def _mean(values: list[float]) -> float:
    finite = [value for value in values if math.isfinite(value)]
    return float(np.mean(finite)) if finite else math.nan
