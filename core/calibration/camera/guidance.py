"""Which view of the board would teach most next, and how to say so."""

import numpy as np

from core.calibration import homography
from core.calibration.board.board import Board
from core.calibration.camera.intrinsics import Calibration
from core.calibration.camera.uncertainty import Sensitivity, sensitivity, view_information
from core.calibration.practice import BoardPlacement, held
from core.calibration.projection import PAPER, Poses, project, vector_of
from core.message import Array, message
from core.optics import CameraModel

MIN_NOISE_PX = 0.02  # no corner is believed better than this


# Poses from which the next one is chosen.
CANDIDATE_POSES = 300
FIRST_SEED = 7
WIDTH_SHARES = (0.25, 1.1)  # share of the picture's width that a level board takes: far and near
MAX_TILT_RAD = np.deg2rad(50)
MAX_ROLL_RAD = np.deg2rad(25)
USUAL_NOISE_PX = 0.2  # [pixel] of a corner's coordinate, until it has been measured
CLEAR_TILT_RAD = np.deg2rad(12)  # tilts below this are called straight
ADVISED_SPACING_PX = 9.0  # [pixel] between neighbouring corners at least: nearer together they are hard to find
RIM_MARGIN_SHARE = 0.03  # share of the picture's width that corners keep from the rim, so that a hand can miss


@message
class Advice:
    """The next view to take."""

    words: str
    outline: Array  # (K, 2) [pixel]: the panel's rim as it would appear
    corners: Array  # (N, 2) [pixel]
    rotation: Array  # (3, 3), camera_from_board
    translation: Array  # (3,) [m]


def advise(
    board: Board,
    size: tuple[int, int],
    calibration: Calibration | None = None,
    taken: Array | None = None,
    *,
    asked: int = 0,
) -> Advice:
    """Choose the most useful next view from what is known so far.

    Among random poses, the one that makes the mean variance of the projection over the picture smallest. Without a
    calibration a usual camera is assumed, and the views `taken` so far, corners (M, N, 2), count as seen by it.
    `asked` counts the times that the operator asked for another view.
    """
    model = usual_camera(size) if calibration is None else calibration.model
    camera = vector_of(model)
    poses = candidates(model, board, FIRST_SEED + asked)
    known, noise, around = prior(model), USUAL_NOISE_PX, None
    if calibration is not None:
        seen, noise = calibration.poses.take(calibration.used), max(calibration.noise, MIN_NOISE_PX)
        around = calibration.corners.pixels[calibration.corners.used]
        known = known + view_information(camera, seen, board.points, noise).sum(axis=0)
    elif taken is not None and len(taken):
        seen, around = homography.board_poses(board.points, taken, camera), taken.reshape(-1, 2)
        known = known + view_information(camera, seen, board.points, noise).sum(axis=0)
    gains = view_information(camera, poses, board.points, noise)
    grid = sensitivity(model, PAPER, around)
    return advice_of(model, poses, choose(grid, known, gains), board)


def advice_of(model: CameraModel, poses: Poses, number: int, board: Board) -> Advice:
    """The pose of that number as the next view."""
    pose, camera = poses.take(slice(number, number + 1)), vector_of(model)
    return Advice(
        words=describe(model, pose, board),
        outline=project(camera, pose, outline_of(board))[0],
        corners=project(camera, pose, board.points)[0],
        rotation=pose.rotations[0],
        translation=pose.translations[0],
    )


def choose(grid: Sensitivity, known: Array, gains: Array) -> int:
    """Information so far (P, P) and of each candidate (K, P, P) → the best candidate."""
    rows = grid.by_camera[np.isfinite(grid.by_camera).all(axis=(1, 2))].reshape(-1, known.shape[0])
    weight = rows.T @ rows
    scale = 1 / np.sqrt(np.diag(known))
    covariances = np.linalg.inv((known + gains) * np.outer(scale, scale)) * np.outer(scale, scale)
    return int(np.argmin(np.einsum("ij,kji->k", weight, covariances)))


