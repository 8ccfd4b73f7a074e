"""The least-squares problem of eq. 9: one camera, many poses of one board, all at once.

Every view has six unknowns of its own, so the poses are eliminated view by view (Schur complement) and only the few
intrinsic unknowns are solved together; the same elimination gives their covariance at the cost of one iteration.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from core.calibration.levenberg_marquardt import Linearisation, descend, soft_costs, soft_weights
from core.calibration.projection import Poses, exponential, linearise, project
from core.message import Array

MAX_STEPS = 60
RIDGE_SHARE = 1e-13  # of the scaled information


class Corners(NamedTuple):
    """Observations: M views of the N corners of one board."""

    points: Array  # (N, 3) [m], board frame
    pixels: Array  # (M, N, 2)
    used: Array  # (M, N) bool: corners that take part

    @property
    def views_used(self) -> Array:
        """(M,) bool: views of which any corner takes part."""
        return np.count_nonzero(self.used, axis=1) > 0

    def take(self, which: Array | slice) -> Corners:
        """The chosen views."""
        return Corners(self.points, self.pixels[which], self.used[which])


class BundleSolution(NamedTuple):
    """A camera and the poses of the board."""

    camera: Array  # (9,)
    poses: Poses


class PoseGram(NamedTuple):
    """Products of the Jacobians by the poses alone, view by view."""

    information: Array  # (M, 6, 6)
    gradient: Array  # (M, 6)


class Gram(NamedTuple):
    """Products of the Jacobians, view by view: all that a step needs."""

    camera: Array  # (M, P, P)
    mixed: Array  # (M, P, 6)
    pose: Array  # (M, 6, 6)
    camera_gradient: Array  # (M, P)
    pose_gradient: Array  # (M, 6)


def errors(corners: Corners, solution: BundleSolution) -> Array:
    """Projected minus seen (M, N, 2) [pixel]; also for corners that take no part."""
    return project(solution.camera, solution.poses, corners.points) - corners.pixels


def view_rms(corners: Corners, solution: BundleSolution) -> Array:
    """(M,) [pixel]: root mean square error of each view over its used corners, both axes together."""
    squares = np.sum(errors(corners, solution) ** 2, axis=2) * corners.used
    return np.sqrt(squares.sum(axis=1) / np.maximum(corners.used.sum(axis=1), 1))


def refine(
    corners: Corners, start: BundleSolution, free: tuple[int, ...], *, soft: float | None = None
) -> BundleSolution:
    """Levenberg-Marquardt on eq. 9 over the `free` parameters and all poses; `soft` [pixel]: soft-L1 loss."""

    def at(solution: BundleSolution) -> Linearisation[BundleSolution, Gram]:
        gram, cost = _gram(corners, solution, free, soft)
        admissible = solution.camera[0] > 0 and solution.camera[1] > 0
        return Linearisation(solution, gram, np.array([cost if admissible else np.inf]))

    def advance(solution: BundleSolution, gram: Gram, damping: Array) -> BundleSolution:
        camera_step, pose_steps = _step(gram, damping)
        camera = solution.camera.copy()
        camera[list(free)] += camera_step
        return BundleSolution(camera, solution.poses.moved(pose_steps))

    return descend(at, advance, start, iterations=MAX_STEPS, close=1e-10).state


def refine_poses(
    corners: Corners, start: BundleSolution, *, soft: float | None = None, steps: int = 12, close: float = 1e-9
) -> Poses:
    """Refine every pose by itself with the camera held, until none gains more than the share `close` of its cost."""

    def at(poses: Poses) -> Linearisation[Poses, PoseGram]:
        gram, costs = _pose_gram(corners, start.camera, poses, soft)
        return Linearisation(poses, gram, costs)

    def advance(poses: Poses, gram: PoseGram, damping: Array) -> Poses:
        return poses.moved(-_solve(_damped(gram.information, damping), gram.gradient))

    found = descend(at, advance, start.poses, iterations=steps, close=close, hopeless=1e6, choose=_the_better_poses)
    return found.state


def _the_better_poses(
    better: Array, there: Linearisation[Poses, PoseGram], here: Linearisation[Poses, PoseGram]
) -> Linearisation[Poses, PoseGram]:
    """Move the boards (M,) that improved."""
    return Linearisation(
        _chosen(better, there.state, here.state),
        PoseGram(
            np.where(better[:, None, None], there.linear.information, here.linear.information),
            np.where(better[:, None], there.linear.gradient, here.linear.gradient),
        ),
        np.where(better, there.costs, here.costs),
    )


def _chosen(which: Array, poses: Poses, others: Poses) -> Poses:
    """Take the `poses` where `which` (M,) is true, the `others` elsewhere."""
    return Poses(
        np.where(which[:, None, None], poses.rotations, others.rotations),
        np.where(which[:, None], poses.translations, others.translations),
    )


def mirrored(poses: Poses, centre: Array) -> Poses:
    """The other pose that looks nearly the same: the board turned over about its line of sight.

    In weak perspective half a turn about the ray to the board's centre (3,) [m], and half a turn of the board in its
    own plane, cancel out in the picture; a planar board therefore has two minima.
    """
    middle = poses.rotations @ centre + poses.translations
    sight = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    rotations = exponential(np.pi * sight) @ poses.rotations * np.array([-1.0, -1.0, 1.0])
    return Poses(rotations, middle - rotations @ centre)


def rescue(
    corners: Corners, solution: BundleSolution, *, soft: float | None = None, ratio: float = 0.9
) -> tuple[BundleSolution, Array]:
    """Turn boards over where the mirrored pose fits better by `ratio`; also (M,) bool: which were turned."""
    other = mirrored(solution.poses, corners.points.mean(axis=0))
    other = refine_poses(corners, BundleSolution(solution.camera, other), soft=soft, steps=8, close=0.01)
    turned = _losses(corners, BundleSolution(solution.camera, other), soft) < ratio**2 * _losses(
        corners, solution, soft
    )
    return BundleSolution(solution.camera, _chosen(turned, other, solution.poses)), turned


def information(corners: Corners, solution: BundleSolution, free: tuple[int, ...]) -> Array:
    """(M, P, P) [1/pixel²]: what each view contributes to the free parameters once its own pose is accounted for."""
    return information_and_pull(corners, solution, free)[0]


def information_and_pull(
    corners: Corners, solution: BundleSolution, free: tuple[int, ...], more: Array | None = None
) -> tuple[Array, Array]:
    """`information` (M, P, P), and the gradient (M, P) of half of every view's cost with its pose following.

    `more` (M, 2N, K): derivatives by more unknowns of all views, which become the last of P.
    """
    gram, _ = _gram(corners, solution, free, None, more)
    pose = _damped(gram.pose, np.zeros(len(gram.pose)))  # a view without corners adds nothing and divides by nothing
    right = np.concatenate((np.swapaxes(gram.mixed, 1, 2), gram.pose_gradient[..., None]), axis=2)
    less = gram.mixed @ _solve(pose, right)
    return gram.camera - less[..., :-1], gram.camera_gradient - less[..., -1]


def covariance(precision: Array, spread: float) -> Array:
    """Information (P, P) [1/pixel²] and the corners' noise [pixel] → covariance (P, P).

    Directions without any information get a huge variance; a pseudo-inverse would give them none.
    """
    scale = 1 / np.sqrt(np.maximum(np.diag(precision), 1e-300))
    level = precision * np.outer(scale, scale) + RIDGE_SHARE * np.eye(len(precision))
    return spread**2 * np.linalg.inv(level) * np.outer(scale, scale)


def pose_covariances(
    corners: Corners, solution: BundleSolution, free: tuple[int, ...], camera: Array, spread: float
) -> Array:
    """Covariance (M, 6, 6) of every view's pose [rad, m]: rotation about the camera's axes, then translation.

    `camera` (P, P): covariance of the free parameters, which the poses follow; `spread`: the corners' noise [pixel].
    """
    gram, _ = _gram(corners, solution, free, None)
    pose = _damped(gram.pose, np.zeros(len(gram.pose)))
    follows = _solve(pose, np.swapaxes(gram.mixed, 1, 2))  # (M, 6, P)
    alone = _solve(pose, np.broadcast_to(np.eye(6), pose.shape))
    return spread**2 * alone + follows @ camera @ np.swapaxes(follows, 1, 2)


def noise(corners: Corners, solution: BundleSolution, free: tuple[int, ...]) -> float:
    """Standard deviation [pixel] of a corner's coordinate, with the unknowns counted off."""
    squares = float(np.sum(np.sum(errors(corners, solution) ** 2, axis=2) * corners.used))
    views = int(np.count_nonzero(corners.views_used))
    return float(np.sqrt(squares / max(2 * np.count_nonzero(corners.used) - len(free) - 6 * views, 1)))


