"""Keep an eye on the board from picture to picture: where it was, whether it is still."""

import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.chessboard import BoardView, glimpse
from core.calibration.board.quality import miscounted, unseen
from core.message import Array

THOROUGH_EVERY = 3  # pictures without a board: one in so many is searched whole, which is slow
REFERENCE_WIDTH_PX = 640  # of the pictures for which motions are stated


class Watcher:
    """Follows one board through live pictures. Owned by one thread."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self.corners: Array | None = None  # (N, 2) [pixel] in the newest picture; None: not seen
        self.moved = float("inf")  # [pixel] mean motion since the picture before, as if pictures were 640 wide
        self._misses = 0

    def look(self, grey: Array) -> BoardView | None:
        """A picture (H, W) uint8 → the board in it, or None."""
        view = glimpse(grey, self.board, self.corners, thorough=self._misses % THOROUGH_EVERY == 0)
        self._misses = 0 if view is not None else self._misses + 1
        self.moved = float("inf") if view is None else self.apart(view.corners, self.corners, grey.shape[1])
        self.corners = None if view is None else view.corners
        return view

    @staticmethod
    def apart(corners: Array, others: Array | None, width: int) -> float:
        """Mean distance [pixel] of corners (N, 2) from where they were, scaled down to pictures 640 wide."""
        if others is None:
            return float("inf")
        return float(np.linalg.norm(corners - others, axis=1).mean()) / max(1.0, width / REFERENCE_WIDTH_PX)


EXPLAIN_PERIOD_S = 1.0  # between two looks for the reason
MAX_COPY_SIDE_PX = 320  # of the copy in which boards of other sizes are looked for


class Explainer:
    """Looks for the reason now and then, one way of miscounting at a time, for they are slow to try."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self._looked = float("-inf")
        self._tries = 0
        self._reason = ""

    def why(self, grey: Array, stamp: float) -> str:
        """A picture (H, W) uint8 of time `stamp` [s] without the board → one sentence, perhaps the former one."""
        if not 0 <= stamp - self._looked < EXPLAIN_PERIOD_S:
            self._looked = stamp
            wrong = miscounted(grey, self.board, self._tries, MAX_COPY_SIDE_PX)
            self._tries += not wrong
            self._reason = wrong or unseen(grey, self.board)
        return self._reason
