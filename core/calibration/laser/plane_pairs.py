"""Pairs of planes seen by camera and laser, and how well a mount explains each pair.

The camera's plane n·P = d, carried into the laser frame by (R, t), is m·P = s with m = R n and s = k d + m·t, k being
the board's true size over the entered one; it predicts q = m/s. A point p of the laser lies m·p - s off the plane.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from core.calibration.laser.planes import Plane
from core.calibration.laser.range_lines import RangeFit
from core.calibration.projection import cross_matrices, exponential
from core.message import Array, message

MIN_PLANE_DISTANCE_M = 0.02  # planes nearer to the laser than this, or behind it, are taken as this near
UNKNOWNS_COUNT = 8  # turn (3), shift (3), range offset, board scale


@message
class PlanePair:
    """One plane that the camera saw and that beams hit."""

    plane: Plane
    ranges: RangeFit


@message
class PointPair:
    """One laser point on a plane that the camera saw, such as a corner on the plane of sight of its vertical edge."""

    plane: Plane
    point: Array  # (3,) [m], laser frame
    covariance: Array  # (3, 3) [m²]


Pair = PlanePair | PointPair


class Guess(NamedTuple):
    """The unknowns."""

    rotation: Array  # (3, 3), laser_from_camera
    translation: Array  # (3,) [m]
    offset: float = 0.0  # [m]: measured range = true range + offset
    scale: float = 1.0  # the board's true size over the entered one

    def moved(self, step: Array) -> Guess:
        """Step (8,): turn [rad], shift [m], offset [m], scale."""
        return Guess(
            exponential(step[None, :3])[0] @ self.rotation,
            self.translation + step[3:6],
            self.offset + float(step[6]),
            self.scale + float(step[7]),
        )


class StackedPairs(NamedTuple):
    """Many pairs side by side; M of them hold beams, K hold points."""

    planes: Planes  # of the M pairs with beams
    q: Array  # (M, 3)
    by_offset: Array  # (M, 3)
    basis: Array  # (M, 3, 3): the measured directions, filled up with zero columns
    q_covariance: Array  # (M, 3, 3) in that basis, filled up with ones on the diagonal
    ranks: Array  # (M,) number of measured directions
    point_planes: Planes  # of the K pairs with points
    points: Array  # (K, 3)
    point_covariance: Array  # (K, 3, 3)
    order: Array  # (M + K,): where each stacked pair stood in the sequence


class Planes(NamedTuple):
    """Planes side by side."""

    normals: Array  # (M, 3)
    distances: Array  # (M,)
    covariances: Array  # (M, 4, 4)


Whitening = tuple[Array, Array]  # (M, 3, 3) and (K,)


def stack(pairs: Sequence[Pair]) -> StackedPairs:
    """Pairs in any order → stacked."""
    beams = [(number, pair) for number, pair in enumerate(pairs) if isinstance(pair, PlanePair)]
    points = [(number, pair) for number, pair in enumerate(pairs) if isinstance(pair, PointPair)]
    basis, covariance = np.zeros((len(beams), 3, 3)), np.tile(np.eye(3), (len(beams), 1, 1))
    for row, (_, pair) in enumerate(beams):
        count = pair.ranges.basis.shape[1]
        basis[row, :, :count] = pair.ranges.basis
        covariance[row, :count, :count] = pair.ranges.covariance
    return StackedPairs(
        planes=planes_of([pair.plane for _, pair in beams]),
        q=np.array([pair.ranges.q for _, pair in beams]).reshape(-1, 3),
        by_offset=np.array([pair.ranges.by_offset for _, pair in beams]).reshape(-1, 3),
        basis=basis,
        q_covariance=covariance,
        ranks=np.array([pair.ranges.basis.shape[1] for _, pair in beams], dtype=int),
        point_planes=planes_of([pair.plane for _, pair in points]),
        points=np.array([pair.point for _, pair in points]).reshape(-1, 3),
        point_covariance=np.array([pair.covariance for _, pair in points]).reshape(-1, 3, 3),
        order=np.array([number for number, _ in beams] + [number for number, _ in points], dtype=int),
    )


def whitening(seen: StackedPairs, guess: Guess) -> Whitening:
    """The matrices that give every residual unit variance at `guess`: from beam noise and the camera's planes."""
    spread, variance = _spread(seen, guess)
    return np.linalg.inv(np.linalg.cholesky(spread)) @ np.swapaxes(seen.basis, 1, 2), 1 / np.sqrt(variance)


def residuals_of(seen: StackedPairs, weights: Whitening) -> Callable[[Guess], tuple[Array, Array]]:
    """Stacked pairs → a function from a guess to whitened residuals (3M + K,) and their Jacobian (…, 8)."""

    def model(guess: Guess) -> tuple[Array, Array]:
        predicted, slope = predict(seen.planes, guess)
        slope[:, :, 6] = -seen.by_offset
        error = predicted - seen.q - guess.offset * seen.by_offset
        off, off_slope = points_off(seen, guess)
        return (
            np.concatenate(((weights[0] @ error[:, :, None]).ravel(), weights[1] * off)),
            np.concatenate(((weights[0] @ slope).reshape(-1, UNKNOWNS_COUNT), weights[1][:, None] * off_slope)),
        )

    return model


