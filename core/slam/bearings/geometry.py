"""Measurement of a landmark by its bearing from a pose: the residuals and derivatives that the filter takes in.

A pose of the past is kept as two points of the plane: where the eye was, and a point 1 m ahead of it. A bearing from
there is the angle between the directions to that point and to the landmark, a range the length of one difference: no
error of the present heading enters, in either form of the filter.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from core.geometry import Pose, wrap, wrap_all
from core.message import Array
from core.slam.ekf.filter import POSE_SIZE, AttachedPoint, Filter, Innovation, perpendicular
from core.slam.ekf.measurement_model import expected

AHEAD_M = 1.0


@dataclass(eq=False)
class PastPose:
    """The eye at some time, as the filter remembers it."""

    eye: AttachedPoint
    ahead: AttachedPoint


def remember(state: Filter, eye: Pose) -> PastPose:
    """Keep where an eye is now; `eye` is robot_from_eye."""
    state.settle()
    x, y = eye.x + AHEAD_M * math.cos(eye.heading), eye.y + AHEAD_M * math.sin(eye.heading)
    here = state.attach_seen(np.array([math.hypot(eye.x, eye.y), math.atan2(eye.y, eye.x)]))
    return PastPose(here, state.attach_seen(np.array([math.hypot(x, y), math.atan2(y, x)])))


def forget(state: Filter, past: PastPose) -> None:
    """Forget a pose of the past."""
    state.detach(past.ahead)
    state.detach(past.eye)


def expected_bearings(state: Filter, eye: Pose, points: Sequence[AttachedPoint]) -> Array:
    """Bearings (M,) [rad] in the eye's axes at which landmarks should be seen now."""
    indices = np.array([state.index_of(point) for point in points], dtype=int)
    return expected(state.pose @ eye, state.points[indices])[0][:, 1]


def seen_now(state: Filter, eye: Pose, points: Sequence[AttachedPoint], bearings: Array) -> Innovation:
    """Landmarks (M) are seen at `bearings` (M,) [rad] in the axes of an eye on the robot as it stands now."""
    state.settle()
    indices = np.array([state.index_of(point) for point in points], dtype=int)
    expectations, slopes = expected(state.pose @ eye, state.points[indices])
    across, lever = slopes[:, 1], state.lever(state.points[indices])
    columns = POSE_SIZE + 2 * indices[:, None] + np.arange(2)
    robot = state.covariance.rows(np.arange(POSE_SIZE))
    relative = state.covariance.rows(columns) - robot[:2] + lever[:, :, None] * robot[2]
    crossing = np.einsum("mk,mks->ms", across, relative)
    seen = crossing[:, columns] - crossing[:, None, :2] + crossing[:, 2, None, None] * lever
    spread = np.einsum("amk,mk->am", seen, across)
    return Innovation(crossing, 0.5 * (spread + spread.T), wrap_all(bearings - expectations[:, 1])[:, None])


def seen_then(state: Filter, past: PastPose, point: AttachedPoint, bearing: float) -> Innovation:
    """A landmark was seen at `bearing` [rad] from a pose of the past."""
    indices = [state.index_of(one) for one in (point, past.eye, past.ahead)]
    place, eye, ahead = state.points[indices]
    to_point, axis = _turning(place - eye), _turning(ahead - eye)
    expectation = _angle(place - eye) - _angle(ahead - eye)
    slopes = np.array([to_point, axis - to_point, -axis])
    return _of_points(state, indices, slopes, wrap(bearing - expectation))


def ranged_then(state: Filter, past: PastPose, point: AttachedPoint, reach: float) -> Innovation:
    """A landmark was `reach` [m] away from a pose of the past."""
    indices = [state.index_of(one) for one in (point, past.eye)]
    place, eye = state.points[indices]
    distance = float(np.hypot(*(place - eye)))
    along = (place - eye) / distance
    return _of_points(state, indices, np.array([along, -along]), reach - distance)


def coincide(state: Filter, one: AttachedPoint, other: AttachedPoint) -> Innovation:
    """Two landmarks are one."""
    indices = [state.index_of(one), state.index_of(other)]
    place, otherwhere = state.points[indices]
    columns = POSE_SIZE + 2 * np.array(indices)[:, None] + np.arange(2)
    turning = state.turning(place[None]) - state.turning(otherwhere[None])
    rows = state.covariance.rows(columns)
    crossing = rows[0] - rows[1] + turning.T * state.covariance.row(2)
    spread = crossing[:, columns[0]] - crossing[:, columns[1]] + np.outer(crossing[:, 2], turning[0])
    return Innovation(crossing, 0.5 * (spread + spread.T), (otherwhere - place)[:, None])


def crossed(
    state: Filter, views: tuple[tuple[PastPose, float], tuple[PastPose, float]], sd: float
) -> tuple[Array, Array, Array] | None:
    """Bearings [rad], `sd` each, from two poses → where they cross (2,), its covariances (2, size) and own (2, 2).

    None where they do not cross ahead of both.
    """
    indices = [state.index_of(one) for past, _ in views for one in (past.eye, past.ahead)]
    first, first_ahead, second, second_ahead = state.points[indices]
    angles = (_angle(first_ahead - first) + views[0][1], _angle(second_ahead - second) + views[1][1])
    rays = np.array([(math.cos(angle), math.sin(angle)) for angle in angles])
    if abs(math.sin(angles[1] - angles[0])) < 1e-3:
        return None
    along = np.linalg.solve(np.column_stack((rays[0], -rays[1])), second - first)
    if along.min() <= 0:
        return None
    place = first + along[0] * rays[0]
    to_place = np.array([_turning(place - first), _turning(place - second)])
    axes = np.array([_turning(first_ahead - first), _turning(second_ahead - second)])
    slopes = np.zeros((2, 4, 2))
    slopes[0, 0], slopes[0, 1] = axes[0] - to_place[0], -axes[0]
    slopes[1, 2], slopes[1, 3] = axes[1] - to_place[1], -axes[1]
    inverse = np.linalg.inv(to_place)
    columns = (POSE_SIZE + 2 * np.array(indices)[:, None] + np.arange(2)).ravel()
    rows = -inverse @ slopes.reshape(2, 8) @ state.covariance.rows(columns)
    own = -rows[:, columns] @ slopes.reshape(2, 8).T @ inverse.T + sd**2 * inverse @ inverse.T
    return place, rows, 0.5 * (own + own.T)


def _of_points(state: Filter, indices: list[int], slopes: Array, residual: float) -> Innovation:
    """A number that depends on differences of points (P): its derivatives (P, 2) → the innovation."""
    columns = (POSE_SIZE + 2 * np.array(indices)[:, None] + np.arange(2)).ravel()
    crossing = slopes.reshape(1, -1) @ state.covariance.rows(columns)
    return Innovation(crossing, crossing[:, columns] @ slopes.reshape(-1, 1), np.array([[residual]]))


def _angle(vector: Array) -> float:
    return math.atan2(float(vector[1]), float(vector[0]))


def _turning(vector: Array) -> Array:
    """(2,): change of a vector's direction with the vector."""
    return perpendicular(vector) / max(float(vector @ vector), 1e-12)
