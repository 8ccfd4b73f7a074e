"""Why no board is seen in live pictures: too dark, out of sight, or counted wrongly."""

from __future__ import annotations

from core.calibration.board import Board
from core.calibration.quality import miscounted, unseen
from core.message import Array

LONGEST = 320  # [pixel] of the copy in which boards of other sizes are looked for


class Explainer:
    """Looks for the reason now and then, one way of miscounting at a time, for they are slow to try."""

    def __init__(self, board: Board, every: float = 1.0) -> None:
        self.board, self.every = board, every  # [s] between looks
        self._looked = float("-inf")
        self._tries = 0
        self._reason = ""

    def why(self, grey: Array, stamp: float) -> str:
        """A picture (H, W) uint8 of time `stamp` [s] without the board → one sentence, perhaps the former one."""
        if not 0 <= stamp - self._looked < self.every:
            self._looked = stamp
            wrong = miscounted(grey, self.board, self._tries, LONGEST)
            self._tries += not wrong
            self._reason = wrong or unseen(grey, self.board)
        return self._reason
