"""The session that the wizards of the camera and of the laser share: views of a board, and the solution of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection
from typing import ClassVar, Generic, Literal, Protocol, TypeVar

import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.chessboard import BoardView, glimpse
from core.calibration.board.quality import miscounted, unseen
from core.calibration.camera.guidance import Advice
from core.errors import BadInput, Refused
from core.message import Array, message

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


class TakenView(Protocol):
    """A view, or a pose, in the session."""

    dropped: bool  # by the person

    @property
    def name(self) -> str:
        """Its name."""
        ...


@message
class BoardVerdict:
    """The outcome of one picture or scan."""

    kind: Literal["background", "nothing", "refused", "moving", "gathering", "same", "counted"]
    words: str  # one sentence for the person
    name: str = ""  # of the view or pose that was taken
    corners: Array | None = None  # (N, 2) [pixel], to be drawn
    beams: Array | None = None  # (K,) numbers of the beams taken for the board, to be highlighted


class WizardProgress(Protocol):
    """How far a wizard is."""

    @property
    def ready(self) -> bool:
        """Good enough to be used."""
        ...

    @property
    def words(self) -> str:
        """A sentence."""
        ...


TakenT = TypeVar("TakenT", bound=TakenView)
CalibrationT = TypeVar("CalibrationT")


class BoardSession(ABC, Generic[TakenT, CalibrationT]):
    """One calibration. Owned by one thread."""

    part: ClassVar[str]  # what is taken: "view"
    min_solved: ClassVar[int]  # before a solution is tried

    def __init__(self, board: Board) -> None:
        self.board = board
        self.taken: list[TakenT] = []
        self.calibration: CalibrationT | None = None
        self.solved: tuple[str, ...] = ()  # names of those that the solution was made of
        self._asked = 0  # how often another suggestion was asked for

    @abstractmethod
    def advice(self) -> Advice | None:
        """The most useful next one; None where nothing can be said yet."""

    @abstractmethod
    def progress(self) -> WizardProgress:
        """The progress so far, and what is missing."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of those that take part."""
        return tuple(each.name for each in self.taken if not each.dropped)

    @property
    def stale(self) -> bool:
        """True when the solution does not cover those that take part."""
        return len(self.names) >= self.min_solved and self.solved != self.names

    def drop(self, name: str) -> None:
        """Leave one out of the next solution. Raises BadInput when there is none of that name."""
        self._named(name).dropped = True

    def restore(self, name: str) -> None:
        """Take one back in. Raises BadInput when there is none of that name."""
        self._named(name).dropped = False

    def adopt(self, calibration: CalibrationT, names: Collection[str]) -> CalibrationT:
        """Take over a solution that was made of those of these names, perhaps in another process."""
        self.calibration = calibration
        self.solved = tuple(each.name for each in self.taken if each.name in names)
        return calibration

    def accept(self) -> CalibrationT:
        """The calibration, if it is good enough to be used. Raises Refused with the reason."""
        progress = self.progress()
        if self.calibration is None or not progress.ready:
            raise Refused(progress.words)
        return self.calibration

    def skip(self) -> Advice | None:
        """Another suggestion, for one who cannot reach the present one."""
        self._asked += 1
        return self.advice()

    def _named(self, name: str) -> TakenT:
        for each in self.taken:
            if each.name == name:
                return each
        raise BadInput(f"There is no {self.part} of that name in this session.")
