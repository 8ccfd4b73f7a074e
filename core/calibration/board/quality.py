"""Judge whether a found board can be used: cut, far, blurred, wrong or misplaced corners; or why none was found."""

from collections.abc import Sequence

import cv2
import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.chessboard import QUICK, BoardView, sample, search, smallest_spacing
from core.calibration.homography import homographies
from core.calibration.levenberg_marquardt import minimise
from core.message import Array, message
from core.sensors.checks import Fault, UnusableReading, fault

MISCOUNTS = ((-1, -1), (-1, 0), (0, -1), (1, 0), (0, 1), (1, 1))
"""How people miscount, the likeliest first: squares instead of inner corners."""
ANY_SIZE = cv2.CALIB_CB_LARGER | cv2.CALIB_CB_NORMALIZE_IMAGE
LONE_MOST = 0.5  # of all dark patches so large that are such squares: noise has patches of any form
LONE_GAP, LONE_GAP_PX = 0.15, 4.0  # share of their side, and [pixel]: corners of squares so near each other touch
LONE_CONTRAST = 60.0  # grey levels between such squares and the paper
LOOKED_AT_PX = 640  # longest side of the copy in which the reason is sought
MIN_SEARCHED_PX = 60  # of a picture's side
LEAST_COUNT = 12  # corners of a board that is believed
PASSED_OVER_SHARE = 0.15  # of the spacing that a corner lies off its grid where others were passed over
LEAST_OTHER_SHARE = 0.2  # of the picture's longest side that a board of another size spans at least: the one shown
MIN_LONE_SQUARES = 12  # that stand apart
LONE_PICTURE_SHARE = 3e-4  # of the picture that such a square fills at least
LONE_FULL_SHARE = 0.9  # of its outline's area that it fills at least
LONE_ROUND_SHARE = 0.75  # its area over that of a square of its perimeter, at least


# Limits beyond which a view is refused.
RIM_DISTANCE_PX = 2  # [pixel] beyond the refinement window that every corner keeps from the rim
MIN_SPACING_PX = 6.0  # [pixel] corners closer together than this are refused: too far
SOFT_EDGE_PX = 5.0  # [pixel] width of an edge above which a warning is given
BLURRED_EDGE_PX = 7.0  # [pixel] width of an edge above which the view is refused
NO_EDGE_PX = 1000.0  # [pixel]: OpenCV's answer where it finds none
ORDINARY_SIDE_PX = 1280  # [pixel] longest side up to which these widths hold; finer pictures have wider edges
SOFT_LOSS_PX = 0.3  # [pixel] scale of the soft-L1 loss of the smoothness test
MISPLACED_CORNER_PX = 1.2  # [pixel] from its smooth grid beyond which a corner is misplaced
MISPLACED_SPACING_SHARE = 0.03  # the same as a share of the corner spacing; the larger one counts
MAX_MISPLACED_SHARE = 0.1  # share of misplaced corners above which the view is refused
SADDLE_CONTRAST_SHARE = 0.4  # share of the board's contrast that makes a crossing of four squares


@message
class ViewQuality:
    """The judgement of a view."""

    sharpness: float  # [pixel] mean width of an edge
    refusals: tuple[str, ...]  # sentences; empty: the view is fit
    warnings: tuple[str, ...]


def judge(grey: Array, view: BoardView, board: Board) -> ViewQuality:
    """A board found in a grey picture (H, W) → its quality in words."""
    refusals: list[str] = []
    warnings: list[str] = []
    side = _cut_side(grey, view)
    if side:
        refusals.append(f"A corner is too close to the {side} rim of the picture; move the board away from it.")
    if view.spacing < MIN_SPACING_PX:
        refusals.append(f"The board is too far: its corners are only {view.spacing:.0f} px apart. Come closer.")
    sharpness = edge_width(grey, view.corners, board)
    finer = max(1.0, max(grey.shape) / ORDINARY_SIDE_PX)
    if sharpness > NO_EDGE_PX:
        refusals.append("The edges cannot be measured: hold still, come closer, or add light.")
    elif sharpness > BLURRED_EDGE_PX * finer:
        refusals.append(_blurred(sharpness))
    elif sharpness > SOFT_EDGE_PX * finer:
        warnings.append(f"Slightly blurred: edges are {sharpness:.1f} px wide.")
    off = off_grid(view.corners, board, grey.shape)
    misplaced = np.flatnonzero(off > max(MISPLACED_CORNER_PX, MISPLACED_SPACING_SHARE * view.spacing))
    if len(misplaced) > MAX_MISPLACED_SHARE * board.count:
        refusals.append(
            f"{len(misplaced)} corners do not lie on a smooth grid; is this the {board.name} board, and flat?"
        )
    elif len(misplaced):
        row, column = divmod(int(misplaced[np.argmax(off[misplaced])]), board.columns)
        warnings.append(f"The corner in row {row + 1}, column {column + 1} is {off.max():.1f} px off the grid.")
    beyond = continues(grey, view.corners, board)
    if beyond:
        refusals.append(
            f"The pattern goes on beyond the {beyond} of the {board.name} corners: the board has more inner corners "
            "than entered. Count the points where four squares meet."
        )
    return ViewQuality(sharpness=sharpness, refusals=tuple(refusals), warnings=tuple(warnings))


