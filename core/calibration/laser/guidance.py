"""Which pose of the board would teach most about the mount."""

import dataclasses
from collections.abc import Callable, Iterator

import numpy as np

from core.calibration.board.board import Board
from core.calibration.camera.guidance import Advice, advice_of, clear
from core.calibration.laser.plane_pairs import Guess, PlanePair, residuals_of, stack, whitening
from core.calibration.laser.planes import Plane, plane_of
from core.calibration.laser.range_lines import fit_ranges
from core.calibration.mount import Extrinsics, Mount
from core.calibration.practice import BoardPlacement, held
from core.calibration.projection import Poses, linearise, vector_of
from core.geometry import Transform
from core.message import Array
from core.optics import CameraModel

CANDIDATE_POSES = 150
FIRST_SEED = 5
LEAST_BEAMS = 15  # that have to meet the panel
CORNER_SD_PX = 0.2  # of a corner
HOLDING = BoardPlacement(nearest=0.35, farthest=1.2, least_tilt=0.0, most_tilt=np.deg2rad(55))


def advise_pose(
    board: Board,
    model: CameraModel,
    rays: Array,
    range_sd: float,
    mount: Mount,
    so_far: Extrinsics | Poses,
    *,
    fresh: Callable[[Plane], bool] = lambda _: True,
    asked: int = 0,
) -> Advice | None:
    """Choose the pose that shrinks the largest uncertainty of the mount most, from what is known so far.

    `rays` (B, 3) are the laser's beams, `range_sd` [m] the noise of an averaged range, `so_far` a solution or, before
    there is one, the poses taken. Planes of the board that are not `fresh` would not be taken; `asked` counts the
    times that the operator asked for another pose. Where the mount's height was measured the board is only turned to
    the left and right: it stands upright. None where no fresh pose is in view of both sensors.
    """
    if isinstance(so_far, Poses):
        guess, known = Guess(mount.nominal.rotation, mount.nominal.translation), np.diag(1 / mount.sds**2)
        for gain in _information_of_each(so_far, board, model, rays, range_sd, guess):
            known = known + (0.0 if gain is None else gain)
    else:
        guess, known = so_far.guess, np.linalg.inv(so_far.covariance)
    holding = dataclasses.replace(HOLDING, upright="height" in mount.from_ruler)
    poses = held(np.random.default_rng(FIRST_SEED + asked), CANDIDATE_POSES, model, board, holding)
    poses = poses.take(clear(model, poses, board))
    best, best_left = None, np.inf
    for number, gain in enumerate(_information_of_each(poses, board, model, rays, range_sd, guess, fresh)):
        if gain is not None:
            left = float(np.sum(np.diag(np.linalg.inv(known + gain)) / mount.sds**2))
            best, best_left = (number, left) if left < best_left else (best, best_left)
    return None if best is None else advice_of(model, poses, best, board)


def beams_on_panel(rays: Array, laser_from_board: Transform, board: Board) -> tuple[Array, Array]:
    """Unit vectors (B, 3) → the numbers (K,) of the beams that meet the panel, and their ranges (K,) [m]."""
    normal = laser_from_board.rotation[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        ranges = (normal @ laser_from_board.translation) / (rays @ normal)
        places = laser_from_board.inverse().apply(rays * ranges[:, None]) - board.centre
        hit = (ranges > 0) & np.all(np.abs(places[:, :2]) <= board.half_size, axis=1)
    return np.flatnonzero(hit), ranges[hit]


def _information_of_each(
    poses: Poses,
    board: Board,
    model: CameraModel,
    rays: Array,
    range_sd: float,
    guess: Guess,
    fresh: Callable[[Plane], bool] = lambda _: True,
) -> Iterator[Array | None]:
    """Information (6, 6) that each pose gives about the mount; None where it is not fresh or the laser misses it."""
    mount = Transform(rotation=guess.rotation, translation=guess.translation)
    by_pose = linearise(vector_of(model), poses, board.points).by_pose
    covariances = CORNER_SD_PX**2 * np.linalg.inv(np.swapaxes(by_pose, 1, 2) @ by_pose)
    for number, covariance in enumerate(covariances):
        pose = poses.take(slice(number, number + 1))
        laser_from_board = mount @ Transform(rotation=pose.rotations[0], translation=pose.translations[0])
        beams, ranges = beams_on_panel(rays, laser_from_board, board)
        plane = plane_of(pose, covariance)
        if len(beams) < LEAST_BEAMS or not fresh(plane):
            yield None
            continue
        seen = stack([PlanePair(plane=plane, ranges=fit_ranges(rays[beams], ranges, range_sd))])
        slope = residuals_of(seen, whitening(seen, guess))(guess)[1][:, :6]
        yield slope.T @ slope
