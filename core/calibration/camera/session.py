"""The camera's wizard without a screen: look at pictures, say what becomes of each, know what to show next."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple, TypedDict

import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.chessboard import BoardView, board_by_hand, find_board
from core.calibration.board.quality import judge, why_none
from core.calibration.board.session import BoardSession, BoardVerdict, Explainer, Watcher
from core.calibration.camera.guidance import Advice, advise
from core.calibration.camera.intrinsics import Calibration, ViewCorners, calibrate
from core.calibration.camera.uncertainty import UncertaintyMap, uncertainty_map
from core.calibration.reports import target
from core.errors import BadInput, Refused
from core.message import Array

GRID_CELLS = (8, 6)  # across, down: the picture's cells in which corners are counted
WANTED_RANGES = (0.7, 0.7, 0.4, 0.5)  # that each measure should span
STILL_MOTION_PX = 0.5  # mean motion of the corners between live pictures, per 640 pixels of width
STILL_TIME_S = 0.25  # before a live picture is taken by itself
NEW_VIEW_SHARE = 0.05  # of the width, by which the corners have moved, on average, from every view taken
NEW_FILE_SHARE = 0.001  # the same for a picture from a file, which cannot be shown again
MIN_VIEW_COUNT = 6  # before the camera can count as calibrated
MIN_SOLVED_VIEWS = 4  # before a solution is tried
MAX_VIEW_COUNT = 400


class Measures(NamedTuple):
    """Position, size and skew of a board in the picture, each 0..1, as operators know them from ROS's calibrator."""

    x: float  # place across the picture
    y: float  # place down the picture
    size: float  # root of the share of the picture that it fills
    skew: float  # how far its corner is from a right angle


def measures(corners: Array, board: Board, size: tuple[int, int]) -> Measures:
    """Corners (N, 2) [pixel] in a picture of this width and height → its four measures."""
    grid = corners.reshape(board.rows, board.columns, 2)
    up_left, up_right, down_right, down_left = grid[0, 0], grid[0, -1], grid[-1, -1], grid[-1, 0]
    falling, rising = down_right - up_left, down_left - up_right  # the diagonals
    area = abs(float(falling[0] * rising[1] - falling[1] * rising[0])) / 2
    side = np.sqrt(area)  # of a square as large
    place = (corners.mean(axis=0) - side / 2) / np.maximum(np.array(size) - side, 1.0)
    along, down = up_left - up_right, down_right - up_right
    cosine = float(along @ down / (np.linalg.norm(along) * np.linalg.norm(down)))
    skew = min(1.0, 2 * abs(np.pi / 2 - float(np.arccos(np.clip(cosine, -1, 1)))))
    x, y = np.clip(place, 0, 1)
    return Measures(float(x), float(y), float(side / np.sqrt(size[0] * size[1])), skew)


def bars(seen: list[Measures]) -> Measures:
    """The measures of all views → how far each has been spanned, 0..1; size and skew count from zero."""
    if not seen:
        return Measures(0.0, 0.0, 0.0, 0.0)
    values = np.array(seen)
    low = values.min(axis=0) * (1, 1, 0, 0)
    return Measures(*(float(value) for value in np.minimum(1.0, (values.max(axis=0) - low) / WANTED_RANGES)))


def cells(corners: list[Array], size: tuple[int, int]) -> Array:
    """Corners (N, 2) [pixel] of every view → how many fell into each cell of the picture (6, 8)."""
    pixels = np.concatenate(corners) if corners else np.empty((0, 2))
    edges = (np.linspace(0, size[1], GRID_CELLS[1] + 1), np.linspace(0, size[0], GRID_CELLS[0] + 1))
    return np.histogram2d(pixels[:, 1], pixels[:, 0], bins=edges)[0].astype(int)


class SessionProgress(NamedTuple):
    """The progress of the wizard."""

    views: int
    p95_px: float | None  # projection uncertainty, 95 % of the picture; None before the first solution
    target_px: float
    ready: bool
    bars: Measures
    cells: Array  # (6, 8) corners seen in each cell of the picture
    words: str


@dataclass
class AcceptedView:
    """A view in the session."""

    name: str
    corners: Array  # (N, 2) [pixel]
    dropped: bool = False  # by the person


