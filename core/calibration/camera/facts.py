"""Facts of our own camera file besides the camera itself: how exact it is, and with which board it was found."""

from typing import Any, TypedDict, TypeGuard

import numpy as np

from core.calibration.files.camera_files import read_json
from core.calibration.projection import PARAMETERS


class DroppedView(TypedDict):
    """A view that did not fit, and why."""

    name: str
    why: str


class BoardPoseEntry(TypedDict):
    """The board in one view, camera_from_board."""

    rvec_rad: list[float]  # rotation vector
    tvec_m: list[float]
    sd_rotation_rad: list[float]  # about the camera's axes
    sd_translation_m: list[float]


class NamedBoardPoseEntry(BoardPoseEntry):
    """The same with the view's name."""

    name: str


class CameraFacts(TypedDict, total=False):
    """How exactly a camera is known."""

    free: list[str]  # the numbers that were estimated
    sd: list[float]  # of these
    covariance: list[list[float]]
    rms_px: float
    p95_uncertainty_px: float
    views_used: int
    views_dropped: list[DroppedView]
    board_poses: list[NamedBoardPoseEntry]  # of the views that were used


class BoardEntry(TypedDict):
    """The board in our own file."""

    inner_corners: list[int]  # columns, rows
    square_m: float
    panel_m: list[float] | None


def known_facts(text: str) -> tuple[CameraFacts, BoardEntry | None]:
    """The text of a camera file → what is to be kept of its camera entry, and its board.

    Only what is whole and plausible is kept; other forms hold nothing of it. Raises BadInput for bad JSON.
    """
    if not text.lstrip().startswith("{"):
        return {}, None
    document = read_json(text)
    entry, board = document.get("camera"), document.get("board")
    return _facts(entry) if isinstance(entry, dict) else {}, _board(board)


def _facts(entry: dict[str, Any]) -> CameraFacts:
    known: CameraFacts = {}
    if _positive(entry.get("rms_px")):
        known["rms_px"] = entry["rms_px"]
    if _positive(entry.get("p95_uncertainty_px")):
        known["p95_uncertainty_px"] = entry["p95_uncertainty_px"]
    if _positive(entry.get("views_used")) and isinstance(entry["views_used"], int):
        known["views_used"] = entry["views_used"]
    free, sd, covariance = entry.get("free"), entry.get("sd"), entry.get("covariance")
    if not isinstance(free, list) or not set(map(str, free)) <= set(PARAMETERS):
        return known
    sds = _array(sd, (len(free),))
    if sds is None or np.any(sds < 0):
        return known
    known["free"], known["sd"] = free, sds.tolist()
    spread = _array(covariance, (len(free), len(free)))
    if spread is not None and np.allclose(spread, spread.T) and np.allclose(np.diag(spread), sds**2, rtol=1e-6):
        known["covariance"] = spread.tolist()
    return known


def _board(board: Any) -> BoardEntry | None:
    """The board as our own file describes it, or None."""
    if not isinstance(board, dict):
        return None
    counts, panel, square = _array(board.get("inner_corners"), (2,)), board.get("panel_m"), board.get("square_m")
    if counts is None or not np.all((counts >= 2) & (counts == np.round(counts))) or not _positive(square):
        return None
    found: BoardEntry = {"inner_corners": counts.astype(int).tolist(), "square_m": square, "panel_m": None}
    if panel is not None:
        sides = _array(panel, (2,))
        if sides is None or not np.all(sides > 0):
            return None
        found["panel_m"] = sides.tolist()
    return found


def _array(rows: Any, shape: tuple[int, ...]) -> Any:
    """A list of finite numbers in this shape as an array, or None."""
    try:
        values = np.array(rows, dtype=float)
    except (ValueError, TypeError):
        return None
    return values if values.shape == shape and np.all(np.isfinite(values)) else None


def _positive(value: Any) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool) and bool(0 < value < np.inf)
