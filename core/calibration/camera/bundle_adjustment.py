"""The least-squares problem of eq. 9: one camera, many poses of one board, all at once.

Every view has six unknowns of its own, so the poses are eliminated view by view (Schur complement) and only the few
intrinsic unknowns are solved together; the same elimination gives their covariance at the cost of one iteration.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from core.calibration.levenberg_marquardt import FIRST_DAMPING, LEAST_DAMPING, Linearisation, descend
from core.calibration.projection import BY_ROW, PARAMETERS, Poses, exponential, linearise, project
from core.message import Array

MAX_STEPS = 60
POSE_BEGIN, POSE_END = len(PARAMETERS), len(PARAMETERS) + 6  # columns of a pose in `linearise`
NEAR_DAMPING = 1e-6  # the first, from a start that is nearly the solution
MOST_OF_PROMISE = 3.0  # times what a step promises, that a pose may still gain
HOPELESS_DAMPING = 1e6  # of a pose
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

    def thinned(self, count: int) -> Corners:
        """So many of the board's corners at most, picked at random but the same every time."""
        if count >= len(self.points):
            return self
        some = np.sort(np.random.default_rng(0).permutation(len(self.points))[:count])
        return Corners(self.points[some], self.pixels[:, some], self.used[:, some])


class BundleSolution(NamedTuple):
    """A camera and the poses of the board."""

    camera: Array  # (9,)
    poses: Poses


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


def refine(
    corners: Corners,
    start: BundleSolution,
    free: tuple[int, ...],
    *,
    soft: float | None = None,
    close: float = 1e-10,
    damping: float = NEAR_DAMPING,
) -> BundleSolution:
    """Levenberg-Marquardt on eq. 9 over the `free` parameters and all poses; `soft` [pixel]: soft-L1 loss."""

    def at(solution: BundleSolution) -> Linearisation[BundleSolution, Gram]:
        gram, cost = _gram(corners, solution, free, soft)
        admissible = solution.camera[0] > 0 and solution.camera[1] > 0
        return Linearisation(solution, gram, cost if admissible else np.inf)

    def advance(solution: BundleSolution, gram: Gram, damping: float) -> tuple[BundleSolution, float]:
        camera_step, pose_steps, promised = _step(gram, damping)
        camera = solution.camera.copy()
        camera[list(free)] += camera_step
        return BundleSolution(camera, solution.poses.moved(pose_steps)), promised

    return descend(at, advance, start, iterations=MAX_STEPS, close=close, damping=damping).state


def refine_poses(
    corners: Corners,
    start: BundleSolution,
    *,
    soft: float | None = None,
    steps: int = 12,
    close: float = 1e-9,
    beyond: Array | None = None,
) -> Poses:
    """Refine every pose by itself with the camera held, until no more than the share `close` is to be gained.

    A pose that is done takes no part in the further steps, nor one that will hardly cost less than `beyond` (M,).
    """
    found = Poses(*(each.copy() for each in start.poses))
    going, poses = np.arange(len(corners.pixels)), start.poses
    level, pull, costs = _by_pose(corners, start.camera, poses, soft)
    damping = np.full(len(going), FIRST_DAMPING)
    for _ in range(steps):
        step = -_solve(_damped(level, damping), pull)
        promised = -np.sum(step * pull, axis=1)
        on = np.where(damping > FIRST_DAMPING, damping < HOPELESS_DAMPING, promised > close * costs)
        if beyond is not None:
            on &= costs - MOST_OF_PROMISE * promised < beyond
            beyond = beyond[on]
        if not on.any():
            break
        going, poses, damping = going[on], poses.take(on), damping[on]
        there = poses.moved(step[on])
        here, ahead = (level[on], pull[on], costs[on]), _by_pose(corners.take(going), start.camera, there, soft)
        better = ahead[2] <= here[2]
        level, pull, costs = (
            np.where(better.reshape(-1, *[1] * (new.ndim - 1)), new, old)
            for new, old in zip(ahead, here, strict=True)
        )
        poses = _chosen(better, there, poses)
        found.rotations[going], found.translations[going] = poses
        damping = np.maximum(np.where(better, damping / 10, damping * 10), LEAST_DAMPING)
    return found


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
    beyond = ratio**2 * _losses(corners, solution, soft)
    other = refine_poses(
        corners, BundleSolution(solution.camera, other), soft=soft, steps=8, close=0.01, beyond=beyond
    )
    turned = _losses(corners, BundleSolution(solution.camera, other), soft) < beyond
    return BundleSolution(solution.camera, _chosen(turned, other, solution.poses)), turned