class BoardNotSeen(UnusableReading):
    """No board of this kind in a picture; the sentence says what is there instead."""

    def __init__(self, why: str | Fault, seen: str = "") -> None:
        super().__init__(*((why, ()) if isinstance(why, str) else (why.sentence, (why,))))
        self.seen = seen  # another board that is there, as in "10x10"


def why_none(grey: Array, board: Board) -> BoardNotSeen:
    """A grey picture in which the board was not found → the likely reason, and what to do."""
    scale = min(2.0, LOOKED_AT_PX / max(grey.shape))
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    small = cv2.resize(grey, None, fx=scale, fy=scale, interpolation=how)
    other = _another_board(small, board)
    if other is not None:
        what = miscount_words(other, board)
        return BoardNotSeen(fault("board.other_count", seen=other.name, entered=board.name, what=what), other.name)
    negative = search(255 - small, board, QUICK)
    if negative is not None:
        width = edge_width(small, negative, board)
        if BLURRED_EDGE_PX < width <= NO_EDGE_PX:
            return BoardNotSeen(_blurred(width / scale))
        return BoardNotSeen(fault("board.inverted"))
    if _lone_squares(small) >= MIN_LONE_SQUARES:
        return BoardNotSeen(fault("board.separate_squares"))
    return BoardNotSeen(unseen(grey, board))


def miscount_words(seen: Board, board: Board) -> str:
    """The size that was counted instead of the inner corners of the board that is seen."""
    return "squares instead of inner corners" if _are_squares(seen, board) else "the wrong number of corners"


def _are_squares(seen: Board, board: Board) -> bool:
    return (seen.columns, seen.rows) == (board.columns - 1, board.rows - 1)


def _another_board(grey: Array, board: Board) -> Board | None:
    """The board of another size that is in a small picture, whole; named as the entered one lies."""
    if min(grey.shape) < MIN_SEARCHED_PX:
        return None
    found, corners, meta = cv2.findChessboardCornersSBWithMeta(grey, (3, 3), ANY_SIZE)
    if not found:
        return None
    rows, columns = meta.shape[:2]
    if not (min(rows, columns) >= 3 and max(rows, columns) <= 40 and rows * columns >= LEAST_COUNT):
        return None
    seen = Board(columns=columns, rows=rows, square=board.square)
    if {columns, rows} == {board.columns, board.rows} or search(grey, seen, QUICK) is None:
        return None  # the other detector sees boards in noise as well
    grid = corners.reshape(-1, 2).astype(float)
    if np.ptp(grid, axis=0).max() < LEAST_OTHER_SHARE * max(grey.shape):
        return None
    if np.any(off_grid(grid, seen, grey.shape) > PASSED_OVER_SHARE * smallest_spacing(grid, seen)):
        return None  # corners of a larger board, some passed over
    wide = (columns >= rows) == (board.columns >= board.rows)
    named = seen if wide else Board(columns=rows, rows=columns, square=board.square)
    beyond = _beyond(grey, grid, seen)
    if any(more for _, more in beyond.values()):
        return None  # it goes on
    across, down = (("left", "right"), ("top", "bottom"))[:: 1 if wide else -1]
    lacking = (*(across if named.columns < board.columns else ()), *(down if named.rows < board.rows else ()))
    if any(beyond[side][0] for side in lacking) and not _are_squares(named, board):
        return None  # it may go on out of the picture
    return named