def candidates(model: CameraModel, board: Board, seed: int = FIRST_SEED) -> Poses:
    """Random poses with the whole board in the picture; the same ones for a `seed`."""
    width = board.width * model.fx / model.width
    how = BoardPlacement(
        nearest=width / WIDTH_SHARES[1],
        farthest=width / WIDTH_SHARES[0],
        most_tilt=MAX_TILT_RAD,
        roll=MAX_ROLL_RAD,
        margin=RIM_MARGIN_SHARE * model.width,
    )
    poses = held(np.random.default_rng(seed), CANDIDATE_POSES, model, board, how)
    good = clear(model, poses, board)
    return poses.take(good) if np.count_nonzero(good) else poses


def clear(model: CameraModel, poses: Poses, board: Board) -> Array:
    """(M,) bool: poses in which neighbouring corners are far enough apart to be found."""
    grid = project(vector_of(model), poses, board.points).reshape(-1, board.rows, board.columns, 2)
    gaps = [np.linalg.norm(np.diff(grid, axis=axis), axis=3).min(axis=(1, 2)) for axis in (1, 2)]
    return np.minimum(*gaps) >= ADVISED_SPACING_PX


def prior(model: CameraModel) -> Array:
    """(8, 8) information: what may be taken for granted about any camera, so that planning can begin with nothing."""
    sds = np.array([0.3 * model.fx, 0.3 * model.fy, 0.1 * model.width, 0.1 * model.width, 0.5, 0.5, 0.01, 0.01])
    return np.diag(1 / sds**2)


def usual_camera(size: tuple[int, int]) -> CameraModel:
    """A camera of 58 degrees across, for a start."""
    return CameraModel(
        width=size[0], height=size[1], fx=0.9 * size[0], fy=0.9 * size[0], cx=(size[0] - 1) / 2, cy=(size[1] - 1) / 2
    )


def describe(model: CameraModel, pose: Poses, board: Board) -> str:
    """A pose of the board → words for the person who holds it: where, how near, which edge to tilt away."""
    corners = project(vector_of(model), pose, board.points)[0]
    place = corners.mean(axis=0) / (model.width, model.height)
    across = ("left", "", "right")[int(np.digitize(place[0], (0.42, 0.58)))]
    down = ("top", "", "bottom")[int(np.digitize(place[1], (0.42, 0.58)))]
    where = " ".join(word for word in (down, across) if word)
    share = float(np.ptp(corners[:, 0])) / model.width
    size = "close up" if share > 0.65 else "at middle distance" if share > 0.4 else "farther away"
    spot = f"fill the {where} of the picture" if where else "stay in the middle of the picture"
    return f"Hold the board {size}, {spot}, {tilt_words(pose.rotations[0], CLEAR_TILT_RAD)}."


def tilt_words(rotation: Array, clear: float) -> str:
    """The board's rotation (3, 3) → 'tilt the left edge away by 40 degrees' or 'facing the camera'."""
    normal = rotation[:, 2] * np.sign(rotation[2, 2])
    right, bottom = -normal[0] / normal[2], -normal[1] / normal[2]  # how fast the depth grows that way
    edges: list[str] = []
    if abs(bottom) > np.tan(clear):
        edges.append("bottom" if bottom > 0 else "top")
    if abs(right) > np.tan(clear):
        edges.append("right" if right > 0 else "left")
    if not edges:
        return "facing the camera"
    angle = round(float(np.degrees(np.arccos(min(1.0, abs(normal[2]))))) / 5) * 5
    kind = "corner" if len(edges) == 2 else "edge"
    return f"tilt the {' '.join(edges)} {kind} away by about {angle} degrees"


def outline_of(board: Board) -> Array:
    """The panel's rim (48, 3) [m] in pieces short enough to bend with the distortion."""
    outline = board.outline
    sides = [np.linspace(outline[side], outline[(side + 1) % 4], 12, endpoint=False) for side in range(4)]
    return np.concatenate(sides)
