"""The common part of every reader of sightings logs, once the columns are understood."""

import math
from pathlib import Path
from typing import Literal

import numpy as np

from core.errors import BadInput
from core.geometry import wrap
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.recording.read_report import ReadReport
from core.recording.recording import SightingRecording, SightingStep
from core.slam.motion import Increment

Ids = Literal["given", "hidden"]
"""The filter may or may not see the identities in the file."""

MOST_ROWS = 5_000_000
MAX_MOVE_M, MAX_SIGHTING_M = 20.0, 100.0  # between two steps, and of what is sighted: half of a log has less


class SightingSteps:
    """Gathers steps in time order while a reader goes through its log."""

    def __init__(self, noise: tuple[float, float], ids: Ids, tally: ReadReport):
        """`noise`: standard deviations of range [m] and bearing [rad]."""
        self._noise: Array = np.diag(np.square(noise))
        self._ids = ids
        self._tally = tally
        self._steps: list[SightingStep] = []

    def add(self, stamp: float, increment: Increment, rows: Array) -> None:
        """The move since the last step, then rows (M, 3) of id, range [m], bearing [rad].

        An id below 0 says that there is no landmark: with given ids such a row is left out, with hidden ones it stays
        among the others. Rows that no sensor can make are counted and left out.
        """
        sightings: list[Sighting] = []
        for number, distance, bearing in rows.tolist():
            if not (0 < distance < 1e4 and abs(bearing) < 7):
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
        return SightingRecording(path=path, steps=tuple(self._steps), report=self._tally.report(form))

    def _check_units(self) -> None:
        """Say it where moves or sightings are longer than any robot's."""
        moves = [math.hypot(step.increment.pose.x, step.increment.pose.y) for step in self._steps]
        ranges = [one.range for step in self._steps for one in step.sightings]
        move, distance = float(np.median(moves)), float(np.median(ranges))
        if move > MAX_MOVE_M or distance > MAX_SIGHTING_M:
            self._tally.fault("sighting.units", used=True, move=f"{move:.4g}", range=f"{distance:.4g}")


def grouped(keys: Array, rows: Array) -> dict[int, Array]:
    """Rows (M, …) by their integer key (M,), in rising order of the key and in the file's order within one."""
    order = np.argsort(keys, kind="stable")
    values, starts = np.unique(keys[order].astype(np.int64), return_index=True)
    return dict(zip(values.tolist(), np.split(rows[order], starts[1:]), strict=True)) if len(values) else {}