def _lone_squares(grey: Array) -> int:
    """Count the dark quadrilaterals of about one size that stand apart: those of a chessboard touch at corners."""
    _, dark = cv2.threshold(grey, 0, 255, cv2.THRESH_BINARY_INV | cv2.THRESH_OTSU)
    inked = dark > 0
    if not 0 < inked.mean() < 1 or grey[~inked].mean() - grey[inked].mean() < LONE_CONTRAST:
        return 0
    areas: list[float] = []
    outlines: list[Array] = []
    large = 0
    for contour in cv2.findContours(dark, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)[0]:
        area = float(cv2.contourArea(contour))
        if area < LONE_PICTURE_SHARE * grey.size:
            continue
        large += 1
        edges = cv2.arcLength(contour, closed=True)
        outline = cv2.approxPolyDP(contour, 0.06 * edges, closed=True)
        full = max(LONE_FULL_SHARE * float(cv2.contourArea(outline)), LONE_ROUND_SHARE * (edges / 4) ** 2)
        if area > full and len(outline) == 4 and cv2.isContourConvex(outline):
            areas.append(area)
            outlines.append(outline[:, 0].astype(float))
    middle = float(np.median(areas)) if areas else 0.0
    alike = [outline for area, outline in zip(areas, outlines, strict=True) if middle / 2 < area < 2 * middle]
    return (
        len(alike)
        if len(alike) > LONE_MOST * large and not _touch(alike, max(LONE_GAP * middle**0.5, LONE_GAP_PX))
        else 0
    )


def _touch(outlines: Sequence[Array], gap: float) -> bool:
    """Return whether most quadrilaterals (4, 2) have a corner that lies within `gap` [pixel] of another's."""
    corners = np.concatenate(outlines)
    owner = np.repeat(np.arange(len(outlines)), 4)
    apart = np.linalg.norm(corners[:, None] - corners, axis=2)
    near = (apart < gap) & (owner[:, None] != owner)
    return 2 * len(set(owner[near.any(axis=1)].tolist())) > len(outlines)


def miscounted(grey: Array, board: Board, which: int, longest: int) -> str:
    """'' or a sentence, if a board shows up when corners are counted differently, by number `which` of MISCOUNTS.

    Looks at a copy whose longest side is `longest` [pixel].
    """
    columns, rows = MISCOUNTS[which % len(MISCOUNTS)]
    size = (board.columns + columns, board.rows + rows)
    if min(size) < 3 or max(size) > 40:
        return ""
    scale = min(2.0, longest / max(grey.shape))
    small = cv2.resize(
        grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    )
    other = Board(columns=size[0], rows=size[1], square=board.square)
    corners = search(small, other, QUICK)
    if corners is None or continues(small, corners, other):
        return ""
    what = "squares instead of inner corners" if (columns, rows) == (-1, -1) else "the wrong number of corners"
    return (
        f"I see a board with {other.name} inner corners, not {board.name}: you may have counted {what}. "
        "Count the points where four squares meet."
    )


def unseen(grey: Array, board: Board) -> str:
    """A grey picture without a board → words about its light."""
    dark, light = np.quantile(grey[::4, ::4], (0.05, 0.95))
    if light < 60:
        return "The picture is too dark to see a board; add light."
    if light - dark < 30:
        return "The picture has almost no contrast; is something covering the lens?"
    return (
        f"I see no {board.name} board. Is the whole board in the picture, sharp and evenly lit, with nothing over it?"
    )


def _blurred(width: float) -> str:
    return f"Blurred: edges are {width:.1f} px wide. Hold still, or add light."


def edge_width(grey: Array, corners: Array, board: Board) -> float:
    """[pixel]: mean width of the edges between squares, of those along rows or columns, whichever are wider.

    2.5 to 3.5 is sharp. Motion along the rows leaves the rows' own edges sharp, so both have to be looked at.
    """
    places = np.ascontiguousarray(corners.reshape(-1, 1, 2), dtype=np.float32)
    size = (board.columns, board.rows)
    widths = [
        np.asarray(cv2.estimateChessboardSharpness(grey, size, places, vertical=vertical)[0]).ravel()[0]
        for vertical in (False, True)
    ]
    return float(max(widths))


def off_grid(corners: Array, board: Board, shape: tuple[int, ...]) -> Array:
    """Corners (N, 2) → distance (N,) [pixel] of each from the best smooth grid.

    The grid is a homography followed by a lens: two radial and two tangential terms about the picture's centre, as
    distortion alone would move good corners by several pixels off a plain homography. The tangential ones also stand
    for a lens that has its middle elsewhere (a picture that was cut).
    """
    height, width = shape[:2]
    centre, unit = np.array([(width - 1) / 2, (height - 1) / 2]), max(width, height) / 2
    seen = (corners - centre) / unit
    flat = (board.points - board.centre)[:, :2] / board.width
    mapping = homographies(np.column_stack((flat, np.zeros(len(flat)))), seen[None])[0]
    start = np.concatenate(((mapping / mapping[2, 2]).ravel()[:8], np.zeros(4)))

    def model(numbers: Array) -> tuple[Array, Array]:
        placed, jacobian = _grid(numbers, flat)
        return (placed - seen).ravel() * unit, jacobian.reshape(-1, 12) * unit

    fit = minimise(model, start, lambda state, step: state + step, soft=SOFT_LOSS_PX, iterations=25)
    return np.linalg.norm(fit.residuals.reshape(-1, 2), axis=1)


