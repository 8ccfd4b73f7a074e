"""A practice board: poses as a person would hold it, the corners a camera would see, and rendered pictures."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from core.calibration.board.board import Board
from core.calibration.camera.undistortion import all_pixels
from core.calibration.projection import Poses, exponential, project, vector_of
from core.message import Array
from core.optics import CameraModel

RAYS_PER_PIXEL = 4  # rays per pixel side
DARK_GREY, LIGHT_GREY, WALL_GREY = 38.0, 205.0, 120.0  # grey levels


@dataclass(frozen=True)
class BoardPlacement:
    """Ranges of the board's poses."""

    nearest: float = 0.25  # [m]
    farthest: float = 0.9  # [m]
    least_tilt: float = 0.0  # [rad] between the board's normal and the line of sight
    most_tilt: float = np.deg2rad(45)
    roll: float = np.deg2rad(20)  # either way, about the line of sight
    margin: float = 4.0  # [pixel] that every corner keeps from the rim of the picture
    upright: bool = False  # turned to the left and right only, as a board that stands


@dataclass(frozen=True)
class ImageExposure:
    """Exposure of the picture."""

    blur: float = 0.5  # [pixel] standard deviation of the lens
    motion: float = 0.0  # [pixel] smeared to the right
    noise: float = 2.0  # [grey level] standard deviation


def held(
    rng: np.random.Generator, count: int, model: CameraModel, board: Board, how: BoardPlacement | None = None
) -> Poses:
    """Random poses with the whole board in the picture: rotations (count, 3, 3), translations (count, 3)."""
    how = how or BoardPlacement()
    rotations, translations = np.empty((0, 3, 3)), np.empty((0, 3))
    for _ in range(1000):
        batch = _any(rng, max(64, 4 * count), model, board, how)
        good = visible(model, batch, board, how.margin)
        rotations = np.concatenate((rotations, batch.rotations[good]))
        translations = np.concatenate((translations, batch.translations[good]))
        if len(rotations) >= count:
            return Poses(rotations[:count], translations[:count])
    raise ValueError("The board does not fit into the picture at these distances.")


def visible(model: CameraModel, poses: Poses, board: Board, margin: float) -> Array:
    """(M,) bool: poses in which every corner lies inside the picture, in front of the camera."""
    pixels = project(vector_of(model), poses, board.points)
    inside = (pixels >= margin) & (pixels <= np.array([model.width - 1, model.height - 1]) - margin)
    depth = poses.points(board.points)[..., 2]
    within = np.linalg.norm(poses.points(board.points)[..., :2] / np.maximum(depth, 1e-3)[..., None], axis=2)
    return inside.all(axis=(1, 2)) & (depth > 0.05).all(axis=1) & (within < model.turning_radius).all(axis=1)


def seen(rng: np.random.Generator, model: CameraModel, poses: Poses, board: Board, noise: float) -> Array:
    """Corners (M, N, 2) [pixel] of the board in M poses, with Gaussian `noise` [pixel] on each coordinate."""
    pixels = project(vector_of(model), poses, board.points)
    return pixels + rng.normal(0.0, noise, pixels.shape)


def picture(
    rng: np.random.Generator, model: CameraModel, poses: Poses, board: Board, exposure: ImageExposure | None = None
) -> Array:
    """The first of the poses as a grey picture (H, W) uint8; a pixel collects RAYS_PER_PIXEL**2 rays."""
    exposure = exposure or ImageExposure()
    rotation, translation = poses.rotations[0], poses.translations[0]
    height, width = model.height, model.width
    shade = np.linspace(0.92, 1.05, width)[None, :] * np.linspace(1.03, 0.94, height)[:, None]
    grey = np.full((height, width), WALL_GREY)
    left, top, right, bottom = _box(model, poses, board)
    if right > left and bottom > top:
        rays = _rays(model)[
            top * RAYS_PER_PIXEL : bottom * RAYS_PER_PIXEL, left * RAYS_PER_PIXEL : right * RAYS_PER_PIXEL
        ]
        into_board = np.linalg.inv(np.column_stack((rotation[:, :2], translation)))
        ground = rays @ into_board[:, :2].T + into_board[:, 2]
        with np.errstate(invalid="ignore", divide="ignore"):  # pixels that no ray reaches stay as the wall
            grey[top:bottom, left:right] = _shades(ground[..., :2] / ground[..., 2:], ground[..., 2], board)
    grey = cv2.GaussianBlur(grey * shade, (0, 0), max(exposure.blur, 0.01))
    if exposure.motion >= 2:
        grey = cv2.blur(grey, (round(exposure.motion), 1))
    return np.clip(grey + rng.normal(0.0, exposure.noise, grey.shape), 0, 255).astype(np.uint8)