class NormalEquations(NamedTuple):
    """Every view's share of the normal equations, its own pose eliminated: PARAMETERS, shapes of the board, rows."""

    precision: Array  # (M, P, P) [1/pixel²]
    pull: Array  # (M, P): gradient of half of the view's cost with its pose following

    def of(self, columns: Sequence[int]) -> NormalEquations:
        """Those of some unknowns alone."""
        chosen = list(columns)
        return NormalEquations(self.precision[:, chosen][:, :, chosen], self.pull[:, chosen])

    def take(self, which: Array) -> NormalEquations:
        """Those of the chosen views alone."""
        return NormalEquations(self.precision[which], self.pull[which])


def equations(
    corners: Corners, solution: BundleSolution, shapes: Sequence[Array] = (), *, rows: bool = False
) -> NormalEquations:
    """The normal equations at a solution; `shapes` and `rows`: more unknowns, as `linearise` has them."""
    unknowns = (*range(len(PARAMETERS)), *range(POSE_END, POSE_END + len(shapes) + BY_ROW * rows))
    gram, _ = _gram(corners, solution, unknowns, None, shapes, rows=rows)
    pose = _damped(gram.pose, 0.0)  # a view without corners adds nothing and divides by nothing
    right = np.concatenate((np.swapaxes(gram.mixed, 1, 2), gram.pose_gradient[..., None]), axis=2)
    less = gram.mixed @ _solve(pose, right)
    return NormalEquations(gram.camera - less[..., :-1], gram.camera_gradient - less[..., -1])


def information(corners: Corners, solution: BundleSolution, free: tuple[int, ...]) -> Array:
    """(M, P, P) [1/pixel²]: what each view contributes to the free parameters once its own pose is accounted for."""
    return equations(corners, solution).of(free).precision


def covariance(precision: Array, spread: float) -> Array:
    """Information (..., P, P) [1/pixel²] and the corners' noise [pixel] → covariance (..., P, P).

    Directions without any information get a huge variance; a pseudo-inverse would give them none.
    """
    scale = 1 / np.sqrt(np.maximum(np.diagonal(precision, axis1=-2, axis2=-1), 1e-300))
    scales = scale[..., :, None] * scale[..., None, :]
    return spread**2 * np.linalg.inv(precision * scales + RIDGE_SHARE * np.eye(precision.shape[-1])) * scales


def pose_covariances(
    corners: Corners, solution: BundleSolution, free: tuple[int, ...], camera: Array, spread: float
) -> Array:
    """Covariance (M, 6, 6) of every view's pose [rad, m]: rotation about the camera's axes, then translation.

    `camera` (P, P): covariance of the free parameters, which the poses follow; `spread`: the corners' noise [pixel].
    """
    gram, _ = _gram(corners, solution, free, None)
    pose = _damped(gram.pose, 0.0)
    follows = _solve(pose, np.swapaxes(gram.mixed, 1, 2))  # (M, 6, P)
    alone = _solve(pose, np.broadcast_to(np.eye(6), pose.shape))
    return spread**2 * alone + follows @ camera @ np.swapaxes(follows, 1, 2)


def noise(corners: Corners, solution: BundleSolution, free: tuple[int, ...]) -> float:
    """Standard deviation [pixel] of a corner's coordinate, with the unknowns counted off."""
    squares = float(np.sum(np.sum(errors(corners, solution) ** 2, axis=2) * corners.used))
    views = int(np.count_nonzero(corners.views_used))
    return float(np.sqrt(squares / max(2 * np.count_nonzero(corners.used) - len(free) - 6 * views, 1)))