def continues(grey: Array, corners: Array, board: Board) -> str:
    """'' or the side on which the pattern goes on beyond the corners (N, 2), as the board was entered too small."""
    return next((side for side, (_, more) in _beyond(grey, corners, board).items() if more), "")


def _beyond(grey: Array, corners: Array, board: Board) -> dict[str, tuple[bool, bool]]:
    """For each side of the corners (N, 2): is the next line of corners out of the picture, and is it there."""
    mapping = homographies(board.points / board.square, corners[None])[0]
    across, down = np.arange(board.columns, dtype=float), np.arange(board.rows, dtype=float)
    contrast = np.median(_crossing(grey, mapping, _pairs(across, down)))
    sides = {
        "left": _pairs(np.array([-1.0]), down),
        "right": _pairs(np.array([float(board.columns)]), down),
        "top": _pairs(across, np.array([-1.0])),
        "bottom": _pairs(across, np.array([float(board.rows)])),
    }
    found = {}
    for side, places in sides.items():
        strength = _crossing(grey, mapping, places)
        out = bool(np.isfinite(strength).mean() <= 0.5)
        found[side] = (out, not out and bool(np.nanmean(strength > SADDLE_CONTRAST_SHARE * contrast) > 0.7))
    return found


def _grid(numbers: Array, flat: Array) -> tuple[Array, Array]:
    """Homography (8), radial and tangential terms (4), places (N, 2) → pixels (N, 2), Jacobian (N, 2, 12)."""
    ground = np.column_stack((flat, np.ones(len(flat))))
    above, below = ground @ numbers[:6].reshape(2, 3).T, ground @ np.append(numbers[6:8], 1.0)
    plane = above / below[:, None]
    (x, y), r2 = plane.T, np.sum(plane**2, axis=1)
    radial = 1 + r2 * (numbers[8] + r2 * numbers[9])
    by_tangential = np.stack((2 * x * y, r2 + 2 * x * x, r2 + 2 * y * y, 2 * x * y), axis=1).reshape(-1, 2, 2)
    one = numbers[10] * x + numbers[11] * y
    slope = numbers[8] + 2 * r2 * numbers[9]
    by_plane = radial[:, None, None] * np.eye(2) + 2 * slope[:, None, None] * plane[:, :, None] * plane[:, None, :]
    by_plane[:, 0, 1] += 2 * one
    by_plane[:, 1, 0] += 2 * one
    by_plane[:, 0, 0] += 6 * numbers[11] * x + 2 * numbers[10] * y
    by_plane[:, 1, 1] += 2 * numbers[11] * x + 6 * numbers[10] * y
    by_mapping = np.zeros((len(flat), 2, 8))
    by_mapping[:, 0, 0:3] = by_mapping[:, 1, 3:6] = ground / below[:, None]
    by_mapping[:, :, 6:8] = -plane[:, :, None] * (flat / below[:, None])[:, None, :]
    by_radial = plane[:, :, None] * np.column_stack((r2, r2 * r2))[:, None, :]
    placed = plane * radial[:, None] + by_tangential @ numbers[10:12]
    return placed, np.concatenate((by_plane @ by_mapping, by_radial, by_tangential), axis=2)


def _crossing(grey: Array, mapping: Array, places: Array) -> Array:
    """Places (K, 2) in squares → how clearly four squares of alternating colour meet there [grey level]."""
    reach = 0.32
    offsets = np.array([[reach, reach], [-reach, -reach], [reach, -reach], [-reach, reach]])
    levels = _levels(grey, mapping, places[:, None] + offsets)
    one, other = levels[:, :2], levels[:, 2:]
    return np.maximum(one.min(axis=1) - other.max(axis=1), other.min(axis=1) - one.max(axis=1))


def _levels(grey: Array, mapping: Array, places: Array) -> Array:
    seen = np.concatenate((places, np.ones((*places.shape[:-1], 1))), axis=-1) @ mapping.T
    return sample(grey, seen[..., :2] / seen[..., 2:])


def _pairs(across: Array, down: Array) -> Array:
    return np.stack(np.meshgrid(across, down), axis=-1).reshape(-1, 2)


def _cut_side(grey: Array, view: BoardView) -> str:
    """The side of the picture to which a corner is too close, or ''."""
    height, width = grey.shape
    low, high = view.corners.min(axis=0), view.corners.max(axis=0)
    gaps = {"left": low[0], "top": low[1], "right": width - 1 - high[0], "bottom": height - 1 - high[1]}
    side = min(gaps, key=lambda name: float(gaps[name]))
    return side if gaps[side] < view.window + RIM_DISTANCE_PX else ""
