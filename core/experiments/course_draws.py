"""Random draws of one run on the paper's course: noisy controls and corners, drawn or read from a file.

As in the simulator that the paper used, the true robot does what was commanded; the noise is in what it hears of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np

from core.errors import BadInput
from core.experiments.paper_course import UPDATES_PER_SIGHTING, Course, drawn_room, edges_along_walls, paper_course
from core.message import Array, message
from core.perception.landmarks.landmarks import Sighting
from core.recording import Ids
from core.recording.archives import CONTROLS, RUN_NOISE
from core.recording.npz import Archive
from core.recording.sightings import MOST_ROWS, grouped
from core.slam.motion import MotionSettings

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
        bearings = (np.arctan2(away[:, 1], away[:, 0]) - heading + np.pi) % (2 * np.pi) - np.pi
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
