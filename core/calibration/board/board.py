"""The chessboard that is shown to the camera."""

from __future__ import annotations

import re

import numpy as np

from core.errors import BadInput
from core.message import Array, message


@message
class Board:
    """A printed chessboard, counted in inner corners: the points where four squares meet.

    Its frame has the first corner as origin, x along a row of corners, y down the rows, z away from the viewer.
    """

    columns: int  # inner corners in a row
    rows: int  # rows of inner corners
    square: float  # [m] side of one square
    panel: tuple[float, float] | None = None  # [m] width and height of the stiff panel that carries the print

    def __post_init__(self) -> None:
        if not (3 <= self.columns <= 40 and 3 <= self.rows <= 40):
            raise BadInput("A board needs 3 to 40 inner corners each way; count the points where four squares meet.")
        if not 0.001 <= self.square <= 1.0:
            raise BadInput("The side of a square must lie between 1 mm and 1 m; give it in metres, as in 0.025.")
        if self.panel is not None and (self.panel[0] < self.width or self.panel[1] < self.height):
            raise BadInput("The panel is smaller than the corners on it; measure the whole stiff board, in metres.")

    @staticmethod
    def parse(text: str, square: float, panel: tuple[float, float] | None = None) -> Board:
        """'9x6' and a square's side [m] → the board."""
        found = re.fullmatch(r"\s*(\d{1,3})\s*[xX×]\s*(\d{1,3})\s*", text)
        if found is None:
            raise BadInput('Write the board as inner corners in a row x rows, for example "9x6".')
        return Board(columns=int(found[1]), rows=int(found[2]), square=square, panel=panel)

    @property
    def name(self) -> str:
        """As an operator writes it: '9x6'."""
        return f"{self.columns}x{self.rows}"

    @property
    def count(self) -> int:
        """Number of inner corners N."""
        return self.columns * self.rows

    @property
    def points(self) -> Array:
        """Corners (N, 3) [m] in the board frame, row by row."""
        grid = np.stack(np.meshgrid(np.arange(self.columns), np.arange(self.rows)), axis=-1).reshape(-1, 2)
        return np.column_stack((grid * self.square, np.zeros(self.count)))

    @property
    def width(self) -> float:
        """[m] between the first and the last corner of a row."""
        return (self.columns - 1) * self.square

    @property
    def height(self) -> float:
        """[m] between the first and the last row."""
        return (self.rows - 1) * self.square

    @property
    def centre(self) -> Array:
        """(3,) [m]: the middle of the corners, in the board frame."""
        return np.array([self.width / 2, self.height / 2, 0.0])

    @property
    def half_size(self) -> tuple[float, float]:
        """[m] from the centre to the panel's sides; without a measured panel, to the rim of the outermost squares."""
        width, height = self.panel or (self.width + 2 * self.square, self.height + 2 * self.square)
        return width / 2, height / 2

    @property
    def outline(self) -> Array:
        """Corners (4, 3) [m] of the panel in the board frame, clockwise as the camera sees them."""
        x, y = self.half_size
        return self.centre + np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])

    @property
    def ambiguous(self) -> bool:
        """True when the print looks the same after half a turn: both counts odd or both even."""
        return (self.columns + self.rows) % 2 == 0
