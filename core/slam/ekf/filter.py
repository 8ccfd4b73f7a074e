"""The extended Kalman filter over pose and landmarks: what its two forms share (eq. 17-33)."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from core.geometry import Pose, rotation
from core.message import Array
from core.slam.ekf.covariance import Covariance
from core.slam.ekf.measurement_model import carried, expected, place_of, residual
from core.slam.motion import Increment

EQUAL_VARIANCE_M2 = 1e-9  # that one landmark may lie apart from itself
EQUALITY_PARTS = 5  # of an equality, taken one after the other
POSE_SIZE = 3  # states of the robot: x, y, heading; two for every landmark follow


def perpendicular(vectors: Array) -> Array:
    """Vectors (..., 2) → the same turned by 90 degrees: how they change when the plane turns."""
    turned = np.empty(vectors.shape)
    np.negative(vectors[..., 1], out=turned[..., 0])
    turned[..., 1] = vectors[..., 0]
    return turned


@dataclass(frozen=True)
class Innovation:
    """The innovation of M sightings (D = 2: range [m], bearing [rad]), or of M single numbers (D = 1)."""

    crossing: Array  # (DM, size): covariance of what was expected with the state
    state: Array  # (DM, DM): its own, without the sensor's noise
    residuals: Array  # (M, D)


@dataclass(eq=False)
class AttachedPoint:
    """A point of the plane that the filter estimates besides its landmarks, for as long as it is attached."""

    place: int = 0  # among the attached ones; the filter keeps it up to date


class Filter(ABC):
    """Pose, landmarks, and one covariance over the errors of both.

    Error of what a sighting depends on, in the world's axes: e = error of landmark - error of robot's place
    + lever x error of heading. The forms differ in how they measure errors: in the lever, in how the covariance
    spreads with a move, in how a correction is applied.

    Moves are gathered and spread over the covariance once, before the next sighting (`settle`).
    """

    def __init__(self, pose: Pose | None = None) -> None:
        self.pose = pose or Pose()
        self.points = np.zeros((0, 2))  # (N + E, 2) [m], world: the landmarks, then the attached points
        self.attached: list[AttachedPoint] = []
        self.covariance = Covariance(np.zeros((POSE_SIZE, POSE_SIZE)))
        self._base = self.pose  # where the covariance was settled last
        self._pending = Increment()

    @abstractmethod
    def lever(self, places: Array) -> Array:
        """Landmarks (N, 2) → lever (N, 2): how the relative error depends on the heading's."""

    @abstractmethod
    def _spread(self, base: Pose, move: Increment) -> None:
        """Spread the covariance over a move from `base` to the present pose."""

    @abstractmethod
    def _move(self, correction: Array) -> None:
        """Apply a correction (size,) to pose and landmarks."""

    @abstractmethod
    def turning(self, places: Array) -> Array:
        """Places (..., 2) → (..., 2): world error of such a place per error of heading, beyond its own error."""

    @abstractmethod
    def error(self, truth: Pose) -> Array:
        """The true pose → this estimate's error (3,) as the covariance measures it."""

    def predict(self, increment: Increment) -> None:
        """Move on (eq. 20)."""
        if not increment.still:
            self.pose = self.pose @ increment.pose
            self._pending = self._pending.then(increment)

    @property
    def places(self) -> Array:
        """The landmarks (N, 2) [m], world."""
        return self.points[: len(self.points) - len(self.attached)]

    @property
    def pending(self) -> Increment:
        """The moves since the covariance was settled, as one."""
        return self._pending

    def amend(self, move: Increment) -> None:
        """The moves since the covariance was settled were together this one."""
        self.pose, self._pending = self._base @ move.pose, move

    def reset_pose(self, pose: Pose, covariance: Array) -> None:
        """Set the robot's pose and its covariance (3, 3) in the world's axes, independent of the former pose.

        The landmarks keep what they know of the world and of each other; nothing binds them to the robot any more.
        """
        self.settle()
        onto = self._world_from_error()
        spread = onto @ self.covariance.dense() @ onto.T
        spread[:POSE_SIZE] = spread[:, :POSE_SIZE] = 0.0
        spread[:POSE_SIZE, :POSE_SIZE] = covariance
        self.pose = self._base = pose
        back = 2 * np.eye(len(spread)) - self._world_from_error()
        spread = back @ spread @ back.T
        self.covariance = Covariance(spread[:POSE_SIZE, :POSE_SIZE])
        if len(self.points):
            self.covariance.append(spread[POSE_SIZE:, :POSE_SIZE], spread[POSE_SIZE:, POSE_SIZE:])

    def settle(self) -> None:
        """Bring the covariance up to the present pose (eq. 21)."""
        if not self._pending.still:
            base, move = self._base, self._pending
            self._pending = Increment()
            self._spread(base, move)
        self._base = self.pose

    def expect(self) -> tuple[Array, Array]:
        """Expected sighting (N, 2) of every landmark, and its covariance (N, 2, 2) without the sensor's noise."""
        self.settle()
        sightings, slopes = expected(self.pose, self.places)
        lever, count = self.lever(self.places), len(self.places)
        robot = self.covariance.first_rows(POSE_SIZE)
        own, cross = robot[:, :POSE_SIZE], robot[:, POSE_SIZE : POSE_SIZE + 2 * count].reshape(POSE_SIZE, count, 2)
        shared = cross[:2].transpose(1, 2, 0)
        spread = self._own_blocks() + own[:2, :2] - shared - shared.transpose(0, 2, 1)
        if lever.any():
            swung = lever[:, :, None] * (cross[2] - own[2, :2] + 0.5 * own[2, 2] * lever)[:, None, :]
            spread += swung + swung.transpose(0, 2, 1)
        return sightings, carried(slopes, spread)

    def innovate(self, indices: Array, sightings: Array) -> Innovation:
        """Landmarks (M,) were sighted (M, 2): how that differs from what was expected (eq. 28-29)."""
        self.settle()
        count = len(indices)
        expectations, slopes = expected(self.pose, self.places[indices])
        lever = self.lever(self.places[indices])
        columns = POSE_SIZE + 2 * indices[:, None] + np.arange(2)
        robot = self.covariance.first_rows(POSE_SIZE)
        relative = self.covariance.rows(columns) - robot[:2] + lever[:, :, None] * robot[2]
        crossing = (slopes @ relative).reshape(2 * count, -1)
        seen = crossing[:, columns] - crossing[:, None, :2] + crossing[:, 2, None, None] * lever
        state = np.einsum("amk,mjk->amj", seen, slopes).reshape(2 * count, 2 * count)
        return Innovation(crossing, state, residual(sightings, expectations))

    def take_in(self, innovation: Innovation, total: Array) -> None:
        """Correct by all sightings at once (eq. 30); `total` (2M, 2M): covariance of the innovation and noise."""
        self._move(self.covariance.absorb(innovation.crossing, total, innovation.residuals.ravel()))
        self._base = self.pose

    def doubt(self, unnoticed: Array) -> None:
        """Add the covariance (3, 3) of a possible unnoticed move, in the robot's frame."""
        self.settle()
        self._spread(self.pose, Increment(Pose(), unnoticed))

    def perturbed(self, indices: Array, unnoticed: Array) -> Array:
        """Return the (2M, 2M) that `doubt` would add to the covariance of the sightings of landmarks (M,)."""
        _, slopes = expected(self.pose, self.places[indices])
        arms = perpendicular(self.places[indices] - (self.pose.x, self.pose.y))
        onto = np.empty((len(indices), 2, POSE_SIZE))
        onto[:, :, :2] = -rotation(self.pose.heading)
        onto[:, :, 2] = -arms
        change = (slopes @ onto).reshape(-1, POSE_SIZE)
        return change @ unnoticed @ change.T

    def add(self, sighting: Array, noise: Array) -> int:
        """A new landmark (eq. 31-33) → its index."""
        place, rows, own = self._seen_from_here(sighting, noise)
        index = len(self.places)
        self.covariance.insert(POSE_SIZE + 2 * index, rows, own)
        self.points = np.insert(self.points, index, place, axis=0)
        return index

    def _seen_from_here(self, sighting: Array, noise: Array) -> tuple[Array, Array, Array]:
        """Range and bearing (2,), noise (2, 2) → the place (2,), its covariances (2, size) and its own (2, 2)."""
        self.settle()
        place, slope = place_of(self.pose, sighting)
        lever = self.lever(place[None])[0]
        robot = self.covariance.first_rows(POSE_SIZE)
        rows = robot[:2] - lever[:, None] * robot[2]
        return place, rows, rows[:, :2] - np.outer(rows[:, 2], lever) + slope @ noise @ slope.T

    def drop(self, index: int) -> None:
        """Forget a landmark."""
        self.covariance.drop(POSE_SIZE + 2 * index, 2)
        self.points = np.delete(self.points, index, axis=0)

    def attach(self, place: Array, rows: Array, own: Array) -> AttachedPoint:
        """A new point at `place` (2,) with covariances `rows` (2, size) to the state and `own` (2, 2)."""
        point = AttachedPoint(len(self.attached))
        self.covariance.append(rows, own)
        self.points = np.vstack((self.points, place))
        self.attached.append(point)
        return point

    def attach_seen(self, sighting: Array) -> AttachedPoint:
        """A new point at exactly this range and bearing (2,) from the robot as it stands now."""
        return self.attach(*self._seen_from_here(sighting, np.zeros((2, 2))))

    def detach(self, point: AttachedPoint) -> None:
        """Forget an attached point."""
        self.drop(self.index_of(point))
        self.attached.remove(point)
        for place, other in enumerate(self.attached):
            other.place = place

    def index_of(self, point: AttachedPoint) -> int:
        """Return the index of an attached point among all points."""
        return len(self.points) - len(self.attached) + point.place

    def apart(self, a: int, b: int) -> tuple[Array, Array]:
        """Two landmarks → their difference (2,) [m] and its covariance (2, 2)."""
        differences, spread = self.all_apart(np.array([a]), np.array([b]))
        return differences[0], spread

    def all_apart(self, firsts: Array, seconds: Array) -> tuple[Array, Array]:
        """Landmarks (K,) and others (K,) → their differences (K, 2) [m] and the covariance of them all (2K, 2K)."""
        self.settle()
        return self.places[firsts] - self.places[seconds], self._differences(firsts, seconds)[1]

    def join(self, firsts: Array, seconds: Array) -> None:
        """Each two landmarks of K pairs are one: exact equalities, all at once, then the `seconds` go.

        Taken in equal parts: where a long loop closes all turns by much, and what a turn does is not linear.
        """
        self.settle()
        for rest in reversed(range(EQUALITY_PARTS)):
            crossing, spread = self._differences(firsts, seconds)
            wanted = (self.places[seconds] - self.places[firsts]).ravel()
            total = (1 + rest) * spread + EQUAL_VARIANCE_M2 * np.eye(len(spread))
            self._move(self.covariance.absorb(crossing, total, wanted))
        self._base = self.pose
        for index in sorted(seconds.tolist(), reverse=True):
            self.drop(index)

    def pose_covariance(self) -> Array:
        """Covariance (3, 3) of x, y, heading in the world's axes."""
        turning = np.eye(POSE_SIZE)
        turning[:2, 2] = self.turning(np.array([self._base.x, self._base.y]))
        settled = turning @ self.covariance.block(0, POSE_SIZE) @ turning.T
        if self._pending.still:
            return settled
        carry, onto = np.eye(POSE_SIZE), np.eye(POSE_SIZE)
        carry[:2, 2] = -(self.pose.y - self._base.y), self.pose.x - self._base.x
        onto[:2, :2] = rotation(self._base.heading)
        return carry @ settled @ carry.T + onto @ self._pending.covariance @ onto.T

    def place_covariances(self) -> Array:
        """Covariances (N, 2, 2) of the landmarks in the world's axes."""
        turning = self.turning(self.places)
        heading = self.covariance.row(2)
        cross = heading[POSE_SIZE : POSE_SIZE + 2 * len(self.places)].reshape(-1, 2)
        spread = self._own_blocks()
        for k in range(2):
            for m in range(2):
                spread[:, k, m] += turning[:, k] * cross[:, m] + turning[:, m] * cross[:, k]
                spread[:, k, m] += turning[:, k] * turning[:, m] * heading[2]
        return spread

    def _differences(self, firsts: Array, seconds: Array) -> tuple[Array, Array]:
        """K pairs of landmarks → covariance of their differences with the state (2K, size) and their own (2K, 2K)."""
        a, b = (POSE_SIZE + 2 * indices[:, None] + np.arange(2) for indices in (firsts, seconds))
        turning = self.turning(self.places[firsts]) - self.turning(self.places[seconds])
        crossing = self.covariance.rows(a) - self.covariance.rows(b) + turning[:, :, None] * self.covariance.row(2)
        crossing = crossing.reshape(2 * len(firsts), -1)
        spread = crossing[:, a.ravel()] - crossing[:, b.ravel()] + np.outer(crossing[:, 2], turning)
        return crossing, 0.5 * (spread + spread.T)

    def _world_from_error(self) -> Array:
        """(size, size): the state's errors in the world's axes from the errors as this form measures them."""
        onto = np.eye(POSE_SIZE + 2 * len(self.points))
        onto[:2, 2] = self.turning(np.array([self.pose.x, self.pose.y]))
        onto[POSE_SIZE:, 2] = self.turning(self.points).ravel()
        return onto

    def _own_blocks(self) -> Array:
        """Every landmark's own block of the covariance (N, 2, 2)."""
        count = len(self.places)
        last = POSE_SIZE + 2 * count
        diagonal = self.covariance.diagonal()[POSE_SIZE:last]
        blocks = np.empty((count, 2, 2))
        blocks[:, 0, 0], blocks[:, 1, 1] = diagonal[::2], diagonal[1::2]
        blocks[:, 0, 1] = blocks[:, 1, 0] = self.covariance.diagonal(1)[POSE_SIZE:last:2]
        return blocks
