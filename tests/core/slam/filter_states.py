"""A filter in some state with landmarks, copies of it, and errors between two as the covariance counts them."""

import copy

import numpy as np

from core.geometry import Pose, rotation
from core.slam.ekf.filter import Filter
from core.slam.ekf.invariant import InvariantFilter, shift_matrix
from core.slam.ekf.paper import PaperFilter
from core.slam.ekf.robust import with_noise
from core.slam.motion import Increment

FORMS: list[type[Filter]] = [InvariantFilter, PaperFilter]
NOISE = np.diag([1e-4, 1e-4])


def some_filter(form: type[Filter], landmarks: int = 4, seed: int = 0, size: float = 0.05) -> Filter:
    """A filter somewhere, with a covariance that connects everything."""
    rng = np.random.default_rng(seed)
    state = form(Pose(0.7, -0.4, 0.9))
    for _ in range(landmarks):
        state.add(np.array([rng.uniform(0.5, 3), rng.uniform(-1.5, 1.5)]), NOISE)
    count = 3 + 2 * landmarks
    state.covariance.lift(size * rng.normal(size=(count + 2, count)))
    return state


def correct(state: Filter, indices: np.ndarray, sightings: np.ndarray, noises: np.ndarray) -> None:
    """Landmarks (M,) were sighted (M, 2) with noise (M, 2, 2): the plain update, which doubts no sighting."""
    innovation = state.innovate(indices, sightings)
    state.take_in(innovation, with_noise(innovation.state, noises))


def apart_by(state: Filter, error: np.ndarray) -> Filter:
    """A copy whose truth differs from the state by `error`."""
    other = copy.deepcopy(state)
    other._move(error)
    other._base = other.pose
    return other


def error_between(estimate: Filter, truth: Filter) -> np.ndarray:
    """The error (size,) of an estimate as its covariance counts it: what `apart_by` has put in."""
    pose = estimate.error(truth.pose)
    if isinstance(estimate, InvariantFilter):
        turned = estimate.places @ rotation(float(pose[2])).T
        places = np.linalg.solve(shift_matrix(float(pose[2])), (truth.places - turned).T).T
    else:
        places = truth.places - estimate.places
    return np.concatenate((pose, places.ravel()))


def slope(function, size: int, step: float = 1e-6) -> np.ndarray:
    """Derivative at zero of a function of `size` numbers, by central differences."""
    columns = [(function(step * unit) - function(-step * unit)) / (2 * step) for unit in np.eye(size)]
    return np.column_stack(columns)


def moved(state: Filter, pose: Pose, noise: np.ndarray | None = None) -> Filter:
    """A copy after a move, its three numbers changed by `noise`."""
    other = copy.deepcopy(state)
    off = np.zeros(3) if noise is None else noise
    other.pose = other.pose @ Pose(pose.x + off[0], pose.y + off[1], pose.heading + off[2])
    other._base = other.pose
    return other


def predicted(state: Filter, increment: Increment) -> Filter:
    """A copy after a move, its covariance settled."""
    other = copy.deepcopy(state)
    other.predict(increment)
    other.settle()
    return other
