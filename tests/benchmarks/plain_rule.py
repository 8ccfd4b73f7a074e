"""The plain rule of data association, as a peer: nearest neighbour, one to one, three hits before a landmark counts.

Sightings go to landmarks by the smallest sum of squared Mahalanobis distances (Hungarian method), each below `gate`.
One that is farther than `fresh` from every landmark goes to the nearest of the places on trial, which stand outside
of the filter, or becomes one; the third sighting makes a place a landmark, and one that stays unseen is struck off.
Nothing is merged, weighed or revised.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.slam.ekf.filter import Filter
from core.slam.ekf.invariant import InvariantFilter
from core.slam.ekf.measurement_model import place_of, residual, squared_distance
from core.slam.motion import Increment
from tests.core.slam.filter_states import correct

FAR = 1e6


@dataclass
class Trial:
    """A place that may become a landmark."""

    place: Array  # (2,) [m] world
    hits: int = 1
    unseen: int = 0


class PlainRule:
    """EKF-SLAM with that rule."""

    def __init__(
        self,
        state: Filter | None = None,
        *,
        gate: float = 9.21,
        fresh: float = 16.0,
        hits: int = 3,
        near: float = 0.35,
        patience: int = 30,
    ) -> None:
        """`near` [m]: a sighting this close to a place on trial is of it; `patience`: updates it may stay unseen."""
        self.filter = state or InvariantFilter()
        self.trials: list[Trial] = []
        self._gate, self._fresh, self._hits, self._near, self._patience = gate, fresh, hits, near, patience

    def advance(self, increment: Increment) -> None:
        """Predict over a move."""
        self.filter.predict(increment)

    def see(self, sightings: Sequence[Sighting]) -> None:
        """Correct by what was sighted from here."""
        readings = np.array([(one.range, one.bearing) for one in sightings]).reshape(-1, 2)
        noises = np.array([one.covariance for one in sightings]).reshape(-1, 2, 2)
        expectations, states = self.filter.expect()
        off = residual(readings[:, None], expectations[None])
        distances = squared_distance(off, states[None] + noises[:, None])[0]
        rows, columns = assigned(distances, self._gate)
        if len(rows):
            correct(self.filter, columns, readings[rows], noises[rows])
        far = np.setdiff1d(np.flatnonzero((distances > self._fresh).all(axis=1)), rows)
        self._try(readings[far], noises[far])

    def _try(self, readings: Array, noises: Array) -> None:
        """Sightings of no landmark (M, 2) with noises (M, 2, 2): count them for the places on trial."""
        places = np.array([place_of(self.filter.pose, reading)[0] for reading in readings]).reshape(-1, 2)
        stand = np.array([trial.place for trial in self.trials]).reshape(-1, 2)
        apart = np.hypot(*(places[:, None] - stand[None]).transpose(2, 0, 1))
        rows, columns = assigned(apart, self._near)
        for trial in self.trials:
            trial.unseen += 1
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
            trial = self.trials[column]
            trial.hits, trial.unseen = trial.hits + 1, 0
            trial.place = trial.place + (places[row] - trial.place) / trial.hits
            if trial.hits >= self._hits:
                self.filter.add(readings[row], noises[row])
        self.trials = [t for t in self.trials if t.hits < self._hits and t.unseen <= self._patience]
        self.trials += [Trial(places[row]) for row in range(len(places)) if row not in rows]


def assigned(costs: Array, limit: float) -> tuple[Array, Array]:
    """Costs (M, N) → the rows and columns of the cheapest one-to-one assignment, leaving out costing `limit`."""
    count = len(costs)
    square = np.hstack((np.where(costs < limit, costs, FAR), np.full((count, count), limit)))
    rows, columns = linear_sum_assignment(square)
    kept = columns < costs.shape[1]
    return rows[kept], columns[kept]
