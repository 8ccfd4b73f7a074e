"""The common part of every reader of sightings logs, once the columns are understood."""

import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np

from core.errors import BadInput
from core.geometry import Pose, wrap
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.recording.read_report import ReadReport
from core.recording.recording import SightingRecording, SightingStep
from core.slam.motion import Increment

Ids = Literal["given", "hidden"]
"""The filter may or may not see the identities in the file."""

MOST_ROWS = 5_000_000
MAX_MOVE_M, MAX_SIGHTING_M = 20.0, 100.0  # between two steps, and of what is sighted: half of a log has less
MAX_BEARING_RAD, MAX_STEER_RAD, MAX_TURN_RATE_RAD_S, MAX_CURVATURE_RAD_M = 7.0, 1.6, 4.0, 2.0  # of bearings, wheels
# that steer, robots and cars: one in ten of a log lies below, or they are degrees
MIN_ANGLES = 10
MIN_TURN_RAD, MAX_TURN_RAD, MIN_WAY_M = 0.02, 1.0, 0.5  # of turns and ways that sightings are compared over …
MIN_MOVES, MAX_PAIRS = 20, 2000  # … and how many of them
MAX_WAY_RATIO, MAX_TURN_RATIO = 1.7, 2.5  # by sightings over what was logged
MAX_RATIO_SPREAD = 0.6  # of half of the turns, by their size


class SightingSteps:
    """Gathers steps in time order while a reader goes through its log."""

    def __init__(self, noise: tuple[float, float], ids: Ids, tally: ReadReport):
        """`noise`: standard deviations of range [m] and bearing [rad]."""
        self._noise: Array = np.diag(np.square(noise))
        self._ids = ids
        self._tally = tally
        self._steps: list[SightingStep] = []
        self._seen: list[dict[int, tuple[float, float]]] = []  # of every step: range [m] and bearing [rad] by id

    def add(self, stamp: float, increment: Increment, rows: Array) -> None:
        """The move since the last step, then rows (M, 3) of id, range [m], bearing [rad].

        An id below 0 says that there is no landmark: with given ids such a row is left out, with hidden ones it stays
        among the others. Rows that no sensor can make are counted and left out.
        """
        sightings: list[Sighting] = []
        self._seen.append(
            {int(number): (distance, bearing) for number, distance, bearing in rows.tolist() if number >= 0}
        )
        for number, distance, bearing in rows.tolist():
            if not (0 < distance < 1e4 and abs(bearing) < MAX_BEARING_RAD):
                self._tally.skip("its range or bearing cannot be")
                continue
            self._tally.read += 1
            if self._ids == "given" and number < 0:
                continue
            sightings.append(
                Sighting(
                    range=distance,
                    bearing=wrap(bearing),
                    covariance=self._noise,
                    stamp=stamp,
                    id=int(number) if self._ids == "given" else None,
                )
            )
        self._steps.append(SightingStep(stamp=stamp, increment=increment, sightings=tuple(sightings)))

    def finish(self, path: Path, form: str) -> SightingRecording:
        """All steps → the recording. Raises BadInput when nothing was seen at all."""
        if not any(step.sightings for step in self._steps):
            raise BadInput(f"{path.name} holds no sighting that can be used. {self._tally.reasons()}".strip())
        self._check_units()
        self._check_moves()
        return SightingRecording(path=path, steps=tuple(self._steps), report=self._tally.report(form))

    def _check_units(self) -> None:
        """Say it where moves or sightings are longer than any robot's."""
        moves = [math.hypot(step.increment.pose.x, step.increment.pose.y) for step in self._steps]
        ranges = [one.range for step in self._steps for one in step.sightings]
        move, distance = float(np.median(moves)), float(np.median(ranges))
        if move > MAX_MOVE_M or distance > MAX_SIGHTING_M:
            self._tally.fault("sighting.units", used=True, move=f"{move:.4g}", range=f"{distance:.4g}")

    def _check_moves(self) -> None:
        """Say it where what is sighted again and again moves otherwise than the robot does."""
        turns = (row for row in self._turns() if MIN_TURN_RAD < abs(row[0]) < MAX_TURN_RAD)
        checks = ("sighting.ways", self._ways(), MAX_WAY_RATIO), ("sighting.turns", turns, MAX_TURN_RATIO)
        for code, moves, most in checks:
            rows = np.array(list(itertools.islice(moves, MAX_PAIRS))).reshape(-1, 2)
            if len(rows) < MIN_MOVES:
                continue
            logged, sighted = rows.T
            ratio = float(np.median(sighted / logged))
            spread = float(np.median(np.abs(sighted - ratio * logged)) / np.median(np.abs(logged)))
            if spread < MAX_RATIO_SPREAD * max(1.0, abs(ratio)) and not 1 / most < ratio < most:
                self._tally.fault(code, used=True, times=f"{ratio:.2g}")
                return

    def _turns(self) -> Iterator[tuple[float, float]]:
        """The turn of each step [rad] as it was logged, and by each landmark that is sighted before and after it."""
        for (before, after), step in zip(itertools.pairwise(self._seen), self._steps[1:], strict=True):
            move = step.increment.pose
            for number in before.keys() & after.keys():
                (distance, bearing), (_, now) = before[number], after[number]
                x, y = distance * math.cos(bearing) - move.x, distance * math.sin(bearing) - move.y
                yield move.heading, wrap(math.atan2(y, x) - now)

    def _ways(self) -> Iterator[tuple[float, float]]:
        """Ways [m] of MIN_WAY_M or more as they were logged, and by each landmark that is sighted at both ends."""
        moved, before = Pose(), dict[int, tuple[float, float]]()
        for step, after in zip(self._steps, self._seen, strict=True):
            moved = moved @ step.increment.pose
            way = math.hypot(moved.x, moved.y)
            if before and way < MIN_WAY_M:
                continue
            for number in before.keys() & after.keys():
                (distance, bearing), (far, now) = before[number], after[number]
                x = distance * math.cos(bearing) - far * math.cos(moved.heading + now)
                y = distance * math.sin(bearing) - far * math.sin(moved.heading + now)
                yield way, (x * moved.x + y * moved.y) / way
            moved, before = Pose(), after


def in_radians(angles: Array, limit: float, what: str, tally: ReadReport) -> Array:
    """Angles or turn rates (N,) as logged → in radians: degrees are converted, and that is said."""
    return np.radians(angles) if are_degrees(angles, limit, what, tally) else angles


def are_degrees(angles: Array, limit: float, what: str, tally: ReadReport) -> bool:
    """Return whether angles (N,) cannot be radians, as one in ten of those that are not 0 is beyond `limit`."""
    sizes = np.abs(angles[np.isfinite(angles) & (angles != 0)])
    if len(sizes) < MIN_ANGLES or np.quantile(sizes, 0.9) < limit:
        return False
    tally.fault("sighting.degrees", what, used=True)
    return True


def grouped(keys: Array, rows: Array) -> dict[int, Array]:
    """Rows (M, …) by their integer key (M,), in rising order of the key and in the file's order within one."""
    order = np.argsort(keys, kind="stable")
    values, starts = np.unique(keys[order].astype(np.int64), return_index=True)
    return dict(zip(values.tolist(), np.split(rows[order], starts[1:]), strict=True)) if len(values) else {}