def _gram(
    corners: Corners, solution: BundleSolution, free: tuple[int, ...], soft: float | None, more: Array | None = None
) -> tuple[Gram, float]:
    linear = linearise(solution.camera, solution.poses, corners.points)
    error, weights, cost = _weighted(corners, linear.pixels, soft)
    by_camera = linear.by_camera[..., list(free)]
    by_camera = by_camera if more is None else np.concatenate((by_camera, more), axis=2)
    count = by_camera.shape[2]
    stacked = np.concatenate((by_camera, linear.by_pose, error[..., None]), axis=2)
    product = np.swapaxes(stacked * weights[..., None], 1, 2) @ stacked
    last = count + 6
    gram = Gram(
        product[:, :count, :count],
        product[:, :count, count:last],
        product[:, count:last, count:last],
        product[:, :count, last],
        product[:, count:last, last],
    )
    return gram, float(cost.sum())


def _pose_gram(corners: Corners, camera: Array, poses: Poses, soft: float | None) -> tuple[PoseGram, Array]:
    linear = linearise(camera, poses, corners.points)
    error, weights, costs = _weighted(corners, linear.pixels, soft)
    weighted = np.swapaxes(linear.by_pose * weights[..., None], 1, 2)
    return PoseGram(weighted @ linear.by_pose, (weighted @ error[..., None])[..., 0]), costs