def _any(rng: np.random.Generator, count: int, model: CameraModel, board: Board, how: BoardPlacement) -> Poses:
    depth = rng.uniform(how.nearest, how.farthest, count)
    place = np.column_stack((rng.uniform(0, model.width, count), rng.uniform(0, model.height, count)))
    ideal = model.undistort((place - (model.cx, model.cy)) / (model.fx, model.fy))  # NaN where no ray reaches
    middle = np.column_stack((ideal, np.ones(count))) * depth[:, None]
    about = rng.choice([-np.pi / 2, np.pi / 2], count) if how.upright else rng.uniform(0, 2 * np.pi, count)
    roll = 0.0 if how.upright else how.roll
    tilt = rng.uniform(how.least_tilt, how.most_tilt, count)
    leaning = exponential(np.column_stack((np.cos(about), np.sin(about), np.zeros(count))) * tilt[:, None])
    rolled = exponential(np.column_stack((np.zeros((count, 2)), rng.uniform(-roll, roll, count))))
    rotations = leaning @ rolled
    return Poses(rotations, middle - rotations @ board.centre)


def _box(model: CameraModel, poses: Poses, board: Board) -> tuple[int, int, int, int]:
    """Left, top, right, bottom [pixel] of what the panel can cover."""
    x, y = _paper(board)
    outline = board.centre + np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])
    sides = [np.linspace(outline[i], outline[(i + 1) % 4], 12) for i in range(4)]
    pixels = project(vector_of(model), poses.take(slice(0, 1)), np.concatenate(sides))[0]
    low = np.clip(np.floor(pixels.min(axis=0)) - 2, 0, (model.width, model.height)).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=0)) + 3, 0, (model.width, model.height)).astype(int)
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def _paper(board: Board) -> tuple[float, float]:
    """[m] from the board's centre to the rim of the white around the print."""
    blank = 0.0 if board.panel else board.square / 2
    return board.half_size[0] + blank, board.half_size[1] + blank


def _shades(places: Array, depth: Array, board: Board) -> Array:
    """Places (h·S, w·S, 2) [m] on the board's plane → mean grey (h, w) of each pixel's rays."""
    x, y = places[..., 0], places[..., 1]
    square = board.square
    dark = (np.floor(x / square) + np.floor(y / square)) % 2 == 0
    printed = (x > -square) & (x < board.width + square) & (y > -square) & (y < board.height + square)
    half_width, half_height = _paper(board)
    panel = (np.abs(x - board.width / 2) < half_width) & (np.abs(y - board.height / 2) < half_height)
    grey = np.where(printed & dark, DARK_GREY, LIGHT_GREY)
    grey = np.where(panel & (depth > 0), grey, WALL_GREY)
    rows, columns = grey.shape
    return grey.reshape(rows // RAYS_PER_PIXEL, RAYS_PER_PIXEL, columns // RAYS_PER_PIXEL, RAYS_PER_PIXEL).mean(
        axis=(1, 3)
    )


@lru_cache(maxsize=2)
def _rays(model: CameraModel) -> Array:
    """Ideal normalised coordinates (H·S, W·S, 2) of the rays of every pixel."""
    ideal = model.undistort(all_pixels(model)).reshape(model.height, model.width, 2)
    return cv2.resize(ideal, None, fx=RAYS_PER_PIXEL, fy=RAYS_PER_PIXEL, interpolation=cv2.INTER_LINEAR)