def predict(planes: Planes, guess: Guess) -> tuple[Array, Array]:
    """The camera's planes and a mount → q as the laser should find it (M, 3), and its derivative (M, 3, 8)."""
    normals, nearness = _carried(planes, guess)
    near = nearness[:, None, None]
    predicted = normals / nearness[:, None]
    slope = np.zeros((len(normals), 3, UNKNOWNS_COUNT))
    cross = cross_matrices(normals)
    turned = cross @ guess.translation
    slope[:, :, :3] = (-cross - predicted[:, :, None] * turned[:, None]) / near
    slope[:, :, 3:6] = -predicted[:, :, None] * normals[:, None] / near
    slope[:, :, 7] = -predicted * (planes.distances / nearness)[:, None]
    return predicted, slope


def disagreement(pairs: Sequence[Pair], guess: Guess, covariance: Array) -> Array:
    """(M,): chi-square (2 dof) of every pair against a mount that is itself uncertain by `covariance` (6, 6)."""
    seen = stack(pairs)
    plain = (np.swapaxes(seen.basis, 1, 2), np.ones(len(seen.points)))
    error, slope = residuals_of(seen, plain)(guess)
    spread, variance = _spread(seen, guess)
    count = 3 * len(seen.q)
    by_mount = slope[:count, :6].reshape(-1, 3, 6)
    spread = spread + by_mount @ covariance @ np.swapaxes(by_mount, 1, 2)
    beams = error[:count].reshape(-1, 3)
    chi2 = np.einsum("ki,kij,kj->k", beams, np.linalg.inv(spread), beams) * 2 / np.maximum(seen.ranks, 1)
    variance = variance + np.einsum("ki,ij,kj->k", slope[count:, :6], covariance, slope[count:, :6])
    values = np.empty(len(seen.order))
    values[seen.order] = np.concatenate((chi2, 2 * error[count:] ** 2 / variance))
    return values


def chi_squares(seen: StackedPairs, guess: Guess) -> Array:
    """(M + K,) of every pair in its original order, divided by half its number of measured directions: expected 2."""
    whitened, _ = residuals_of(seen, whitening(seen, guess))(guess)
    beams = np.sum(whitened[: 3 * len(seen.q)].reshape(-1, 3) ** 2, axis=1) * 2 / np.maximum(seen.ranks, 1)
    values = np.empty(len(seen.order))
    values[seen.order] = np.concatenate((beams, 2 * whitened[3 * len(seen.q) :] ** 2))
    return values


def behind(seen: StackedPairs, guess: Guess) -> int:
    """Count the planes that this guess puts behind the laser."""
    return int(np.count_nonzero(_nearness(seen.planes, guess)[1] <= MIN_PLANE_DISTANCE_M))


def planes_of(planes: Sequence[Plane]) -> Planes:
    """Planes side by side."""
    return Planes(
        np.array([plane.normal for plane in planes]).reshape(-1, 3),
        np.array([plane.distance for plane in planes]),
        np.array([plane.covariance for plane in planes]).reshape(-1, 4, 4),
    )


def _spread(seen: StackedPairs, guess: Guess) -> tuple[Array, Array]:
    """Covariance of q (M, 3, 3) in the measured basis, and variance of the points' distances (K,) [m²]."""
    normals, nearness = _carried(seen.planes, guess)
    near = nearness[:, None, None]
    by_normal = guess.rotation - normals[:, :, None] * (guess.translation @ guess.rotation) / near
    by_plane = np.concatenate((by_normal, -guess.scale * normals[:, :, None] / near), axis=2) / near
    inside = np.swapaxes(seen.basis, 1, 2) @ by_plane
    spread = seen.q_covariance + inside @ seen.planes.covariances @ np.swapaxes(inside, 1, 2)
    spread = spread + 1e-9 * np.trace(spread, axis1=1, axis2=2)[:, None, None] * np.eye(3)  # planes through the laser
    normals, _ = _carried(seen.point_planes, guess)
    camera_points = (seen.points - guess.translation) @ guess.rotation
    by_plane = np.column_stack((camera_points, np.full(len(camera_points), -guess.scale)))
    variance = np.einsum("ki,kij,kj->k", normals, seen.point_covariance, normals)
    variance = variance + np.einsum("ki,kij,kj->k", by_plane, seen.point_planes.covariances, by_plane)
    return spread, np.maximum(variance, 1e-18)


def _nearness(planes: Planes, guess: Guess) -> tuple[Array, Array]:
    normals = planes.normals @ guess.rotation.T
    return normals, guess.scale * planes.distances + normals @ guess.translation


def _carried(planes: Planes, guess: Guess) -> tuple[Array, Array]:
    """Planes in the laser frame: normals (M, 3) and distances (M,), kept positive."""
    normals, nearness = _nearness(planes, guess)
    return normals, np.maximum(nearness, MIN_PLANE_DISTANCE_M)


def points_off(seen: StackedPairs, guess: Guess) -> tuple[Array, Array]:
    """Distances of the points from their planes (K,) [m] (eq. 13), and the derivative (K, 8)."""
    if len(seen.points) == 0:
        return np.zeros(0), np.zeros((0, UNKNOWNS_COUNT))
    normals, nearness = _nearness(seen.point_planes, guess)
    off = np.sum(normals * seen.points, axis=1) - nearness
    slope = np.zeros((len(normals), UNKNOWNS_COUNT))
    slope[:, :3] = np.cross(normals, seen.points - guess.translation)
    slope[:, 3:6] = -normals
    slope[:, 7] = -seen.point_planes.distances
    return off, slope