class StoredView(TypedDict):
    """A view as it is stored."""

    name: str
    corners: list[list[float]]  # [pixel]
    dropped: bool


class CameraState(TypedDict):
    """All that a session needs to go on after a restart, as JSON."""

    board: tuple[int, int, float]  # columns, rows, square [m]
    size: tuple[int, int] | None  # [pixel]
    taken: list[StoredView]


class CameraSession(BoardSession[AcceptedView, Calibration]):
    """One calibration from the first picture to the accepted camera. Owned by one thread."""

    part, min_solved = "view", MIN_SOLVED_VIEWS

    def __init__(self, board: Board, still_for: float = STILL_TIME_S) -> None:
        super().__init__(board)
        self._still_for = still_for  # [s] before a live picture is taken by itself
        self.size: tuple[int, int] | None = None  # [pixel] of the views; before the first, of the newest picture
        self._advice: Advice | None = None
        self._watcher = Watcher(board)
        self._still_since: float | None = None
        self._explainer = Explainer(board)

    def look(self, grey: Array, stamp: float) -> BoardVerdict:
        """A live picture (H, W) uint8 of time `stamp` [s] → its verdict; it is taken when sharp, still and new."""
        self._check_size(grey)
        view = self._watcher.look(grey)
        if view is None:
            self._still_since = None
            return BoardVerdict(kind="nothing", words=self._explainer.why(grey, stamp))
        verdict = self._judged(grey, view)
        if verdict is not None:
            self._still_since = None
            return verdict
        if self._watcher.moved > STILL_MOTION_PX:
            self._still_since = None
            return BoardVerdict(kind="moving", words="Good view; hold it still.", corners=view.corners)
        self._still_since = stamp if self._still_since is None else self._still_since
        if stamp - self._still_since < self._still_for:
            return BoardVerdict(kind="moving", words="Hold still …", corners=view.corners)
        return self._take(f"view {len(self.taken) + 1}", view)

    def capture(self, grey: Array, name: str, extreme: Array | None = None) -> BoardVerdict:
        """A picture that was uploaded or taken on purpose → its verdict; it is taken unless unfit or known.

        `extreme`: its extreme corners (4, 2) [pixel], marked by hand. Raises BadInput.
        """
        self._check_size(grey)
        view = find_board(grey, self.board) if extreme is None else board_by_hand(grey, self.board, extreme)
        if view is None:
            return BoardVerdict(kind="nothing", words=str(why_none(grey, self.board)))
        return self._judged(grey, view, given=True) or self._take(name, view)

    @property
    def views(self) -> tuple[ViewCorners, ...]:
        """The views that take part; with `size` and `board` all that a solver in another process needs."""
        return tuple(ViewCorners(name=each.name, corners=each.corners) for each in self.taken if not each.dropped)

    def solve(self) -> Calibration:
        """Solve here and now. Raises BadInput with too few views."""
        views = self.views
        if self.size is None or len(views) < MIN_SOLVED_VIEWS:
            raise BadInput(f"{len(views)} views are too few; take at least {MIN_SOLVED_VIEWS}.")
        return self.adopt(calibrate(views, self.board, self.size), self.names)

    def adopt(self, calibration: Calibration, names: Collection[str]) -> Calibration:
        """Take over a solution; it changes what is advised."""
        self._advice = None
        return super().adopt(calibration, names)

    def uncertainty(self) -> UncertaintyMap | None:
        """The live map; None before the first solution."""
        return None if self.calibration is None else uncertainty_map(self.calibration)

    def advice(self) -> Advice | None:
        """The most useful next view; None before the first picture gives the size."""
        if self._advice is None and self.size is not None:
            taken = np.array([view.corners for view in self.views]).reshape(-1, self.board.count, 2)
            self._advice = advise(self.board, self.size, self.calibration, taken, asked=self._asked)
        return self._advice

    def skip(self) -> Advice | None:
        """Another suggestion, for one who cannot reach the present one."""
        self._advice = None
        return super().skip()

    def progress(self) -> SessionProgress:
        """The progress so far, and what is missing."""
        size = self.size or (1, 1)
        views = [view.corners for view in self.views]
        known = self.uncertainty()
        p95, wanted = (None if known is None else known.p95), target(size[0])
        missing = MIN_VIEW_COUNT - len(views)
        if missing > 0:
            words = f"{missing} more view{'s' * (missing > 1)} at least."
            if len(views) < MIN_SOLVED_VIEWS:
                words = f"{words[:-1]}; view {MIN_SOLVED_VIEWS} brings a first estimate."
        elif p95 is None:
            words = "Not solved yet."
        elif self.stale:
            words = "Not solved with the newest views yet."
        elif self.calibration is not None and self.calibration.undecided:
            words = self.calibration.undecided
        elif p95 > wanted:
            words = (
                f"95 % of the picture is known to ±{p95:.2f} px; {wanted:.2f} px are wanted. Show the suggested view."
            )
        else:
            words = f"Done: 95 % of the picture is known to ±{p95:.2f} px."
            if self.calibration is not None and self.calibration.deciding:
                words += f" But {self.calibration.deciding}"
        decided = self.calibration is not None and not self.calibration.undecided
        ready = missing <= 0 and p95 is not None and p95 <= wanted and not self.stale and decided
        spanned = bars([measures(corners, self.board, size) for corners in views])
        return SessionProgress(len(views), p95, wanted, ready, spanned, cells(views, size), words)

    def state(self) -> CameraState:
        """All that is needed to go on after a restart, as JSON."""
        return {
            "board": (self.board.columns, self.board.rows, self.board.square),
            "size": self.size,
            "taken": [
                {"name": each.name, "corners": each.corners.tolist(), "dropped": each.dropped} for each in self.taken
            ],
        }

    @staticmethod
    def resumed(state: CameraState) -> CameraSession:
        """Restore a session from `state`; it must be solved again."""
        columns, rows, square = state["board"]
        session = CameraSession(Board(columns=columns, rows=rows, square=square))
        session.size = state["size"]
        session.taken = [
            AcceptedView(each["name"], np.array(each["corners"]), each["dropped"]) for each in state["taken"]
        ]
        return session

    def _check_size(self, grey: Array) -> None:
        """The first view that is taken fixes the size; before that it is the newest picture's. Raises BadInput."""
        size = (grey.shape[1], grey.shape[0])
        if self.size is not None and size != self.size:
            if self.taken:
                raise BadInput(
                    f"This picture is {size[0]}x{size[1]}, the views so far are {self.size[0]}x{self.size[1]}; "
                    "a calibration holds for one camera setting only: begin a new session for this one."
                )
            self._advice, self._still_since, self._watcher = None, None, Watcher(self.board)
        self.size = size

    def _judged(self, grey: Array, view: BoardView, *, given: bool = False) -> BoardVerdict | None:
        """The reason against taking a view, or None; one that is `given` counts unless it is the same picture."""
        quality = judge(grey, view, self.board)
        if quality.refusals:
            return BoardVerdict(kind="refused", words=quality.refusals[0], corners=view.corners)
        same = self._same(view.corners, NEW_FILE_SHARE if given else NEW_VIEW_SHARE)
        if same:
            words = "every picture counts once" if given else "move on to the suggested view"
            return BoardVerdict(kind="same", words=f"Same as {same}; {words}.", corners=view.corners)
        return None

    def _same(self, corners: Array, min_share: float) -> str:
        """The name of a view from which the corners moved by less than this share of the picture's width, or ''."""
        width = self.size[0] if self.size else 1
        for each in self.taken:
            if not each.dropped and np.linalg.norm(each.corners - corners, axis=1).mean() < min_share * width:
                return each.name
        return ""

    def _take(self, name: str, view: BoardView) -> BoardVerdict:
        if len(self.taken) >= MAX_VIEW_COUNT:
            raise Refused(f"{len(self.taken)} views are more than enough; drop some or start again.")
        known = {each.name for each in self.taken}
        unique = next(each for each in (name, *(f"{name} ({n})" for n in range(2, 9999))) if each not in known)
        self.taken.append(AcceptedView(unique, view.corners))
        self._advice, self._still_since = None, None
        return BoardVerdict(kind="counted", words=f"Counted as {unique}.", name=unique, corners=view.corners)