def _gram(
    corners: Corners,
    solution: BundleSolution,
    free: tuple[int, ...],
    soft: float | None,
    shapes: Sequence[Array] = (),
    *,
    rows: bool = False,
) -> tuple[Gram, float]:
    """`free`: numbers of the columns of `linearise` that count as the camera's."""
    linear = linearise(solution.camera, solution.poses, corners.points, shapes, rows=rows)
    error, weights, costs = _weighted(corners, linear.pixels, soft)
    product, gradient = _products(linear.columns, error, weights)
    camera, pose = list(free), slice(POSE_BEGIN, POSE_END)
    some = product[:, camera]
    gram = Gram(some[:, :, camera], some[:, :, pose], product[:, pose, pose], gradient[:, camera], gradient[:, pose])
    return gram, float(costs.sum())


def _by_pose(corners: Corners, camera: Array, poses: Poses, soft: float | None) -> tuple[Array, Array, Array]:
    """Every pose's information (M, 6, 6), its gradient (M, 6) and its cost (M,), the camera held."""
    linear = linearise(camera, poses, corners.points)
    error, weights, costs = _weighted(corners, linear.pixels, soft)
    return *_products(linear.columns[:, POSE_BEGIN:], error, weights), costs


def _products(columns: Array, error: Array, weights: Array | None) -> tuple[Array, Array]:
    """Derivatives (M, C, 2N), errors and their weights (M, 2N) → JᵀWJ (M, C, C) and JᵀWe (M, C)."""
    if weights is not None:
        root = np.sqrt(weights)
        columns, error = columns * root[:, None], error * root
    return columns @ np.swapaxes(columns, 1, 2), (columns @ error[..., None])[..., 0]


def _weighted(corners: Corners, pixels: Array, soft: float | None) -> tuple[Array, Array | None, Array]:
    """Errors (M, 2N), u before v, their weights (M, 2N), None for one each, and the cost of every view (M,)."""
    error = np.ascontiguousarray(np.swapaxes(pixels - corners.pixels, 1, 2))
    squares, used = error[:, 0] ** 2 + error[:, 1] ** 2, corners.used
    flat = error.reshape(len(error), -1)
    if soft is None:
        weights = None if used.all() else np.tile(used.astype(float), 2)
        return flat, weights, np.sum(squares * used, axis=1)
    rising = np.sqrt(1 + squares / soft**2)
    return flat, np.tile(used / rising, 2), np.sum(2 * soft**2 * (rising - 1) * used, axis=1)


def _losses(corners: Corners, solution: BundleSolution, soft: float | None) -> Array:
    return _weighted(corners, project(solution.camera, solution.poses, corners.points), soft)[2]


def _step(gram: Gram, damping: float) -> tuple[Array, Array, float]:
    """One damped step: the camera's (P,), every pose's (M, 6), and by how much it should lower the cost."""
    pose = _damped(gram.pose, damping)
    right = np.concatenate((np.swapaxes(gram.mixed, 1, 2), gram.pose_gradient[..., None]), axis=2)
    solved = _solve(pose, right)
    camera = gram.camera.sum(axis=0)
    camera = camera + np.diag(damping * np.diag(camera))
    less = np.sum(gram.mixed @ solved, axis=0)
    schur, pull = camera - less[:, :-1], gram.camera_gradient.sum(axis=0)
    gradient = pull - less[:, -1]
    scale = np.sqrt(np.maximum(np.diag(schur), 1e-300))
    step = -np.linalg.lstsq(schur / np.outer(scale, scale), gradient / scale, rcond=1e-14)[0] / scale
    steps = -(solved[..., -1] + solved[..., :-1] @ step)
    return step, steps, float(-pull @ step - np.sum(gram.pose_gradient * steps))


def _damped(matrices: Array, damping: Array | float) -> Array:
    """Matrices (M, 6, 6) with their diagonals raised by the factor 1 + damping, (M,) or one for all."""
    raised = matrices.copy()
    index = np.arange(matrices.shape[-1])
    diagonal = raised[:, index, index]
    floor = 1e-12 * np.maximum(diagonal.max(axis=1, keepdims=True), 1e-12)
    raised[:, index, index] = diagonal * (1 + np.reshape(damping, (-1, 1))) + floor
    return raised


def _solve(matrices: Array, right: Array) -> Array:
    """Solve (M, 6, 6) against (M, 6) or (M, 6, K)."""
    return (
        np.linalg.solve(matrices, right[..., None])[..., 0] if right.ndim == 2 else np.linalg.solve(matrices, right)
    )