def _weighted(corners: Corners, pixels: Array, soft: float | None) -> tuple[Array, Array, Array]:
    """Errors (M, 2N), their weights (M, 2N) and the cost of every view (M,)."""
    error = pixels - corners.pixels
    lengths = np.where(corners.used, np.linalg.norm(error, axis=2), 0.0)
    if soft is None:
        weights, costs = corners.used.astype(float), np.sum(lengths**2, axis=1)
    else:
        weights = corners.used * soft_weights(lengths, soft)
        costs = soft_costs(lengths, soft).sum(axis=1)
    return error.reshape(len(error), -1), np.repeat(weights, 2, axis=1), costs


def _losses(corners: Corners, solution: BundleSolution, soft: float | None) -> Array:
    return _weighted(corners, project(solution.camera, solution.poses, corners.points), soft)[2]


def _step(gram: Gram, damping: Array) -> tuple[Array, Array]:
    """One step, damped by one number (1,): the camera's (P,) and every pose's (M, 6)."""
    pose = _damped(gram.pose, damping)
    right = np.concatenate((np.swapaxes(gram.mixed, 1, 2), gram.pose_gradient[..., None]), axis=2)
    solved = _solve(pose, right)
    camera = gram.camera.sum(axis=0)
    camera = camera + np.diag(damping * np.diag(camera))
    schur = camera - np.sum(gram.mixed @ solved[..., :-1], axis=0)
    gradient = gram.camera_gradient.sum(axis=0) - np.sum(gram.mixed @ solved[..., -1:], axis=0)[:, 0]
    scale = np.sqrt(np.maximum(np.diag(schur), 1e-300))
    step = -np.linalg.lstsq(schur / np.outer(scale, scale), gradient / scale, rcond=1e-14)[0] / scale
    return step, -(solved[..., -1] + solved[..., :-1] @ step)


def _damped(matrices: Array, damping: Array) -> Array:
    """Matrices (M, 6, 6) with their diagonals raised by the factor 1 + damping, (M,) or (1,) for all alike."""
    raised = matrices.copy()
    index = np.arange(matrices.shape[-1])
    diagonal = raised[:, index, index]
    floor = 1e-12 * np.maximum(diagonal.max(axis=1, keepdims=True), 1e-12)
    raised[:, index, index] = diagonal * (1 + damping[:, None]) + floor
    return raised


def _solve(matrices: Array, right: Array) -> Array:
    """Solve (M, 6, 6) against (M, 6) or (M, 6, K)."""
    return (
        np.linalg.solve(matrices, right[..., None])[..., 0] if right.ndim == 2 else np.linalg.solve(matrices, right)
    )
